"""Effects on a milled cut's waveform: forms and ranges are *chosen*, none is a plain textbook one.

Parts are (3, n), N. What changes the chip is the law worked out again, not a column times a size.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from autodb.proofs.cases.base.build import Hidable
from autodb.proofs.cases.base.case import Array
from autodb.proofs.cases.cuts.cut_effects import components_apart
from autodb.proofs.cases.mill.milling import MillWorld

Three = tuple[float, float, float]
NUDGE = 0.02
"""Share of the largest size at which columns of what changes the chip are taken."""


@dataclass(frozen=True)
class MillEffect(Hidable[MillWorld]):
    """An effect on a waveform; its size is a share of the force where not said otherwise."""

    def most(self, world: MillWorld) -> float:
        """60 % of the force."""
        del world
        return 0.6


@dataclass(frozen=True)
class ChipChange(MillEffect):
    """What changes the chip: the law is worked out again."""

    def changed(self, world: MillWorld, size: float) -> MillWorld:
        """Return the world cut so."""
        raise NotImplementedError

    def part(self, world: MillWorld, total: Array, size: float) -> Array:
        """The law with it less the law without."""
        del total
        return np.asarray(self.changed(world, size).base - world.base, dtype=np.float64)

    def columns(self, world: MillWorld, total: Array) -> Array:
        """What a little of it changes."""
        little = NUDGE * self.most(world)
        return self.part(world, total, little)[None] / little


@dataclass(frozen=True)
class EdgeOfMillLeftOut(MillEffect):
    """The edge force that the law has and the simulation lacks; its size is E tangential, N/mm."""

    shares: Three
    term = "edge_force"
    own = True

    def most(self, world: MillWorld) -> float:
        """200 N/mm."""
        del world
        return 200.0

    def on(self, world: MillWorld, size: float) -> MillWorld:
        """An edge force of this size."""
        return world.of(edge_N_mm=size * np.array(self.shares), edged=True)

    def columns(self, world: MillWorld, total: Array) -> Array:
        """Tangential, radial, axial edge forces of 1 N/mm."""
        del total
        return np.asarray(world.of(edge_N_mm=np.ones(3), edged=True).courses[1])

    def part(self, world: MillWorld, total: Array, size: float) -> Array:
        """The edge force of the world, which has this size."""
        del total, size
        return np.asarray(world.parts[self.term], dtype=np.float64)


@dataclass(frozen=True)
class RunOut(ChipChange):
    """Teeth stand out unlike: the axis is off, or one tooth is chipped. The size is mm."""

    shape: tuple[float, ...]  # of each tooth, up to 1
    term = "runout"
    stage = 1

    def most(self, world: MillWorld) -> float:
        """As much as the feed."""
        return world.cut.feed_mm

    def changed(self, world: MillWorld, size: float) -> MillWorld:
        """Teeth that stand out."""
        return replace(world, out_mm=tuple(size * one for one in self.shape))


@dataclass(frozen=True)
class ThinChips(ChipChange):
    """The specific force rises as the chip thins, by a size at no thickness."""

    thin_mm: float
    fades: bool
    term = "size_effect"
    stage = 1

    def most(self, world: MillWorld) -> float:
        """2.5 times at no thickness."""
        del world
        return 1.5

    def changed(self, world: MillWorld, size: float) -> MillWorld:
        """Harder where thin."""
        return world.of(thin=(size, self.thin_mm, self.fades))


@dataclass(frozen=True)
class DeeperCut(ChipChange):
    """The real depth differs by a size in mm, either way."""

    sign: float
    term = "depth_error"
    stage = 2

    def most(self, world: MillWorld) -> float:
        """0.3 mm, a quarter of the depth at most."""
        return min(0.3, 0.25 * world.cut.depth_mm)

    def changed(self, world: MillWorld, size: float) -> MillWorld:
        """Deeper, or less deep."""
        return world.deeper(self.sign * size)


@dataclass(frozen=True)
class WearWithin(MillEffect):
    """The edge part grows while the mill cuts; the size is its growth at the end, 100 N/mm."""

    shares: Three
    bent: float
    term = "tool_wear"

    def most(self, world: MillWorld) -> float:
        """200 N/mm."""
        del world
        return 2.0

    def columns(self, world: MillWorld, total: Array) -> Array:
        """Tangential, radial, axial edge forces that grow, each its own."""
        del total
        u = world.cut.engaged_s / (world.cut.end_s - world.cut.begin_s)
        grown = (1.0 - self.bent) * u + self.bent * np.sqrt(u)
        return np.asarray(world.of(edge_N_mm=np.full(3, 100.0)).courses[1] * grown)

    def part(self, world: MillWorld, total: Array, size: float) -> Array:
        """Its columns times size and shares."""
        columns = self.columns(world, total)
        return np.asarray(size * np.tensordot(np.array(self.shares), columns, axes=1))


@dataclass(frozen=True)
class ScaledForce(MillEffect):
    """A change of the cutting force by a share (n,) that follows from time, place or force."""

    share: Callable[[MillWorld], Array]

    def columns(self, world: MillWorld, total: Array) -> Array:
        """The share of the force, without what sensors add."""
        del total
        return np.asarray(self.share(world) * world.base)[None]


@dataclass(frozen=True)
class HardStretch(ScaledForce):
    """A stretch of other material, with soft ends."""

    between: tuple[float, float]
    term = "hard_spot"
    stage = 1

    def interval(self, world: MillWorld) -> tuple[float, float] | None:
        """When it begins and ends."""
        del world
        return self.between


@dataclass(frozen=True)
class GivesWay(ScaledForce):
    """Tool or work gives way: the relative error grows with the force."""

    term = "deflection"
    stage = 2


@dataclass(frozen=True)
class Banded(ScaledForce):
    """The force depends on the place along the work: no identifier stands for that."""

    term = "unknown"
    stage = 1


def giving_way(world: MillWorld, *, half: float) -> Array:
    """-u, u = F/F_max, or F/(F + half F_max), F across the tool."""
    across = np.hypot(world.base[0], world.base[1])
    u = across / max(float(np.max(across)), 1e-9)
    return np.asarray(-u / (u + half) if half else -u)


def within_stretch(world: MillWorld, *, between: tuple[float, float], soft: float) -> Array:
    """1 inside, rising over a share of the stretch at both ends."""
    first, last = between
    u = (world.cut.t_s - first) / (last - first)
    rise = np.clip(np.minimum(u, 1.0 - u) / soft, 0.0, 1.0)
    return np.asarray(rise**2 * (3.0 - 2.0 * rise))


def bands(world: MillWorld, *, period_mm: float, phase: float) -> Array:
    """A wave with a little of its double along the slide."""
    angle = 2.0 * np.pi * world.cut.x_mm / period_mm + phase
    return np.asarray(np.sin(angle) + 0.3 * np.sin(2.0 * angle))


@dataclass(frozen=True)
class Chatter(MillEffect):
    """A tone that wanders a little in phase, in the work only; the size is N."""

    frequency_Hz: float
    phase: Callable[[Array], Array]
    rises: float
    ways: tuple[complex, complex, complex]
    term = "chatter"

    def most(self, world: MillWorld) -> float:
        """60 % of the largest force."""
        return 0.6 * float(np.max(np.abs(world.base)))

    def tone(self, world: MillWorld) -> Array:
        """Return cosine and sine (2, n)."""
        cut = world.cut
        u = cut.engaged_s / (cut.end_s - cut.begin_s)
        course = cut.engaged * (1.0 - self.rises + self.rises * u)
        angle = 2.0 * np.pi * self.frequency_Hz * cut.t_s + self.phase(cut.t_s)
        return np.asarray(course * np.array([np.cos(angle), np.sin(angle)]))

    def columns(self, world: MillWorld, total: Array) -> Array:
        """Cosine and sine in each component."""
        del total
        return np.concatenate([components_apart(np.tile(one, (3, 1))) for one in self.tone(world)])

    def part(self, world: MillWorld, total: Array, size: float) -> Array:
        """Each component in its own phase."""
        del total
        cos, sin = self.tone(world)
        ways = np.array(self.ways)[:, None]
        return np.asarray(size * (ways.real * cos + ways.imag * sin), dtype=np.float64)


@dataclass(frozen=True)
class Adds(MillEffect):
    """What a sensor adds to components by a course of time (n,); the size is N."""

    shares: Three
    course: Callable[[MillWorld], Array]

    def most(self, world: MillWorld) -> float:
        """60 % of the largest force."""
        return 0.6 * float(np.max(np.abs(world.base)))

    def columns(self, world: MillWorld, total: Array) -> Array:
        """The course in each component that has a share."""
        del total
        shared = np.array(self.shares)[:, None] != 0.0
        return components_apart(np.where(shared, self.course(world), 0.0))

    def part(self, world: MillWorld, total: Array, size: float) -> Array:
        """The course times size and shares."""
        del total
        return np.asarray(size * np.array(self.shares)[:, None] * self.course(world))


@dataclass(frozen=True)
class LinkDrift(Adds):
    """An offset that follows the clock, also in air."""

    term = "sensor_drift"


@dataclass(frozen=True)
class ChipHeat(Adds):
    """An offset that rises while chips heat the sensor and relaxes when cutting stops."""

    term = "thermal_drift"


@dataclass(frozen=True)
class Hum(Adds):
    """A hum of the mains, also in air: no identifier stands for it."""

    term = "unknown"


def warming_in_work(world: MillWorld, *, seconds: float) -> Array:
    """First order towards 1 in the work, towards 0 outside."""
    cut = world.cut
    begun = np.clip(cut.t_s - cut.begin_s, 0.0, None)
    ended = np.clip(cut.t_s - cut.end_s, 0.0, None)
    rise = -np.expm1(-begun / seconds)
    return np.asarray(rise + np.expm1(-ended / seconds) * (ended > 0.0))


@dataclass(frozen=True)
class LinkGain(MillEffect):
    """One component's constant is another, or changes while it is recorded."""

    shares: Three
    clock: Callable[[Array], Array]
    term = "gain"
    stage = 3

    def columns(self, world: MillWorld, total: Array) -> Array:
        """The component times a course of time."""
        u = world.cut.t_s / world.cut.t_s[-1]
        return components_apart(
            np.where(np.array(self.shares)[:, None] != 0.0, total * self.clock(u), 0.0)
        )

    def part(self, world: MillWorld, total: Array, size: float) -> Array:
        """Its column times size and sign."""
        return np.asarray(size * sum(self.shares) * self.columns(world, total)[0])


@dataclass(frozen=True)
class CrossTalk(MillEffect):
    """A component takes a share of another."""

    shares: tuple[float, ...]  # of x from y and z, y from x and z, z from x and y
    term = "crosstalk"
    stage = 3

    def columns(self, world: MillWorld, total: Array) -> Array:
        """Each component in each other."""
        del world
        made = np.zeros((6, *total.shape))
        pairs = [(i, j) for i in range(3) for j in range(3) if i != j]
        for k, (i, j) in enumerate(pairs):
            made[k, i] = total[j]
        return made

    def part(self, world: MillWorld, total: Array, size: float) -> Array:
        """Its columns times size and shares."""
        return np.asarray(size * np.tensordot(self.shares, self.columns(world, total), axes=1))
