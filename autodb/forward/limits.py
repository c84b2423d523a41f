"""How predicted cuts stand to what a machine gives: within, exceeded, or not entered.

A prediction is a distribution, of a mill that of its peak within a turn, of a program's line that
of the largest along it; its probability beyond a limit in either direction follows. Speeds of
spindle and feed are asked for, not predicted: one above its limit is sure.

What a motor gives changes with speed. Between two points of a curve its power is a straight line:
exactly so where its torque is constant, and where its power is. Below the first its torque is
constant; where the last ends, so does the spindle's speed. A cut whose speed changes has the least
of what its slowest and its fastest moment leave.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from autodb.cutting.elements import RAD_S_A_RPM
from autodb.files.channels import axis_words
from autodb.files.machine import AxisLimits
from autodb.forward.prediction import Interval, Moment, Peaks, PredictedCut, chance_beyond
from autodb.pairs.engaged import BANDS
from autodb.wording import amount_words, listed, localized, msgid, phrase

WORTH_SAYING = 0.001
"""Probability from which a limit is spoken of. Chosen."""
MAY_BE = 0.025
"""Probability up to which a limit counts as kept: the 95 % interval then ends within it."""
SPINDLE = "spindle"
LINEAR = ("x", "y", "z")
FEEDS = {
    "turn": "z", "bore": "z", "thread": "z", "drill": "z", "face": "x", "groove": "x",
    "taper": "xz", "contour": "xz", **dict.fromkeys(BANDS, "xy"),
}  # fmt: skip
"""Axes that feed, by operation. Where a path is oblique to them the feed is that of the path."""
Standing = Literal["not entered", "within", "exceeded"]
SAID_OF = {
    "exceeded": msgid("limits exceeded: {limits}"),
    "within": msgid("limits within: {limits}"),
    "not entered": msgid("limits not entered: {limits}"),
}
QUANTITIES_LIMITED = (
    msgid("force"), msgid("feed"), msgid("travel"), msgid("spindle torque"), msgid("spindle power"),
    msgid("spindle speed"),
)  # fmt: skip
"""What limits are of."""


@dataclass(frozen=True)
class Exceeding:
    """A limit that a cut (number from 1) may exceed: whose, which, in what unit, how probably."""

    cut: int
    axis: str
    limit: float
    unit: str
    probability: float

    @property
    def statement(self) -> str:
        """The line for the planner, without the cut."""
        axis, limit = axis_words(self.axis), amount_words(self.limit, self.unit, ".6g")
        if self.unit in ("rpm", "mm/min"):
            return phrase("faster than {axis}'s {limit}", axis=axis, limit=limit)
        chance = probability_words(self.probability)
        return phrase(
            "{chance} chance to exceed {axis}'s {limit}", chance=chance, axis=axis, limit=limit
        )


@dataclass(frozen=True)
class LimitStanding:
    """How cuts stand to one limit of a machine; None where it is not entered, or says nothing.

    ``cut``: the one (number from 1) that most probably exceeds it, with that ``probability``, None
    of a travel; ``limit``: what the machine gives there.
    """

    axis: str
    quantity: str
    unit: str
    standing: Standing
    limit: float | None = None
    probability: float | None = None
    cut: int | None = None

    @property
    def words(self) -> str:
        """Whose it is and what, with its limit and the chance to exceed it."""
        what = self.what
        if self.limit is None or self.probability is None:
            return what
        limit = amount_words(self.limit, self.unit, ".6g")
        if self.standing == "within" and self.probability < WORTH_SAYING:
            return phrase("{what} {limit}", what=what, limit=limit)
        chance = probability_words(self.probability)
        return phrase(
            "{what} {limit} ({chance} chance to exceed it)", what=what, limit=limit, chance=chance
        )

    @property
    def what(self) -> str:
        """Whose it is and what."""
        if self.axis == SPINDLE:
            return phrase(f"{SPINDLE} {self.quantity}")
        return phrase("{axis} {quantity}", axis=self.axis, quantity=phrase(self.quantity))


@dataclass(frozen=True)
class _Asked:
    """What of one cut meets one limit: which, None where none is entered, and how probably."""

    axis: str
    quantity: str
    unit: str
    limit: float | None
    probability: float | None


def exceeding(
    cuts: Sequence[PredictedCut], limits: Mapping[str, AxisLimits]
) -> tuple[Exceeding, ...]:
    """Return the limits, by axis, that cuts may exceed, in the order of the cuts."""
    return _exceeding(_numbered(cuts, limits))


def exceeding_and_standings(
    cuts: Sequence[PredictedCut], limits: Mapping[str, AxisLimits]
) -> tuple[tuple[Exceeding, ...], tuple[LimitStanding, ...]]:
    """Return ``exceeding`` and ``limit_standings`` of cuts, worked out together."""
    asked = _numbered(cuts, limits)
    return _exceeding(asked), _standings(asked)


_Numbered = Sequence[tuple[int, _Asked]]


def _numbered(cuts: Sequence[PredictedCut], limits: Mapping[str, AxisLimits]) -> _Numbered:
    return [(k, one) for k, cut in enumerate(cuts, start=1) for one in _asked(cut, limits)]


def _exceeding(asked: _Numbered) -> tuple[Exceeding, ...]:
    return tuple(
        Exceeding(number, one.axis, one.limit, one.unit, one.probability)
        for number, one in asked
        if one.limit is not None and one.probability is not None
        if one.probability >= WORTH_SAYING
    )


def limit_standings(
    cuts: Sequence[PredictedCut],
    limits: Mapping[str, AxisLimits],
    spans_mm: Mapping[str, float] | None = None,
) -> tuple[LimitStanding, ...]:
    """Return how cuts stand to each limit that machines have, entered or not.

    One that is entered for some of the cuts alone, as a curve that others go beyond, is judged by
    these. ``spans_mm``: how far cuts reach along axes, where that is known.
    """
    travels = [
        _Asked(axis, "travel", "mm", *_travel(limits[axis], span))
        for axis, span in (spans_mm or {}).items()
        if axis in limits
    ]
    return (*_standings(_numbered(cuts, limits)), *(_standing(None, one) for one in travels))


def _standings(asked: _Numbered) -> tuple[LimitStanding, ...]:
    worst: dict[tuple[str, str], tuple[int, _Asked]] = {}
    for number, one in asked:
        key = one.axis, one.quantity
        known = worst.setdefault(key, (number, one))[1].probability
        if one.probability is not None and (known is None or one.probability > known):
            worst[key] = number, one
    return tuple(_standing(number, one) for number, one in worst.values())


def _travel(most: AxisLimits, span_mm: float) -> tuple[float | None, float | None]:
    """Return how far an axis goes, and whether a span is more: then no place of it is right."""
    if most.travel_low_mm is None or most.travel_high_mm is None:
        return None, None
    whole = most.travel_high_mm - most.travel_low_mm
    return whole, float(span_mm > whole)


def limit_standing(probability: float | None) -> Standing:
    """Return how a limit stands that is exceeded so probably; None: it is not entered."""
    if probability is None:
        return "not entered"
    return "within" if probability <= MAY_BE else "exceeded"


def _standing(number: int | None, one: _Asked) -> LimitStanding:
    stands = limit_standing(one.probability)
    cut = None if one.probability is None else number
    return LimitStanding(one.axis, one.quantity, one.unit, stands, one.limit, one.probability, cut)


def _asked(cut: PredictedCut, limits: Mapping[str, AxisLimits]) -> Iterator[_Asked]:
    """Yield what of a cut meets limits: of the machine's linear axes, and of its spindle."""
    worst = cut if cut.peaks is None else cut.peaks
    for axis in LINEAR:
        if axis not in limits:
            continue
        force: Interval = getattr(worst, f"force_{axis}_N")
        yield _load(axis, "force", "N", force, limits[axis].force_N)
        if axis in FEEDS.get(cut.operation, "") and cut.feed_mm_min is not None:
            most = limits[axis].speed_mm_min
            yield _speed(axis, "feed", "mm/min", cut.feed_mm_min, most)
    spindle = limits.get(SPINDLE, AxisLimits())
    torque = load_limit(spindle, "torque_N_m", cut)
    yield _load(SPINDLE, "torque", "N·m", worst.torque_N_m, torque)
    yield _load(SPINDLE, "power", "W", worst.power_W, load_limit(spindle, "power_W", cut))
    yield _speed(SPINDLE, "speed", "rpm", max(_speeds_rpm(cut)), fastest_rpm(spindle))


