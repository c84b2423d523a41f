"""When rows were taken: on even steps that stamps only blur, or when the stamps say.

A stamp that is wrong by δ shows as a place that is off by v·δ. Of two accounts of when rows were
taken the one is right under which places are smooth.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from autodb.timing.steps import AROUND, FILLED_ROWS, Numbered, rows_a_stamp
from autodb.timing.verdict import StampFinding
from autodb.wording import localized, phrase, stored_msgid

Array = NDArray[np.float64]

EVENLY, UNEVENLY = 0.003, 0.03
"""Kinks that places may have on even steps, and at stamps of rows that were taken unevenly: a row
in a hundred that is missing makes 0.01; a robot's joint at its stamps has 0.02. Chosen."""
COARSE_PLACE = 0.05
"""Share of the squared way of a step that the resolution of a place may make, to show kinks."""
EVEN = 1e-4
"""Share of a step by which even stamps may be off: at 100 mm/s and 1 ms a place is off by 10 nm."""
CLEARLY = 0.8
"""Ratio of the squared roughness of places under two accounts, below which one is right. Chosen."""
GIVEN = 0.5
"""Share of the squared ways from row to row that a recorded speed may leave, to tell the stamps
right: of a joint that sticks and slips on a slow bus it leaves a quarter. Chosen."""
SLOW_STAMPS = 101
"""Stamps over which a clock that wanders is smoothed. Chosen."""
STEADY_RATE = 0.002
"""Share by which the rate of rows that share stamps may vary: clocks do by less, chosen."""
FINE, LATE_S = 0.02, 0.5
"""Share of a step by which rows are off besides, and time (s) that a clock is late in all at most,
where it only gains or loses slowly: what moves is derived from rows that are truly even. Chosen."""
ROUNDED = 1.0 + 1e-3
"""Share of their resolution by which stamps that are rounded, or cut off, are off at most."""
WANDERS = 0.05
"""Share of a step by which a clock may wander off before rows are resampled. Chosen."""
COARSE = 0.25
"""Share of a step that the resolution of stamps may be, where rows are taken at their stamps: of a
half, friction was found 6 % off. Chosen."""
INDEPENDENT = 2.0
"""Ratio of the scatter of stamps to that of their steps, over √2, from which on their errors add
up: 1 where each is by itself. Chosen."""
USUAL = 0.995
"""Share of rows beyond whose roughness none counts more: one glitch decides nothing. Chosen."""
FAST_SHARE = 0.75
"""Places are compared where they move faster than this share of their rows. Chosen."""
ROUNDED_SHARED = stored_msgid(
    "stamps rounded to {step} that several rows share: times rebuilt from the number of rows"
)
PACKETS = stored_msgid(
    "several rows bear the stamp of their packet: times rebuilt from the number of rows"
)
JITTER = stored_msgid("stamps jitter by {sd} (one sd): times rebuilt from the number of rows")
ROUNDED_TO = stored_msgid("stamps rounded to {step}: times rebuilt from the number of rows")
GAINS = stored_msgid("the clock gains or loses up to {share}: rows left as they came")
CLOCK_WANDERS = stored_msgid("the clock wanders by {count} steps: rows resampled")
UNEVEN = stored_msgid(
    "rows taken unevenly (steps scatter by {share} of one): resampled at their stamps"
)


@dataclass(frozen=True)
class Clock:
    """When the rows of a run were taken: ``times_s`` (n,), never falling.

    ``on_grid``: on whole steps, so that no row has to be resampled · ``blur_s``: standard deviation
    of what they may be wrong by · ``unfit``: why no times can be told.
    """

    times_s: Array
    on_grid: bool
    findings: tuple[StampFinding, ...]
    blur_s: float = 0.0
    unfit: str = ""


def clock(
    t_s: Array,
    rows: Numbered,
    places: Sequence[Array],
    speeds: Sequence[tuple[Array, Array]] = (),
) -> Clock:
    """Say when rows with the stamps ``t_s`` (n,) were taken; ``places`` (n,) each.

    ``speeds``: places whose speed was recorded, with it, in their unit a second.
    """
    since = t_s - rows.step_s * rows.number
    first = float(np.median(since))
    if abs(first - t_s[0]) < EVEN * rows.step_s + 0.5 * rows.resolution_s:
        first = float(t_s[0])
    even = np.asarray(first + rows.step_s * rows.number, dtype=np.float64)
    off = t_s - even
    largest = float(np.abs(off).max())
    if largest <= EVEN * rows.step_s:
        return Clock(even, True, ())
    if (set_anew := _set_at_gaps(even, off, rows)) is not None:
        return set_anew
    many = rows_a_stamp(t_s) if rows.shared else 1
    slow = _slow(off, many)
    fast = off - slow
    chance = 5.0 * float(np.std(fast)) / np.sqrt(SLOW_STAMPS)
    wanders = float(np.abs(slow).max()) > WANDERS * rows.step_s + rows.resolution_s + chance
    if not wanders:
        slow, fast = np.zeros_like(off), off
    if wanders and not rows.shared and _nearly_even(slow, fast, rows):
        return Clock(even, True, (_kept_as_it_came(slow, rows.step_s),))
    if np.abs(fast).max() <= ROUNDED * rows.resolution_s:
        known = _by_number(even, slow, fast, rows, wanders=wanders)
        return _unless_kinked(known, places, EVENLY) if rows.shared else known
    honest = None if rows.shared else _stamps_are_right(t_s, even + slow, places)
    alike = float(np.std(fast)) <= INDEPENDENT * float(np.std(np.diff(fast))) / np.sqrt(2.0)
    if not rows.shared and (honest or not alike):
        borne_out = _by_its_speed(np.maximum.accumulate(t_s), even + slow, speeds)
        return _unless_kinked(_as_stamped(t_s, off, rows), () if borne_out else places, UNEVENLY)
    return _unless_kinked(_by_number(even, slow, fast, rows, wanders=wanders), places, EVENLY)


