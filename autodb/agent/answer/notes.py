"""What a planner is told beside predicted forces, in words.

Confirmed terms of a pair: how large each is, and what it is of cuts asked for. What is assumed of
the tool, and which cuts are in another state, have an older edge, no stated end, or lie outside of
what the pair was learnt from.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from autodb.agent.learn.known import KnownPair
from autodb.agent.learn.learnt_from import LearntFrom
from autodb.cutting import tools
from autodb.cutting.shear import NAMES, PARAMETERS
from autodb.files.channels import axis_words
from autodb.files.job_cut import JobCut
from autodb.fitting.gaussian import NORMAL_95
from autodb.forward.prediction import PredictedCut, ToolOf
from autodb.pairs.engaged import BY_NAME, DEPTH, FEED
from autodb.pairs.forecast import worn
from autodb.pairs.posterior import BAND, WEAR, PairPosterior, lot_key
from autodb.terms.chip import HARD_SPOT, built_up_edge
from autodb.wording import (
    amount_words,
    listed,
    localized,
    msgid,
    phrase,
    shop_amount,
    significant,
)

NOTICED = 0.05
"""Share of a band's change from which on a cut is said to be in it. Chosen."""
PROFILED = ("face", "taper", "contour")
"""Operations that change the diameter."""
RANGES = ((DEPTH, msgid("depth"), "mm"), (FEED, msgid("feed"), "mm"))


class AskedCut(Protocol):
    """A cut, or a line of a program, that a planner asks for."""

    @property
    def name(self) -> str:
        """What it is called."""

    @property
    def operation(self) -> str:
        """What it is."""

    def ranges(self, tool_diameter_mm: float | None) -> Mapping[str, tuple[float, float]]:
        """Return from where to where what is stated of it goes, by channel."""


@dataclass(frozen=True)
class UsedBeyond:
    """A calibration, by number, that sensed a force beyond the range of its cuts.

    ``parameters``: the version that was learnt with it, by number; None: none is kept.
    """

    component: str
    calibration: int
    axis: str
    version: int
    parameters: int | None

    @property
    def words(self) -> str:
        """What that does to the intervals, and the remedy."""
        where = (
            ""
            if self.parameters is None
            else phrase("; 'autodb trace parameters {number}' has it", number=self.parameters)
        )
        return phrase(
            "force.{component} was sensed beyond the cuts that calibration {number} (axis {axis} "
            "version {version}) was made with: the intervals are wider by what it may be off there"
            "{where}; calibrate with cuts like these to narrow them",
            component=self.component,
            number=self.calibration,
            axis=axis_words(self.axis),
            version=self.version,
            where=where,
        )


def said_of_states(cuts: Sequence[PredictedCut]) -> Iterable[str]:
    """Say which cuts are predicted in another process state than the usual one."""
    for number, cut in enumerate(cuts, start=1):
        if cut.state is not None:
            yield phrase(
                "cut {number} '{name}': in the state '{state}', which its speed or the wear of its "
                "edge implies",
                number=number,
                name=cut.name,
                state=cut.state,
            )


def said_of_open_ends(cuts: Sequence[JobCut]) -> Iterable[str]:
    """Say which cuts go to a diameter that is not stated: what they take is that of their start."""
    for number, cut in enumerate(cuts, start=1):
        if cut.operation in PROFILED and cut.end_diameter_mm is None:
            yield phrase(
                "{cut}: its torque and power are those at its start, {diameter}; state "
                "end_diameter_mm for their mean and end",
                cut=_cut_words(number, cut.name),
                diameter=amount_words(cut.diameter_mm or 0.0, "mm"),
            )


def said_of_older_edges(longest_s: float | None, cuts: Sequence[JobCut]) -> Iterable[str]:
    """Say which cuts have an older edge than any that a pair without wear was learnt from."""
    for number, cut in enumerate(cuts, start=1):
        if longest_s is not None and (cut.cutting_time_s or 0.0) > longest_s:
            yield phrase(
                "{cut}: no edge had cut for more than {longest}; its intervals leave room for the "
                "wear of an older one",
                cut=_cut_words(number, cut.name),
                longest=amount_words(longest_s, "s"),
            )


def said_of_geometry(known: KnownPair, cuts: Sequence[AskedCut]) -> Iterable[str]:
    """Say which geometry of the tool is assumed because nobody stated it, and how far it is off."""
    kinds = dict.fromkeys(BY_NAME[cut.operation].kind for cut in cuts)
    said = [one.words for kind in kinds for one in tools.assumed_of(kind, known.tool.numbers)]
    if said:
        yield phrase(
            "assumed for {tool}, because it is not stated: {numbers}; state it in a tool file to "
            "narrow the intervals",
            tool=known.tool.name,
            numbers=listed(dict.fromkeys(said)),
        )


