"""Why intervals are wider than what a pair has learnt says: four reasons.

**Past predictions** were less right than they said: every interval is wider by one factor, which
`autodb/forward/scored.py` finds.

**An edge is older than any that a pair was learnt with.** Forces of edges nobody has seen are not
those of fresh ones, and they grow. Where a pair's posterior has no wear yet, the high end of a
turned cut whose edge has cut T seconds before, when its cuts have gone up to T_0, is farther off by

    g F (T - T_0) / T_L

with the growth g that edges have at a flank wear of 0.3 mm, by component: 26 % of the cutting
force, 117 % of the feed force, 78 % of the passive force, the middle of what Vicomtech's turning
tests of tools 3, 11, 13, 15 and 16 show at 0.27 to 0.39 mm. T_L is 900 s, the life of ISO 3685's
reference conditions; most shops plan for longer, so that few edges grow faster.

Where the posterior has wear, an edge that is said to be older than any that was seen is that, or
was changed and nobody set its counter back. Of edges whose lives are spread evenly up to one that
nobody knows, the next of n reaches T, given that it reaches the longest seen, T_r, with

    p = (T_r / T)^n

The value is the mean of both accounts with that probability: of an edge of age T, and of one that
was changed at T_r and has cut T - T_r since. The interval runs from what a new edge takes to what
one of age T does.

**Nobody has decided what some cuts were.** Of a pair with an open mismatch some cuts are excluded:
they were not as learnt. Until a person says what they were, the next cut may be of either kind, and
its force F has a mixture of both,

    F ~ (1 - p) N(m (1 + b), s²) + p sum_j v_j N(m (1 + r_j), (m s_j)²),    sum v_j = 1

with m and s as learnt, and of each excluded cut j the share r_j by which its force was off what is
learnt, which s_j of sensing and scatter blurs. What nobody has decided on also bent what was learnt
from the others: b is what they are off by here. All is local: with weights of all cuts of the pair
to the one asked for,

    w_j = 2^(-a_j / A) exp(-½ sum_d (x_d - x_dj)² / h_d²)

a_j cuts ago, at x the logarithms of cutting speed, time on the edge and flank wear, as far as both
state them, p = (sum of excluded w_j + p_0) / (sum of w_j + 1), p_0 the excluded share of all cuts
by age alone, which also shares its one cut's weight among them, and b = sum of w_j r_j / (sum of
w_j + 1) over cuts that are not excluded. A band of speed widens where it is,
wear where edges are as old, what nobody can place everywhere; the newest cuts tell most. The
interval runs between the mixture's 2.5 and 97.5 %, and never inside of what was learnt.

Sources: mixture of predictive distributions, Gneiting and Ranjan 2013 (Electron. J. Statist. 7);
local weights, Nadaraya 1964; the largest of even draws, with its scale's prior 1/T (Pareto).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import erfc, exp, sqrt
from statistics import NormalDist
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.turning import FORCE_ROLES, PASSIVE_AXIS
from autodb.fitting.gaussian import NORMAL_95
from autodb.forward.limits import QUANTITIES
from autodb.forward.prediction import Interval, Moment, Peaks, PredictedCut, wider_interval
from autodb.pairs.engaged import BANDS, CUTTING_TIME, FLANK_WEAR, SPEED
from autodb.wording import phrase_many

Array = NDArray[np.float64]

LIFE_S = 900.0
GROWN = {"Fc": 0.26, "Ff": 1.17, "Fp": 0.78}
"""g, by what a force is called; the torque and the power grow as the cutting force does."""
FORCES = ("force_x_N", "force_y_N", "force_z_N")
FIELDS = tuple(each.field for each in QUANTITIES)
PARTS = ("peaks", "start", "end")
TANGENTIAL = 1
EDGES = 4
"""n, edges that a pair's oldest is the oldest of. Chosen: those of a few days."""
HALF_LIFE = 30.0
"""A, cuts of the pair after which a cut tells half as much. Chosen: a shop's day or two."""
PLACED = {SPEED: (0.0, 0.12), CUTTING_TIME: (60.0, 0.35), FLANK_WEAR: (0.05, 0.35)}
"""What cuts are alike in: what is added before the logarithm is taken (m/min, s, mm), and h.
Chosen: 12 % of speed, a third of an edge's age."""
TAIL = 0.025
STEPS, NEAR = 50, 1e-12
"""Steps in which an end is sought, at most, and how near to it they end, in parts of the range."""

STANDARD = NormalDist()

Reach = tuple[float, float]
"""Factors on the distances of an interval's low and high end from its value."""

_Predicted = TypeVar("_Predicted", PredictedCut, Moment, Peaks)


def wider(one: _Predicted, factor: float) -> _Predicted:
    """Return what is predicted with every interval as wide as past predictions ask for."""
    if factor == 1.0:
        return one
    return _with(one, lambda own, _: wider_interval(own, factor))


