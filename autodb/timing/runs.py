"""Rows in the order of time: what runs backwards, wraps, starts again or arrived out of order."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.timing.verdict import StampFinding
from autodb.wording import stored_msgid

Array = NDArray[np.float64]
Index = NDArray[np.intp]

WRAPS: tuple[tuple[float, str], ...] = (
    *((2.0**32 * unit, f"32-bit {name}") for unit, name in ((1e-6, "µs"), (1e-3, "ms"))),
    *((2.0**32 * unit, f"32-bit {name}") for unit, name in ((1e-7, "100 ns"), (1e-9, "ns"))),
    *((2.0**31 * unit, f"31-bit {name}") for unit, name in ((1e-6, "µs"), (1e-3, "ms"))),
    *((2.0**24 * unit, f"24-bit {name}") for unit, name in ((1e-6, "µs"), (1e-3, "ms"))),
    *((2.0**16 * unit, f"16-bit {name}") for unit, name in ((1e-3, "ms"), (1e-4, "0.1 ms"))),
    (2.0**16 * 1e-6, "16-bit µs"),
)
"""Spans (s) after which counters of a clock begin again at zero, and what they count."""
CALENDAR: tuple[tuple[float, str], ...] = ((60.0, "minute"), (3600.0, "hour"), (86400.0, "day"))
"""Spans (s) after which a time of the day begins again. As long may a run be that starts again, so
that position has to go on."""
LATE_ROWS = 200
"""Rows that may arrive late; where more do, the clock was set back. Chosen."""
OFTEN = 0.2
"""Share of rows that go back in time, above which stamps jitter. Chosen."""
ORDERLY = 0.1
"""Share of a step by which steps of rows that were sorted may differ. Chosen."""
NEIGHBOURS = 5
NO_STAMP = stored_msgid("{rows} without a stamp, or with one far off, left out")
BACKWARDS = stored_msgid("time runs backwards: rows turned round")
LATE = stored_msgid("{rows} out of order put at their time")
GOES_BACK = stored_msgid("the clock goes back by {time} at row {row}: a run of its own")
ROWS = stored_msgid("{count} rows")
ROW = stored_msgid("1 row")


@dataclass(frozen=True)
class Ordered:
    """The file's ``rows`` in time, and their stamps (n,); ``starts``: where a run begins."""

    rows: Index
    t_s: Array
    starts: tuple[int, ...]
    findings: tuple[StampFinding, ...]


def in_order(t_s: Array, channels: Sequence[Array], places: Sequence[Array]) -> Ordered:
    """Put the rows of a file in order.

    ``t_s`` (N,) its stamps, NaN where there is none, ``channels`` (N,) each, ``places`` those that
    are positions or angles.
    """
    findings: list[StampFinding] = []
    rows = np.flatnonzero(np.isfinite(t_s))
    rows = rows[~_stray(t_s[rows])]
    if len(rows) < len(t_s):
        lost = len(t_s) - len(rows)
        sentence = NO_STAMP.format(rows=_rows(lost))
        findings.append(StampFinding("no stamp", sentence, lost))
    steps = np.diff(t_s[rows])
    if np.sum(steps < 0) > np.sum(steps > 0):
        rows = rows[::-1]
        findings.append(StampFinding("backwards", BACKWARDS, len(rows)))
    rows, late = _sorted(t_s, rows, channels)
    if late:
        findings.append(StampFinding("out of order", LATE.format(rows=_rows(late)), late))
    found = _counted_on(t_s[rows], [place[rows] for place in places])
    return Ordered(rows, found[0], found[1], (*findings, *found[2]))


def _stray(t: Array) -> NDArray[np.bool_]:
    """Return which single stamps (n,) are far off while those about them go on."""
    far = LATE_ROWS * _typical(t)
    stray = np.zeros(len(t), dtype=np.bool_)
    goes_on = (t[2:] > t[:-2]) & (t[2:] - t[:-2] < far)
    off = np.abs(t[1:-1] - 0.5 * (t[2:] + t[:-2])) > far
    stray[1:-1] = goes_on & off
    return stray


