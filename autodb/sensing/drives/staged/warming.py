"""Stage four: how friction falls as the axis warms, from passes repeated at one speed (P2 IV)."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from autodb.fitting import linear
from autodb.fitting.groups import small_sample
from autodb.sensing.drives.fit.thermal import lost
from autodb.sensing.drives.staged.clusters import within
from autodb.terms.warming import WARMUP, warmth

Array = NDArray[np.float64]
Numbers = NDArray[np.intp]

FEWEST_PASSES = 12
"""Passes of levels that were repeated, which tell warming. Chosen."""
RUNS = 4
"""Runs that the passes are taken for, within which what they leave is alike: P2's three and its
cycles. So many tell how runs differ, as Student's t counts them."""
LEAST_DROP = 1e-3
"""Drop below which no time constant shows. Chosen: a tenth of a percent of friction."""
STEP = 1e-3
"""Relative step of a derivative."""


@dataclass(frozen=True)
class WarmingDrop:
    """Drop at 10 000 mm/min, time constant s, and their covariance (2, 2)."""

    drop: float
    time_constant_s: float
    covariance: Array

    def lost(self, inputs: Mapping[str, Array]) -> Array:
        """Return the share of friction lost in each row (n,)."""
        return _lost(self._values, inputs)

    def slopes(self, inputs: Mapping[str, Array]) -> Array:
        """Return the derivatives (n, 2) of that share by drop and time constant."""
        here = self._values
        return np.column_stack(
            [
                (_lost(here + step, inputs) - _lost(here - step, inputs)) / (2.0 * step.sum())
                for step in np.diag(STEP * here)
            ]
        )

    def sd(self, slopes: Array) -> Array:
        """Return the sd (n,) of what has these derivatives (n, 2)."""
        variance = np.einsum("ij,jk,ik->i", slopes, self.covariance, slopes)
        return np.asarray(np.sqrt(np.maximum(variance, 0.0)))

    @property
    def _values(self) -> Array:
        return np.array([self.drop, self.time_constant_s])


def _lost(at: Array, inputs: Mapping[str, Array]) -> Array:
    """Return the share lost in each row (n,) at a drop and a time constant: P2's line, (2,)."""
    shape = {"drop": float(at[0]), "time_constant": float(at[1]), "levelling": 0.0}
    return lost(shape, inputs)


def warming_of(
    group: Numbers, friction: Array, middle: Numbers, inputs: Mapping[str, Array]
) -> WarmingDrop | None:
    """Return the warming that passes (n,) in time show; None where too few were repeated.

    ``group`` (n,): passes alike but for warmth, ``middle`` (n,) the row amid each. The logarithm of
    friction, less its mean over the group, follows ln(1 − drop · w), w as the term has it. Errors
    of passes are alike within RUNS equal parts of them (Newey and West 1987). A time constant as
    long as the recording, or of a drop of nothing, is held: only their ratio shows.
    """
    names, at, count = np.unique(group, return_inverse=True, return_counts=True)
    kept = (count[at] > 1) & (friction > 0)
    if kept.sum() < FEWEST_PASSES:
        return None
    of, rows = at[kept], middle[kept]
    target = within(np.log(friction[kept]), of)

    def left(values: NDArray[np.float64]) -> Array:
        warm = warmth(inputs["t"], inputs["velocity"], time_constant_s=float(np.exp(values[1])))
        return within(np.log1p(-values[0] * warm[rows]), of) - target

    drop, time = WARMUP.shape[:2]
    longest_s = min(time.upper, max(float(np.ptp(inputs["t"])), 2.0 * time.starts[0]))
    bounds = ([drop.lower, np.log(time.lower)], [drop.upper, np.log(longest_s)])
    found = [
        least_squares(left, [drop.starts[0], np.log(start)], bounds=bounds)
        for start in time.starts
        if start < longest_s
    ]
    best = min(found, key=lambda one: float(one.cost))
    jacobian = np.asarray(best.jac) / np.array([1.0, np.exp(best.x[1])])
    held = np.any(best.active_mask) or best.x[0] < LEAST_DROP
    free = [0] if held else [0, 1]
    fit = linear.least_squares(jacobian[:, free], left(best.x), lags=len(rows) // RUNS)
    few = small_sample(RUNS - 1) * len(rows) / max(1, len(rows) - len(names) - 2)
    covariance = np.zeros((2, 2))
    covariance[np.ix_(free, free)] = fit.covariance * few
    return WarmingDrop(float(best.x[0]), float(np.exp(best.x[1])), covariance)
