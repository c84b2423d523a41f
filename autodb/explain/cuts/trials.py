"""Cuts that a shop can make after a table of cuts, each close to what the table shows as usual.

A trial is the table's most usual cut some times over, with one thing changed, or two: feed, depth
or speed, or what the edge and the clock went through before. Only what the table has is changed.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from autodb.explain.cuts.stack import FLANK_WEAR, Conditions
from autodb.wording import significant, stored_msgid

Array = NDArray[np.float64]

CUTS = 10
FACTORS = (0.5, 2.0)
LEAST, MOST = 0.5, 1.5
"""Shares of the least and the most that the table's cuts and edges went through: a trial stays
between them. Chosen: lighter cuts are harmless, much heavier ones are not."""
SAME = 1.05
"""Values that differ by less than this factor are the same."""
REST = 0.5
"""A trial after a rest begins this share of the table's time after its last cut."""
FEED, DEPTH, SPEED = ("cutting.feed", "chip.thickness"), ("cutting.depth",), ("cutting.speed",)
UNIT = {FEED: "mm", DEPTH: "mm", SPEED: "m/min"}
MAKE = stored_msgid("Make {count} cuts like cut {number}")
MORE_FIRST = stored_msgid(
    "Cut {time} more with the last edge, then make {count} cuts like cut {number}"
)
REST_FIRST = stored_msgid(
    "Let the machine rest for {time}, then make {count} cuts like cut {number}"
)
CHANGED = {
    FEED: stored_msgid("{move}, with a feed of {size} instead of {before}"),
    DEPTH: stored_msgid("{move}, with a depth of {size} instead of {before}"),
    SPEED: stored_msgid("{move}, with a speed of {size} instead of {before}"),
}
FEED_FOR_DEPTH = stored_msgid(
    "{move}, with a feed of {feed} instead of {had_feed} and with a depth of {depth} instead of "
    "{had_depth}"
)


@dataclass(frozen=True)
class Setting:
    """How a trial is set: factors on the usual cut's columns, and that in words.

    ``words``: of a trial whose words stand in ``{move}``.
    """

    words: str = "{move}"
    factors: dict[tuple[str, ...], float] = field(default_factory=dict)


@dataclass(frozen=True)
class Before:
    """What comes before a trial: another edge, its cutting time by then, a pause of the clock.

    ``words``: of the trial too, of ``{count}`` cuts like one with a ``{number}``.
    """

    words: str
    edge: float | None = None
    cutting_time_s: float | None = None
    pause_s: float = 0.0


@dataclass(frozen=True)
class CutTrial:
    """A trial in words, in the imperative, and the conditions of its cuts."""

    words: str
    known: Conditions


def usual(known: Conditions) -> int:
    """Return the row of the cut that is nearest to the median of feed, depth and speed."""
    seen = [v for _, v in _settable(known) if np.ptp(v) > 0]
    off = [np.abs(np.log(v / np.median(v))) for v in seen]
    return int(np.argmin(np.sum(off, axis=0))) if off else 0


def plain_trials(known: Conditions) -> list[CutTrial]:
    """Return the trials in which one thing is changed, and the usual cut once more."""
    row, once = usual(known), Setting()
    before = _before(known)
    settings = [once, *_settings(known, row)]
    return [
        *(_trial(known, row, setting, before[0]) for setting in settings),
        *(_trial(known, row, once, other) for other in before[1:]),
    ]


def paired(known: Conditions) -> list[CutTrial]:
    """Return the trials in which a setting is changed, and what comes before."""
    row = usual(known)
    pairs = product(_settings(known, row), _before(known)[1:])
    return [_trial(known, row, setting, before) for setting, before in pairs]


def joined_trials(parts: Sequence[Conditions]) -> Conditions:
    """Return the conditions of all trials, one after the other."""
    first = parts[0]

    def all_of(read: Callable[[Conditions], Array]) -> Array:
        return np.concatenate([read(part) for part in parts])

    def known_of(read: Callable[[Conditions], Array | None]) -> Array | None:
        found = [values for part in parts if (values := read(part)) is not None]
        return np.concatenate(found) if found else None

    return replace(
        first,
        number=all_of(lambda part: part.number),
        t_s=all_of(lambda part: part.t_s),
        depth_mm=all_of(lambda part: part.depth_mm),
        thickness_mm=known_of(lambda part: part.thickness_mm),
        speed_m_min=known_of(lambda part: part.speed_m_min),
        edge=known_of(lambda part: part.edge),
        cutting_time_s=known_of(lambda part: part.cutting_time_s),
        land_mm=known_of(lambda part: part.land_mm),
        other={name: np.concatenate([part.other[name] for part in parts]) for name in first.other},
    )


def _settable(known: Conditions) -> list[tuple[tuple[str, ...], Array]]:
    """Return what can be set of the columns that the table has, with its values (n,)."""
    found: list[tuple[tuple[str, ...], Array]] = []
    if known.thickness_mm is not None:
        found.append((FEED, known.thickness_mm))
    if DEPTH[0] in known.recorded:
        found.append((DEPTH, known.depth_mm))
    if known.speed_m_min is not None:
        found.append((SPEED, known.speed_m_min))
    return found


