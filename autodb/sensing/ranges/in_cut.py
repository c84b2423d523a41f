"""Mean forces of the one cut of a recording over time, where the tool is wholly in the work."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb import signals
from autodb.errors import UnusableInput
from autodb.timing import Timing
from autodb.wording import localized, phrase

Array = NDArray[np.float64]

SMOOTH_S = 0.25
"""Length over which the size of the force is a mean."""
HIGH, SHARE = 0.9, 0.6
"""Quantile of the force's size that counts as in the work, and the share of it from which on it
does. Chosen."""
TRIMMED = 0.1
"""Share of the cut at each end in which the tool may come in or go out. Chosen."""
SHORTEST_S = 0.5


@dataclass(frozen=True)
class Mean:
    """Mean force and its standard deviation, N: errors of all rows are taken to go together."""

    force_N: float
    sd_N: float


def steady_rows(forces_N: Array, timing: Timing, *, where: str) -> slice:
    """Return the rows of the longest stretch, without a gap, in which forces (c, n) are those of
    the cut.

    Raises UnusableInput, naming ``where``, for one that is too short.
    """
    from scipy.ndimage import uniform_filter1d

    size = np.sqrt(np.sum(np.nan_to_num(forces_N) ** 2, axis=0))
    window = max(1, round(SMOOTH_S * timing.rate_hz))
    smooth = signals.by_piece(
        lambda own: uniform_filter1d(own, window, mode="nearest"), size, timing.pieces
    )
    inside = smooth > SHARE * np.quantile(smooth, HIGH)
    stretches = signals.flagged_runs(inside, timing.pieces)
    longest = max(stretches, key=lambda one: one.stop - one.start)
    begin, end = longest.start, longest.stop
    trim = round(TRIMMED * (end - begin))
    if end - begin - 2 * trim < SHORTEST_S * timing.rate_hz:
        raise UnusableInput(
            phrase(
                "{where}: no {shortest} s of a steady cut; record one longer cut",
                where=where,
                shortest=localized(f"{SHORTEST_S:g}"),
            )
        )
    return slice(begin + trim, end - trim)


def mean_of(force_N: Array, sd_N: Array, rows: slice) -> Mean:
    """Return the mean of a force (n,) over rows."""
    return Mean(float(np.nanmean(force_N[rows])), float(np.sqrt(np.nanmean(sd_N[rows] ** 2))))
