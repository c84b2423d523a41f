"""Way lubrication: short rises of a feed axis' range at regular intervals, in air as in cut."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.signals.segments import flagged_runs

Array = NDArray[np.float64]

RISES = 0.04
"""Least rise over the level around, as a share of it: below it a mean does not feel it. Chosen."""
SPREADS = 5.0
"""and in robust standard deviations of the range around its level. Chosen."""
LEVEL, BELOW = 0.25, 2.1
"""Level: the quantile that pulses over half of a short part still leave; the standard deviation is
so many times the distance from it to the median of what lies below (normal distribution)."""
SHORT_S = 1.0
"""A pulse ends within, and the average's own length. Chosen."""
FEWEST = 3
"""Three pulses make two intervals that can be equal. Chosen."""
REGULAR, THERE = 0.1, 0.75
"""How far a pulse may be from its place in the regular row, as a share of the interval, and the
share of such places in air and cut at which there is one. Chosen."""


@dataclass(frozen=True)
class Pulses:
    """Where pulses are seen and where they are expected, in samples, and every how many seconds."""

    seen: tuple[slice, ...]
    expected: tuple[slice, ...]
    every_s: float


def regular_pulses(
    parts: list[tuple[int, Array]], *, rate_hz: float, averaged_s: float
) -> Pulses | None:
    """Return pulses of a range that come at regular intervals over its steady parts, or None.

    ``parts``: the first sample and the range (n,), averaged over ``averaged_s``, of each part that
    has a level of its own, air and cut. A pulse at the edge of a part, of which only some is seen,
    does not tell the interval. Where the row has a place is a pulse, seen or not.
    """
    found: list[slice] = []
    whole: list[tuple[int, int, int]] = []  # first sample, highest, end
    for first, part in parts:
        for run in _rises(part, rate_hz=rate_hz, short_s=SHORT_S + averaged_s):
            begin, end = first + run.start, first + run.stop
            found.append(slice(begin, end))
            if run.start > 0 and run.stop < part.size:
                whole.append((begin, begin + int(np.nanargmax(part[run])), end))
    if len(whole) < FEWEST:
        return None
    seen = np.array(whole, dtype=np.float64)
    row = _row(seen[:, 1])
    if row is None:
        return None
    places = _places(*row, [(first, first + part.size) for first, part in parts])
    if len(found) < THERE * len(places):
        return None
    before, after = (np.median(np.abs(seen[:, k] - seen[:, 1])) for k in (0, 2))
    expected = [slice(max(0, round(at - before)), round(at + after)) for at in places]
    return Pulses(tuple(found), tuple(expected), row[0] / rate_hz)


def _places(every: float, first: float, parts: list[tuple[int, int]]) -> list[float]:
    """Return where the row has a place within one of the parts, in samples."""
    return [
        first + every * number
        for begin, end in parts
        for number in range(
            int(np.ceil((begin - first) / every)), int(np.ceil((end - first) / every))
        )
    ]


def _rises(part: Array, *, rate_hz: float, short_s: float) -> list[slice]:
    """Return the short rises of one part over its level."""
    known = part[np.isfinite(part)]
    if known.size < rate_hz:
        return []
    level = float(np.quantile(known, LEVEL))
    spread = BELOW * float(level - np.median(known[known <= level]))
    least = max(RISES * level, SPREADS * spread)
    over = flagged_runs(np.nan_to_num(part - level) > 0.4 * least)
    high = [run for run in over if np.nanmax(part[run]) - level > least]
    return [run for run in high if run.stop - run.start < short_s * rate_hz]


def _row(at: Array) -> tuple[float, float] | None:
    """Return the interval of which every distance is a whole multiple, and a first place."""
    number = np.round((at - at[0]) / np.min(np.diff(at)))
    every, first = (float(v) for v in np.polyfit(number, at, 1))
    off = at - first - every * number
    return (every, first) if np.max(np.abs(off)) <= REGULAR * every else None
