"""Cuts in which a current jumps though the force does not: a start or a rapid inside a row."""

import numpy as np
from numpy.typing import NDArray

from autodb import fitting

Array = NDArray[np.float64]

TRANSIENT_WINDOW = 4
"""Rows on each side that a row is compared with when transients are looked for."""
TRANSIENT_SPREADS = 10.0
"""A row this many robust standard deviations off its neighbours is a transient."""


def transients(current: Array, target: Array, groups: NDArray[np.generic]) -> NDArray[np.bool_]:
    """Return rows in which the current leaves its neighbours while the force does not.

    In each group, in the order of the rows, the residual from a robust line is compared with the
    median over the 2·TRANSIENT_WINDOW + 1 rows around it (Hampel's identifier). A start, a stop or
    a rapid inside a row makes the current jump though the cut goes on. Groups of fewer rows than
    half of that tell nothing.
    """
    _, of, rows = np.unique(groups, return_inverse=True, return_counts=True)
    judged = rows[of.ravel()] > TRANSIENT_WINDOW
    if not judged.any():
        return np.zeros(len(current), dtype=np.bool_)
    c0, c1 = fitting.robust_line(current, target)
    expected = c0 + c1 * current
    jump_current = _off_neighbours(expected, groups)
    jump_target = _off_neighbours(target, groups)
    jump = _off_neighbours(target - expected, groups)
    limit = TRANSIENT_SPREADS * fitting.spread(jump[judged])
    jumps = (np.abs(jump) > limit) & (np.abs(jump_current) > np.abs(jump_target))
    return np.asarray(judged & jumps)


def _off_neighbours(values: Array, groups: NDArray[np.generic]) -> Array:
    off = np.zeros_like(values)
    width = 2 * TRANSIENT_WINDOW + 1
    for group in np.unique(groups):
        own = values[groups == group]
        windows = np.lib.stride_tricks.sliding_window_view(own, min(width, len(own)))
        centre = np.clip(np.arange(len(own)) - TRANSIENT_WINDOW, 0, len(windows) - 1)
        off[groups == group] = own - np.median(windows, axis=1)[centre]
    return off
