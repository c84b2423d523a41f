"""One milled cut in time and the forces of a law of its own; ranges are *chosen*.

Force N, h mm, slices b mm of each tooth j at φ from the normal left of the feed, seen by a table
under the work. Tangential, radial and axial, d:

    shear K_d b h0 (h/h0)^(1 - m_d), h0 = 0.05 mm; edge_force E_d b (1 - e^(-h/h_p))
    h = min over k teeth before of k f sin φ + o_j - o_(j-k), not below 0

o_j: how far tooth j stands out. Noise of a force link is 1.5 to 8 N, white, or partly slower than
that: P4 Table 5 has 0.9 to 3.7 % between repeats of cuts of 72 to 389 N.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.cases.base.case import Array
from autodb.proofs.cases.base.disturbance import ChannelNoise
from autodb.proofs.cases.base.moves import log_uniform

THIN_MM = 0.05  # h0
SLICE_MM = 0.1
Rows = NDArray[np.intp]
OPERATIONS = ("slot", "side-up", "side-down")


@dataclass(frozen=True)
class Milling:
    """A cut: rows (n,) of time, angle of tooth 0, slide, table; in the work from begin to end.

    ``enters``: the mill comes into the work from its edge; else it is in it at once.
    """

    t_s: Array
    angle_rad: Array
    x_mm: Array
    a_rad: Array
    c_rad: Array
    operation: str
    diameter_mm: float
    teeth: int
    helix_rad: float
    depth_mm: float
    width_mm: float
    feed_mm: float
    speed_rpm: float
    direction_rad: float
    begin_s: float
    end_s: float
    enters: bool

    @property
    def arc_rad(self) -> tuple[float, float]:
        """Angles at which a tooth comes into the work and leaves it."""
        angle = float(np.arccos(1.0 - 2.0 * self.width_mm / self.diameter_mm))
        arcs = {"slot": (0.0, np.pi), "side-up": (0.0, angle)}
        return arcs.get(self.operation, (np.pi - angle, np.pi))

    @property
    def feed_mm_s(self) -> float:
        """Speed of the slide."""
        return self.feed_mm * self.teeth * self.speed_rpm / 60.0

    @property
    def engaged_s(self) -> Array:
        """Time in the work before each row."""
        return np.clip(self.t_s - self.begin_s, 0.0, self.end_s - self.begin_s)

    @property
    def engaged(self) -> Array:
        """1 in the work, 0 outside."""
        inside = (self.t_s >= self.begin_s) & (self.t_s <= self.end_s)
        return inside.astype(np.float64)


@dataclass(frozen=True)
class MillLaw:
    """Constants of tangential, radial, axial; ``thin``: (size, mm, fades) of a size effect."""

    shear_N_mm2: Array
    exponent: Array
    edge_N_mm: Array
    plough_mm: float
    edged: bool = True
    thin: tuple[float, float, bool] = (0.0, 1.0, True)


@dataclass(frozen=True)
class MillWorld:
    """A cut, its law, and how far each tooth stands out; parts are (3, n)."""

    cut: Milling
    law: MillLaw
    out_mm: tuple[float, ...]

    def of(self, **constants: Any) -> "MillWorld":
        """The same cut under a law with other constants."""
        return replace(self, law=replace(self.law, **constants))

    def deeper(self, by_mm: float) -> "MillWorld":
        """The same with another depth."""
        return replace(self, cut=replace(self.cut, depth_mm=self.cut.depth_mm + by_mm))

    @cached_property
    def courses(self) -> Array:
        """Forces (2, 3, 3, n): of shear and edge; tangential, radial, axial; x, y, z."""
        made = np.zeros((2, 3, 3, self.cut.t_s.size))
        for row, sin, cos, chip, width in self._slices():
            for kind, forces in enumerate(self._forces(chip)):
                t, r, a = (width * one for one in forces)
                ways = ((0, 0, -t * cos), (0, 1, t * sin), (1, 0, -r * sin), (1, 1, -r * cos))
                for d, i, one in (*ways, (2, 2, a)):
                    made[kind, d, i] += np.bincount(row, one, self.cut.t_s.size)
        return self._seen(made)

    def _slices(self) -> Iterator[tuple[Rows, Array, Array, Array, float]]:
        """Slices of each tooth that cut: row, sin and cos of φ, chip, width."""
        cut, out = self.cut, np.array(self.out_mm)
        count = max(2, round(cut.depth_mm / SLICE_MM))
        lag = (np.arange(count) + 0.5) / count * cut.depth_mm * np.tan(cut.helix_rad)
        inside = np.flatnonzero(cut.engaged)
        reach = cut.engaged_s[inside] * cut.feed_mm_s / (0.5 * cut.diameter_mm)
        least_sin = 1.0 - reach if cut.enters else np.full(inside.size, -1.0)
        first, last = cut.arc_rad
        for tooth in range(cut.teeth):
            tip = cut.angle_rad[inside] - tooth * 2.0 * np.pi / cut.teeth
            phi = np.mod(tip[:, None] - lag / (0.5 * cut.diameter_mm), 2.0 * np.pi)
            cuts = (phi >= first) & (phi <= last) & (np.sin(phi) >= least_sin[:, None])
            sin, cos = np.sin(phi[cuts]), np.cos(phi[cuts])
            left = [
                back * cut.feed_mm * sin + out[tooth] - out[(tooth - back) % cut.teeth]
                for back in range(1, cut.teeth + 1 if np.any(out) else 2)
            ]
            chip = np.minimum.reduce(left)
            some = chip > 0.0
            row = inside[np.nonzero(cuts)[0][some]]
            yield row, sin[some], cos[some], chip[some], cut.depth_mm / count

    def _forces(self, chip: Array) -> tuple[list[Array], list[Array]]:
        """Shear and edge forces a mm of chips (m,): tangential, radial, axial."""
        law = self.law
        size, thin_mm, fades = law.thin
        more = np.exp(-chip / thin_mm) if fades else 1.0 / (1.0 + chip / thin_mm)
        rubs = -np.expm1(-chip / law.plough_mm) if law.plough_mm else np.ones_like(chip)
        harder = THIN_MM * (1.0 + size * more)
        shear = [
            k * harder * (chip / THIN_MM) ** (1.0 - m)
            for k, m in zip(law.shear_N_mm2, law.exponent, strict=True)
        ]
        return shear, [k * rubs for k in law.edge_N_mm]

    def _seen(self, made: Array) -> Array:
        """Forces (..., 3, n) in the feed's frame as the tilted table sees them."""
        cut = self.cut
        sin, cos = np.sin(cut.direction_rad), np.cos(cut.direction_rad)
        x, y, z = (made[..., i, :] for i in range(3))
        machine = np.stack([cos * x - sin * y, sin * x + cos * y, z], axis=-2)
        return np.asarray(np.einsum("ijn,...jn->...in", table_rotations(cut), machine))

    @property
    def parts(self) -> dict[str, Array]:
        """Contributions of the law's terms, N."""
        shear, edge = self.courses.sum(axis=1)
        return {"shear": shear, "edge_force": edge} if self.law.edged else {"shear": shear}

    @property
    def base(self) -> Array:
        """Their sum."""
        return np.asarray(np.sum(list(self.parts.values()), axis=0), dtype=np.float64)


