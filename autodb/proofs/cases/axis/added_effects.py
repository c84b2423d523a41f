"""Effects that add to the current: forms and ranges are *chosen*, none is a plain textbook one."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from autodb.proofs.cases.axis.effect import CaseWorld, HiddenEffect
from autodb.proofs.cases.base.moves import RATE_HZ, Array

WANDER_TURNS = (0.5, 0.9, 1.5)  # of a slow wander in the whole time


@dataclass(frozen=True)
class HiddenStribeck(HiddenEffect):
    """Friction of low speed: d x falling share of |v|, by a table or 1/(1 + (v/v_f)^n)."""

    fade_mm_s: float
    exponent: float  # 0: by the table
    term = "stribeck"

    def columns(self, world: CaseWorld, total: Array) -> Array:
        """1 at creep; the table is gone at six times the fading speed."""
        del total
        u = np.abs(world.moves.v) / self.fade_mm_s
        if self.exponent:
            return (world.way / (1.0 + u**self.exponent))[None]
        share = np.interp(u, (0.0, 0.4, 1.0, 2.2, 6.0), (1.0, 0.86, 0.5, 0.17, 0.0))
        return (world.way * share)[None]


@dataclass(frozen=True)
class Asymmetry(HiddenEffect):
    """Friction that differs by direction: size x d^2 (Coulomb) mixed with d^2 x viscous share."""

    viscous: float  # share, 0 to 1
    term = "asymmetry"

    def columns(self, world: CaseWorld, total: Array) -> Array:
        """The mixture; zero at standstill."""
        del total
        rise = world.machine.rise(np.abs(world.moves.v))
        return (world.way**2 * (1.0 - self.viscous + self.viscous * rise))[None]


@dataclass(frozen=True)
class FrictionAlong(HiddenEffect):
    """Friction that changes along the travel: d x g(x), g peaking at about 1."""

    place: Callable[[Array], Array]
    term = "position_friction"

    def columns(self, world: CaseWorld, total: Array) -> Array:
        """Zero at standstill, the same g both ways."""
        del total
        return (world.way * self.place(world.moves.x))[None]


def softplus_rise(x: Array, *, from_mm: float, bend_mm: float) -> Array:
    """Softplus: nothing before a place, then rising; 1 at 100 mm beyond it."""
    return bend_mm * np.logaddexp(0.0, (x - from_mm) / bend_mm) / 100.0


def bump(x: Array, *, at_mm: float, wide_mm: float) -> Array:
    """Smooth hump, half of it gone at wide/4 from its middle: 1/cosh^2."""
    share: Array = 1.0 / np.cosh(3.526 * (x - at_mm) / wide_mm) ** 2
    return share


def rippled(x: Array, *, period_mm: float, phase: float, sharp: float) -> Array:
    """Periodic with rounded crests: tanh of a sine."""
    share: Array = np.tanh(sharp * np.sin(2.0 * np.pi * x / period_mm + phase)) / np.tanh(sharp)
    return share


@dataclass(frozen=True)
class Spring(HiddenEffect):
    """A restoring load about a rest that hardens: u (1 + h u^2) or sinh; u is way/200 mm."""

    rest_mm: float
    harden: float  # of the cubic; 0: sinh
    term = "spring"

    def columns(self, world: CaseWorld, total: Array) -> Array:
        """1 at about 200 mm from the rest."""
        del total
        u = (world.moves.x - self.rest_mm) / 200.0
        return (u * (1.0 + self.harden * u**2) if self.harden else np.sinh(1.5 * u) / 2.13)[None]


@dataclass(frozen=True)
class HiddenCogging(HiddenEffect):
    """A motor's force periodic in position: with a second harmonic, or with leaning flanks."""

    period_mm: float
    phase: float
    second: float  # share of the second harmonic; 0: leaning flanks
    second_phase: float
    term = "cogging"

    def columns(self, world: CaseWorld, total: Array) -> Array:
        """sin p + h sin(2 p + q), or the angle of a vector that sin and cos lean."""
        del total
        p = 2.0 * np.pi * world.moves.x / self.period_mm + self.phase
        if self.second:
            return (np.sin(p) + self.second * np.sin(2.0 * p + self.second_phase))[None]
        return (1.9 * np.arctan2(0.5 * np.sin(p), 1.0 - 0.5 * np.cos(p)))[None]


@dataclass(frozen=True)
class CrossCoupling(HiddenEffect):
    """Another axis' acceleration, sensed through the frame: a first-order lag or a moving mean."""

    cutoff_hz: float  # 0: mean over `mean` samples
    mean: int
    term = "cross_coupling"

    def columns(self, world: CaseWorld, total: Array) -> Array:
        """1 at an acceleration of 1 m/s^2 that lasts."""
        from scipy.signal import lfilter

        del total
        if self.cutoff_hz:
            stays = np.exp(-2.0 * np.pi * self.cutoff_hz / RATE_HZ)
            slow = lfilter([1.0 - stays], [1.0, -stays], world.moves.y_a)
        else:
            slow = lfilter(np.ones(self.mean) / self.mean, [1.0], world.moves.y_a)
        return np.asarray(slow, dtype=np.float64)[None] / 1000.0


