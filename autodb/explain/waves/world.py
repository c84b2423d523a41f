"""What candidates of a milled waveform are built from: a simulation's waves and how teeth cut."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.candidates import CandidateForm, spline
from autodb.explain.waves.law import in_ways, rubbing
from autodb.explain.waves.teeth import Law, StandsOut
from autodb.explain.waves.waves import Waves
from autodb.files.channels import FORCES
from autodb.sensing.table.model import carried_columns
from autodb.timing import Timing

Array = NDArray[np.float64]
Over = Callable[[Array], Array]
"""Forces a mm of edge (k, m) of chips (m,)."""

ROUND_MM = (0.0, 0.004, 0.012)
"""Chips at which two thirds of an edge's force act, of a rounded edge."""
BUMPS = 5
"""Smooth functions that any other is summed up of, of the chip's thickness."""
FINE = 1025
"""Points between which these are taken as straight."""
RESTS = 1e-12
"""Share of a simulation's squares below which what its waves leave of it is nothing."""


@dataclass(frozen=True)
class Tilted:
    """A table: rotations into its frame (3, 3, n), ω and ω' in it (3, n)."""

    rotation: Array
    omega: Array
    faster: Array

    def columns(self) -> Array:
        """Return what a kilogram on it, and its moments, add (3, n, 4), N a kg and a kg·m."""
        return carried_columns(self.rotation, self.omega, self.faster)

    def at(self, rows: NDArray[np.intp]) -> "Tilted":
        """Return the same at some rows."""
        return Tilted(self.rotation[..., rows], self.omega[:, rows], self.faster[:, rows])


@dataclass(frozen=True)
class SimulatedWaves:
    """A simulation's waves, rows (n,) of C components.

    ``timing``: the pieces that its rows lie in; ``has_edge``: the simulation has an edge force;
    ``out``: how far each tooth stands out, and ``deeper_mm`` how far the depth is off, where that
    was found; ``tilted``: how the table is, None: it stands still. ``cutting`` (C, n): what the
    simulation leaves out of the force that teeth make, ``lacking``: of the force that is sensed,
    and ``gained`` what components show beside it by their scale; None: as simulated.
    """

    waves: Waves
    timing: Timing
    has_edge: bool
    out: StandsOut | None = None
    deeper_mm: float | None = None
    tilted: Tilted | None = None
    cutting: Array | None = None
    lacking: Array | None = None
    gained: Array | None = None

    def at(self, rows: NDArray[np.intp]) -> "SimulatedWaves":
        """Return the same at some rows."""
        return replace(
            self,
            waves=self.waves.at(rows),
            timing=self.timing.at(rows),
            tilted=None if self.tilted is None else self.tilted.at(rows),
            cutting=None if self.cutting is None else self.cutting[:, rows],
            lacking=None if self.lacking is None else self.lacking[:, rows],
            gained=None if self.gained is None else self.gained[:, rows],
        )

    @property
    def components(self) -> int:
        """Force components."""
        return len(self.waves.names)

    @property
    def kept(self) -> list[int]:
        """Which of x, y and z they are."""
        return [FORCES.index(name) for name in self.waves.names]

    @property
    def engaged(self) -> Array:
        """1 in the work, 0 outside (n,)."""
        return self.waves.teeth.engaged

    @cached_property
    def time(self) -> Array:
        """Time over the recording, 0 to 1 (n,)."""
        t = self.waves.t_s
        return np.asarray((t - t[0]) / (t[-1] - t[0]))

    @cached_property
    def worn(self) -> Array:
        """Time in the work, 0 to 1 (n,); over a gap in which it is there it goes on."""
        lasts = np.ones(len(self.engaged))
        for piece in self.timing.pieces[1:]:
            missing_s = float(self.waves.t_s[piece.start] - self.waves.t_s[piece.start - 1])
            lasts[piece.start] = missing_s * self.timing.rate_hz
        spent = np.cumsum(self.engaged * lasts)
        return np.asarray(spent / max(float(spent[-1]), 1.0))

    @cached_property
    def measured_s(self) -> float:
        """How long its pieces last together, s."""
        t = self.waves.t_s
        return float(sum(t[piece.stop - 1] - t[piece.start] for piece in self.timing.pieces))

    @cached_property
    def turns_a_s(self) -> float:
        """Turns of the spindle a second, over its pieces: between them turns are not counted."""
        angle = self.waves.teeth.angle_rad
        ends = ((angle[piece.start], angle[piece.stop - 1]) for piece in self.timing.pieces)
        turned = sum(abs(last - first) for first, last in ends)
        return float(turned / (2.0 * np.pi) / self.measured_s)

    @cached_property
    def simulated(self) -> Array:
        """The simulation, and what teeth that stand out change in it (C, n)."""
        return self.waves.simulation + self.stands_out

    @property
    def made(self) -> Array:
        """The force that teeth make: the simulated one, and what was found that it leaves out."""
        return self.simulated if self.cutting is None else self.waves.simulation + self.cutting

    @property
    def sensed(self) -> Array:
        """The force that is sensed: the simulated one, and what was found that it leaves out."""
        return self.simulated if self.lacking is None else self.waves.simulation + self.lacking

    @property
    def shown(self) -> Array:
        """What components show of it, each by its own scale (C, n)."""
        return self.sensed if self.gained is None else self.sensed + self.gained

    @cached_property
    def stands_out(self) -> Array:
        """What teeth that stand out change (C, n)."""
        if self.out is None:
            return np.zeros_like(self.waves.simulation)
        law, teeth = self.waves.law.whole, self.waves.teeth
        return self.waves.seen(teeth.forces(law, self.out) - teeth.forces(law))

    def cut(self, law: Law) -> Array:
        """Return what a law makes of the chips as they are (C, n)."""
        return self.waves.seen(self.waves.teeth.forces_at(law, self.chips))

    @cached_property
    def chips(self) -> list[Array]:
        """The chips of each tooth's slices (m,) mm."""
        return self.waves.teeth.chips(self.out)

    @cached_property
    def shear_ways(self) -> Array:
        """What the chip makes, tangential, radial and axial (C, n, 3)."""
        return self.cut_each_way(self.shear)

    @cached_property
    def edge_ways(self) -> Array:
        """What the simulation's edge makes."""
        return self.cut_each_way(self.waves.law.of_edge)

    @property
    def shear(self) -> Law:
        """The law but for its edge's force: all of it, of a simulation without one."""
        return self.waves.law.of_shear if self.has_edge else self.waves.law.whole

    def cut_each_way(self, law: Law) -> Array:
        """Return what a law makes of the chips in each way alone (C, n, 3)."""
        ways = self.waves.seen(self.waves.teeth.ways_at(law, self.chips))
        return np.ascontiguousarray(np.moveaxis(ways, 0, -1))

    @cached_property
    def edges(self) -> tuple[Array, ...]:
        """Edge forces of 1 N/mm (C, n, 3): of a sharp edge, and of rounded ones."""
        return tuple(np.split(self._each_way(_rubbed), len(ROUND_MM), axis=-1))

    @cached_property
    def bumps(self) -> Array:
        """Smooth functions of the chip, each way (C, n, 3 · BUMPS)."""
        return self._each_way(partial(_bumps, feed_mm=self.waves.teeth.mill.feed_mm))

    def _each_way(self, over: Over) -> Array:
        """Return what functions of the chip, N/mm, make each way (C, n, k · 3)."""
        ways = self.waves.seen(in_ways(self.waves.teeth.moments(over, self.chips)))
        made = np.moveaxis(ways, (0, 1), (-2, -1))
        return np.ascontiguousarray(made.reshape(*made.shape[:2], -1))