def table_rotations(cut: Milling) -> Array:
    """Return rotations (3, 3, n) from the machine to the table: T_z(c) T_x(a), P4."""
    one, zero = np.ones_like(cut.a_rad), np.zeros_like(cut.a_rad)
    sa, ca, sc, cc = np.sin(cut.a_rad), np.cos(cut.a_rad), np.sin(cut.c_rad), np.cos(cut.c_rad)
    about_x = np.array([[one, zero, zero], [zero, ca, -sa], [zero, sa, ca]])
    about_z = np.array([[cc, -sc, zero], [sc, cc, zero], [zero, zero, one]])
    return np.asarray(np.einsum("ijn,jkn->ikn", about_z, about_x))


def draw_milling(rng: np.random.Generator, *, tilts: bool) -> Milling:
    """A cut of 2 to 3 s; every third on a table that tilts meanwhile, or where it must."""
    rate_Hz = float(rng.choice([2500.0, 4000.0, 5000.0]))
    t = np.arange(round(rate_Hz * rng.uniform(2.0, 3.0))) / rate_Hz
    speed = log_uniform(rng, 1500.0, 6000.0)
    wander = 1.0 + rng.uniform(0.0, 5e-4) * np.sin(2.0 * np.pi * rng.uniform(0.2, 1.0) * t)
    turned_rad = np.cumsum(2.0 * np.pi * speed / 60.0 * wander) / rate_Hz
    diameter = float(rng.choice([6.0, 8.0, 10.0, 12.0, 16.0]))
    teeth, operation = int(rng.integers(2, 7)), str(rng.choice(OPERATIONS))
    feed = log_uniform(rng, 0.03, 0.12)
    width = diameter if operation == "slot" else diameter * rng.uniform(0.1, 0.7)
    begin, end = rng.uniform(0.1, 0.2) * t[-1], rng.uniform(0.88, 0.96) * t[-1]
    slide = feed * teeth * speed / 60.0 * t
    a, c = (_tilt(rng, t) for _ in range(2)) if tilts or rng.random() < 1 / 3 else (0 * t, 0 * t)
    return Milling(
        t_s=t,
        angle_rad=turned_rad + rng.uniform(0.0, 2.0 * np.pi),
        x_mm=slide + rng.uniform(0.0, 50.0),
        a_rad=a,
        c_rad=c,
        operation=operation,
        diameter_mm=diameter,
        teeth=teeth,
        helix_rad=float(np.radians(rng.choice([0.0, 30.0, 35.0, 38.0, 45.0]))),
        depth_mm=diameter * rng.uniform(0.08, 0.4),
        width_mm=float(width),
        feed_mm=feed,
        speed_rpm=speed,
        direction_rad=float(rng.choice([0.0, 0.0, rng.uniform(-np.pi, np.pi)])),
        begin_s=float(begin),
        end_s=float(end),
        enters=bool(rng.random() < 0.5),
    )


