"""Which cuts of a predicted job the cuts are that were then made.

A cut that says which one it is, by name or by the line of its program, is that one. Any other is
looked for by what was cut: operation, depth, width and diameter are as asked for within tolerances,
feed and speed within what an override makes of them, and so is how long it took, where that is
known. A line of a program is looked for by its speed and by how long it took. Where several cuts of
the job fit, the order of all decides, as far as it leaves one way only (longest common
subsequence); the rest is left open, to be asked.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np
from numpy.typing import NDArray

from autodb.files.channels import DURATION
from autodb.pairs.engaged import DEPTH, DIAMETER, FEED, RPM, SPEED, WIDTH, Conditions

SAME: Mapping[str, tuple[float, float]] = {
    DEPTH: (0.05, 0.05), WIDTH: (0.05, 0.05), DIAMETER: (0.01, 0.1),
}  # fmt: skip
"""By how much what is cut may be off and be the same: a share, or mm where that is more. Chosen:
allowances vary and tools wear by so much; steps of a job differ by more."""
OVERRIDE = (0.5, 1.5)
"""Between which shares of what was asked for feed and speed may be. Chosen: what the switches of
most controllers reach while cutting."""
LASTS = (0.1, 0.5)
"""By how much a cut may be longer or shorter than was asked for: a share, or s where that is more.
Chosen: entry and exit take some turns, slides speed up and slow down."""
LINE_RPM = 0.05
"""Share by which the speed of a program's line may be off. Chosen: a motor slips by less."""
MOST = 500
"""Cuts up to which their order is looked at. Chosen: a thousand take a second."""


@dataclass(frozen=True)
class CutOfJob:
    """A cut of a job that was predicted: what is known of it by channel.

    ``of_program``: one line of a program or several, of which speed and feed alone are known, and
    ``block`` which line it is; ``end_mm``: the diameter where it ends, if that is another;
    ``time_s``: how long it takes as asked for, None where nobody says how far it goes.
    """

    name: str
    operation: str
    conditions: Conditions
    block: int | None = None
    end_mm: float | None = None
    time_s: float | None = None
    of_program: bool = False


@dataclass(frozen=True)
class MadeCut:
    """A cut that was made, in the order of the machine; what it says itself of which it is."""

    operation: str
    conditions: Conditions
    name: str | None = None
    block: float | None = None

    @property
    def says(self) -> bool:
        """Whether it says which cut it is."""
        return self.name is not None or self.block is not None


@dataclass(frozen=True)
class Match:
    """Places in the job, from 0, that a made cut may have: one, none, or several to be asked about.

    ``by_name``: it says so itself.
    """

    places: tuple[int, ...]
    by_name: bool = False

    @property
    def place(self) -> int | None:
        """The one place that it has; None: there is none, or not one."""
        return self.places[0] if len(self.places) == 1 else None


def fits(asked: CutOfJob, made: MadeCut) -> bool:
    """Say whether a made cut may be the one asked for: operation, conditions, how long it took."""
    if asked.operation != made.operation:
        return False
    if asked.of_program:
        return _fits_line(asked, made)
    same = [name for name in SAME if name in asked.conditions and name in made.conditions]
    alike = all(_same(name, made.conditions[name], asked) for name in same)
    known = bool(same or FEED in made.conditions)
    return alike and known and overridden_alike(asked, made) and _lasts_alike(asked, made)


def _fits_line(asked: CutOfJob, made: MadeCut) -> bool:
    """Say whether a made cut may be a line of a program: its speed is known, and how long it took.

    Where its feed is not known on both sides it took as long as without an override.
    """
    rpm, made_rpm = asked.conditions.get(RPM), made.conditions.get(RPM)
    time_s, lasted_s = asked.time_s, made.conditions.get(DURATION)
    if rpm is None or made_rpm is None or time_s is None or lasted_s is None:
        return False
    fed = FEED in asked.conditions and FEED in made.conditions
    alike = abs(made_rpm - rpm) <= LINE_RPM * rpm and (fed or _near(lasted_s, time_s, time_s))
    return alike and overridden_alike(asked, made) and _lasts_alike(asked, made)


