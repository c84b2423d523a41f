"""A recorded cut begins in air: where it approached, entered, cut and left.

What stops: the cut in the middle of its run, the spindle at its end.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

MARGIN_S = 0.5
"""What a transition takes on either side of where the load crosses between the two levels: the
average over 0.5 s, and an entry of as long."""


@dataclass(frozen=True)
class CutSegments:
    """The parts of a recorded cut, as slices of the samples; a part may be empty.

    ``entry`` and ``exit`` are the transitions, ``margin_s`` on either side of the crossing.
    """

    air: slice
    entry: slice
    cut: slice
    exit: slice


@dataclass(frozen=True)
class LoadLevels:
    """In which samples (n,) a load is nearer to its level in cut than in air, and both levels."""

    cutting: Flags
    air: float
    cut: float

    def share(self, load: Array) -> Array:
        """Return a load (n,) as a share of the way from air to cut: 0 in air, 1 in cut."""
        return (load - self.air) / (self.cut - self.air)


def two_levels(load: Array) -> LoadLevels | None:
    """Return the two levels of a load (n,), by fuzzy c-means; NaN (standing) is bridged.

    A recording starts in air. None when the clusters are not apart by 6 times their spread.
    """
    import skfuzzy

    known = np.isfinite(load)
    if known.sum() < 10:
        return None
    filled = np.interp(np.arange(len(load)), np.flatnonzero(known), load[known])
    centres, member, *_ = skfuzzy.cluster.cmeans(
        filled[None, :], c=2, m=2.0, error=1e-4, maxiter=200, seed=0
    )
    label = np.argmax(member, axis=0)
    spread = np.median(np.abs(filled - centres[label, 0]))
    if abs(centres[0, 0] - centres[1, 0]) < 6.0 * spread:
        return None
    air = label[np.flatnonzero(known)[0]]
    cutting = np.asarray(label != air)
    if not cutting.any():
        return None
    return LoadLevels(cutting, float(centres[air, 0]), float(centres[1 - air, 0]))


STEPS_S = 0.04
"""Between moments at which a cut that fades is tried to begin and to end. Chosen."""
SHORTEST_S = 0.5
"""of such a cut. Chosen."""


def fading_levels(load: Array, arm: Array, begins: Array, *, rate_hz: float) -> LoadLevels | None:
    """Return the levels of a load (n,) that goes with an arm, and where it is in cut.

    ``arm`` (n,) less its value where the cut begins, plus ``begins`` there (n,), is the arm of a
    load in a cut that begins there: the load is a constant, and something times the arm from where
    it begins to where it ends, which are those of least squares. The level in cut is that of the
    whole arm. None when the two levels are not apart by 6 times what is left.
    """
    step = max(1, round(STEPS_S * rate_hz))
    known = np.isfinite(load)
    if known.sum() < 10:
        return None
    rows = np.arange(0, len(load), step)
    values = np.interp(rows, np.flatnonzero(known), load[known])
    fewest = max(2, round(SHORTEST_S * rate_hz / step))
    best = (np.inf, 0, 0, 0.0, 0.0)
    for begin in range(1, len(rows) - fewest):
        arms = np.maximum(arm[rows] - arm[rows[begin]] + begins[rows[begin]], 0.0)
        best = min(best, _best_end(values, arms / begins[rows[begin]], begin, fewest))
    squares, begin, end, air, rise = best
    spread = np.sqrt(squares / len(rows))
    if not np.isfinite(squares) or rise < 6.0 * spread:
        return None
    cutting = np.zeros(len(load), dtype=np.bool_)
    cutting[rows[begin] : rows[end] if end < len(rows) else len(load)] = True
    return LoadLevels(cutting, air, air + rise)


def _best_end(
    values: Array, share: Array, begin: int, fewest: int
) -> tuple[float, int, int, float, float]:
    """Return the squares left, begin, the end of least, the level in air and the rise."""
    size = len(values)
    ends = np.arange(begin + fewest, size + 1)
    own = share[begin:]
    sum_h, sum_hh, sum_hy = (
        np.cumsum(column)[ends - begin - 1] for column in (own, own**2, own * values[begin:])
    )
    mean = values.mean()
    across = sum_hy - sum_h * mean
    within = np.maximum(sum_hh - sum_h**2 / size, 1e-12 * size)
    rise = across / within
    squares = np.sum((values - mean) ** 2) - across * rise
    at = int(np.argmin(np.where(rise > 0.0, squares, np.inf)))
    if rise[at] <= 0.0:
        return np.inf, 0, 0, 0.0, 0.0
    air = mean - rise[at] * sum_h[at] / size
    return float(squares[at]), begin, int(ends[at]), float(air), float(rise[at])


def flagged_runs(flags: Flags, pieces: Sequence[slice] = (slice(0, None),)) -> list[slice]:
    """Return where flags (n,) are set, as slices in order, each within one piece of even rows."""
    found = []
    for piece in pieces:
        edges = np.flatnonzero(np.diff(np.concatenate(([0], flags[piece].astype(int), [0]))))
        pairs = zip(edges[::2] + piece.start, edges[1::2] + piece.start, strict=True)
        found += [slice(int(begin), int(end)) for begin, end in pairs]
    return found


def cut_segments(cutting: Flags, *, rate_hz: float, margin_s: float = MARGIN_S) -> CutSegments:
    """Return the parts around the longest run of cutting samples (n,), of which there is one."""
    longest = max(flagged_runs(cutting), key=lambda run: run.stop - run.start)
    margin, end = round(margin_s * rate_hz), len(cutting)
    marks = (longest.start - margin, longest.start + margin, longest.stop - margin)
    before, begins, ends = (min(max(0, mark), end) for mark in marks)
    ends = max(begins, ends)
    first = min(margin, max(0, before - margin))  # what there is of a short approach is all used
    return CutSegments(
        air=slice(first, before),
        entry=slice(before, begins),
        cut=slice(begins, ends),
        exit=slice(ends, min(end, longest.stop + margin)),
    )


def air_and_cut(load: Array, *, rate_hz: float, margin_s: float = MARGIN_S) -> CutSegments | None:
    """Split one recorded cut by its load (n,): a range or a force that rises or falls in the cut.

    None when air and cut are not told apart (`two_levels`), or a part is shorter than 0.3 s.
    """
    found = two_levels(load)
    if found is None:
        return None
    parts = cut_segments(found.cutting, rate_hz=rate_hz, margin_s=margin_s)
    short = 0.3 * rate_hz
    if any(part.stop - part.start < short for part in (parts.air, parts.cut)):
        return None
    return parts


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