def _load(axis: str, quantity: str, unit: str, predicted: Interval, limit: float | None) -> _Asked:
    chance = None if limit is None else chance_beyond(predicted, limit)
    return _Asked(axis, quantity, unit, limit, chance)


def _speed(axis: str, quantity: str, unit: str, asked: float, limit: float | None) -> _Asked:
    return _Asked(axis, quantity, unit, limit, None if limit is None else float(asked > limit))


def load_limit(most: AxisLimits, key: str, cut: PredictedCut) -> float | None:
    """Return what an axis or a spindle gives in a cut, by key of its limits; None: not entered."""
    known = [getattr(most, key)]
    for rpm in _speeds_rpm(cut) if key in ("torque_N_m", "power_W") else ():
        turns = RAD_S_A_RPM * rpm
        share = 1.0 if most.efficiency is None else most.efficiency
        if key == "torque_N_m":
            powers = [(speed, RAD_S_A_RPM * speed * at) for speed, at in most.torque_curve or ()]
            given_W = _motor_power_W(powers, rpm)
            known.append(None if given_W is None else share * given_W / turns)
        else:
            given_W = _motor_power_W(most.power_curve or (), rpm)
            known.append(None if given_W is None else share * given_W)
    return min((one for one in known if one is not None), default=None)


def _motor_power_W(curve: Sequence[tuple[float, float]], rpm: float) -> float | None:
    """Return the power at a speed of a curve of power over speeds; None where it has ended."""
    if not curve or rpm > curve[-1][0]:
        return None
    speeds, powers = zip((0.0, 0.0), *curve, strict=True)
    return float(np.interp(rpm, speeds, powers))


