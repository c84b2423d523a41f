"""A table of turning cuts and the forces of a law of its own; ranges are *chosen*.

Force N, depth and feed mm, speed m/min. With depth b, feed h, component j of x, y, z:

    shear K_j b h0 (h/h0)^(1 - m_j), h0 = 0.2 mm; edge_force E_j b, or E_j b (1 - e^(-h/h_p))

Scatter of a cut has sd sqrt(a^2 + (b F)^2): b is what P1's repeated cut scatters (its Table 2:
9.2 N at 486 N, 17.9 N at 326 N), a what its current sensors add, or a dynamometer's 1.5 N.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from autodb.proofs.cases.base.case import Array
from autodb.proofs.cases.base.moves import log_uniform

FEED_MM = 0.2  # h0
SCATTER = np.array([0.0549, 0.0189, 0.0549])  # b of x, y, z
SENSED_N = np.array([25.0, 18.5, 16.1])  # a of forces from currents
DYNAMOMETER_N = np.array([1.5, 1.5, 1.5])


@dataclass(frozen=True)
class CaseCuts:
    """Conditions of cuts, each (n,); ``edge`` counts from 0, ``used_s`` is the time on it before.

    ``labelled``: whether the table says which edge it was.
    """

    t_s: Array
    duration_s: Array
    speed_m_min: Array
    feed_mm: Array
    depth_mm: Array
    diameter_mm: Array
    z_mm: Array
    edge: Array
    used_s: Array
    labelled: bool


@dataclass(frozen=True)
class CaseLaw:
    """Constants of the force law, each of x, y, z; ``plough_mm`` 0: the edge force is E_j b."""

    shear_N_mm2: Array
    exponent: Array
    edge_N_mm: Array
    edged: bool
    plough_mm: float


@dataclass(frozen=True)
class CutWorld:
    """Cuts and the law of their forces; parts are (3, n)."""

    cuts: CaseCuts
    law: CaseLaw

    def of(self, **constants: Any) -> "CutWorld":
        """The same cuts under a law with other constants."""
        return CutWorld(self.cuts, replace(self.law, **constants))

    @cached_property
    def parts(self) -> dict[str, Array]:
        """Contributions of the law's terms, N."""
        cuts, law = self.cuts, self.law
        growth = (cuts.feed_mm / FEED_MM) ** (1.0 - law.exponent[:, None])
        parts = {"shear": law.shear_N_mm2[:, None] * cuts.depth_mm * FEED_MM * growth}
        if law.edged:
            parts["edge_force"] = law.edge_N_mm[:, None] * self.edge_mm
        return parts

    @cached_property
    def base(self) -> Array:
        """Their sum."""
        return np.asarray(np.sum(list(self.parts.values()), axis=0), dtype=np.float64)

    @cached_property
    def edge_mm(self) -> Array:
        """Length of edge that ploughs, (n,)."""
        cuts, plough = self.cuts, self.law.plough_mm
        return cuts.depth_mm * (-np.expm1(-cuts.feed_mm / plough) if plough else 1.0)


def draw_law(rng: np.random.Generator) -> CaseLaw:
    """A material: x takes the least, y the most; three of four have an edge force."""
    shear = log_uniform(rng, 600.0, 2600.0) * np.array([rng.uniform(0.2, 0.4), 1.0, 0.5])
    edge = log_uniform(rng, 20.0, 90.0) * np.array([rng.uniform(0.5, 1.0), 1.0, 0.8])
    spread = np.exp(rng.uniform(-0.2, 0.2, (2, 3)))
    return CaseLaw(
        shear_N_mm2=shear * spread[0],
        exponent=rng.uniform(0.02, 0.25, 3),
        edge_N_mm=edge * spread[1],
        edged=bool(rng.random() < 0.75),
        plough_mm=float(rng.choice([0.0, rng.uniform(0.01, 0.04)])),
    )


def draw_cuts(rng: np.random.Generator) -> CaseCuts:
    """10 to 1000 cuts: all different, a grid of conditions, or a few that repeat, as in a shop."""
    n = round(log_uniform(rng, 10.0, 1000.0))
    conditions = _conditions(rng, n)
    speed, feed, depth = conditions[:, rng.integers(conditions.shape[1], size=n)]
    if conditions.shape[1] == n:
        speed, feed, depth = conditions
    duration = np.exp(rng.uniform(np.log(8.0), np.log(60.0), n))
    starts = np.cumsum(duration + rng.uniform(20.0, 120.0, n))
    labelled, edge = _edges(rng, n)
    used = np.cumsum(duration) - duration
    first = np.searchsorted(edge, edge)
    return CaseCuts(
        t_s=starts - starts[0],
        duration_s=duration,
        speed_m_min=speed,
        feed_mm=feed,
        depth_mm=depth,
        diameter_mm=rng.uniform(20.0, 110.0, n),
        z_mm=rng.uniform(10.0, 300.0, n),
        edge=edge,
        used_s=used - used[first],
        labelled=labelled,
    )


def _conditions(rng: np.random.Generator, n: int) -> Array:
    """Speeds, feeds and depths (3, m) that the table has: m = n of all different ones."""
    kind = rng.integers(3)
    if kind == 0:
        return np.array([rng.uniform(70.0, 320.0, n), _feeds(rng, n), rng.uniform(0.4, 3.2, n)])
    if kind == 1:
        speeds, depths = rng.uniform(70.0, 320.0, 4), rng.uniform(0.4, 3.2, 4)
        grid = np.meshgrid(speeds, _feeds(rng, 4), depths)
        return np.array([values.ravel() for values in grid])
    few = int(rng.integers(5, 12))
    return np.array([rng.uniform(70.0, 320.0, few), _feeds(rng, few), rng.uniform(0.4, 3.2, few)])


def _feeds(rng: np.random.Generator, n: int) -> Array:
    return np.asarray(np.exp(rng.uniform(np.log(0.03), np.log(0.45), n)), dtype=np.float64)


def _edges(rng: np.random.Generator, n: int) -> tuple[bool, Array]:
    """Two to eight edges one after the other, or one edge that the table does not name."""
    count = int(rng.integers(2, 9))
    if rng.random() < 0.25:
        return False, np.zeros(n)
    changes = rng.choice(np.arange(1, n), size=min(count, n // 3) - 1, replace=False)
    return True, np.searchsorted(np.sort(changes), np.arange(n), side="right").astype(np.float64)


def scatter_N(world: CutWorld, rng: np.random.Generator) -> Array:
    """Standard deviation (3, n) of a cut's forces, sensed by currents or by a dynamometer."""
    sensing = SENSED_N if rng.random() < 0.5 else DYNAMOMETER_N
    sd: Array = np.hypot(sensing[:, None], SCATTER[:, None] * world.base)
    return sd