def with_room_for_wear(cut: PredictedCut, *, cut_s: float, seen_s: float) -> PredictedCut:
    """Return a turned cut with room for the wear of an edge that has cut ``cut_s`` before.

    ``seen_s``: the longest that an edge had cut of those that the pair was learnt from. Cuts in a
    state of their own, and operations whose wear is not known so, stay as they are.
    """
    if cut.operation not in PASSIVE_AXIS or cut.state is not None or cut_s <= seen_s:
        return cut
    older = (cut_s - seen_s) / LIFE_S
    roles = zip(FORCES, FORCE_ROLES[cut.operation], strict=True)
    growth = {name: GROWN[role] for name, role in roles}
    growth |= dict.fromkeys(("torque_N_m", "power_W"), GROWN["Fc"])
    return _stretched(cut, {name: _grown(cut, name, g * older) for name, g in growth.items()})


def chance_as_old(cut_s: float, *, seen_s: float) -> float:
    """Return how probable an edge is as old as is said, s, where the oldest seen was younger."""
    return min(1.0, (seen_s / cut_s) ** EDGES) if cut_s > 0.0 else 1.0


def holding_too(one: _Predicted, other: _Predicted) -> _Predicted:
    """Return what is predicted with intervals that hold another account of it, too."""

    def wide(own: Interval, its: Interval) -> Interval:
        return replace(own, low=min(own.low, its.low), high=max(own.high, its.high))

    return _of_both(one, other, wide)


def mean_of_both(one: _Predicted, other: _Predicted, share: float) -> _Predicted:
    """Return what is predicted with values that are the mean of two accounts; ends stay.

    ``share``: the probability of the first.
    """

    def mean(own: Interval, its: Interval) -> Interval:
        value = share * own.value + (1.0 - share) * its.value
        return replace(own, value=value, low=min(own.low, value), high=max(own.high, value))

    return _of_both(one, other, mean)


def _of_both(
    one: _Predicted, other: _Predicted, both: Callable[[Interval, Interval], Interval]
) -> _Predicted:
    """Return what is predicted with each interval made of those of two accounts of it."""
    changed = _with(one, lambda own, name: both(own, getattr(other, name)), deep=False)
    if isinstance(changed, PredictedCut) and isinstance(other, PredictedCut):
        parts = {name: (getattr(one, name), getattr(other, name)) for name in PARTS}
        made = {
            n: a if a is None or b is None else _of_both(a, b, both) for n, (a, b) in parts.items()
        }
        return replace(changed, **made)
    return changed


def _grown(cut: PredictedCut, name: str, grown: float) -> Reach:
    """Return how much farther the end is on the side to which the force grows."""
    own = getattr(cut, name)
    upwards = own.value >= 0.0
    room = (own.high - own.value) if upwards else (own.value - own.low)
    factor = 1.0 + grown * abs(own.value) / room if room > 0.0 else 1.0
    return (1.0, factor) if upwards else (factor, 1.0)


def _stretched(one: PredictedCut, reach: Mapping[str, Reach]) -> PredictedCut:
    """Return a cut with the ends of its intervals so much farther off."""
    return _with(one, lambda own, name: _farther(own, *reach[name]) if name in reach else own)


def _farther(own: Interval, low: float, high: float) -> Interval:
    return replace(
        own,
        low=own.value - low * (own.value - own.low),
        high=own.value + high * (own.high - own.value),
    )


def _with(
    one: _Predicted, changed: Callable[[Interval, str], Interval], *, deep: bool = True
) -> _Predicted:
    """Return what is predicted with each interval changed, of its field's name.

    ``deep``: also those of a cut's peaks, its start and its end.
    """
    changes: dict[str, Any] = {name: changed(getattr(one, name), name) for name in FIELDS}
    if deep and isinstance(one, PredictedCut):
        for name in PARTS:
            part = getattr(one, name)
            changes[name] = None if part is None else _with(part, changed)
    return replace(one, **changes)