@dataclass(frozen=True)
class HiddenExternalLoad(HiddenEffect):
    """A load in a stretch that no motion explains: a cut that grows a little, or a push."""

    start_s: float
    stop_s: float
    edge_s: float
    lean: float  # growth over the stretch; of a push 0
    push: bool
    term = "external_load"

    def columns(self, world: CaseWorld, total: Array) -> Array:
        """Ramps and a slope between them, or half a sine wave to a power below one."""
        del total
        t = world.moves.t
        u = np.clip((t - self.start_s) / (self.stop_s - self.start_s), 0.0, 1.0)
        if self.push:
            return np.sin(np.pi * u)[None] ** 0.5
        rise = np.clip((t - self.start_s) / self.edge_s, 0.0, 1.0)
        fall = np.clip((self.stop_s - t) / self.edge_s, 0.0, 1.0)
        return (rise * fall * (1.0 + self.lean * (u - 0.5)))[None]

    def interval(self, world: CaseWorld) -> tuple[float, float] | None:
        """From the first to the last of it, s."""
        del world
        return self.start_s, self.stop_s


@dataclass(frozen=True)
class SensorDrift(HiddenEffect):
    """An offset that follows the clock, whatever the axis does."""

    course: Callable[[Array], Array]
    term = "sensor_drift"

    def columns(self, world: CaseWorld, total: Array) -> Array:
        """1 at its largest, about."""
        del total
        return self.course(world.moves.t)[None]


def exponential_settling(t: Array, *, time_constant_s: float) -> Array:
    """Exponential settling."""
    return -np.expm1(-t / time_constant_s)


def root(t: Array, *, whole_s: float) -> Array:
    """As the square root of time, as heat goes into a wall."""
    return np.sqrt(t / whole_s)


def wander(t: Array, *, whole_s: float, phases: tuple[float, float, float]) -> Array:
    """Three slow waves of half to one and a half turns in the whole time."""
    waves = [
        np.sin(2.0 * np.pi * n * t / whole_s + phase) / n**0.5
        for n, phase in zip(WANDER_TURNS, phases, strict=True)
    ]
    return np.asarray(np.sum(waves, axis=0) / 2.0, dtype=np.float64)


@dataclass(frozen=True)
class AnyCogging(HiddenEffect):
    """Cogging of one period at any phase, with any second harmonic."""

    period_mm: float
    term = "cogging"

    def columns(self, world: CaseWorld, total: Array) -> Array:
        """Sine and cosine, twice."""
        del total
        return _waves(2.0 * np.pi * world.moves.x / self.period_mm, (1, 2))


@dataclass(frozen=True)
class AnyRippled(HiddenEffect):
    """Friction of one period along the travel at any phase, with any third harmonic."""

    period_mm: float
    term = "position_friction"

    def columns(self, world: CaseWorld, total: Array) -> Array:
        """Direction times sine and cosine, twice."""
        del total
        return world.way * _waves(2.0 * np.pi * world.moves.x / self.period_mm, (1, 3))


def _waves(angle: Array, orders: tuple[int, ...]) -> Array:
    return np.array([wave(order * angle) for order in orders for wave in (np.sin, np.cos)])


@dataclass(frozen=True)
class OddEffect(HiddenEffect):
    """A load or friction that no identifier stands for: some function of all the moves."""

    law: Callable[[CaseWorld], Array]
    term = "unknown"

    def columns(self, world: CaseWorld, total: Array) -> Array:
        """1 at its largest, about."""
        del total
        return self.law(world)[None]


def corner(world: CaseWorld, *, at_mm: float, wide_mm: float, at_mm_s: float) -> Array:
    """Friction in one corner of place x speed only."""
    near = 1.0 / np.cosh((world.moves.x - at_mm) / wide_mm)
    return (
        world.way * near * np.exp(-((np.log((np.abs(world.moves.v) + 0.1) / at_mm_s) / 0.6) ** 2))
    )


def pump(world: CaseWorld, *, hz: float, phase: float) -> Array:
    """A load periodic in time: a pump that pulsates."""
    p = 2.0 * np.pi * hz * world.moves.t + phase
    return np.sin(p) + 0.3 * np.sin(2.0 * p)


def friction_across(world: CaseWorld, *, wide_mm: float, power: float) -> Array:
    """Friction that depends on where the other axis stands."""
    u = (world.moves.y - np.min(world.moves.y)) / wide_mm
    friction: Array = world.way * u**power
    return friction


def load_across(world: CaseWorld, *, wide_mm: float, power: float) -> Array:
    """A load that depends on where the other axis stands; its mean would be a weight: none."""
    u = (world.moves.y - np.min(world.moves.y)) / wide_mm
    load: Array = np.tanh(u**power)
    return load - np.mean(load)


def place_and_speed(world: CaseWorld, *, from_mm: float, mm_s: float) -> Array:
    """A load that is place times speed, the same either way; its mean would be a weight: none."""
    load = (world.moves.x - from_mm) / 200.0 * np.tanh(np.abs(world.moves.v) / mm_s)
    return load - np.mean(load)
