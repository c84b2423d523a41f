"""Stage four: how friction falls as the axis warms, from passes repeated at one speed (P2 IV)."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from autodb import fitting
from autodb.terms.drive import WARMUP, warmth

Array = NDArray[np.float64]
Numbers = NDArray[np.intp]

FEWEST_PASSES = 12
"""Passes of levels that were repeated, which tell warming. Chosen."""
LAGS_SHARE = 0.1
"""Share of the passes over which what a pass leaves is taken as alike. Chosen: a run of P2's is a
quarter of its sweep."""
STEP = 1e-3


@dataclass(frozen=True)
class Warming:
    """Drop at 10 000 mm/min, time constant s, and their covariance (2, 2)."""

    drop: float
    time_constant_s: float
    covariance: Array

    def factor(self, inputs: Mapping[str, Array]) -> Array:
        """Return by what friction is multiplied in each row (n,)."""
        return _factor(self.drop, self.time_constant_s, inputs)

    def loss(self, inputs: Mapping[str, Array]) -> tuple[float, float]:
        """Return the share of friction lost when the axis was warmest, and its sd."""
        at = np.array([self.drop, self.time_constant_s])
        slope = [
            (_lost(at + step, inputs) - _lost(at - step, inputs)) / (2.0 * step.sum())
            for step in np.diag(STEP * at)
        ]
        sd = float(np.sqrt(max(0.0, np.array(slope) @ self.covariance @ np.array(slope))))
        return _lost(at, inputs), sd


def _factor(drop: float, time_constant_s: float, inputs: Mapping[str, Array]) -> Array:
    made: Array = WARMUP.function(
        inputs["t"], inputs["velocity"], drop=drop, time_constant_s=time_constant_s, levelling=0.0
    )
    return made


def _lost(at: Array, inputs: Mapping[str, Array]) -> float:
    return 1.0 - float(_factor(float(at[0]), float(at[1]), inputs).min())


def warming_of(
    group: Numbers, friction: Array, middle: Numbers, inputs: Mapping[str, Array]
) -> Warming | None:
    """Return the warming that passes (n,) in time show; None where too few were repeated.

    ``group`` (n,): passes alike but for warmth, ``middle`` (n,) the row amid each. The logarithm of
    friction, less its mean over the group, follows ln(1 − drop · w), w as the term has it. Errors
    of passes are alike over LAGS_SHARE of them (Newey and West 1987).
    """
    names, at, count = np.unique(group, return_inverse=True, return_counts=True)
    kept = (count[at] > 1) & (friction > 0)
    if kept.sum() < FEWEST_PASSES:
        return None
    of, rows = at[kept], middle[kept]
    target = _within(np.log(friction[kept]), of)

    def left(values: NDArray[np.float64]) -> Array:
        warm = warmth(inputs["t"], inputs["velocity"], time_constant_s=float(np.exp(values[1])))
        return _within(np.log1p(-values[0] * warm[rows]), of) - target

    drop, time = WARMUP.shape[:2]
    bounds = ([drop.lower, np.log(time.lower)], [drop.upper, np.log(time.upper)])
    found = [
        least_squares(left, [drop.starts[0], np.log(start)], bounds=bounds) for start in time.starts
    ]
    best = min(found, key=lambda one: float(one.cost))
    if np.any(best.active_mask):
        return None
    lags = max(1, round(LAGS_SHARE * len(rows)))
    jacobian = np.asarray(best.jac) / np.array([1.0, np.exp(best.x[1])])
    fit = fitting.least_squares(jacobian, left(best.x), lags=lags)
    covariance = fit.covariance * (len(rows) - 2) / max(1, len(rows) - len(names) - 2)
    return Warming(float(best.x[0]), float(np.exp(best.x[1])), covariance)


def _within(values: Array, of: Numbers) -> Array:
    count = np.bincount(of)
    mean = np.bincount(of, values) / np.maximum(count, 1)
    return np.asarray(values - mean[of])