def _rubbed(chip_mm: Array) -> Array:
    return np.array([rubbing(chip_mm, round_mm) for round_mm in ROUND_MM])


def _bumps(chip_mm: Array, *, feed_mm: float) -> Array:
    """Return smooth functions of the chip (BUMPS, m), finer where it is thin."""
    grid = np.linspace(0.0, 1.0, FINE)
    u = np.sqrt(np.clip(chip_mm / feed_mm, 0.0, 1.0))
    return np.array([np.interp(u, grid, one) for one in spline(grid, BUMPS).T])


def own_columns_of_waves(world: SimulatedWaves) -> dict[str, Array]:
    """Return the simulation's own terms (C, n): shear, its edge and run-out if it has them, and
    what its waves leave of it.
    """
    own = {"shear": world.shear_ways.sum(axis=-1)}
    if world.has_edge:
        own["edge_force"] = world.edge_ways.sum(axis=-1)
    if world.waves.uneven is not None:
        own["runout"] = world.waves.runout
    rest = world.simulated - sum(own.values())
    if np.sum(rest**2) > RESTS * np.sum(world.simulated**2):
        own["rest"] = rest
    return own


def form(columns: Array, shape: Mapping[str, float] | None = None, **options: Any) -> CandidateForm:
    """Return a shape of columns (C, n, p), with what is known of it by name."""
    return CandidateForm(keep_shape(columns), shape or {}, **options)


def keep_shape(columns: Array) -> Callable[..., Array]:
    """Return a function that gives columns (C, n, p), whatever their shape is called.

    Each lies in one piece of memory: they are filtered one by one.
    """
    return partial(_as_is, np.moveaxis(np.ascontiguousarray(np.moveaxis(columns, -1, 1)), 1, -1))


def _as_is(columns: Array, **shape: float) -> Array:
    del shape
    return columns


def on_each(world: SimulatedWaves, course: Array) -> Array:
    """Return columns (C, n, C · p) of courses (n, p), free in each component."""
    count, n = world.components, len(course)
    made = np.zeros((count, count, course.shape[1], n))
    for i in range(count):
        made[i, i] = course.T
    return np.moveaxis(made.reshape(count, -1, n), 1, -1)


def shape_columns(shape: CandidateForm) -> Array:
    """Return a shape's columns (C, n, p)."""
    return np.asarray(shape.law(**shape.shape))
