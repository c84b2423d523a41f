"""How long an edge lasts in a job: until its cuts pass a limit, with the wear that was learnt.

Between which ends a life lies holds what is open of the pair's law, of its wear and of how that
bends, what edges differ by, and what past predictions widen intervals by.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.agent.answer.bounds.aged_parts import AgedPart, part_of_cuts, part_of_program
from autodb.agent.answer.prediction_basis import PredictionBasis
from autodb.errors import UnusableInput, near_words
from autodb.files.job import Job
from autodb.files.machine import AxisLimits
from autodb.forward.limits import QUANTITIES, PredictedQuantity
from autodb.forward.line_parts import Followed
from autodb.forward.prediction import PredictedCut
from autodb.forward.tool_life import EdgeLife, PartCut, chances_of, edge_life, quantile_of
from autodb.pairs.posterior import Wear
from autodb.wording import amount_words, localized, phrase, phrase_many

Array = NDArray[np.float64]

AGES, FIRST = 32, 0.02
"""Ages at which forces are predicted, and the share of the oldest at which the second stands.
Chosen: a life is off by less than 1 % of what 400 give."""
LOOKED_AT, SOONEST = 400, 1e-3
"""Ages at which chances are looked at, and the share of the oldest at which the second stands."""
BEYOND = 3.0
"""How far beyond the oldest edge that was seen a life is looked for, of its age. Chosen: farther
nothing is known of how edges end."""
POWERS = ((-(3.0**0.5), 1.0 / 6.0), (0.0, 2.0 / 3.0), (3.0**0.5, 1.0 / 6.0))
"""Standard deviations and weights at which a normal is summed (Gauss and Hermite, three points)."""
SURE = 0.95
"""How surely a limit is kept, where nothing else is asked for."""


@dataclass(frozen=True)
class ToolLife:
    """How long an edge lasts in a job, the limit that ends it first at the front.

    ``edge``: what it is called beside others, else empty. ``start_s``: its age at first;
    ``part_s``: cutting time of a part, None where the job does not state how far its cuts go;
    ``searched_s``: the oldest age that was looked at; ``learnt_s``: that of the oldest edge behind
    the pair's wear. ``why``: no life is known, and what would teach it.
    """

    job: str
    material: str
    tool: str
    edge: str
    start_s: float
    part_s: float | None
    learnt_s: float | None
    searched_s: float | None
    sure: float
    lives: tuple[EdgeLife, ...]
    why: str | None
    notes: tuple[str, ...]

    @property
    def lines(self) -> tuple[str, ...]:
        """What a planner is told, a line each."""
        if self.why is not None:
            return (self.why, *self.notes)
        return (*self.life_lines, *self.notes)

    @property
    def life_lines(self) -> tuple[str, ...]:
        """How long it lasts by each limit, and when to change it; or why nobody knows."""
        if self.why is not None:
            return (self.why,)
        return (*(one.words for one in self.lives), *self._change)

    @property
    def _change(self) -> tuple[str, ...]:
        """Say after how much the edge is changed in time."""
        sure = localized(f"{100.0 * self.sure:.4g}")
        parts = [one.sure_parts for one in self.lives if one.sure_parts is not None]
        minutes = [one.sure_min for one in self.lives if one.sure_min is not None]
        if not minutes:
            return ()
        if min(minutes) == 0.0:
            return (
                phrase(
                    "the limits are not kept with {sure} % probability even by the edge as it is "
                    "at first",
                    sure=sure,
                ),
            )
        life = amount_words(min(minutes), "min", ".3g")
        if parts:
            life = phrase_many(
                "{count} part, {life}", "{count} parts, {life}", min(parts), life=life
            )
        return (
            phrase(
                "change the edge after {life} to keep the limits with {sure} % probability",
                life=life,
                sure=sure,
            ),
        )


@dataclass(frozen=True)
class LifeCourse:
    """How the chance that an edge has passed its first limit grows: ``chances`` at ``ages_s`` (n,).

    ``cut``: the one that passes it, in a part of ``part_s`` of cutting.
    """

    ages_s: Array
    chances: Array
    cut: PartCut
    part_s: float

    @property
    def most_parts(self) -> int:
        """How many parts begin within the ages that are searched."""
        ahead_s = float(self.ages_s[-1] - self.ages_s[0]) - self.cut.begin_s
        return max(int(ahead_s / self.part_s) + 1, 0) if ahead_s >= 0.0 else 0

    def chance(self, parts: int) -> float:
        """Return the chance that fewer than so many parts keep the limit."""
        age_s = float(self.ages_s[0]) + self.cut.begin_s + (parts - 1) * self.part_s
        z = [quantile_of(one) for one in self.chances.tolist()]
        return float(chances_of(np.interp([age_s], self.ages_s, z))[0])


def limit_stated(text: str, *, where: str) -> tuple[str, float]:
    """Return channel and limit of CHANNEL=VALUE; raises UnusableInput where it is none."""
    channel, _, value = text.partition("=")
    try:
        return channel.strip(), float(value)
    except ValueError:
        raise UnusableInput(
            phrase(
                "{where} {text}: write CHANNEL=VALUE, such as torque.spindle=40",
                where=where,
                text=text,
            )
        ) from None


def tool_life(
    basis: PredictionBasis,
    job: Job,
    *,
    limits: Mapping[str, float] | None = None,
    sure: float = SURE,
    program: Followed | None = None,
) -> ToolLife:
    """Return how long an edge lasts in a job's cuts, or all lines of its program; as `life_of`."""
    which = () if program is None else range(len(program.lines))
    return life_of(basis, job, limits=limits, sure=sure, program=program, which=which)[0]


