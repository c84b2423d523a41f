"""Tool life: for how long an edge cuts until a force, torque or power passes a limit.

An edge of cutting time T has passed the limit with the chance P(|F(T)| > limit); its force grows
with T, so that this is the distribution of its life. Life is said by its middle and the ends
between which it lies with 95 % probability: the times at which that chance is 50, 2.5 and 97.5 %.
Flank wear is not sensed: a life until a width of wear needs a limit of a load that stands for it
(ISO 3685 and 8688 end lives by the width of wear).

A part is the job once through, with one edge: its cut k begins, in part n, at the age

    T = T_0 + (n - 1) P + s_k

with the age T_0 of the edge at first, the cutting time P of a part and s_k of its cuts before k. As
in recordings, a cut's force is that of the age at which it begins.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import floor
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from autodb.wording import amount_words, localized, msgid, phrase

Array = NDArray[np.float64]

TINY = 1e-15
"""Chance below which there is none. Chosen."""
LEVELS = (0.025, 0.5, 0.975)
"""Chances at the low end, the middle and the high end of a life."""
QUANTITY_WORDS = {
    "force.x": msgid("force x"),
    "force.y": msgid("force y"),
    "force.z": msgid("force z"),
    "torque.spindle": msgid("spindle torque"),
    "spindle.power": msgid("spindle power"),
}
"""What passes a limit, by channel."""


@dataclass(frozen=True)
class PartCut:
    """A cut of a part: its number from 1, name, and begin s_k."""

    number: int
    name: str
    begin_s: float


@dataclass(frozen=True)
class LifeEnds:
    """A life: the ends at which it has ended with 50 %, 2.5 % and 97.5 % probability.

    None: none is found in the ages that are searched.
    """

    value: float | None
    low: float | None
    high: float | None

    def words(self, unit: str, form: str) -> str:
        """Return 'value unit (low to high)'; what is beyond the search is said to be longer."""
        longer = phrase("longer than was searched")
        if self.low is None:
            return longer
        low = localized(f"{self.low:{form}}")
        high = longer if self.high is None else localized(f"{self.high:{form}}")
        if self.value is None:
            return phrase("at least {low} {unit}", low=low, unit=phrase(unit))
        value = f"{localized(f'{self.value:{form}}')} {phrase(unit)}"
        return phrase("{value} ({low} to {high})", value=value, low=low, high=high)


@dataclass(frozen=True)
class EdgeLife:
    """Until one cut passes one limit: cutting time, parts and metres of feed path of one edge.

    ``parts`` are whole ones that keep the limit; they and ``path_m`` are None where the job does
    not state how far its cuts go. ``sure_parts`` or, without parts, ``sure_min``: those that keep
    it with the probability that was asked for; None: beyond the search.
    """

    cut: int
    name: str
    channel: str
    unit: str
    limit: float
    minutes: LifeEnds
    parts: LifeEnds | None
    path_m: LifeEnds | None
    sure_min: float | None
    sure_parts: int | None

    @property
    def _parts_word(self) -> str:
        """What parts are called beside their number."""
        parts = self.parts or LifeEnds(None, None, None)
        number = parts.low if parts.value is None else parts.value
        return msgid("part") if number == 1 else msgid("parts")

    @property
    def words(self) -> str:
        """Say how long an edge lasts."""
        spans = [] if self.parts is None else [self.parts.words(self._parts_word, ".0f")]
        spans.append(self.minutes.words("min", ".3g"))
        if self.path_m is not None:
            spans.append(self.path_m.words(msgid("m of feed path"), ".3g"))
        return phrase(
            "an edge lasts {life} until {quantity} of cut {cut} passes {limit}",
            life=", ".join(spans),
            quantity=phrase(QUANTITY_WORDS[self.channel]),
            cut=f"{self.cut} '{self.name}'" if self.name else f"{self.cut}",
            limit=amount_words(self.limit, self.unit, ".6g"),
        )


def passing_ages_s(ages_s: Array, chances: Array, levels: Sequence[float]) -> list[float | None]:
    """Return the ages at which a chance (n,) over rising ages (n,) first reaches levels.

    Between ages the chance's normal quantile is a straight line. None: it does not reach one.
    """
    found: list[float | None] = []
    z = np.array([quantile_of(one) for one in chances.tolist()])
    for level in levels:
        wanted = quantile_of(level)
        reached = np.flatnonzero(z >= wanted)
        if len(reached) == 0:
            found.append(None)
            continue
        k = int(reached[0])
        if k == 0:
            found.append(float(ages_s[0]))
            continue
        share = (wanted - z[k - 1]) / (z[k] - z[k - 1])
        found.append(float(ages_s[k - 1] + share * (ages_s[k] - ages_s[k - 1])))
    return found


def quantile_of(chance: float) -> float:
    """Return the normal quantile of a chance, cut off where no chance is told from none."""
    return NormalDist().inv_cdf(min(max(chance, TINY), 1.0 - TINY))


def chances_of(quantiles: Array) -> Array:
    """Return the chances (n,) whose normal quantiles (n,) these are."""
    return np.array([NormalDist().cdf(one) for one in quantiles.tolist()])


def whole_parts(age_s: float, *, start_s: float, cut: PartCut, part_s: float) -> int:
    """Return how many whole parts keep a limit that a cut passes at an age of the edge."""
    ahead = age_s - start_s - cut.begin_s
    return 0 if ahead <= 0.0 else floor(ahead / part_s) + (0 if ahead % part_s == 0.0 else 1)


def edge_life(
    ages_s: Array,
    chances: Array,
    cut: PartCut,
    *,
    channel: str,
    unit: str,
    limit: float,
    part_s: float | None,
    path_mm: float | None,
    sure: float,
) -> EdgeLife:
    """Return the life of an edge until a cut passes a limit, of chances over ages (n,).

    ``ages_s`` begin with that of the edge at first; ``part_s``, ``path_mm``: of one part, None
    where the job does not state it; ``sure``: the probability of what keeps the limit surely.
    """
    start_s = float(ages_s[0])
    *ends, surely = passing_ages_s(ages_s, chances, (LEVELS[1], LEVELS[0], LEVELS[2], 1.0 - sure))
    parts = path = None
    sure_parts = None

    def counted(age_s: float | None) -> int | None:
        if age_s is None or part_s is None:
            return None
        return whole_parts(age_s, start_s=start_s, cut=cut, part_s=part_s)

    if part_s is not None:
        parts = LifeEnds(*map(counted, ends))
        sure_parts = counted(surely)
        if path_mm is not None:
            each = [None if one is None else (one - start_s) / part_s for one in ends]
            path = LifeEnds(*(None if one is None else 0.001 * path_mm * one for one in each))
    minutes = [None if one is None else (one - start_s) / 60.0 for one in (*ends, surely)]
    return EdgeLife(
        cut=cut.number,
        name=cut.name,
        channel=channel,
        unit=unit,
        limit=limit,
        minutes=LifeEnds(*minutes[:3]),
        parts=parts,
        path_m=path,
        sure_min=minutes[3],
        sure_parts=sure_parts,
    )
