"""The published way from current to force: the gate that reference lathes must pass.

P1's own calibration (sections 9, 10): a straight line of force over the range in cut for X and Z;
for the spindle T = a(n) ΔI^b(n), a and b cubic in the speed, apart below and above the base speed.
Where it lands on P1's errors the lathes are as hard as P1's, and other ways may be judged on them.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from autodb.proofs.runs.lathe.lathe_cuts import LatheCuts

Array = NDArray[np.float64]

PUBLISHED_RMSE_N = {"x": 29.0, "spindle": 36.0, "z": 27.0}
"""P1, table 1, prediction by regression: 16, 113 and 180 test cuts."""
BASE_RPM = 1570.0
"""P1, section 6."""
CUBIC = 4
"""Coefficients of a and of b."""


def published_force_N(axis: str, known: LatheCuts, tested: LatheCuts) -> Array:
    """Return the force (n,) that the published calibration senses with an axis on test cuts."""
    return (_spindle_N if axis == "spindle" else _feed_N)(known, tested)


def _feed_N(known: LatheCuts, tested: LatheCuts) -> Array:
    line = np.polyfit(known.range_A, known.force_N, 1)
    return np.asarray(np.polyval(line, tested.range_A), dtype=np.float64)


def _spindle_N(known: LatheCuts, tested: LatheCuts) -> Array:
    law = SpindleLaw.fitted(known.speed_rpm, known.rise_A, known.torque_Nm)
    return 1000.0 * law(tested.speed_rpm, tested.rise_A) / tested.radius_mm


@dataclass(frozen=True)
class SpindleLaw:
    """T = a(n) ΔI^b(n): coefficients of a, then of b, below and above the base speed."""

    below: Array
    above: Array

    @classmethod
    def fitted(cls, rpm: Array, rise_A: Array, torque_Nm: Array) -> "SpindleLaw":
        """Fit both ranges of speed by least squares on the torque."""
        slow = rpm <= BASE_RPM
        return cls(
            *(_power_law(rpm[part], rise_A[part], torque_Nm[part]) for part in (slow, ~slow))
        )

    def __call__(self, rpm: Array, rise_A: Array) -> Array:
        """Return torque (n,); none where the range does not rise."""
        slow = rpm <= BASE_RPM
        return np.where(slow, _torque(self.below, rpm, rise_A), _torque(self.above, rpm, rise_A))


def _torque(law: Array, rpm: Array, rise_A: Array) -> Array:
    krpm = rpm / 1000.0 - BASE_RPM / 1000.0
    scale, exponent = np.polyval(law[:CUBIC], krpm), np.polyval(law[CUBIC:], krpm)
    rise = np.maximum(rise_A, 0.0)
    return np.asarray(scale * np.where(rise > 0, np.maximum(rise, 1e-9) ** exponent, 0.0))


def _power_law(rpm: Array, rise_A: Array, torque_Nm: Array) -> Array:
    b, ln_a = np.polyfit(np.log(rise_A), np.log(torque_Nm), 1)
    start = np.zeros(2 * CUBIC)
    start[CUBIC - 1], start[-1] = np.exp(ln_a), b

    def error(law: Array) -> Array:
        return _torque(law, rpm, rise_A) - torque_Nm

    return np.asarray(least_squares(error, start, x_scale=0.1).x, dtype=np.float64)
