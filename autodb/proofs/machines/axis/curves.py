"""Friction against speed: its reversal, and the curves of drawn axes, none an estimator's.

A curve's speed is >= 0, mm/s; its value is a share. Viscous curves are 0 at 0 and 1 at STATED_MM_S,
none of them is a straight line; dips are 1 at 0 and fade. Plain exp(-v/v_s) and exp(-(v/v_s)^2) are
not drawn: they are Stribeck's law, which estimators fit.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from autodb.proofs.machines.lathe.process import Array

STATED_MM_S = 150.0  # speed at which a viscous curve is 1; chosen


def reversal(v: Array, width_mm_s: float) -> Array:
    """Smooth direction of motion: v/sqrt(v^2 + w^2), 0 at standstill."""
    return v / np.hypot(v, width_mm_s)


class FrictionCurve(Protocol):
    """A share of a friction level as a function of speed."""

    def share(self, speed_mm_s: Array) -> Array:
        """Value at each speed."""


@dataclass(frozen=True)
class TableCurve:
    """Straight pieces between drawn points, ever less steep."""

    points_mm_s: tuple[float, ...]
    values: tuple[float, ...]

    def share(self, speed_mm_s: Array) -> Array:
        """Interpolated, divided by the value at STATED_MM_S."""
        points, values = self.points_mm_s, self.values
        return np.interp(speed_mm_s, points, values) / np.interp(STATED_MM_S, points, values)


@dataclass(frozen=True)
class RationalCurve:
    """Friction that levels off: v/(v + v_h)."""

    half_mm_s: float

    def share(self, speed_mm_s: Array) -> Array:
        """(v/(v + v_h)) / (V/(V + v_h)), V = STATED_MM_S."""
        whole = STATED_MM_S / (STATED_MM_S + self.half_mm_s)
        return speed_mm_s / (speed_mm_s + self.half_mm_s) / whole


@dataclass(frozen=True)
class LogCurve:
    """The logarithmic part of P2's friction law, P5 ln(|v|/P6 + 1)."""

    bend_mm_s: float

    def share(self, speed_mm_s: Array) -> Array:
        """ln(v/P6 + 1)/ln(V/P6 + 1), V = STATED_MM_S."""
        whole = float(np.log1p(STATED_MM_S / self.bend_mm_s))
        share: Array = np.log1p(speed_mm_s / self.bend_mm_s) / whole
        return share


@dataclass(frozen=True)
class PowerCurve:
    """A power of speed below one."""

    exponent: float

    def share(self, speed_mm_s: Array) -> Array:
        """(v/V)^n, V = STATED_MM_S."""
        share: Array = (speed_mm_s / STATED_MM_S) ** self.exponent
        return share


@dataclass(frozen=True)
class GaussianDip:
    """A Gaussian of the logarithm of speed: it fades more slowly than any Stribeck law."""

    fade_mm_s: float

    def share(self, speed_mm_s: Array) -> Array:
        """exp(-ln(1 + v/v_f)^2)."""
        share: Array = np.exp(-(np.log1p(speed_mm_s / self.fade_mm_s) ** 2))
        return share


@dataclass(frozen=True)
class RationalDip:
    """Half of it is gone at the fading speed."""

    fade_mm_s: float

    def share(self, speed_mm_s: Array) -> Array:
        """1/(1 + (v/v_f)^2)."""
        return 1.0 / (1.0 + (speed_mm_s / self.fade_mm_s) ** 2)


@dataclass(frozen=True)
class ExponentialDip:
    """Flat at creep, an exponential tail: the hyperbolic secant."""

    fade_mm_s: float

    def share(self, speed_mm_s: Array) -> Array:
        """1/cosh(v/v_f)."""
        share: Array = 1.0 / np.cosh(speed_mm_s / self.fade_mm_s)
        return share
