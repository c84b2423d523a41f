"""Way lubrication: short rises of a feed axis' range at regular intervals, in air as in cut."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.signals.segments import runs

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
    """Where pulses are, in samples, and every how many seconds they come."""

    where: tuple[slice, ...]
    every_s: float


def regular_pulses(
    parts: list[tuple[int, Array]], *, rate_hz: float, averaged_s: float
) -> Pulses | None:
    """Return pulses of a range that come at regular intervals over its steady parts, or None.

    ``parts``: the first sample and the range (n,), averaged over ``averaged_s``, of each part that
    has a level of its own, air and cut. A pulse may be missing where it falls between parts; one at
    the edge of a part, of which only some is seen, does not tell the interval.
    """
    found: list[slice] = []
    highest_s: list[float] = []
    for first, part in parts:
        for run in _rises(part, rate_hz=rate_hz, short_s=SHORT_S + averaged_s):
            found.append(slice(first + run.start, first + run.stop))
            if run.start > 0 and run.stop < part.size:
                highest_s.append((first + run.start + int(np.nanargmax(part[run]))) / rate_hz)
    if len(highest_s) < FEWEST:
        return None
    row = _row(np.array(highest_s))
    if row is None:
        return None
    every_s, first_s = row
    ends_s = [(first / rate_hz, (first + part.size) / rate_hz) for first, part in parts]
    number = np.arange(-1000, 1000)
    places = sum(int(np.sum((a <= first_s + every_s * number) & (first_s + every_s * number < b)))
                 for a, b in ends_s)  # fmt: skip
    if len(found) < THERE * places:
        return None
    return Pulses(tuple(found), every_s)


def _rises(part: Array, *, rate_hz: float, short_s: float) -> list[slice]:
    """Return the short rises of one part over its level."""
    known = part[np.isfinite(part)]
    if known.size < rate_hz:
        return []
    level = float(np.quantile(known, LEVEL))
    spread = BELOW * float(level - np.median(known[known <= level]))
    least = max(RISES * level, SPREADS * spread)
    over = runs(np.nan_to_num(part - level) > 0.4 * least)
    high = [run for run in over if np.nanmax(part[run]) - level > least]
    return [run for run in high if run.stop - run.start < short_s * rate_hz]


def _row(at_s: Array) -> tuple[float, float] | None:
    """Return the interval of which every distance is a whole multiple, and a first place."""
    number = np.round((at_s - at_s[0]) / np.min(np.diff(at_s)))
    every_s, first_s = (float(v) for v in np.polyfit(number, at_s, 1))
    off = at_s - first_s - every_s * number
    return (every_s, first_s) if np.max(np.abs(off)) <= REGULAR * every_s else None
