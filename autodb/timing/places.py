"""Places as loggers give them: counters that wrap, leaps, and places that are refreshed seldom."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from autodb.timing.verdict import StampFinding
from autodb.wording import localized, phrase, stored_msgid

Array = NDArray[np.float64]
Index = NDArray[np.intp]

PLACES = (".position", ".angle")
"""Ends of the names of channels that say where an axis is: smooth over time."""
EFFORTS = (".current", ".drive_force", ".drive_torque")
"""Ends of the names of channels that say what a drive gives."""
TURN_DEG = 360.0
FASTEST = 0.4
"""Share of a turn that an angle may go in one row and still be counted on: half a turn could be
either way. Chosen."""
LEAP, SELDOM = 10.0, 0.02
"""Times the widest ordinary step that a position leaps by where it does not move there, and the
share of its rows that do so at most. Chosen."""
FOLLOWED = 0.5
"""Share of its widest step by which the steps of a place change from row to row at most, where rows
are dense enough to follow it. Chosen."""
ORDINARY = 0.999
"""Share of the steps of an angle that are ordinary. Chosen."""
ALIKE = 2.0
"""Ratio of the steps before and after a wrap at most: an axis goes on through it. Chosen."""
POLLED, RESOLUTIONS, FEWEST_STEPS = 0.9, 5.0, 50
"""A place is refreshed seldom where over this share of its steps that are RESOLUTIONS times its
resolution, of so many at least, have a neighbour of zero. Chosen: an encoder's own steps are of one
resolution."""
LEAST_REPEATED = 0.25
"""Share of the rows that repeat the place before at least, where it is refreshed seldom: every
second row where it always moves, and it rests for half of the time. Chosen."""
FEWEST_HELD = 3
"""Rows from one refreshing of an effort to the next at least, to be held: of two inertia was within
0.3 %, of four 0.9 % too small, of sixteen 5 %."""
SLOWEST_POLL = 50
"""Rows from one refreshing of a place to the next at most. Chosen."""
SPLINE = stored_msgid(
    "{channel} is refreshed every {count} rows only: the rows between by a spline"
)
STRAIGHT = stored_msgid(
    "{channel} is refreshed every {count} rows only: the rows between by straight lines"
)
WRAPS_AT = stored_msgid("{channel} wraps at {at}: counted on, {count}")
ONCE = stored_msgid("once")
TIMES = stored_msgid("{count} times")


def filled_between(name: str, values: Array) -> tuple[Array, StampFinding | None]:
    """Return a place (n,) that is refreshed only every few rows, between them by a spline.

    What moves on every row does not stand still in between.
    """
    from scipy.interpolate import CubicSpline

    if np.count_nonzero(values[1:] == values[:-1]) < LEAST_REPEATED * len(values):
        return values, None
    wide = np.abs(np.diff(values))
    moved = wide[wide > 0]
    if moved.size < FEWEST_STEPS or not np.isfinite(wide).all():
        return values, None
    far = np.flatnonzero(wide[1:-1] > RESOLUTIONS * moved.min()) + 1
    beside = (wide[far - 1] == 0) | (wide[far + 1] == 0)
    if far.size < FEWEST_STEPS or np.mean(beside) < POLLED:
        return values, None
    changes = np.flatnonzero(wide > 0) + 1
    every = float(np.median(np.diff(far)))
    if not 1.0 < every <= SLOWEST_POLL:
        return values, None
    knots = _polls(changes, every, len(values))
    sentence = SPLINE.format(channel=name, count=f"{every:g}")
    made = CubicSpline(knots, values[knots])(np.arange(len(values)))
    return np.asarray(made, dtype=np.float64), StampFinding("polled place", sentence, len(values))


def drawn_between(name: str, values: Array) -> tuple[Array, StampFinding | None]:
    """Return an effort (n,) that is refreshed every few rows only, between them by straight lines.

    Held, it would lag behind by half of that time, and inertia come out too small.
    """
    changes = np.flatnonzero(values[1:] != values[:-1]) + 1
    if not FEWEST_STEPS < changes.size <= len(values) / FEWEST_HELD:
        return values, None
    lasts = np.diff(changes)
    every = float(np.median(lasts))
    alike = np.quantile(lasts, [0.5 * (1.0 - POLLED), POLLED]) - every
    if not FEWEST_HELD <= every <= SLOWEST_POLL or alike[0] < -1.0 or alike[1] > 1.0:
        return values, None
    knots = np.concatenate([[0], changes])
    made = np.interp(np.arange(len(values)), knots, values[knots])
    sentence = STRAIGHT.format(channel=name, count=f"{every:g}")
    return made, StampFinding("polled effort", sentence, len(values))


def _polls(changes: Index, every: float, rows: int) -> Index:
    """Return the rows at which a place was refreshed: where it changed, and as often where it
    rested.
    """
    ends = np.concatenate([[0], changes, [rows - 1]])
    rests = [
        np.arange(begin + every, end - 0.5 * every, every)
        for begin, end in pairwise(ends)
        if end - begin > 1.5 * every
    ]
    return np.unique(np.concatenate([ends, *rests]).astype(np.intp))


def unwrapped(name: str, values: Array) -> tuple[Array, StampFinding | None, str]:
    """Return a place (n,) counted on over its wraps, what was found, and why it cannot be used.

    An angle wraps at a turn, a position where its counter has no more digits.
    """
    if len(values) < 2 or not np.isfinite(values).all():
        return values, None, ""
    if name.endswith(".angle"):
        return _angle(name, values, np.abs(np.diff(values)))
    leaps = leaping(values)
    if not leaps.size:
        return values, None, ""
    return _position(name, values, np.diff(values), leaps)


def _angle(name: str, values: Array, wide: Array) -> tuple[Array, StampFinding | None, str]:
    turns = np.flatnonzero(wide > 0.5 * TURN_DEG)
    if not turns.size or np.ptp(values) > TURN_DEG * (1.0 + 1e-9):
        return values, None, ""
    on = np.unwrap(values, period=TURN_DEG)
    fastest = float(np.quantile(np.abs(np.diff(on)), ORDINARY))
    if fastest > FASTEST * TURN_DEG:
        why = phrase(
            "{name} starts again at {turn_deg}° and turns by {fastest}° in a row: too far "
            "to count turns; record it at a higher rate, or counted on over turns",
            name=name,
            turn_deg=localized(f"{TURN_DEG:g}"),
            fastest=localized(f"{fastest:.3g}"),
        )
        return values, None, why
    sentence = WRAPS_AT.format(channel=name, at=f"{TURN_DEG:g}°", count=_times(len(turns)))
    return on, StampFinding("wrapped place", sentence, len(turns)), ""


def _times(count: int) -> str:
    return ONCE if count == 1 else TIMES.format(count=count)


def leaping(values: Array) -> Index:
    """Return the rows (k,) before which a place leaps as no axis moves."""
    wide = np.diff(values)
    if wide.size < 10:
        return np.zeros(0, dtype=np.intp)
    np.abs(wide, out=wide)
    most = float(wide.max())
    if not most > 0.02 * float(np.ptp(values)):
        return np.zeros(0, dtype=np.intp)
    ordinary = float(wide[wide < 0.25 * most].max(initial=0.0))
    leaps = np.flatnonzero(wide >= 0.5 * most)
    if not 0.0 < LEAP * ordinary < most or len(leaps) > SELDOM * wide.size:
        return np.zeros(0, dtype=np.intp)
    bends = np.abs(np.diff(wide))
    bends[np.maximum(leaps - 1, 0)] = 0.0
    bends[np.minimum(leaps, len(bends) - 1)] = 0.0
    if bends.max() > FOLLOWED * ordinary:
        return np.zeros(0, dtype=np.intp)
    return np.asarray(leaps + 1, dtype=np.intp)


def _position(
    name: str, values: Array, steps: Array, leaps: Index
) -> tuple[Array, StampFinding | None, str]:
    """Count a position on over the leaps at which it goes on as fast as before."""
    own = steps[leaps - 1]
    before = steps[np.maximum(leaps - 2, 0)]
    after = steps[np.minimum(leaps, len(steps) - 1)]
    through = (before * after > 0) & (before * own < 0)
    slower, faster = np.minimum(abs(before), abs(after)), np.maximum(abs(before), abs(after))
    through &= faster <= ALIKE * slower
    spans = np.abs(own) + 0.5 * np.abs(before + after)
    reach = np.ptp(values)
    through &= np.abs(spans - reach) <= 2.0 * np.abs(before + after) + 1e-9 * reach
    if not through.all():
        return values, None, ""
    span = float(np.median(spans))
    on = values.copy()
    for row, way in zip(leaps, np.sign(before), strict=True):
        on[row:] += way * span
    sentence = WRAPS_AT.format(channel=name, at=f"{span:.6g}", count=_times(len(leaps)))
    return on, StampFinding("wrapped place", sentence, len(leaps)), ""
