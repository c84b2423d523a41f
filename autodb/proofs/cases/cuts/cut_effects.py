"""Effects on cutting forces, per cut: forms and ranges are *chosen*, none is a plain textbook one.

Parts are (3, n), N. Shares of the components are drawn with each effect.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from autodb.proofs.cases.base.build import Hidable
from autodb.proofs.cases.base.case import Array
from autodb.proofs.cases.cuts.cuts import CaseCuts, CutWorld

Shares = tuple[float, float, float]
EVEN: Shares = (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class CutEffect(Hidable[CutWorld]):
    """An effect that takes ``shares`` of its size in x, y and z; with free ones, three columns."""

    shares: Shares

    def most(self, world: CutWorld) -> float:
        """60 % of the force."""
        del world
        return 0.6

    def course(self, world: CutWorld, total: Array) -> Array:
        """What it adds (3, n) at size 1 with even shares."""
        raise NotImplementedError

    def part(self, world: CutWorld, total: Array, size: float) -> Array:
        """Its course times size and shares."""
        part: Array = size * np.array(self.shares)[:, None] * self.course(world, total)
        return part

    def columns(self, world: CutWorld, total: Array) -> Array:
        """A column for each component."""
        return components_apart(self.course(world, total))


def components_apart(course: Array) -> Array:
    """Columns (k, 3, n) of one component each, of those components that are not all zero."""
    columns = np.eye(3)[:, :, None] * course
    return np.asarray(columns[np.any(course != 0.0, axis=1)], dtype=np.float64)


@dataclass(frozen=True)
class EdgeForceLeftOut(CutEffect):
    """The edge force that the law has and the simulation lacks; its size is E of y, N/mm."""

    term = "edge_force"
    own = True

    def most(self, world: CutWorld) -> float:
        """300 N/mm."""
        del world
        return 300.0

    def on(self, world: CutWorld, size: float) -> CutWorld:
        """An edge force of this size."""
        return world.of(edge_N_mm=size * np.array(self.shares), edged=True)

    def course(self, world: CutWorld, total: Array) -> Array:
        """Length of edge that ploughs."""
        del total
        return np.tile(world.edge_mm, (3, 1))


@dataclass(frozen=True)
class Relative(CutEffect):
    """A change of the force, or of its shear part, by a share that follows from the cut."""

    share: Callable[[CaseCuts], Array]
    shear: bool

    def course(self, world: CutWorld, total: Array) -> Array:
        """The share of what it changes."""
        changed = world.parts["shear"] if self.shear else total
        return self.share(world.cuts) * changed


@dataclass(frozen=True)
class SizeEffect(Relative):
    """The specific force rises as the chip thins."""

    term = "size_effect"
    stage = 1

    def most(self, world: CutWorld) -> float:
        """2.5 times at no thickness; at the thinnest cuts about twice."""
        del world
        return 1.5


def thinning(cuts: CaseCuts, *, thin_mm: float, fades: bool) -> Array:
    """Exponential, or 1/(1 + h/h1)."""
    u = cuts.feed_mm / thin_mm
    share: Array = np.exp(-u) if fades else 1.0 / (1.0 + u)
    return share


@dataclass(frozen=True)
class SpeedSoftening(Relative):
    """The shear part falls with speed, ever."""

    term = "speed_softening"
    stage = 1


def softer(cuts: CaseCuts, *, at_m_min: float, wide: float) -> Array:
    """-tanh of the logarithm of speed over ``wide``; of 0: -v/(v + v_h)."""
    v = cuts.speed_m_min
    share: Array = -np.tanh(np.log(v / at_m_min) / wide) if wide else -v / (v + at_m_min)
    return share


@dataclass(frozen=True)
class BuiltUpEdge(Relative):
    """A built-up edge changes rake and force in a band of speeds, and vanishes on both sides."""

    term = "built_up_edge"
    stage = 1


def band(cuts: CaseCuts, *, at_m_min: float, wide: float, ends: bool) -> Array:
    """-1/cosh^2 of the logarithm of speed over ``wide``, or -(1 - u^2)^2 that ends at u = 1."""
    u = np.log(cuts.speed_m_min / at_m_min) / wide
    inside: Array = np.clip(1.0 - (u / 1.8) ** 2, 0.0, None) ** 2 if ends else np.cosh(u) ** -2.0
    return -inside


@dataclass(frozen=True)
class ToolWear(CutEffect):
    """Force per depth that grows with the cutting time on the edge, at a rate of each edge.

    The size is the growth of the tangential force at the end of an edge's life over E = 100 N/mm.
    """

    life_s: float
    rates: tuple[float, ...]
    stages: bool
    term = "tool_wear"

    def most(self, world: CutWorld) -> float:
        """300 N/mm."""
        del world
        return 3.0

    def course(self, world: CutWorld, total: Array) -> Array:
        """Three stages 0.2 (1 - e^(-12 u)) + 0.5 u + 0.3 u^5, or 0.3 u^0.5 + 0.1 (e^(2 u) - 1)."""
        del total
        cuts = world.cuts
        rate = np.array(self.rates)[cuts.edge.astype(np.intp) % len(self.rates)]
        u = rate * (cuts.used_s + 0.5 * cuts.duration_s) / self.life_s
        three = -0.2 * np.expm1(-12.0 * u) + 0.5 * u + 0.3 * u**5
        worn = three if self.stages else 0.3 * np.sqrt(u) + 0.1 * np.expm1(2.0 * u)
        return np.tile(100.0 * cuts.depth_mm * worn, (3, 1))


@dataclass(frozen=True)
class HardSpot(CutEffect):
    """A run of cuts in other material: an even run with soft ends, or a hump."""

    first: int
    last: int
    hump: bool
    term = "hard_spot"
    stage = 1

    def most(self, world: CutWorld) -> float:
        """As much force again."""
        del world
        return 1.0

    def course(self, world: CutWorld, total: Array) -> Array:
        """A share of the whole force; cut numbers count from 1."""
        number = np.arange(1, world.cuts.t_s.size + 1)
        inside = (number >= self.first) & (number <= self.last)
        u = (number - self.first + 0.5) / (self.last - self.first + 1)
        even = np.where((number == self.first) | (number == self.last), 0.7, 1.0)
        return inside * (np.sin(np.pi * np.clip(u, 0.0, 1.0)) if self.hump else even) * total

    def interval(self, world: CutWorld) -> tuple[float, float] | None:
        """First and last cut."""
        del world
        return float(self.first), float(self.last)


@dataclass(frozen=True)
class DepthError(CutEffect):
    """The real depth differs by a size in mm, the same in every cut or growing a little."""

    grows: float  # share that it gains over the table
    term = "depth_error"
    stage = 2

    def most(self, world: CutWorld) -> float:
        """0.3 mm."""
        del world
        return 0.3

    def course(self, world: CutWorld, total: Array) -> Array:
        """Force is proportional to depth."""
        u = world.cuts.t_s / world.cuts.t_s[-1]
        share: Array = (1.0 + self.grows * u) / world.cuts.depth_mm
        return total * share


@dataclass(frozen=True)
class NoseRadius(CutEffect):
    """A shallow cut sits on the nose: the thrust turns from z to x by an angle, size x course."""

    depth_mm: float
    fades: bool
    term = "nose_radius"
    stage = 2

    def most(self, world: CutWorld) -> float:
        """1 rad at no depth."""
        del world
        return 1.0

    def course(self, world: CutWorld, total: Array) -> Array:
        """For a small angle, e^(-a_p/a_n) or 1/(1 + (a_p/a_n)^2)."""
        u = world.cuts.depth_mm / self.depth_mm
        angle = np.exp(-u) if self.fades else 1.0 / (1.0 + u**2)
        return np.array([angle * total[2], np.zeros_like(u), -angle * total[0]])

    def part(self, world: CutWorld, total: Array, size: float) -> Array:
        """The thrust turned: its length stays."""
        turned = self.course(world, total)[0] / total[2]
        x, _, z = total
        cos, sin = np.cos(size * turned), np.sin(size * turned)
        return np.array([x * cos + z * sin - x, np.zeros_like(x), z * cos - x * sin - z])


@dataclass(frozen=True)
class Deflection(CutEffect):
    """Tool or work gives way: the relative error grows with the force."""

    half_N: float  # the error levels off at about this force; 0: it does not
    term = "deflection"
    stage = 2

    def course(self, world: CutWorld, total: Array) -> Array:
        """-F u; u = F_y over its largest, or F_y/(F_y + half)."""
        y: Array = total[1]
        share = y / (y + self.half_N) if self.half_N else y / np.max(world.base[1])
        return -share * total


@dataclass(frozen=True)
class ForceDrift(CutEffect):
    """The offset of one component's sensor follows the clock; the size is a share of its mean."""

    clock: Callable[[Array], Array]
    term = "sensor_drift"

    def course(self, world: CutWorld, total: Array) -> Array:
        """The mean force of each component times a course of time, 0 to about 1."""
        del total
        u = world.cuts.t_s / world.cuts.t_s[-1]
        mean: Array = np.mean(world.base, axis=1)[:, None]
        return mean * self.clock(u)