def _tilt(rng: np.random.Generator, t: Array) -> Array:
    """One or two smooth swings of a rotary axis by 5 to 25°."""
    total = np.zeros_like(t)
    for _ in range(int(rng.integers(1, 3))):
        middle, half = rng.uniform(0.1, 0.9) * t[-1], rng.uniform(0.1, 0.5)
        u = np.clip((t - middle) / half, -1.0, 1.0)
        smooth = 0.5 + 0.9375 * u - 0.625 * u**3 + 0.1875 * u**5
        total = total + rng.choice([-1.0, 1.0]) * np.radians(rng.uniform(5.0, 25.0)) * smooth
    return np.asarray(total)


def draw_mill_law(rng: np.random.Generator) -> MillLaw:
    """A material: the tangential force takes most; of four three have an edge force."""
    shear = log_uniform(rng, 700.0, 2600.0) * np.array([1.0, rng.uniform(0.25, 0.6), 0.2])
    edge = log_uniform(rng, 8.0, 40.0) * np.array([1.0, rng.uniform(0.8, 1.6), 0.15])
    spread = np.exp(rng.uniform(-0.2, 0.2, (2, 3)))
    return MillLaw(
        shear_N_mm2=shear * spread[0],
        exponent=rng.uniform(0.05, 0.3, 3),
        edge_N_mm=edge * spread[1],
        plough_mm=float(rng.choice([0.0, rng.uniform(0.003, 0.012)])),
        edged=bool(rng.random() < 0.75),
    )


def draw_link_noise(rng: np.random.Generator) -> ChannelNoise:
    """Noise of a force link: white, of half of them partly slower, over some rows."""
    sd = log_uniform(rng, 1.5, 8.0)
    if rng.random() < 0.5:
        return ChannelNoise(slow=0.0, rho=0.0, white=sd)
    slow = rng.uniform(0.3, 0.8)
    return ChannelNoise(
        slow=sd * slow, rho=rng.uniform(0.6, 0.97), white=sd * float(np.sqrt(1 - slow**2))
    )