def _lasts_alike(asked: CutOfJob, made: MadeCut) -> bool:
    """Say whether a cut took as long as asked for, as far as both are known.

    At the feed and speed that it was made with; where these are not known on both sides, as long as
    an override may make of it.
    """
    if asked.time_s is None or DURATION not in made.conditions:
        return True
    slowest, fastest = OVERRIDE
    least_s, most_s = asked.time_s / fastest, asked.time_s / slowest
    rates = [one.conditions.get(FEED, 0.0) * one.conditions.get(RPM, 0.0) for one in (asked, made)]
    if all(rates):
        least_s = most_s = asked.time_s * rates[0] / rates[1]
    return _near(made.conditions[DURATION], least_s, most_s)


def _near(lasted_s: float, least_s: float, most_s: float) -> bool:
    share, least_off_s = LASTS
    off_s = max(share * most_s, least_off_s)
    return least_s - off_s <= lasted_s <= most_s + off_s


def overridden_alike(asked: CutOfJob, made: MadeCut) -> bool:
    """Say whether feed and speed are those asked for, but for an override."""
    speed = RPM if RPM in made.conditions else SPEED
    low, high = OVERRIDE
    return bool(asked.conditions) and all(
        low * asked.conditions[name] <= made.conditions[name] <= high * asked.conditions[name]
        for name in (FEED, speed)
        if name in asked.conditions and name in made.conditions
    )


def _same(name: str, value: float, asked: CutOfJob) -> bool:
    """Say whether a value is what was asked for; of a diameter, or between it and its end."""
    share, least = SAME[name]
    ends = [asked.conditions[name]]
    if name == DIAMETER and asked.end_mm is not None:
        ends.append(asked.end_mm)
    off = max(share * max(ends), least)
    return min(ends) - off <= value <= max(ends) + off


def matched(asked: Sequence[CutOfJob], made: Sequence[MadeCut]) -> list[Match]:
    """Return of each made cut, in their order, which cuts of the job it may be."""
    every = [_places(asked, one) for one in made]
    there = [k for k, places in enumerate(every) if places]
    found = [Match(places, one.says) for places, one in zip(every, made, strict=True)]
    if any(len(every[k]) > 1 for k in there) and len(there) <= MOST:
        by_order = _in_order(len(asked), [every[k] for k in there])
        for k, places in zip(there, by_order, strict=True):
            found[k] = Match(places, made[k].says)
    return found


def _places(asked: Sequence[CutOfJob], made: MadeCut) -> tuple[int, ...]:
    """Return the places of one cut: those of its name or block, else those that fit."""
    if not made.says:
        return tuple(k for k, one in enumerate(asked) if fits(one, made))
    if made.name is None:
        return tuple(k for k, one in enumerate(asked) if one.block == made.block)
    called = tuple(k for k, one in enumerate(asked) if one.name == made.name)
    number = made.name.removesuffix(".0")
    if called or not number.isdecimal() or not 0 < int(number) <= len(asked):
        return called
    return (int(number) - 1,)


def _in_order(n: int, places: Sequence[tuple[int, ...]]) -> list[tuple[int, ...]]:
    """Return the places that are left to cuts which are made in the order of the job.

    The job of n cuts may be made several times. Where not all cuts can be in order, or where they
    are repeated or missing, so that several ways are left, all of their places are.
    """
    passes = ceil(len(places) / n)
    fit = np.zeros((passes * n, len(places)), dtype=np.bool_)
    for k, some in enumerate(places):
        for place in some:
            fit[place::n, k] = True
    before, after = _longest(fit), _longest(fit[::-1, ::-1])[::-1, ::-1]
    if before[-1, -1] < len(places):
        return list(places)
    on_a_way = fit & (before[:-1, :-1] + 1 + after[1:, 1:] == len(places))
    return [
        tuple(sorted({int(p) % n for p in np.flatnonzero(on_a_way[:, k])}))
        for k in range(len(places))
    ]


def _longest(fit: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Return how many of the first k cuts can be in order in the first p places (p + 1, k + 1)."""
    longest = np.zeros((fit.shape[0] + 1, fit.shape[1] + 1), dtype=np.int32)
    for p, row in enumerate(fit):
        best = np.maximum(longest[p, 1:], longest[p, :-1] + row)
        longest[p + 1, 1:] = np.maximum.accumulate(best)
    return longest