@dataclass(frozen=True)
class ForceGain(CutEffect):
    """One component's constant changes in the course of the table.

    A constant factor on one component cannot be told from constants of the law of this component.
    """

    clock: Callable[[Array], Array]
    term = "gain"
    stage = 3

    def most(self, world: CutWorld) -> float:
        """40 %."""
        del world
        return 0.4

    def course(self, world: CutWorld, total: Array) -> Array:
        """The force times a course of time, 0 to 1."""
        return total * self.clock(world.cuts.t_s / world.cuts.t_s[-1])


@dataclass(frozen=True)
class OutlyingCuts(Relative):
    """A change of the force that no identifier stands for."""

    term = "unknown"
    stage = 2


def whip(cuts: CaseCuts, *, power: float) -> Array:
    """The bar bends away from the chuck."""
    return -((cuts.z_mm / 300.0) ** power)


def by_hour(cuts: CaseCuts, *, period_s: float, phase: float) -> Array:
    """Coolant that comes and goes, periodic in time."""
    p = 2.0 * np.pi * cuts.t_s / period_s + phase
    share: Array = np.sin(p) + 0.2 * np.sin(2.0 * p)
    return share


def by_turns(cuts: CaseCuts, *, every: int) -> Array:
    """Two spindles or pallets in turn: every second or third cut is another."""
    return np.where(np.arange(cuts.t_s.size) % every == 0, 1.0, 0.0)
