"""Effects that change friction or the whole current: forms and ranges are *chosen*."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from autodb.proofs.cases.axis.effect import CaseWorld, HiddenEffect
from autodb.proofs.cases.base.moves import RATE_HZ, Array

STEP_S = 0.2  # of the slow integration of warmth


@dataclass(frozen=True)
class HiddenWarmup(HiddenEffect):
    """Friction falls as friction work warms the lubricant, and comes back at rest.

    dw/dt = (q (1 - w) - k (1 - q) w)/T, q = P/(P + P_half), P the friction's power as a share of
    its mean. The size is the drop at full warmth: a share, or what divides (1 + size w).
    """

    time_constant_s: float
    cool: float  # k
    divides: bool
    term = "warmup"
    stage = 1

    def most(self, world: CaseWorld) -> float:
        """A drop of 60 %."""
        del world
        return 0.6

    def part(self, world: CaseWorld, total: Array, size: float) -> Array:
        """Less friction."""
        del total
        warm = self._warmth(world)
        factor = 1.0 / (1.0 + size * warm) if self.divides else 1.0 - size * warm
        return world.friction * (factor - 1.0)

    def columns(self, world: CaseWorld, total: Array) -> Array:
        """For a small drop."""
        del total
        return (-world.friction * self._warmth(world))[None]

    def _warmth(self, world: CaseWorld) -> Array:
        """Warmth 0..1, integrated over STEP_S and straight between."""
        power = np.abs(world.way * world.moves.v)
        count = round(STEP_S * RATE_HZ)
        times, powers = (
            world.moves.t[::count],
            np.add.reduceat(power, np.arange(0, power.size, count)),
        )
        pace = powers / (powers + np.mean(powers))
        warm = np.zeros(times.size)
        gain = STEP_S / self.time_constant_s
        for i in range(1, times.size):
            q, w = pace[i - 1], warm[i - 1]
            warm[i] = w + gain * (q * (1.0 - w) - self.cool * (1.0 - q) * w)
        return np.interp(world.moves.t, times, warm)


@dataclass(frozen=True)
class Presliding(HiddenEffect):
    """After a reversal friction builds up over a short way, and is held at standstill.

    Coulomb friction of direction d becomes s (2 c(u) - 1), s the last direction, u the way since
    the reversal: c = 1 - 1/(1 + u/l)^2, or two Maxwell slips. The size is the share that does so.
    """

    length_mm: float
    slips: bool
    term = "presliding"
    stage = 1

    def most(self, world: CaseWorld) -> float:
        """All of Coulomb friction."""
        del world
        return 1.0

    def columns(self, world: CaseWorld, total: Array) -> Array:
        """What is added if all of it does."""
        del total
        u = world.turned_mm / self.length_mm
        built = 1.0 - 1.0 / (1.0 + u) ** 2
        if self.slips:
            built = 0.6 * np.minimum(u, 1.0) + 0.4 * np.minimum(u / 3.0, 1.0)
        return (world.machine.coulomb_A * (world.held * (2.0 * built - 1.0) - world.way))[None]


@dataclass(frozen=True)
class Backlash(HiddenEffect):
    """Within the gap after a reversal the load side's friction is absent: size is its share."""

    gap_mm: float
    soft: float  # share of the gap over which the step is smooth
    straight: bool
    term = "backlash"
    stage = 1

    def most(self, world: CaseWorld) -> float:
        """All of the friction."""
        del world
        return 1.0

    def columns(self, world: CaseWorld, total: Array) -> Array:
        """What is added if all friction is on the load side."""
        del total
        u = (world.turned_mm / self.gap_mm - 1.0) / self.soft
        taken = np.clip(0.5 + 0.5 * u, 0.0, 1.0) if self.straight else 0.5 + 0.5 * np.tanh(u)
        return (-world.friction * (1.0 - taken))[None]


@dataclass(frozen=True)
class Compliance(HiddenEffect):
    """The load hangs on a spring: its acceleration is not the motor's. Size: its share of inertia.

    a_l/a = (2 z w s + w^2)/(s^2 + 2 z w s + w^2), bilinear at RATE_HZ; a second mode on some.
    """

    hz: float
    damping: float
    second: float  # share of the load on a mode at 1.7 times the frequency
    term = "compliance"
    stage = 1

    def most(self, world: CaseWorld) -> float:
        """Nine tenths of the inertia."""
        del world
        return 0.9

    def columns(self, world: CaseWorld, total: Array) -> Array:
        """What is added if all inertia is the load's."""
        del total
        first, other = (self._load(world, hz) for hz in (self.hz, 1.7 * self.hz))
        load = (1.0 - self.second) * first + self.second * other
        return (world.machine.inertia_A_s2_mm * (load - world.moves.a))[None]

    def _load(self, world: CaseWorld, hz: float) -> Array:
        from scipy.signal import bilinear, lfilter

        w = 2.0 * RATE_HZ * np.tan(np.pi * min(hz, 0.45 * RATE_HZ) / RATE_HZ)
        swing = 2.0 * self.damping * w
        top, bottom = bilinear([swing, w**2], [1.0, swing, w**2], RATE_HZ)
        return np.asarray(lfilter(top, bottom, world.moves.a), dtype=np.float64)


