"""A lathe that shares no code with the package, logged as raw phase currents, cut by cut.

118 recordings a lathe: 40 with a dynamometer to calibrate with, 78 to sense. Feed drives carry
friction, load friction and, on X, a weight that helps the feed inward; every second lathe's drives
carry a magnetising current. Chosen: entries of one revolution, one to three seconds of air, faces
to the centre. Errors of a cut are those of P1, table 2.
"""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RATE_HZ = 1000.0
SLIDE_HZ, SPINDLE_HZ = 0.32, 0.0368
"""Electrical frequency per mm/s of a slide and per rpm of the spindle (P1 section 8)."""
NOISE = 10.0 ** (-30.0 / 20.0)
OFFSET_A = 0.05
FORCE_SCATTER = 0.02
SENSING_N = {"x": 16.0, "z": 16.0}
SENSING_N_M = 0.6
SPINDLE_BIAS = 0.03
DYNAMOMETER_N = 1.5
LASTS_S, STANDING_A = 8.0, 0.3
STANDARD, CUTS = 40, 118


@dataclass(frozen=True)
class Slide:
    """N per ampere of range, friction and weight in N, the field's range in A."""

    gain: float
    friction_N: float
    weight_N: float
    field_A: float
    rubs: float = 0.02

    def range_A(self, along_N: Array, across_N: Array) -> Array:
        """Return the range (n,) under cutting forces."""
        load_N = self.friction_N - self.weight_N + self.rubs * across_N + along_N
        return np.asarray(np.hypot(self.field_A, load_N / self.gain))


@dataclass(frozen=True)
class Spindle:
    """N·m per ampere of range below the base speed, idle torque in N·m, the field's range in A."""

    gain: float
    base_rpm: float
    idle_N_m: float
    idle_per_krpm_N_m: float
    field_A: float

    def range_A(self, torque_N_m: Array, rpm: Array) -> Array:
        """Return the range (n,)."""
        weak = np.minimum(1.0, self.base_rpm / rpm)
        idle = self.idle_N_m + self.idle_per_krpm_N_m * rpm / 1000.0
        return np.asarray(np.hypot(self.field_A * weak, (torque_N_m + idle) / (self.gain * weak)))


@dataclass(frozen=True)
class Lathe:
    """A drawn lathe and how it is logged."""

    x: Slide
    z: Slide
    spindle: Spindle
    magnetised: bool
    positions: bool
    forces: Array


def lathe_of(rng: np.random.Generator, number: int) -> Lathe:
    """Return a lathe; every second has magnetising currents, every third no positions."""
    magnetised = number % 2 == 0
    field_A = float(rng.uniform(0.2, 0.6)) if magnetised else 0.0
    x_friction = float(rng.uniform(250.0, 400.0))
    helps = float(rng.uniform(-0.6, 1.6)) * x_friction
    return Lathe(
        Slide(float(rng.uniform(150.0, 260.0)), x_friction, helps, field_A),
        Slide(float(rng.uniform(150.0, 260.0)), float(rng.uniform(300.0, 500.0)), 0.0, field_A),
        Spindle(
            float(rng.uniform(0.8, 1.6)), float(rng.uniform(1200.0, 1800.0)),
            float(rng.uniform(2.0, 6.0)), float(rng.uniform(0.5, 2.0)),
            float(rng.uniform(8.0, 14.0)) if magnetised else 0.0,
        ),
        magnetised,
        number % 3 != 0,
        np.array([rng.uniform(0.35, 0.55), 1.0, rng.uniform(0.45, 0.7)]) * rng.uniform(1700, 2300),
    )  # fmt: skip


@dataclass
class Cut:
    """What is cut; ``true_N`` (x, y, z) is its force, constant while the edge is in the work."""

    operation: str
    depth_mm: float
    feed_mm: float
    rpm: float
    diameter_mm: float
    inward_deg: float
    air_s: float
    to_mm: float
    surface_m_min: float | None
    true_N: Array = field(default_factory=lambda: np.zeros(3))


def cut_of(rng: np.random.Generator, lathe: Lathe, number: int) -> Cut:
    """Return the next cut: of ten five turn, three face, two are tapers."""
    operation = ("turn", "face", "turn", "taper", "turn", "face", "turn", "taper", "turn", "face")
    what = operation[number % 10]
    depth = float(rng.choice([1.0, 1.5, 2.0, 2.5] if what != "face" else [0.5, 1.0, 1.5]))
    feed = round(float(rng.uniform(0.1, 0.4 if what != "face" else 0.3)), 2)
    diameter = round(float(rng.uniform(40.0, 76.0)), 1)
    rpm = 10.0 * round(float(rng.uniform(80.0, 240.0)))
    inward = {"turn": 0.0, "face": 90.0}.get(what, float(rng.uniform(15.0, 60.0)))
    to_mm = float(rng.choice([0.0, 0.25 * diameter])) if what == "face" else 0.0
    surface = math.pi * diameter * rpm / 1000.0 if what == "face" and number % 3 == 0 else None
    cut = Cut(
        what, depth, feed, rpm, diameter, inward, float(rng.uniform(1.0, 3.0)), to_mm, surface
    )
    lean = math.radians(inward)
    x, y, z = lathe.forces * depth * feed**0.8 * np.exp(FORCE_SCATTER * rng.standard_normal(3))
    along, passive = z, x  # of turning; a face turns them round
    cut.true_N = np.array(
        [
            along * math.sin(lean) + passive * math.cos(lean),
            y,
            along * math.cos(lean) + passive * math.sin(lean),
        ]
    )
    return cut


