"""Stretches of stamps with one rate each."""

from itertools import pairwise

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from autodb.timing.steps import common_step

Array = NDArray[np.float64]

BLOCK = 50
"""Rows over which a rate is measured. Chosen."""
APART = 0.1
"""Share by which two rates differ at least: less is a clock that wanders. Chosen."""
LASTS = 4
"""Blocks that a rate lasts at least. Chosen."""
GAP = 5.0
"""Times the mean of a block's steps that one of them may be: more is a gap. Chosen."""
CLEAN = 0.8
"""Share of a block's steps that are its median, within 2 %. Chosen."""


def runs_of_one_rate(t_s: Array) -> list[slice]:
    """Return the stretches of stamps (n,), none falling, over which the rate is the same.

    A block's rate is that of most of its steps, or of all of them where they are rough.
    """
    count = (len(t_s) - 1) // BLOCK
    if count < 2 * LASTS:
        return [slice(0, len(t_s))]
    ahead = np.diff(t_s)
    ahead = ahead[ahead > 0]
    if not ahead.size or common_step(ahead):
        return [slice(0, len(t_s))]
    steps = np.diff(t_s)[: count * BLOCK].reshape(count, BLOCK)
    middle, mean = np.median(steps, axis=1), np.mean(steps, axis=1)
    clean = np.mean(np.abs(steps - middle[:, None]) <= 0.02 * middle[:, None], axis=1) >= CLEAN
    own = np.where(clean, middle, mean)
    whole = steps.max(axis=1) <= GAP * mean + steps.max(axis=1) * clean
    known = np.flatnonzero(whole & (own > 0))
    if len(known) < CLEAN * count:
        return [slice(0, len(t_s))]
    turns = _turns(np.log(own[known]))
    if len(turns) == 1:
        return [slice(0, len(t_s))]
    borders = [0, *(_border(np.diff(t_s), own, known, k) for k in turns[1:]), len(t_s)]
    return [slice(a, b) for a, b in pairwise(borders)]


def _turns(rate: Array) -> list[int]:
    """Return the blocks (k,) at which another rate begins, logarithms (n,) each; the first is 0."""
    turns = [0]
    if np.ptp(rate) <= np.log1p(APART):
        return turns
    ahead = sliding_window_view(rate, LASTS)
    after = np.median(ahead, axis=1)
    lasts = np.all(np.abs(ahead - after[:, None]) < 0.5 * np.log1p(APART), axis=1)
    for k in (int(block) for block in np.flatnonzero(lasts)):
        long = k - turns[-1] >= LASTS
        if long and _another(float(after[k] - np.median(rate[turns[-1] : k]))):
            turns.append(k)
    return turns


def _another(apart: float) -> bool:
    """Say whether steps whose logarithms are so far apart are of two rates.

    A whole number of times as long they are those of rows that are missing.
    """
    times = np.exp(abs(apart))
    return bool(times > 1.0 + APART and abs(times / np.round(times) - 1.0) > 0.02)


def _border(steps: Array, middle: Array, known: NDArray[np.intp], k: int) -> int:
    """Return the row at which the rate of block ``known[k]`` begins."""
    block = int(known[k])
    begin = max(0, (int(known[k - 1])) * BLOCK)
    old, new = middle[known[k - 1]], middle[block]
    near = steps[begin : (block + 1) * BLOCK]
    is_new = np.abs(np.log(np.maximum(near, 1e-300) / new)) < np.abs(
        np.log(np.maximum(near, 1e-300) / old)
    )
    # the row before the first step from which on most steps are new
    gain = np.concatenate([[0.0], np.cumsum(np.where(is_new, 1.0, -1.0))])
    return begin + int(np.argmin(gain))