def life_of(
    basis: PredictionBasis,
    job: Job,
    *,
    limits: Mapping[str, float] | None = None,
    sure: float = SURE,
    program: Followed | None = None,
    which: Sequence[int] = (),
    edge: str = "",
) -> tuple[ToolLife, LifeCourse | None]:
    """Return how long an edge lasts in a job's cuts, which it makes in turn, part after part.

    The course is that of its first limit, None where no wear was learnt or parts do not count.
    ``program``: that of the job, followed, in place of its cuts, and ``which`` lines of it the edge
    makes, by their places; ``edge``: what it is called.

    ``limits``: by channel (force.x, torque.spindle, spindle.power), instead of the machine's;
    ``sure``: the probability with which they are kept by those parts that are surely made. Raises
    UnusableInput for another channel, where there is no limit, or where lengths are missing.
    """
    refuse_limits(limits or {})
    basis = basis.of_lot(job.lot)
    start_s = 0.0 if program is not None else job.cut[0].cutting_time_s or 0.0
    found = ToolLife(
        job.name, job.material, basis.known.tool.name, edge, start_s, None, None, None, sure, (),
        None, (),
    )  # fmt: skip
    wear = basis.known.posterior.wear
    if wear is None:
        return replace(found, why=_not_learnt(basis)), None
    part = part_of_cuts(basis, job) if program is None else part_of_program(basis, program, which)
    oldest_s = max(BEYOND * wear.reference_s, 2.0 * start_s)
    more_s = np.geomspace(SOONEST * oldest_s, oldest_s - start_s, LOOKED_AT - 1)
    ages_s = start_s + np.concatenate([[0.0], more_s])
    lives = _lives(basis, part, ages_s, limits=limits, sure=sure)
    found = replace(
        found, part_s=part.part_s, learnt_s=wear.reference_s, searched_s=oldest_s,
        lives=tuple(one for one, _ in lives),
    )  # fmt: skip
    first, chances = lives[0]
    cut = next(one for one in part.cut_of if one.number == first.cut)
    course = None if part.part_s is None else LifeCourse(ages_s, chances, cut, part.part_s)
    return replace(found, notes=_notes(basis, found, part)), course


def _not_learnt(basis: PredictionBasis) -> str:
    return phrase(
        "no wear was learnt of {pair}, so that the life of its edges is not known; import cuts of "
        "several edges that state tool.cutting_time, the time that their edge had cut before, and "
        "confirm tool_wear with 'autodb mismatch confirm' where 'autodb refresh' finds it",
        pair=f"{basis.material} / {basis.known.tool.name}",
    )


def refuse_limits(limits: Mapping[str, float]) -> None:
    """Raise UnusableInput for a limit of another channel, or that is none."""
    channels = [one.channel for one in QUANTITIES]
    for channel, limit in limits.items():
        if channel not in channels:
            raise UnusableInput(
                phrase(
                    "limit of '{channel}': is nothing that is predicted{hint}",
                    channel=channel,
                    hint=near_words(channel, channels),
                )
            )
        if not 0.0 < limit < np.inf:
            raise UnusableInput(
                phrase(
                    "limit of {channel}: {value} is none; state a number above 0",
                    channel=channel,
                    value=localized(f"{limit:g}"),
                )
            )


