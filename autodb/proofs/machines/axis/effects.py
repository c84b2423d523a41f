"""Extra effects of a feed axis in air, each one small and named; forms and sizes are *chosen*.

Current A, position mm, speed mm/s. None has the estimators' form.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from autodb.proofs.machines.axis.curves import reversal
from autodb.proofs.machines.axis.motion import TrueMotion
from autodb.proofs.machines.lathe.process import Array


class AxisEffect(Protocol):
    """One more physical effect: a name (term identifier) and its part of the current."""

    @property
    def term(self) -> str:
        """Identifier of the effect in the vocabulary."""

    def part_A(self, motion: TrueMotion, friction_A: Array) -> Array:
        """Contribution at every sample, A, given the motion and the friction without effects."""


@dataclass(frozen=True)
class AxisExternalLoad:
    """A load that no motion explains, in an interval with smooth edges."""

    start_s: float
    stop_s: float
    size_A: float
    edge_s: float = 0.15
    term: str = "external_load"

    def part_A(self, motion: TrueMotion, friction_A: Array) -> Array:  # noqa: ARG002
        """Size x logistic rise x logistic fall."""
        rise = np.tanh((motion.t - self.start_s) / self.edge_s)
        fall = np.tanh((motion.t - self.stop_s) / self.edge_s)
        return 0.5 * self.size_A * (rise - fall)


@dataclass(frozen=True)
class PositionFriction:
    """Friction that grows with position beyond a place, the same in both directions."""

    slope_A_mm: float
    from_mm: float = 300.0
    bend_mm: float = 15.0
    term: str = "position_friction"

    def part_A(self, motion: TrueMotion, friction_A: Array) -> Array:  # noqa: ARG002
        """sgn(v) g(x), g = slope x bend x ln(1 + e^((x - x0)/bend)); 0 at standstill."""
        rise_mm = self.bend_mm * np.logaddexp(0.0, (motion.x - self.from_mm) / self.bend_mm)
        return self.slope_A_mm * rise_mm * reversal(motion.v, 0.25)


@dataclass(frozen=True)
class AxisCogging:
    """A force of the motor periodic in position, the same sign in both directions."""

    amplitude_A: float
    period_mm: float
    phase_rad: float = 0.7
    second: float = 0.15  # share of the second harmonic
    term: str = "cogging"

    def part_A(self, motion: TrueMotion, friction_A: Array) -> Array:  # noqa: ARG002
        """Amplitude x (sin + share of the second harmonic)."""
        angle = 2.0 * np.pi * motion.x / self.period_mm + self.phase_rad
        return self.amplitude_A * (np.sin(angle) + self.second * np.sin(2.0 * angle))


@dataclass(frozen=True)
class AxisWarmup:
    """Friction falls as the lubricant warms by friction work, and recovers at rest."""

    drop: float
    time_constant_s: float = 20.0
    half_mm_s: float = 15.0  # speed at which warming runs at half pace
    term: str = "warmup"

    def part_A(self, motion: TrueMotion, friction_A: Array) -> Array:
        """-drop x w x friction; T dw/dt = q (1 - w) - (1 - q) w/4, w(0) = 0.

        q = |v|/(|v| + v_half) is the pace of warming, the lubricant cools at a quarter of it.
        """
        heat = np.abs(motion.v) / (np.abs(motion.v) + self.half_mm_s)
        step = np.diff(motion.t, prepend=motion.t[0]) / self.time_constant_s
        warm = np.empty_like(heat)
        level = 0.0
        for i, (gain, share) in enumerate(zip(heat, step, strict=True)):
            level += share * (gain * (1.0 - level) - 0.25 * (1.0 - gain) * level)
            warm[i] = level
        return -self.drop * warm * friction_A