@dataclass(frozen=True)
class UndecidedCuts:
    """The newest cuts of a pair, oldest first, and how they were off.

    ``placed`` (n, 3): logarithms as in PLACED, NaN: not stated; ``excluded`` (n,); ``off`` and
    ``sd`` (n, 3): of x, y, z by what share of what is learnt, NaN: not sensed. ``waiting``:
    the mismatches that are open, by number, channel and term.
    """

    placed: Array
    excluded: NDArray[np.bool_]
    off: Array
    sd: Array
    waiting: tuple[tuple[int, str, str], ...]

    @property
    def words(self) -> str:
        """Why intervals are wider, and what decides."""
        named = (f"{number} ({channel}: {term})" for number, channel, term in self.waiting)
        count = int(self.excluded.sum())
        return phrase_many(
            "intervals hold what {excluded} showed beside what was learnt, until mismatch "
            "{numbers} is decided: 'autodb mismatch confirm {first}' or 'autodb mismatch reject "
            "{first}'",
            "intervals hold what {excluded} showed beside what was learnt, until mismatches "
            "{numbers} are decided: 'autodb mismatch confirm {first}' or 'autodb mismatch reject "
            "{first}'",
            len(self.waiting),
            excluded=phrase_many("{count} excluded cut", "{count} excluded cuts", count),
            numbers=", ".join(named),
            first=self.waiting[0][0],
        )

    def widened(
        self, cuts: Sequence[PredictedCut], stated: Sequence[Mapping[str, float]]
    ) -> tuple[PredictedCut, ...]:
        """Return cuts that are predicted in the usual state with intervals that hold either kind.

        ``stated``: the conditions of each by channel, as far as they are known.
        """
        places = np.array(
            [placed({SPEED: c.speed_m_min, **s}) for c, s in zip(cuts, stated, strict=True)]
        )
        return tuple(
            cut if cut.state is not None else self._widened(cut, place)
            for cut, place in zip(cuts, places, strict=True)
        )

    def _widened(self, cut: PredictedCut, place: Array) -> PredictedCut:
        near, age = self._near(place)
        reach: dict[str, Reach] = {}
        for k, name in enumerate(FORCES):
            known = np.isfinite(self.off[:, k])
            there, others = known & self.excluded, known & ~self.excluded
            if not there.any():
                continue
            off = self.off[:, k]
            chance = (near + age / np.sum(age[known]))[there] / (np.sum(near[known]) + 1.0)
            bent = float(near[others] @ off[others] / (np.sum(near[others]) + 1.0))
            seen = _Seen(off[there], self.sd[there, k], chance, bent)
            reach[name] = seen.reach(getattr(cut, name))
        if not reach:
            return cut
        turned = cut.operation not in BANDS and FORCES[TANGENTIAL] in reach
        low, high = (max(ends) for ends in zip(*reach.values(), strict=True))
        both = reach[FORCES[TANGENTIAL]] if turned else (low, high)
        return _stretched(cut, reach | dict.fromkeys(("torque_N_m", "power_W"), both))

    def _near(self, place: Array) -> tuple[Array, Array]:
        """Return the weights of all cuts (n,) for one asked for, and those by age alone."""
        age = np.exp2(-np.arange(len(self.excluded))[::-1] / HALF_LIFE)
        width = np.array([h for _, h in PLACED.values()])
        apart = np.nan_to_num((place - self.placed) / width)
        return age * np.exp(-0.5 * np.sum(apart**2, axis=1)), age


@dataclass(frozen=True)
class _Seen:
    """How excluded cuts (j,) were off, with which sd, how probable each is, and b of the others."""

    off: Array
    sd: Array
    chance: Array
    bent: float

    def reach(self, own: Interval) -> Reach:
        """Return by what the distances of an interval's ends are larger, 1 at least."""
        size = abs(own.value)
        if size == 0.0 or not own.low < own.value < own.high:
            return 1.0, 1.0
        learnt = own.value * (1.0 + self.bent)
        middle = np.concatenate([[learnt], own.value * (1.0 + self.off)])
        spread = np.concatenate([[(own.high - own.low) / (2.0 * NORMAL_95)], size * self.sd])
        share = np.concatenate([[1.0 - float(np.sum(self.chance))], self.chance])
        low, high = (_quantile(middle, spread, share, at) for at in (TAIL, 1.0 - TAIL))
        return (
            max((own.value - low) / (own.value - own.low), 1.0),
            max((high - own.value) / (own.high - own.value), 1.0),
        )


def placed(stated: Mapping[str, Any]) -> list[float]:
    """Return where a cut is among others: logarithms as in PLACED, NaN where it does not say."""
    return [
        float(np.log(stated[name] + more)) if stated.get(name) is not None else np.nan
        for name, (more, _) in PLACED.items()
    ]


def _quantile(middle: Array, spread: Array, share: Array, at: float) -> float:
    """Return where a mixture of normals has a share ``at`` below.

    By Newton's steps of its normal score, which is nearly a line, in a bracket that shrinks.
    """
    low, high = float(np.min(middle - 6.0 * spread)), float(np.max(middle + 6.0 * spread))
    near, aim = NEAR * (high - low), STANDARD.inv_cdf(at)
    mean = float(share @ middle)
    place = mean + aim * sqrt(float(share @ (spread**2 + (middle - mean) ** 2)))
    for _ in range(STEPS):
        score = (place - middle) / spread
        below = float(share @ [0.5 * erfc(one) for one in (score / -sqrt(2.0)).tolist()])
        low, high = (place, high) if below < at else (low, place)
        dense = float(share @ (np.exp(-0.5 * score**2) / spread))
        then = low
        if 0.0 < below < 1.0 and dense > 0.0:
            reached = STANDARD.inv_cdf(below)
            then = place - (reached - aim) * exp(-0.5 * reached**2) / dense
        before, place = place, then if low < then < high else 0.5 * (low + high)
        if abs(place - before) < near:
            break
    return place