def _lives(
    basis: PredictionBasis,
    part: AgedPart,
    ages_s: Array,
    *,
    limits: Mapping[str, float] | None,
    sure: float,
) -> list[tuple[EdgeLife, Array]]:
    """Return the lives until each limit is passed, by the cut that passes it first, and the chances
    at ages (n,) that it is; the first to end at the front.
    """
    asked = [
        (k, what, limit)
        for k, cut in enumerate(part.once)
        for what in QUANTITIES
        if (limit := _limit(what, cut, limits, basis.limits)) is not None
    ]
    if not asked:
        raise UnusableInput(
            phrase(
                "machine '{machine}' states no limit of a force, torque or power; state one with "
                "the question, such as torque.spindle=40, or of the machine with 'autodb machine "
                "update'",
                machine=basis.machine,
            )
        )
    wear = basis.known.posterior.wear
    assert wear is not None
    loaded = part.most_loaded(float(ages_s[-1]))
    asked = [one for one in asked if one[0] in loaded]
    by_channel: dict[str, tuple[EdgeLife, Array]] = {}
    for (k, what, limit), chance in zip(asked, _chances(part, wear, ages_s, asked), strict=True):
        one = edge_life(
            ages_s,
            chance,
            part.cut_of[k],
            channel=what.channel,
            unit=what.unit,
            limit=limit,
            part_s=part.part_s,
            path_mm=part.path_mm,
            sure=sure,
        )
        other = by_channel.get(what.channel)
        if other is None or life_rank(one) < life_rank(other[0]):
            by_channel[what.channel] = one, chance
    return sorted(by_channel.values(), key=lambda found: life_rank(found[0]))


def life_rank(one: EdgeLife) -> tuple[float, float]:
    """Return by what lives are sorted: the shortest first; equal ones may differ by a rounding."""
    ends = one.minutes.value, one.minutes.low
    first, second = (np.inf if end is None else float(f"{end:.9g}") for end in ends)
    return first, second


def _limit(
    what: PredictedQuantity,
    cut: PredictedCut,
    stated: Mapping[str, float] | None,
    limits: Mapping[str, AxisLimits],
) -> float | None:
    return what.limit(limits, cut) if not stated else stated.get(what.channel)


def _chances(
    part: AgedPart,
    wear: Wear,
    ages_s: Array,
    asked: Sequence[tuple[int, PredictedQuantity, float]],
) -> Array:
    """Return the chances (q, n) that what is asked for is beyond its limit at ages (n,)."""
    alike = [(_as_old(ages_s, wear, off), weight) for off, weight in POWERS]
    far_s = max(float(one[-1]) for one, _ in alike)
    grid_s = np.concatenate([[0.0], np.geomspace(FIRST * far_s, far_s, AGES - 1)])
    which = list(dict.fromkeys(k for k, _, _ in asked))
    found = dict(zip(which, part.at_ages(which, grid_s), strict=True))
    made = []
    for k, what, limit in asked:
        its = [what.chance(one, limit) or 0.0 for one in found[k]]
        z = np.array([quantile_of(one) for one in its])
        # A chance that falls with age is that of a wear that is not told from none
        z = np.maximum.accumulate(z)
        made.append(sum(w * chances_of(np.interp(one, grid_s, z)) for one, w in alike))
    return np.array(made)


def _as_old(ages_s: Array, wear: Wear, off: float) -> Array:
    """Return the ages at which wear adds as much as it does at these, bent ``off`` sds more."""
    more = np.exp(off * wear.power_sd)
    return np.asarray(wear.reference_s * (ages_s / wear.reference_s) ** more)


def _notes(basis: PredictionBasis, found: ToolLife, part: AgedPart) -> tuple[str, ...]:
    """Say what a life rests on beyond what was seen."""
    said = []
    learnt_s, oldest_s = found.learnt_s or 0.0, found.searched_s or 0.0
    ends = [one.minutes.value for one in found.lives if one.minutes.value is not None]
    if not ends or found.start_s + 60.0 * min(ends) > learnt_s:
        said.append(
            phrase(
                "no edge was seen beyond {seen}; what is said of older ones, up to {searched}, is "
                "what the wear learnt until then would become",
                seen=amount_words(learnt_s / 60.0, "min", ".3g"),
                searched=amount_words(oldest_s / 60.0, "min", ".3g"),
            )
        )
    if any(one.state is not None for one in part.once):
        said.append(phrase("some cuts are of another process state, which holds no wear"))
    said.append(
        phrase(
            "95 % intervals, of an edge like those that were seen; an edge that breaks, and flank "
            "wear, are not in them"
        )
    )
    return (*basis.waiting, *said)
