"""A drive at its current limit: the range sits flat at its maximum while it fluctuates below."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.signals.segments import flagged_runs

Array = NDArray[np.float64]

WITHIN = 3.0
"""Flat: within this many standard deviations of the noise."""
DIPS, DEEP = 2, 8.0
"""The range comes back to the top from so many dips, deeper than this many of them: nothing else
tells a limit from a force that is constant, or rises and then is. Chosen."""
SHARE, MORE = 0.15, 2.0
"""The range is at its top for this share of the cut at least, and this times as long as at any
level below, at each fifth of the way up to three. Chosen."""
QUIET = 1.45
"""and scatters by no more than this times the noise: a load that turns slowly at its top scatters
by twice of it. Chosen."""


@dataclass(frozen=True)
class Flat:
    """The level of a limit, in the unit of the range, and for what share of the time it is held."""

    level: float
    share: float


def held_at_top(range_A: Array, *, noise_A: float) -> Flat | None:
    """Return the limit that a range (n,) in cut runs into, or None.

    ``noise_A``: standard deviation of the range in air, where nothing fluctuates. A range that is
    at its limit from entry to exit is not told from a constant one.
    """
    known = range_A[np.isfinite(range_A)]
    if known.size == 0 or noise_A <= 0.0:
        return None
    top, low = (float(v) for v in np.quantile(known, (0.9, 0.02)))
    if _dips(known, top, noise_A) < DIPS:
        return None
    flat = known[np.abs(known - top) <= WITHIN * noise_A]
    levels = low + np.array([0.2, 0.4, 0.6]) * (top - low)
    below = np.mean(np.abs(known[:, None] - levels) <= WITHIN * noise_A, axis=0)
    share = flat.size / known.size
    if share < max(SHARE, MORE * float(np.max(below))) or np.std(flat) > QUIET * noise_A:
        return None
    return Flat(float(np.mean(flat)), share)


def _dips(range_A: Array, top_A: float, noise_A: float) -> int:
    """Return how often the range leaves its top and comes back."""
    at_top = np.flatnonzero(np.abs(range_A - top_A) <= WITHIN * noise_A)
    if not at_top.size:
        return 0
    return len(flagged_runs(range_A[at_top[0] : at_top[-1]] < top_A - DEEP * noise_A))