@dataclass(frozen=True)
class ChangedGain(HiddenEffect):
    """Motor or sensor constant changes: everything is multiplied by 1 + size x course(t)."""

    course: Callable[[Array], Array]
    term = "gain"
    stage = 2

    def most(self, world: CaseWorld) -> float:
        """40 %."""
        del world
        return 0.4

    def columns(self, world: CaseWorld, total: Array) -> Array:
        """What is added at a change of 1."""
        return (self.course(world.moves.t) * total)[None]


def drifting(t: Array, *, whole_s: float, power: float) -> Array:
    """From 0 to 1, bent."""
    return (t / whole_s) ** power


def stepping(t: Array, *, at_s: float, wide_s: float) -> Array:
    """A smooth step."""
    return 0.5 + 0.5 * np.tanh((t - at_s) / wide_s)


@dataclass(frozen=True)
class Lag(HiddenEffect):
    """The recording is later or earlier than the simulation, by a size in s."""

    sign: float
    term = "lag"
    stage = 2

    def most(self, world: CaseWorld) -> float:
        """20 ms."""
        del world
        return 0.02

    def part(self, world: CaseWorld, total: Array, size: float) -> Array:
        """The total of a moment before or after, by cubic splines, less that of now."""
        from scipy.interpolate import CubicSpline

        t = world.moves.t
        at = np.clip(t - self.sign * size, t[0], t[-1])
        return np.asarray(CubicSpline(t, total)(at) - total, dtype=np.float64)

    def columns(self, world: CaseWorld, total: Array) -> Array:
        """By 2 and by 10 ms."""
        return np.array([self.part(world, total, size) for size in (0.002, 0.010)])


@dataclass(frozen=True)
class Saturation(HiddenEffect):
    """Clipped at a limit, (1 - size) of the largest value: both ways, or one, hard or softly."""

    sides: tuple[float, ...]  # +1, -1
    knee: float  # share of what is cut off over which it goes over; 0: hard
    term = "saturation"
    stage = 3

    @property
    def on_noise(self) -> bool:
        """A hard limit is one of the record, noise and all."""
        return self.knee == 0.0

    def most(self, world: CaseWorld) -> float:
        """A limit at 30 % of the largest value."""
        del world
        return 0.7

    def part(self, world: CaseWorld, total: Array, size: float) -> Array:
        """Clipped less as it was."""
        clipped = total
        largest = max(float(np.max(side * world.base)) for side in self.sides)
        limit = (1.0 - size) * largest if largest > 0.0 else np.inf
        for side in self.sides:
            over = side * clipped - limit
            wide = self.knee * size * largest
            if wide > 0.0:
                clipped = clipped - side * wide * np.logaddexp(0.0, over / wide)
            else:
                clipped = clipped - side * np.maximum(over, 0.0)
        return np.asarray(clipped - total, dtype=np.float64)

    def columns(self, world: CaseWorld, total: Array) -> Array:
        """At a limit of half the largest value."""
        return self.part(world, total, 0.5)[None]


@dataclass(frozen=True)
class LostSign(HiddenEffect):
    """A magnitude is recorded. Its size lies in the weight: 0 where all is positive anyway.

    The weight is (1 - size) x what makes all of the current positive.
    """

    term = "lost_sign"
    stage = 3

    @property
    def on_noise(self) -> bool:
        """The record's sign is lost, noise and all."""
        return True

    def most(self, world: CaseWorld) -> float:
        """No weight."""
        del world
        return 1.0

    def on(self, world: CaseWorld, size: float) -> CaseWorld:
        """A weight that leaves little to lose."""
        own = world.base - world.parts.get("gravity", np.zeros_like(world.base))
        whole = float(np.max(-own))
        return world.of(weight_A=(1.0 - size) * whole, weighs=True)

    def part(self, world: CaseWorld, total: Array, size: float) -> Array:
        """Twice what is negative."""
        del world, size
        return np.abs(total) - total

    def columns(self, world: CaseWorld, total: Array) -> Array:
        """The same."""
        return self.part(world, total, 1.0)[None]