def said_of_ranges(made: LearntFrom, cuts: Sequence[AskedCut], tool: ToolOf) -> Iterable[str]:
    """Say which cuts lie outside the depths, feeds and operations that the pair was learnt from."""
    for operation in dict.fromkeys(cut.operation for cut in cuts):
        if operation not in made.operations:
            yield phrase(
                "operation '{operation}' was never cut; its forces come from the law alone, with "
                "wider intervals",
                operation=operation,
            )
    for number, asked in enumerate(cuts, start=1):
        stated = asked.ranges(tool.diameter_mm)
        for channel, what, unit in RANGES:
            if channel not in stated or channel not in made.ranges:
                continue
            (least, most), (low, high) = stated[channel], made.ranges[channel]
            if not (low * 0.999 <= least and most <= high * 1.001):
                value = most if most > high * 1.001 else least
                said = phrase(
                    "{what} {value} was never cut ({low} to {high})",
                    what=phrase(what),
                    value=amount_words(value, unit, ".4g"),
                    low=localized(f"{shop_amount(low, unit)[0]:g}"),
                    high=amount_words(high, unit),
                )
                if asked.name or len(cuts) > 1:
                    name = _cut_words(number, asked.name)
                    said = phrase("{cut}: {said}", cut=name, said=said)
                yield said


def _cut_words(number: int, name: str) -> str:
    """Return which cut it is, by its number and its name."""
    if not name:
        return phrase("cut {number}", number=number)
    return phrase("cut {number} '{name}'", number=number, name=name)


def terms_words(posterior: PairPosterior, terms: Iterable[str]) -> Iterator[str]:
    """Say how large each of some confirmed terms is that a posterior holds, each once."""
    for name in dict.fromkeys(terms):
        if name == WEAR and posterior.wear is not None:
            yield _wear_words(posterior)
        elif name == BAND and posterior.terms.band is not None:
            yield listed([BAND, _band_words(posterior)], ": ")
        elif name == HARD_SPOT.name:
            lots = posterior.terms.lots
            yield from (listed([name, _lot_words(posterior, lot)], ": ") for lot in lots)
        else:
            yield from _law_words(posterior, name)


def _law_words(posterior: PairPosterior, name: str) -> Iterator[str]:
    """Say what the numbers of the law are that hold a term."""
    from autodb.terms.vocabulary import all_terms

    numbers = {n for term in all_terms() if term.name == name for n in term.in_law}
    said = []
    for k in sorted(NAMES.index(number) for number in numbers):
        half = NORMAL_95 * float(np.sqrt(posterior.law.covariance[k, k]))
        middle = float(posterior.law.mean[k])
        value, low, high = (
            float(PARAMETERS[k].outside(at)) for at in (middle, middle - half, middle + half)
        )
        said.append(
            phrase(
                "{name} {value} ({low} to {high}) {unit}",
                name=NAMES[k], value=localized(significant(value)),
                low=localized(significant(low)), high=localized(significant(high)),
                unit=PARAMETERS[k].unit
            )
        )  # fmt: skip
    if said:
        yield listed([name, listed(said)], ": ")


def _share_words(mean: float, sd: float) -> str:
    half = NORMAL_95 * sd
    middle, low, high = (localized(f"{100 * at:+.0f}") for at in (mean, mean - half, mean + half))
    return phrase("{value} % ({low} to {high} %)", value=middle, low=low, high=high)


def _band_words(posterior: PairPosterior) -> str:
    band, place = posterior.terms.band, posterior.columns(BAND)
    assert band is not None
    half = NORMAL_95 * float(np.sqrt(band.covariance[0][0]))
    ends = (band.centre_m_min * np.exp(step * half) for step in (-1.0, 1.0))
    low, high = (localized(f"{end:.3g}") for end in ends)
    sd = np.sqrt(np.diag(posterior.state.covariance)[place])
    along, across = map(_share_words, posterior.state.mean[place].tolist(), sd.tolist())
    return phrase(
        "around {centre_m_min} m/min ({low} to {high}) force along the cutting speed "
        "changes by {along} and across it by {across}",
        centre_m_min=localized(f"{band.centre_m_min:.3g}"),
        low=low,
        high=high,
        along=along,
        across=across,
    )


def _lot_words(posterior: PairPosterior, lot: str) -> str:
    place = posterior.columns(lot_key(lot)).start
    sd = float(np.sqrt(posterior.state.covariance[place, place]))
    return phrase(
        "forces of lot '{lot}' differ by {mean}",
        lot=lot,
        mean=_share_words(float(posterior.state.mean[place]), sd),
    )


