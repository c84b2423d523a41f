"""A drive at its current limit: the range sits flat at its maximum while it fluctuates below."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.signals.segments import runs

Array = NDArray[np.float64]

WITHIN = 3.0
"""Flat: within this many standard deviations of the noise."""
DIPS, DEEP = 2, 8.0
"""The range comes back to the top from so many dips, deeper than this many of them: nothing else
tells a limit from a force that is constant, or rises and then is. Chosen."""
AVERAGES = 5.0
"""The longest flat stretch at the top lasts at least this many averages,"""
LONGER = 3.0
"""and this times the longest at any level below, at each quarter of the way. Chosen."""
QUIET = 1.3
"""and scatters by no more than this times the noise: a load that turns slowly at its top scatters
by twice of it. Chosen."""


@dataclass(frozen=True)
class Flat:
    """The level of a limit, in the unit of the range, and where it is held longest, in samples."""

    level: float
    longest: slice


def held_at_top(range_A: Array, *, noise_A: float, averaged: float) -> Flat | None:
    """Return the limit that a range (n,) in cut runs into, or None.

    ``noise_A``: standard deviation of the range in air, where nothing fluctuates. A range that is
    at its limit from entry to exit is not told from a constant one. ``averaged``: the samples that
    the range is a moving average over.
    """
    known = range_A[np.isfinite(range_A)]
    if known.size == 0 or noise_A <= 0.0:
        return None
    top, low = (float(v) for v in np.quantile(known, (0.9, 0.02)))
    if _dips(range_A, top, noise_A) < DIPS:
        return None
    longest = _longest(range_A, top, noise_A)
    size = longest.stop - longest.start
    below = [_longest(range_A, low + share * (top - low), noise_A) for share in (0.25, 0.5, 0.75)]
    longer = LONGER * max(run.stop - run.start for run in below)
    if size < max(AVERAGES * averaged, longer) or np.std(range_A[longest]) > QUIET * noise_A:
        return None
    return Flat(float(np.mean(range_A[longest])), longest)


def _dips(range_A: Array, top_A: float, noise_A: float) -> int:
    """Return how often the range leaves its top and comes back."""
    at_top = np.flatnonzero(np.abs(range_A - top_A) <= WITHIN * noise_A)
    if not at_top.size:
        return 0
    return len(runs(range_A[at_top[0] : at_top[-1]] < top_A - DEEP * noise_A))


def _longest(range_A: Array, level_A: float, noise_A: float) -> slice:
    flat = runs(np.abs(range_A - level_A) <= WITHIN * noise_A)
    return max(flat, key=lambda run: run.stop - run.start, default=slice(0, 0))
