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
SHORT_S = 1.5
"""A pulse ends within; the average spreads it by half a second on each side."""
FEWEST = 3
"""Three pulses make two intervals that can be equal. Chosen."""
REGULAR_S = 0.3
"""How far a pulse may be from its place in the regular row: half an average. Chosen."""


@dataclass(frozen=True)
class Pulses:
    """Where pulses are, in samples, and every how many seconds they come."""

    where: tuple[slice, ...]
    every_s: float


def regular_pulses(parts: list[tuple[int, Array]], *, rate_hz: float) -> Pulses | None:
    """Return pulses of a range that come at regular intervals over its steady parts, or None.

    ``parts``: the first sample and the range (n,) of each part that has a level of its own, air and
    cut. A pulse may be missing where it falls between parts.
    """
    found = [slice(run.start + first, run.stop + first)
             for first, part in parts for run in _rises(part, rate_hz)]  # fmt: skip
    if len(found) < FEWEST:
        return None
    begins_s = np.array([run.start for run in found]) / rate_hz
    every_s = _interval_s(begins_s)
    return None if every_s is None else Pulses(tuple(found), every_s)


def _rises(part: Array, rate_hz: float) -> list[slice]:
    """Return the short rises of one part over its level: its median, with its slow change."""
    known = np.isfinite(part)
    if known.sum() < rate_hz:
        return []
    level = float(np.median(part[known]))
    low = part[known][part[known] <= level]
    spread = 1.4826 * float(np.median(level - low))  # of the half that no pulse lifts
    least = max(RISES * level, SPREADS * spread)
    over = runs(np.nan_to_num(part - level) > 0.4 * least)
    high = [run for run in over if np.nanmax(part[run]) - level > least]
    return [run for run in high if run.stop - run.start < SHORT_S * rate_hz]


def _interval_s(begins_s: Array) -> float | None:
    """Return the interval of which every distance is a whole multiple, or None."""
    least = float(np.min(np.diff(begins_s)))
    number = np.round((begins_s - begins_s[0]) / least)
    every_s, first_s = np.polyfit(number, begins_s, 1)
    off = begins_s - first_s - every_s * number
    return float(every_s) if np.max(np.abs(off)) <= REGULAR_S else None
