"""What stops: the cut in the middle of its run, the spindle at its end."""

import numpy as np
from numpy.typing import NDArray

from autodb.signals.segments import LoadLevels, flagged_runs

Array = NDArray[np.float64]

GONE, THERE = 0.25, 0.5
"""Shares of the way from air to cut below which a cut is gone, and above which it is there."""
GONE_S, THERE_S = 0.15, 0.3
"""For how long, at least: shorter than 0.15 s nothing but an average over 0.1 s says so. Chosen."""
SLOWS_PER_S = 0.3
"""A spindle brakes where it loses this share of its speed in a second; constant cutting speed in
facing outwards changes it by less (0.25/s at 5 mm/s of diameter on 20 mm). Chosen."""
SLOWED = 0.9
"""and where it has come below this share of what it was. Chosen."""
BLOCK_S = 0.1


def interrupted(load: Array, found: LoadLevels, *, rate_hz: float) -> slice | None:
    """Return where a load (n,) falls back to its level in air between two parts of cut, or None.

    NaN, an axis that stands, is gone too. A load averaged over ``BLOCK_S`` or so.
    """
    share = found.share(load)
    there = [
        run for run in flagged_runs(share > THERE) if run.stop - run.start >= THERE_S * rate_hz
    ]
    if len(there) < 2:
        return None
    inside = slice(there[0].stop, there[-1].start)
    gone = flagged_runs(~(share[inside] >= GONE))
    longest = max(gone, key=lambda run: run.stop - run.start, default=slice(0, 0))
    if longest.stop - longest.start < GONE_S * rate_hz:
        return None
    return slice(inside.start + longest.start, inside.start + longest.stop)


def slowing_from(speed: Array, *, rate_hz: float) -> int | None:
    """Return the sample from which a speed (n,), in any unit, falls and does not come back.

    NaN is standstill. None where it does not fall, or by less than a tenth.
    """
    block = max(1, round(BLOCK_S * rate_hz))
    count = speed.size // block
    mean = np.median(np.nan_to_num(np.abs(speed[: count * block])).reshape(count, block), axis=1)
    if count < 2 or not mean.any():
        return None
    least = 1e-9 * float(np.max(mean))
    falls = (mean[:-1] - mean[1:]) / np.maximum(mean[:-1], least) / BLOCK_S > SLOWS_PER_S
    for run in flagged_runs(falls):
        if np.max(mean[run.stop :]) <= SLOWED * mean[run.start]:
            return int(run.start * block)
    return None