def _sorted(t_s: Array, rows: Index, channels: Sequence[Array]) -> tuple[Index, int]:
    """Return the rows with those that arrived late at their time, and how many were moved.

    Only where the steps then are even: stamps that merely jitter past each other are no order. Nor
    are two runs over the same time, of which rows with one stamp are no copies.
    """
    t = t_s[rows]
    step = _typical(t)
    moved = rows.copy()
    late, done = 0, 0
    backs = np.flatnonzero(np.diff(t) < 0)
    if len(backs) > OFTEN * len(t):
        return rows, 0
    for back in backs:
        if back < done:
            continue
        before = t[max(0, int(back) - LATE_ROWS) : back + 1]
        begin = int(np.argmax(before > t[back + 1])) + max(0, int(back) - LATE_ROWS)
        behind = t[back + 1 : back + 1 + LATE_ROWS] < t[back]
        if behind.all():
            continue
        end = _settled(t, begin, int(back + 2 + np.flatnonzero(behind)[-1]))
        window = slice(max(0, begin - 2), min(len(t), end + 2))
        order = np.argsort(t[window], kind="stable")
        apart = _uneven(t[window], step)
        if _uneven(t[window][order], step) <= 0.25 * apart and _copies(
            t[window][order], rows[window][order], channels
        ):
            late += int(np.sum(order != np.arange(len(order))))
            moved[window] = rows[window][order]
            done = window.stop
    return moved, late


def _copies(t: Array, rows: Index, channels: Sequence[Array]) -> bool:
    """Say whether rows with one stamp (n,), sorted, are copies of each other."""
    twice = np.flatnonzero(np.diff(t) == 0)
    one, other = rows[twice], rows[twice + 1]
    return all(np.array_equal(c[one], c[other], equal_nan=True) for c in channels)


def _settled(t: Array, begin: int, end: int) -> int:
    """Return the row from which on all stamps, as far as rows may be late, are later."""
    for _ in range(NEIGHBOURS):
        top = t[begin:end].max()
        behind = np.flatnonzero(t[end : end + LATE_ROWS] < top)
        if not behind.size:
            return end
        end += int(behind[-1]) + 1
    return end


def _uneven(t: Array, step: float) -> int:
    """Return how many steps are off, those between rows with one stamp left out."""
    steps = np.diff(t)
    return int(np.sum(np.abs(steps[steps != 0] - step) > ORDERLY * step))


def _typical(t: Array) -> float:
    steps = np.diff(t)
    ahead = steps[steps > 0]
    return float(np.median(ahead)) if ahead.size else 0.0


def _counted_on(
    t_s: Array, places: Sequence[Array]
) -> tuple[Array, tuple[int, ...], list[StampFinding]]:
    """Return stamps that go on where the clock went back, where runs begin, and what was found.

    A step back of less than a few steps is left to what jitters.
    """
    step = _typical(t_s)
    t, starts, findings = t_s.copy(), [0], []
    for back in np.flatnonzero(np.diff(t_s) < 0):
        begin = int(back) + 1
        fell = float(t_s[back] - t_s[begin])
        ahead = t_s[begin : begin + LATE_ROWS]
        at_end = len(ahead) < LATE_ROWS and fell <= NEIGHBOURS * step
        if at_end or (np.median(ahead) > t_s[back] and fell < LATE_ROWS * step):
            continue  # it soon is past where it was: jitter
        span, name, certain = _span(fell, step)
        goes_on = _goes_on(places, begin)
        if span and goes_on is not False and (certain or goes_on):
            t[begin:] += span
            sentence = f"{name} wrapped: counted on over {span:.9g} s"
            findings.append(StampFinding("wrapped", sentence, len(t) - begin))
            continue
        t[begin:] += fell + step
        starts.append(begin)
        sentence = GOES_BACK.format(time=f"{fell:.6g} s", row=begin + 1)
        findings.append(StampFinding("restarted", sentence, len(t) - begin))
    return t, tuple(starts), findings


def _span(fell: float, step: float) -> tuple[float, str, bool]:
    """Return the span of the counter that wrapped, its name, and whether nothing else is as long.

    0 where no counter fits.
    """
    for number, (span, name) in enumerate((*WRAPS, *CALENDAR)):
        if abs(fell + step - span) <= 2.0 * step:
            certain = number < len(WRAPS)
            return span, f"a counter of {name}" if certain else f"the time of the {name}", certain
    return 0.0, "", False


def _goes_on(places: Sequence[Array], begin: int) -> bool | None:
    """Say whether the axes go on over a row as they move about it; None where all stand."""
    moving = False
    for place in places:
        near = np.abs(np.diff(place[max(0, begin - NEIGHBOURS) : begin + NEIGHBOURS]))
        own = min(begin, NEIGHBOURS) - 1
        others = np.delete(near, own)
        if not others.size:
            continue
        if near[own] > 3.0 * others.max() and near[own] > 0:
            return False
        moving = moving or bool(others.max() > 0)
    return True if moving else None


def _rows(count: int) -> str:
    return ROWS.format(count=count) if count > 1 else ROW
