"""Calibration cuts on both sides of a fold: a weight helps the feed, and a force takes it up.

The range is the load's magnitude, beside a magnetising current: with F_0 the force at which weight
and friction are in balance,

    I_c² = I_a² + (F² − 2 F F_0)/k²,

so that it falls from its value in air, is least at F_0, and is back at 2 F_0 (P1 section 8). Below,
two forces show one range; above, each its own. A line through such cuts is none of either.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.sensing.ranges.forms import MeasuredCuts

Array = NDArray[np.float64]

BETTER = 0.5
"""Share of what a straight line leaves of the squares, below which the fold is taken. Chosen."""
SIDE = 2
"""Cuts on either side of it at least. Chosen."""
CLEAR = 2.0
"""Standard deviations of the range by which a cut is on one side, or above what folds. Chosen."""
TINY_A = 1e-12
"""Range below which it is none, A."""
SETTLED = 1e-12
"""Relative change at which a fit ends."""
MOST_LN = 40.0
"""Of k, in its own unit, the logarithm is at most this, and no less than minus this: along a line
that does not fold every large k is as good."""
STARTS = np.linspace(0.1, 0.9, 9)
"""Quantiles of the forces that are tried as the fold to start from."""


@dataclass(frozen=True)
class Fold:
    """Force up to which a range is that of two forces, and the current up to which it may be."""

    force: float
    current: float


def fold_of(sensed: MeasuredCuts, force: Array) -> Fold | None:
    """Return the fold that cuts (n,) lie on both sides of, or None.

    ``sensed.current``: the rise of the range over the air where that is known, else the range.
    """
    if len(force) < 2 * SIDE + 2:
        return None
    sign = 1.0 if np.median(force) >= 0.0 else -1.0
    along = sign * force
    fits = [_fit(sensed, along, start) for start in np.quantile(along, STARTS)]
    at, gain, magnetising, left = min(fits, key=lambda one: float(one[3] @ one[3]))
    line = np.polyfit(along, sensed.current, 1)
    straight = sensed.current - np.polyval(line, along)
    sd = float(np.sqrt(left @ left / (len(along) - 2)))
    off = (along - at) / gain
    sides = min(int(np.sum(off > CLEAR * sd)), int(np.sum(off < -CLEAR * sd)))
    if at <= 0.0 or sides < SIDE or left @ left > BETTER * (straight @ straight):
        return None
    idle = 0.0 if sensed.air is not None else float(np.hypot(magnetising, at / gain))
    return Fold(sign * 2.0 * at, idle + CLEAR * sd)


def _fit(sensed: MeasuredCuts, along: Array, start: float) -> tuple[float, float, float, Array]:
    """Return F_0, k, the magnetising range where none in air is known, and what is left (n,), A."""
    from scipy.optimize import least_squares

    air = sensed.air
    range_A = sensed.current if air is None else sensed.current + air

    def left(values: Array) -> Array:
        return np.asarray(_range_A(values, along, air) - range_A)

    def slopes(values: Array) -> Array:
        return _slopes(values, along, air)

    spread = max(float(np.ptp(range_A)), 1e-9)
    gain = max(float(np.max(np.abs(along - start))), 1e-9) / spread
    found = least_squares(
        left, (start, np.log(gain), 0.1 * spread), jac=slopes, method="lm",
        x_scale=(gain, 1.0, spread), ftol=SETTLED, xtol=SETTLED, gtol=SETTLED,
    )  # fmt: skip
    return float(found.x[0]), _gain(found.x[1]), float(found.x[2]), found.fun


def _gain(ln_gain: float) -> float:
    return float(np.exp(np.clip(ln_gain, -MOST_LN, MOST_LN)))


def _range_A(values: Array, along: Array, air: Array | None) -> Array:
    """Return the ranges (n,) of forces at F_0, ln k and the magnetising range."""
    at, gain, magnetising = values[0], _gain(values[1]), values[2]
    if air is None:
        return np.asarray(np.hypot(magnetising, (along - at) / gain))
    square = air**2 + along * (along - 2.0 * at) / gain**2
    return np.asarray(np.sqrt(np.maximum(square, 0.0)))


def _slopes(values: Array, along: Array, air: Array | None) -> Array:
    """Return the derivatives (n, 3) of the ranges."""
    at, gain, magnetising = values[0], _gain(values[1]), values[2]
    by = np.zeros((len(along), 3))
    moves = abs(values[1]) < MOST_LN
    whole = np.maximum(_range_A(values, along, air), TINY_A)
    if air is None:
        off = (along - at) / gain
        by[:, 0], by[:, 1] = -off / gain / whole, moves * -(off**2) / whole
        by[:, 2] = magnetising / whole
        return by
    seen = whole > TINY_A
    by[:, 0] = seen * -along / gain**2 / whole
    by[:, 1] = moves * seen * -along * (along - 2.0 * at) / gain**2 / whole
    return by
