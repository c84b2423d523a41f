"""The step of a clock, the resolution of its stamps, and the number of each row on even steps."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.intp]

ALIKE = 0.02
"""Share of a step within which steps are one and the same. Chosen."""
MOSTLY = 0.6
"""Share of the steps that have to be alike for their median to be the step. Chosen."""
WINDOW = 200
"""Rows over which a step is measured where stamps are too rough for single steps. Chosen."""
WHOLE = 0.42
"""How far from a whole number of steps a step may be and still be counted. Below a half."""
AROUND = 25
"""Rows on either side that show whether stamps stay behind by a row: chosen."""
STAYS = 0.7
"""Steps by which they stay behind where rows are missing: between none and one."""
STAMPS = 10
"""Stamps over which the step of rows that share them is measured at first. Chosen."""
SHARED = 0.2
"""Share of steps of zero from which on several rows share a stamp. Chosen."""
RESOLUTIONS = tuple(sorted([10.0**-k for k in range(7)] + [2.0**-k for k in range(1, 11)]))[::-1]
"""Resolutions of stamps that are looked for, s: decimals, and powers of two (1/64 s is the tick of
a common operating system)."""
FEWEST_STEPS = 5
"""Stamps that differ from the one before, without which none says a rate."""
COARSE_STAMPS = 0.1
"""Share of a step from which on the resolution of stamps may look like rows that are missing: where
it explains all that they are off by, none is."""
COARSE_STEP = 0.5
"""Share of a step from which on the resolution of stamps makes neighbours share one."""
SAMPLED = 100_000
FILLED_ROWS = 5
"""Missing rows in a row that are filled from their neighbours: chosen, so few change no filter."""


@dataclass(frozen=True)
class Numbered:
    """Rows numbered on even steps.

    ``number`` (n,): how many steps after the first row, never falling · ``step_s`` ·
    ``resolution_s``: of the stamps, 0 where they have none · ``shared``: whether several rows share
    a stamp.
    """

    number: Index
    step_s: float
    resolution_s: float
    shared: bool


def numbered(t_s: Array) -> Numbered | None:
    """Number rows by their stamps (n,); None where the stamps stand still, but for a few."""
    steps = np.diff(t_s)
    ahead = steps[steps > 0]
    if ahead.size < FEWEST_STEPS:
        return None
    shared, resolution_s = share_stamps(t_s), resolution(t_s)
    if resolution_s > COARSE_STAMPS * float(np.mean(ahead)):
        every = np.arange(len(t_s))
        step = _slope(t_s, every)
        if step > 0 and np.ptp(t_s - step * every) <= 1.02 * resolution_s:
            return Numbered(every, step, resolution_s, shared)
    step = _first_step(t_s, steps, ahead, shared=shared)
    if not step > 0:
        return None
    number = _counted(t_s, steps, step, shared=shared)
    for _ in range(2):
        step = _slope(t_s, number)
        number = _counted(t_s, steps, step, shared=shared)
    return Numbered(number, _slope(t_s, number), resolution_s, shared)


def share_stamps(t_s: Array) -> bool:
    """Say whether several rows share a stamp, for its resolution or since they come in packets."""
    same = float(np.mean(np.diff(t_s) == 0))
    mean = float(t_s[-1] - t_s[0]) / (len(t_s) - 1)
    return same > SHARED or (same > 0 and resolution(t_s) >= COARSE_STEP * mean)


def rows_a_stamp(t_s: Array) -> int:
    """Return how many rows share a stamp, about."""
    return int(np.ceil(len(t_s) / max(1, int(np.sum(np.diff(t_s) > 0)))))


def resolution(t_s: Array) -> float:
    """Return the coarsest resolution that all stamps (n,) are written with, s; 0: none is seen."""
    rows = t_s[:: max(1, len(t_s) // SAMPLED)]
    since = rows - t_s[0]
    fine = 4.0 * float(np.spacing(np.abs(t_s).max()))
    for unit in RESOLUTIONS:
        off = np.abs(since / unit - np.round(since / unit))
        if off.max() <= 1e-3 + fine / unit and fine < 0.1 * unit:
            return unit
    return 0.0


def _first_step(t_s: Array, steps: Array, ahead: Array, *, shared: bool) -> float:
    middle = float(np.median(ahead))
    alike = np.abs(steps - middle) <= ALIKE * middle
    if not shared and np.mean(alike) >= MOSTLY:
        return float(np.mean(steps[alike]))
    base = common_step(ahead) if not shared else 0.0
    if base:
        return base
    many = rows_a_stamp(t_s) if shared else 1
    over = max(1, min(max(WINDOW, STAMPS * many), len(t_s) // 2))
    return float(np.median(t_s[over:] - t_s[:-over]) / over)


def common_step(ahead: Array) -> float:
    """Return the step of which all others (n,) are whole multiples, 0 where there is none.

    It has to be there often: rows that are written on change.
    """
    least = float(np.quantile(ahead, 0.01))
    alike = np.abs(ahead - least) <= ALIKE * least
    if np.mean(alike) <= SHARED:
        return 0.0
    base = float(np.mean(ahead[alike]))
    off = np.abs(ahead / base - np.round(ahead / base))
    return base if np.quantile(off, 0.99) < ALIKE else 0.0


def _counted(t_s: Array, steps: Array, step: float, *, shared: bool) -> Index:
    """Return the number (n,) of each row, missing ones counted in."""
    whole = np.round(steps / step)
    clean = np.mean(np.abs(steps / step - whole) > WHOLE) <= 1e-3
    if not shared and clean and whole.min() >= 0:
        return _spread(np.concatenate([[0], np.cumsum(whole)]).astype(np.intp))
    missing = np.zeros(len(t_s), dtype=np.intp)
    missing[1:] = _missing(t_s, steps, step, shared=shared)
    return np.asarray(np.arange(len(t_s)) + np.cumsum(missing), dtype=np.intp)


def _spread(number: Index) -> Index:
    """Return numbers with a row that shares its with the next before a free one moved on."""
    twice = np.flatnonzero(np.diff(number) == 0) + 1
    free = twice[twice < len(number) - 1]
    free = free[number[free + 1] - number[free] >= 2]
    moved = number.copy()
    moved[free] += 1
    return moved


def _missing(t_s: Array, steps: Array, step: float, *, shared: bool) -> Index:
    """Return how many rows are missing before each row but the first, (n − 1,).

    Single stamps are too rough to say: stamps that stay behind the number of rows do.
    """
    from scipy.ndimage import median_filter

    late = t_s - step * np.arange(len(t_s))
    many = 1
    if shared:
        many = rows_a_stamp(t_s)
    around = max(AROUND, 4 * many)
    if len(t_s) < 3 * around:
        return np.zeros(len(steps), dtype=np.intp)
    middle = median_filter(late, size=around, mode="nearest")
    half = around // 2
    last = len(t_s) - 1
    at = np.arange(len(steps))
    before = middle[np.maximum(at - half, 0)]
    after = middle[np.minimum(at + 1 + half, last)]
    stays = (after - before) / step
    often = np.asarray(steps > (many + 0.5) * step)
    found = np.where(often & (stays > STAYS * many), np.maximum(np.round(stays), 1), 0.0)
    # of neighbouring rows the widest step is where rows are missing
    order = np.flatnonzero(found)
    kept = np.zeros(len(steps), dtype=np.intp)
    for row in order[np.argsort(-steps[order], kind="stable")]:
        if not kept[max(0, row - half) : row + half + 1].any():
            kept[row] = int(found[row])
    return kept


def _slope(t_s: Array, number: Index) -> float:
    """Return the step that fits stamps (n,) best, s, those far off left out.

    Of rows that share a stamp the first counts: there the clock went on. Over a gap it may have
    been set: each part between gaps has a beginning of its own.
    """
    part = np.cumsum(np.append(0, np.diff(number) > 1 + FILLED_ROWS))
    begins = np.flatnonzero(np.diff(t_s) > 0) + 1
    if FEWEST_STEPS <= len(begins) < len(t_s) - 1:
        t_s, number, part = t_s[begins], number[begins], part[begins]
    n = number.astype(np.float64)
    kept = np.ones(len(n), dtype=np.bool_)
    for _ in range(3):
        count, since = (_about_means(values, part, kept) for values in (n, t_s - t_s[0]))
        slope = float(count[kept] @ since[kept]) / float(count[kept] @ count[kept])
        off = since - slope * count
        far = np.abs(off - np.median(off))
        kept = far <= 5.0 * 1.4826 * float(np.median(far)) + 1e-12
    return slope


def _about_means(values: Array, part: Index, kept: NDArray[np.bool_]) -> Array:
    """Return values (n,) less the mean of those of their part that are kept."""
    rows = np.maximum(np.bincount(part, kept), 1.0)
    return np.asarray(values - (np.bincount(part, kept * values) / rows)[part], dtype=np.float64)