def said_of_terms(
    posterior: PairPosterior,
    tool: ToolOf,
    asked: Sequence[JobCut],
    found: Sequence[PredictedCut],
) -> Iterator[str]:
    """Say what confirmed terms are of the forces predicted, and what to state to have them.

    ``asked``: none for the lines of a program, which state nothing of their edge.
    """
    yield from _said_of_wear(posterior, tool, asked, found)
    yield from _said_of_lots(posterior)
    band = posterior.terms.band
    for number, cut in enumerate(found, start=1) if band is not None else ():
        assert band is not None
        inside = float(
            built_up_edge(
                np.array(cut.speed_m_min),
                change=1.0,
                centre_m_min=band.centre_m_min,
                width=band.width,
            )
            - 1.0
        )
        if inside > NOTICED and cut.state is None:
            yield phrase(
                "{cut}: {share} % into the band of {band}: {what}",
                cut=_cut_words(number, cut.name), share=f"{100 * inside:.0f}", band=BAND,
                what=_band_words(posterior)
            )  # fmt: skip


def _said_of_lots(posterior: PairPosterior) -> Iterator[str]:
    lots = posterior.terms.lots
    if posterior.lot in lots:
        yield phrase(
            "{what}; this is in the forces", what=_lot_words(posterior, str(posterior.lot))
        )
    elif lots:
        which = (
            phrase("no lot is stated")
            if posterior.lot is None
            else phrase("lot '{lot}' is not known", lot=posterior.lot)
        )
        known = listed((_lot_words(posterior, lot) for lot in lots), "; ")
        yield phrase("{which}: predicted as of the other lots; {known}", which=which, known=known)


def _three(value: float) -> str:
    return localized(significant(value))


def _wear_words(posterior: PairPosterior) -> str:
    """Return how a posterior says that edges wear."""
    wear = posterior.wear
    assert wear is not None
    place = posterior.columns(WEAR)
    half = NORMAL_95 * np.sqrt(np.diag(posterior.state.covariance)[place])
    along, across = (
        phrase(
            "{value} ({low} to {high})",
            value=_three(value),
            low=_three(value - one),
            high=_three(value + one),
        )
        for value, one in zip(posterior.state.mean[place], half, strict=True)
    )
    differ = (
        phrase("edges differ by {between} %", between=localized(f"{100 * wear.between:.0f}"))
        if wear.between
        else phrase("edges alike")
    )
    return phrase(
        "{wear}: each mm of an edge takes {along} N more along the cutting speed and "
        "{across} N across the edge after {reference} s, as T^{power}; {differ}",
        wear=WEAR,
        along=along,
        across=across,
        reference=localized(f"{wear.reference_s:.0f}"),
        power=localized(f"{wear.power:.2g}"),
        differ=differ,
    )


def _said_of_wear(
    posterior: PairPosterior, tool: ToolOf, asked: Sequence[JobCut], found: Sequence[PredictedCut]
) -> Iterator[str]:
    """Say what wear is of the forces predicted, and which cuts count as made with a fresh edge.

    ``asked``: none for the lines of a program, which state nothing of their edge.
    """
    if posterior.wear is None:
        return
    fresh = [k for k, cut in enumerate(asked, start=1) if cut.cutting_time_s is None]
    if fresh or not asked:
        numbers = ", ".join(map(str, fresh))
        which = phrase("cut {numbers}", numbers=numbers) if fresh else phrase("every line")
        yield (
            phrase(
                "{which}: predicted for a fresh edge; the pair's edges wear, so state in "
                "cutting_time_s how long the edge has cut before",
                which=which,
            )
        )
    for number, cut in enumerate(asked, start=1):
        if cut.cutting_time_s and found[number - 1].state is None:
            yield listed([_cut_words(number, cut.name), _wear_of_cut(posterior, tool, cut)], ": ")


def _wear_of_cut(posterior: PairPosterior, tool: ToolOf, cut: JobCut) -> str:
    """Return what wear is of each force of a cut, with 95 % intervals."""
    assert posterior.wear is not None
    assert cut.cutting_time_s is not None
    conditions = [cut.conditions(tool.diameter_mm)]
    added = worn(posterior, BY_NAME[cut.operation].cuts(tool.numbers, conditions, called=tool.name))
    place, by = posterior.columns(WEAR), added.slopes[0, :3]
    covariance = posterior.state.covariance[place, place]
    half = NORMAL_95 * np.sqrt(np.einsum("qi,ij,qj->q", by, covariance, by) + added.own[0, :3])
    forces = listed(
        phrase(
            "force.{component} {value} N ({low} to {high})",
            component=component,
            value=localized(f"{value:.0f}"),
            low=localized(f"{value - one:.0f}"),
            high=localized(f"{value + one:.0f}"),
        )
        for component, value, one in zip("xyz", added.mean[0, :3], half, strict=True)
    )
    longest_s = posterior.wear.reference_s
    beyond = (
        phrase(
            "; no edge was seen beyond {longest} s: its intervals hold a new one, too",
            longest=localized(f"{longest_s:.0f}"),
        )
        if cut.cutting_time_s > longest_s
        else ""
    )
    return phrase(
        "its edge has cut {cutting_time} s before; {wear} is {forces} of it{beyond}",
        cutting_time=localized(f"{cut.cutting_time_s:g}"),
        wear=WEAR,
        forces=forces,
        beyond=beyond,
    )