def _settings(known: Conditions, row: int) -> list[Setting]:
    """Return each column at half, at twice and at either limit, and another shape of one area."""
    made = []
    for columns, values in _settable(known):
        now, low, high = float(values[row]), *_limits(values)
        targets = {float(f"{np.clip(f * now, low, high):.3g}") for f in FACTORS}
        targets |= {float(f"{limit:.3g}") for limit in (low, high)}
        made += [
            Setting(_changed(columns, now, target), {columns: target / now})
            for target in sorted(targets)
            if max(target / now, now / target) > SAME
        ]
    return [*made, *_same_area(known, row)]


def _limits(values: Array) -> tuple[float, float]:
    return LEAST * float(values.min()), MOST * float(values.max())


def _changed(columns: tuple[str, ...], now: float, target: float) -> str:
    asked, had = (f"{significant(value)} {UNIT[columns]}" for value in (target, now))
    return CHANGED[columns].format(move="{move}", size=asked, before=had)


def _same_area(known: Conditions, row: int) -> list[Setting]:
    """Return more feed for less depth, and less for more, the area of the chip kept."""
    seen = dict(_settable(known))
    if not {FEED, DEPTH} <= seen.keys():
        return []
    made = []
    for factor in FACTORS:
        factors = {FEED: factor, DEPTH: 1.0 / factor}
        now = {c: float(seen[c][row]) for c in factors}
        inside = [
            _limits(seen[c])[0] <= f * now[c] <= _limits(seen[c])[1] for c, f in factors.items()
        ]
        if all(inside):
            (feed, had_feed), (depth, had_depth) = (
                [f"{significant(value)} {UNIT[c]}" for value in (f * now[c], now[c])]
                for c, f in factors.items()
            )
            words = FEED_FOR_DEPTH.format(
                move="{move}", feed=feed, depth=depth, had_feed=had_feed, had_depth=had_depth
            )
            made.append(Setting(words, factors))
    return made


def _before(known: Conditions) -> list[Before]:
    """Return what may come before a trial, nothing first."""
    made = [Before(MAKE)]
    time, edge = known.cutting_time_s, known.edge
    if time is not None and edge is not None:
        last = float(time[-1])
        longer = MOST * float(time.max()) - last
        made.append(
            Before(
                stored_msgid("Change the edge and make {count} cuts like cut {number}"),
                edge=float(edge.max()) + 1.0,
                cutting_time_s=float(time.min()),
            )
        )
        made.append(
            Before(
                _after(MORE_FIRST, longer),
                cutting_time_s=last + longer,
                pause_s=longer,
            )
        )
    pause_s = REST * float(known.t_s[-1] - known.t_s[0])
    if "t" in known.recorded and pause_s > 0:
        made.append(Before(_after(REST_FIRST, pause_s), pause_s=pause_s))
    return made


def _after(words: str, time_s: float) -> str:
    """Return the words of trials after some time, in min."""
    time = f"{significant(time_s / 60.0, 2)} min"
    return words.format(time=time, count="{count}", number="{number}")


def _trial(known: Conditions, row: int, setting: Setting, before: Before) -> CutTrial:
    factor = {name: f for columns, f in setting.factors.items() for name in columns}

    def set_to(values: Array | None, name: str = "") -> Array | None:
        return None if values is None else np.full(CUTS, values[row] * factor.get(name, 1.0))

    count = np.arange(CUTS, dtype=np.float64)
    depth = set_to(known.depth_mm, DEPTH[0])
    assert depth is not None
    time = _cutting_time(known, before, count)
    other = {n: v for n, values in known.other.items() if (v := set_to(values, n)) is not None}
    land = _land(known, before)
    new = {"tool.cutting_time": time, FLANK_WEAR: land}
    other |= {name: v for name, v in new.items() if v is not None and name in other}
    return CutTrial(
        setting.words.format(move=before.words.format(count=CUTS, number=f"{known.number[row]:g}")),
        replace(
            known,
            number=known.number.max() + 1.0 + count,
            t_s=known.t_s[-1] + before.pause_s + _step(known.t_s) * (1.0 + count),
            depth_mm=depth,
            thickness_mm=set_to(known.thickness_mm, FEED[0]),
            speed_m_min=set_to(known.speed_m_min, SPEED[0]),
            edge=_edge(known, before),
            cutting_time_s=time,
            land_mm=land,
            other=other,
        ),
    )


def _land(known: Conditions, before: Before) -> Array | None:
    """Return the flank wear at each cut of a trial (CUTS,): as in the last cut, or of the least
    worn edge that was seen where the edge is changed.
    """
    if known.land_mm is None:
        return None
    return np.full(CUTS, known.land_mm[-1] if before.edge is None else known.land_mm.min())


def _edge(known: Conditions, before: Before) -> Array | None:
    if known.edge is None:
        return None
    return np.full(CUTS, known.edge[-1] if before.edge is None else before.edge)


def _cutting_time(known: Conditions, before: Before, count: Array) -> Array | None:
    """Return the cutting time of the edge at each cut of a trial (CUTS,)."""
    if known.cutting_time_s is None:
        return None
    step = _step(known.cutting_time_s)
    if before.cutting_time_s is not None:
        return np.asarray(before.cutting_time_s + step * count)
    return np.asarray(known.cutting_time_s[-1] + step * (1.0 + count))


def _step(values: Array) -> float:
    """Return the usual step from cut to cut, of those that rise."""
    steps = np.diff(values)
    rising = steps[steps > 0]
    return float(np.median(rising)) if rising.size else 0.0