def _set_at_gaps(even: Array, off: Array, rows: Numbered) -> Clock | None:
    """Return the clock of rows that are even between gaps, over which it was set; else None."""
    gaps = np.flatnonzero(np.diff(rows.number) > 1 + FILLED_ROWS) + 1
    if not gaps.size or rows.shared or rows.resolution_s > FINE * rows.step_s:
        return None
    set_by = np.empty_like(off)
    for begin, end in pairwise([0, *gaps, len(off)]):
        set_by[begin:end] = np.median(off[begin:end])
    if np.abs(off - set_by).max() > EVEN * rows.step_s + ROUNDED * rows.resolution_s:
        return None
    return Clock(even + set_by, True, ())


def _unless_kinked(found: Clock, places: Sequence[Array], most: float) -> Clock:
    """Return a clock, unfit where places are not smooth under it: rows are missing among those
    that share stamps, or neither stamps nor numbers are right.
    """
    bent = kinks(np.maximum.accumulate(found.times_s), places)
    if found.unfit or bent is None or bent <= most:
        return found
    unfit = phrase(
        "{sentence}, but the axis then moves by leaps ({bent} % of its way in a step), "
        "as where rows are missing or stamps wrong: when rows were taken cannot be told",
        sentence=found.findings[0].sentence,
        bent=localized(f"{100 * bent**0.5:.2g}"),
    )
    return replace(found, unfit=unfit)


def _by_its_speed(stamped: Array, even: Array, speeds: Sequence[tuple[Array, Array]]) -> bool:
    """Say whether recorded speeds give most of what places move from stamp to stamp, and clearly
    less of it on even steps: the stamps are right, though an axis that sticks and slips is no
    smooth one.
    """
    one = other = whole = 0.0
    for place, speed in speeds:
        moved, mean = np.diff(place), 0.5 * (speed[1:] + speed[:-1])
        size = float(moved @ moved) or 1.0
        one += float(np.sum((moved - mean * np.diff(stamped)) ** 2)) / size
        other += float(np.sum((moved - mean * np.diff(even)) ** 2)) / size
        whole += 1.0
    return bool(one < GIVEN * whole and one < CLEARLY * other)