def fastest_rpm(most: AxisLimits) -> float | None:
    """Return the fastest that a spindle turns: as stated, or where its curves end."""
    ends = [curve[-1][0] for curve in (most.torque_curve, most.power_curve) if curve]
    return min((one for one in (most.speed_rpm, *ends) if one is not None), default=None)


def _speeds_rpm(cut: PredictedCut) -> tuple[float, ...]:
    """Return the spindle's speeds at moments of a cut, the fastest and the slowest among them."""
    at = [one.speed_rpm for one in (cut.peaks, cut.start, cut.end) if one is not None]
    return (cut.speed_rpm, *(rpm for rpm in at if rpm is not None))


def probability_words(probability: float) -> str:
    """Return a probability in words."""
    if probability > 0.999:
        return phrase("over {share} %", share=localized("99.9"))
    form = ".2g" if probability < 0.995 else ".1f"
    return f"{localized(f'{100.0 * probability:{form}}')} %"


def standings_in_words(standings: Sequence[LimitStanding]) -> Iterator[str]:
    """Say, a line each, which limits are exceeded, which are kept and which nobody entered."""
    for standing in ("exceeded", "within", "not entered"):
        some = [one.words for one in standings if one.standing == standing]
        if some:
            yield phrase(SAID_OF[standing], limits=listed(some))


@dataclass(frozen=True)
class PredictedQuantity:
    """A predicted quantity: its channel, field and unit, and the axis and key of its limit."""

    channel: str
    field: str
    unit: str
    axis: str
    key: str

    def of(self, some: PredictedCut | Peaks | Moment | None) -> Interval | None:
        """Return the interval of a cut, its peaks or a moment; None where there are none."""
        found: Interval | None = getattr(some, self.field, None)
        return found

    def limit(self, limits: Mapping[str, AxisLimits], cut: PredictedCut) -> float | None:
        """Return what the machine gives of it in a cut; None where its limit is not entered."""
        stated = limits.get(self.axis)
        return None if stated is None else load_limit(stated, self.key, cut)

    def chance(self, cut: PredictedCut, limit: float | None) -> float | None:
        """Return the probability that a cut's peak, or mean, exceeds a limit, if there is one."""
        worst = self.of(cut.peaks or cut)
        return None if worst is None or limit is None else chance_beyond(worst, limit)


QUANTITIES = (
    *(PredictedQuantity(f"force.{a}", f"force_{a}_N", "N", a, "force_N") for a in LINEAR),
    PredictedQuantity("torque.spindle", "torque_N_m", "N·m", SPINDLE, "torque_N_m"),
    PredictedQuantity("spindle.power", "power_W", "W", SPINDLE, "power_W"),
)