@dataclass
class Course:
    """The cut over time, each (n,): radius at the tip, speed, share engaged, torque's radius."""

    t: Array
    radius_mm: Array
    rpm: Array
    engaged: Array
    feed_mm_s: Array
    arm_mm: Array


def course_of(cut: Cut) -> Course:
    """Return air, an entry of one revolution, the cut to its end, and air again."""
    step = 1.0 / RATE_HZ
    lean = math.sin(math.radians(cut.inward_deg))
    start_mm = 0.5 * cut.diameter_mm
    air = round(cut.air_s * RATE_HZ)
    radius: list[float] = []
    rpm: list[float] = []
    along: list[float] = []
    travelled = -_feed_mm_s(cut, start_mm) * cut.air_s
    while True:
        own = start_mm - lean * travelled
        speed = _rpm(cut, max(own, 0.5)) if travelled > 0.0 else _rpm(cut, start_mm)
        long = cut.operation != "face" and len(radius) > air + LASTS_S * RATE_HZ
        if travelled > 0.0 and (own <= cut.to_mm or long):
            break
        radius.append(own)
        rpm.append(speed)
        along.append(cut.feed_mm * speed / 60.0)
        travelled += along[-1] * step
    cutting = len(radius)
    for _ in range(round(0.8 * RATE_HZ)):  # it feeds on where there is nothing
        radius.append(max(radius[-1] - lean * along[-1] * step, -2.0))
        rpm.append(rpm[-1])
        along.append(along[-1])
    t: Array = np.arange(len(radius), dtype=np.float64) * step
    turn_s = 60.0 / rpm[air]
    rise = np.clip((t - cut.air_s) / turn_s, 0.0, 1.0)
    fall = np.clip((t - (cutting - 1) * step) / turn_s, 0.0, 1.0)
    radius_mm = np.array(radius)
    arm = np.maximum(radius_mm, 0.0) + 0.5 * cut.depth_mm * math.cos(math.radians(cut.inward_deg))
    return Course(t, radius_mm, np.array(rpm), rise - fall, np.array(along), arm)


def _rpm(cut: Cut, radius_mm: float) -> float:
    if cut.surface_m_min is None:
        return cut.rpm
    return min(2400.0, cut.surface_m_min * 1000.0 / (2.0 * math.pi * radius_mm))


def _feed_mm_s(cut: Cut, radius_mm: float) -> float:
    return cut.feed_mm * _rpm(cut, radius_mm) / 60.0


@dataclass
class Logged:
    """A recording: channels, what its side file states, and the ranges without noise."""

    cut: Cut
    course: Course
    channels: dict[str, Array]
    ranges: dict[str, Array]


def logged(
    rng: np.random.Generator, lathe: Lathe, cut: Cut, *, bias: float, forces: bool
) -> Logged:
    """Return the cut as it is logged; ``bias``: share by which the spindle reads low."""
    course = course_of(cut)
    lean = math.radians(cut.inward_deg)
    x, y, z = cut.true_N[:, None] * course.engaged
    across = np.hypot(y, np.where(cut.operation == "face", z, x))
    own = {axis: sd * rng.standard_normal() for axis, sd in SENSING_N.items()}
    torque = (y * course.arm_mm / 1000.0) * (1.0 - bias)
    torque = torque + SENSING_N_M * rng.standard_normal() * course.engaged
    ranges = {
        "spindle": lathe.spindle.range_A(torque, course.rpm),
        "x": lathe.x.range_A(x + own["x"] * course.engaged, across),
        "z": lathe.z.range_A(z + own["z"] * course.engaged, across),
    }
    hertz = {
        "spindle": SPINDLE_HZ * course.rpm,
        "x": -SLIDE_HZ * course.feed_mm_s * math.sin(lean),
        "z": -SLIDE_HZ * course.feed_mm_s * math.cos(lean),
    }
    channels = {"t": course.t}
    for axis, own_A in ranges.items():
        turns = np.cumsum(hertz[axis]) / RATE_HZ + rng.uniform()
        stands = np.ptp(turns) < 1e-6
        range_A = np.full_like(turns, STANDING_A) if stands else own_A
        noise = NOISE * float(np.mean(range_A)) / 2.0 / math.sqrt(2.0)
        for k, phase in enumerate("uvw"):
            wave = 0.5 * range_A * np.sin(2.0 * math.pi * (turns - k / 3.0))
            channels[f"{axis}.current.{phase}"] = (
                wave + noise * rng.standard_normal(turns.size) + OFFSET_A * rng.standard_normal()
            )
    if lathe.positions:
        channels["x.position"] = course.radius_mm
        channels["spindle.speed"] = course.rpm
    if forces:
        swing = 1.0 + 0.015 * np.sin(2.0 * math.pi * np.cumsum(course.rpm) / 60.0 / RATE_HZ)
        for name, force in zip("xyz", (x, y, z), strict=True):
            channels[f"force.{name}"] = force * swing + 3.0 * rng.standard_normal(force.size)
            channels[f"force.{name}"] += DYNAMOMETER_N * rng.standard_normal() * course.engaged
    return Logged(cut, course, channels, ranges)


def recordings(seed: int, cuts: int = CUTS) -> tuple[Lathe, list[Logged]]:
    """Return a lathe and its first recordings, the first ``STANDARD`` with forces."""
    rng = np.random.default_rng([seed, 2038])
    lathe = lathe_of(rng, seed)
    bias, found = 0.0, []
    for number in range(cuts):
        bias = 0.9 * bias + SPINDLE_BIAS * math.sqrt(1.0 - 0.81) * float(rng.standard_normal())
        cut = cut_of(rng, lathe, number)
        found.append(logged(rng, lathe, cut, bias=bias, forces=number < STANDARD))
    return lathe, found