def _slow(off: Array, many: int) -> Array:
    """Return what of the stamps' lateness (n,) wanders slowly; ``many`` rows share a stamp."""
    from scipy.ndimage import uniform_filter1d

    size = min(SLOW_STAMPS * many, max(1, len(off) // 4))
    return uniform_filter1d(uniform_filter1d(off, size, mode="reflect"), size, mode="reflect")


def _by_number(even: Array, slow: Array, fast: Array, rows: Numbered, *, wanders: bool) -> Clock:
    """Return the clock of rows that their number tells the times of."""
    rounded = np.abs(fast).max() <= ROUNDED * rows.resolution_s
    if rounded:
        kind, what = "rounded", (ROUNDED_SHARED if rows.shared else ROUNDED_TO)
        what = what.format(step=_time(rows.resolution_s))
    elif rows.shared:
        kind, what = "shared", PACKETS
    else:
        kind, what = "jittered", JITTER.format(sd=_time(float(np.std(fast))))
        if np.std(fast) > rows.step_s:
            unfit = phrase(
                "stamps jitter by {std} (one sd), rows are {step} apart: their order is not known",
                std=_time(float(np.std(fast))),
                step=_time(rows.step_s),
            )
            return Clock(even, True, (), unfit=unfit)
    found = [StampFinding(kind, what, len(even))]
    if not wanders:
        return Clock(even, True, tuple(found))
    rate = float(np.std(np.diff(slow))) / rows.step_s
    if rows.shared and rate > STEADY_RATE:
        unfit = phrase(
            "several rows share a stamp, and their rate varies by {rate} %, as where rows "
            "are missing: when they were taken cannot be told",
            rate=localized(f"{100 * rate:.2g}"),
        )
        return Clock(even, True, tuple(found), unfit=unfit)
    return Clock(even + slow, False, (*found, _wandering(slow, rows.step_s)))


def _nearly_even(slow: Array, fast: Array, rows: Numbered) -> bool:
    """Say whether a clock only gains or loses slowly: rows are as even as its rate is steady."""
    rate = float(np.abs(np.diff(slow)).max()) / rows.step_s
    blurred = FINE * rows.step_s + ROUNDED * rows.resolution_s
    return bool(
        rate <= STEADY_RATE and np.abs(fast).max() <= blurred and np.abs(slow).max() <= LATE_S
    )


def _kept_as_it_came(slow: Array, step_s: float) -> StampFinding:
    rate = 100.0 * float(np.abs(np.diff(slow)).max()) / step_s
    sentence = GAINS.format(share=f"{rate:.2g} %")
    return StampFinding("wanders", sentence, len(slow))


def _wandering(slow: Array, step_s: float) -> StampFinding:
    way = float(np.ptp(slow)) / step_s
    return StampFinding("wanders", CLOCK_WANDERS.format(count=f"{way:.2g}"), len(slow))


def _as_stamped(t_s: Array, off: Array, rows: Numbered) -> Clock:
    uneven = float(np.std(np.diff(off))) / rows.step_s
    sentence = UNEVEN.format(share=f"{uneven:.2g}")
    found = (StampFinding("uneven", sentence, len(t_s)),)
    if rows.resolution_s > COARSE * rows.step_s:
        unfit = phrase(
            "rows taken unevenly, about every {step}, with stamps rounded to {resolution}: "
            "when they were taken cannot be told",
            step=_time(rows.step_s),
            resolution=_time(rows.resolution_s),
        )
        return Clock(t_s, False, found, unfit=unfit)
    blur = rows.resolution_s / np.sqrt(12.0)
    return Clock(np.maximum.accumulate(t_s), False, found, blur_s=blur)


def _stamps_are_right(t_s: Array, even: Array, places: Sequence[Array]) -> bool | None:
    """Say which account of the times makes places smooth; None where both do."""
    stamped = np.maximum.accumulate(t_s)
    one = other = 0.0
    for place in places:
        by_stamp, by_number = roughness(stamped, place), roughness(even, place)
        moving = _moving(place)
        both = np.concatenate([by_stamp[moving], by_number[moving]])
        finite = both[np.isfinite(both)]
        if not finite.size or not finite.max() > 0:
            continue
        most = float(np.quantile(finite, USUAL))
        if not most > 0:
            most = float(finite.max())
        one += float(np.mean(np.minimum(by_stamp[moving], most))) / most
        other += float(np.mean(np.minimum(by_number[moving], most))) / most
    if one < CLEARLY * other:
        return True
    return False if other < CLEARLY * one else None


def kinks(t_s: Array, places: Sequence[Array]) -> float | None:
    """Return how much the ways of places bend from row to row, as a share of them, squared.

    Roughness of the fastest rows over the square of a step's way, less what a place's resolution
    gives: that of the place of which least is due to it. None where no place moves.
    """
    found = []
    for place in places:
        moving = _moving(place)
        way = np.abs(place[4:] - place[:-4])[moving] / 4.0
        rough = roughness(t_s, place)[moving]
        known = np.isfinite(rough)
        if not np.any(known) or not np.mean(way**2) > 0:
            continue
        steps = np.abs(np.diff(place))
        grain = float(steps[steps > 1e-9 * np.ptp(place)].min()) ** 2 / 12.0
        if grain < COARSE_PLACE * np.mean(way**2):
            bent = max(float(np.mean(rough[known])) - 2.0 * grain, 0.0)
            found.append(bent / float(np.mean(way**2)))
    return min(found, default=None)


def _moving(place: Array) -> NDArray[np.bool_]:
    """Return which rows (n − 4,) are among the fastest, over a while: no kink chooses itself."""
    reach = max(2, min(AROUND, len(place) // 8))
    padded = np.pad(place, reach, mode="edge")
    speed = np.abs(padded[2 * reach :] - padded[: -2 * reach])[2:-2]
    return np.asarray((speed > 0) & (speed >= np.quantile(speed, FAST_SHARE)), dtype=np.bool_)


def roughness(t_s: Array, place: Array) -> Array:
    """Return by how much each place (n,) is off the cubic through its four neighbours, squared.

    Shape (n − 4,); over the variance that white noise of unit variance gives it, so that it is the
    noise's variance where the times are right. Infinite where times fall together.
    """
    here = t_s[2:-2]
    near = [(t_s[:-4], place[:-4]), (t_s[1:-3], place[1:-3])]
    near += [(t_s[3:-1], place[3:-1]), (t_s[4:], place[4:])]
    expected, gain = np.zeros(len(here)), np.ones(len(here))
    with np.errstate(divide="ignore", invalid="ignore"):
        for i, (own, value) in enumerate(near):
            weight = np.ones(len(here))
            for j, (other, _) in enumerate(near):
                if j != i:
                    weight *= (here - other) / (own - other)
            expected += weight * value
            gain += weight**2
        found = (place[2:-2] - expected) ** 2 / gain
    return np.where(np.isfinite(found), found, np.inf)


def _time(seconds: float) -> str:
    """Return a time with a unit that suits it."""
    for unit, name in ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs")):
        if seconds >= unit:
            return f"{seconds / unit:.3g} {name}"
    return f"{seconds / 1e-9:.3g} ns"
