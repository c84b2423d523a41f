"""What answers about a machine's pair rest on, read at once: each answer is then calculated."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from sqlalchemy.orm import Session

from autodb.agent.answer import in_state
from autodb.agent.answer.in_state import States, states_of_version
from autodb.agent.answer.said_of_terms import said_of_terms
from autodb.agent.answer.undecided_causes import (
    NONE_OPEN,
    OpenCauses,
    open_causes,
    said_of_open,
    undecided_cuts,
)
from autodb.agent.learn.known import Behind, KnownPair
from autodb.agent.learn.learnt_from import LearntFrom
from autodb.agent.matching.past_predictions import width_of_next
from autodb.agent.rows.calibrations import used_beyond
from autodb.agent.rows.catalogue import refuse_other_geometry
from autodb.agent.rows.machines import Owner
from autodb.agent.rows.posteriors import learnt_pairs
from autodb.cutting import tools
from autodb.errors import near_words
from autodb.files.channels import axis_words
from autodb.files.job_cut import JobCut
from autodb.files.machine import AxisLimits
from autodb.forward.cut_figures import CutFigures, cut_figures
from autodb.forward.limits import Exceeding, LimitStanding, exceeding, limit_standings
from autodb.forward.prediction import PredictedCut, ToolOf
from autodb.forward.scored import AS_STATED, Width
from autodb.forward.widening import UndecidedCuts, wider, with_room_for_wear
from autodb.pairs.engaged import BY_NAME, CUTTING_TIME, DEPTH, FEED
from autodb.store import models
from autodb.wording import amount_words, listed, localized, msgid, phrase, shop_amount

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
class LookedUp:
    """What one cut will take, on what that rests, and how it stands to the machine's limits.

    ``exceeds``: those that it may go beyond; ``limits``: all, with those that nobody entered.
    """

    material: str
    tool: str
    cut: PredictedCut
    behind: Behind
    notes: tuple[str, ...]
    exceeds: tuple[Exceeding, ...]
    limits: tuple[LimitStanding, ...]
    figures: CutFigures


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


@dataclass(frozen=True)
class Stamp:
    """What grounds of a learnt pair depend on: as long as it is equal, so are they.

    ``usual`` and ``others``: newest versions of the pair's states, by id; nobody changes a version.
    ``width``: what past predictions make of the intervals; ``open``: causes that wait for a person.
    """

    usual: int
    others: frozenset[int]
    tool: Mapping[str, float]
    limits: Mapping[str, AxisLimits]
    width: Width
    open: OpenCauses


@dataclass(frozen=True)
class PredictionBasis:
    """The posterior of a machine's pair, what its cuts were, and the machine's limits by axis.

    ``states``: None where the pair is not learnt; ``learnt``: then the names of those that are.
    ``width``: what past predictions make of the intervals; ``undecided``: what the ``open`` causes
    do until a person decides on them, or None; ``apart``: what is said of others; ``beyond``: of
    calibrations that were used beyond the range of their cuts.
    """

    machine: str
    limits: Mapping[str, AxisLimits]
    material: str
    known: KnownPair
    states: States | None
    learnt: tuple[str, ...]
    width: Width = AS_STATED
    open: OpenCauses = NONE_OPEN
    undecided: UndecidedCuts | None = None
    apart: tuple[str, ...] = ()
    beyond: tuple[UsedBeyond, ...] = ()

    @property
    def stamp(self) -> Stamp | None:
        """What they depend on; None where the pair is not learnt."""
        usual = self.known.behind.parameters
        if usual is None or self.states is None:
            return None
        others = frozenset(one.row.id for one in self.states.others)
        return Stamp(usual, others, self.known.tool.numbers, self.limits, self.width, self.open)

    def of_lot(self, lot: str | None) -> "PredictionBasis":
        """Return what answers about one lot of the material rest on."""
        known = replace(self.known, posterior=replace(self.known.posterior, lot=lot))
        return self if lot is None else replace(self, known=known)

    def with_tool(self, stated: Mapping[str, float]) -> "PredictionBasis":
        """Return what answers rest on where this is stated of the tool, and nobody said before.

        Raises UnusableInput where it is known otherwise.
        """
        known = self.known.tool
        refuse_other_geometry(known.name, known.numbers, stated)
        tool = ToolOf(known.name, {**known.numbers, **stated})
        return replace(self, known=replace(self.known, tool=tool))

    def predict(
        self, cuts: Sequence[JobCut]
    ) -> tuple[tuple[PredictedCut, ...], list[models.CuttingParameters]]:
        """Predict cuts, each in its process state; return them, and the states' parameters.

        Raises UnusableInput where the tool cannot make one.
        """
        made, used = in_state.predict_in_states(
            self.known.posterior, self.known.tool, self.states, cuts
        )
        return self.widened(
            made, [cut.conditions(self.known.tool.diameter_mm) for cut in cuts]
        ), used

    def widened(
        self, cuts: Sequence[PredictedCut], stated: Sequence[Mapping[str, float]] = ()
    ) -> tuple[PredictedCut, ...]:
        """Return predicted cuts as wide as past predictions and open causes ask for.

        ``stated``: the conditions of each by channel; none: of lines of a program.
        """
        wide = tuple(wider(cut, self.width.factor) for cut in cuts)
        known = stated or [{}] * len(wide)
        longest_s = self.longest_s
        if longest_s is not None:
            wide = tuple(
                with_room_for_wear(cut, cut_s=one.get(CUTTING_TIME, 0.0), seen_s=longest_s)
                for cut, one in zip(wide, known, strict=True)
            )
        return wide if self.undecided is None else self.undecided.widened(wide, known)

    @property
    def waiting(self) -> tuple[str, ...]:
        """What waits for a person, and what decides it."""
        return (*(() if self.undecided is None else (self.undecided.words,)), *self.apart)

    @property
    def longest_s(self) -> float | None:
        """The longest that an edge had cut before a cut that the pair was learnt from.

        None where its posterior has wear, or its cuts do not say.
        """
        if self.states is None or self.known.posterior.wear is not None:
            return None
        ends = self.states.usual.ranges.get(CUTTING_TIME)
        return None if ends is None else ends[1]

    def look_up(self, cut: JobCut) -> LookedUp:
        """Return what one cut will take. Raises UnusableInput where the tool cannot make it."""
        (found,), _ = self.predict([cut])
        return LookedUp(
            material=self.material,
            tool=self.known.tool.name,
            cut=found,
            behind=self.known.behind,
            notes=self.said([cut], [found]),
            exceeds=self.exceeding([found]),
            limits=self.standings([found]),
            figures=cut_figures(found),
        )

    def said(self, cuts: Sequence[JobCut], found: Sequence[PredictedCut]) -> tuple[str, ...]:
        """Say what a planner has to know of predicted cuts."""
        return (
            *self.notes(cuts),
            *_open_ended(cuts),
            *_older(self.longest_s, cuts),
            *said_of_states(found),
            *said_of_terms(self.known.posterior, self.known.tool, cuts, found),
        )

    def exceeding(self, found: Sequence[PredictedCut]) -> tuple[Exceeding, ...]:
        """Return the machine's limits that predicted cuts may exceed."""
        return exceeding(found, self.limits)

    def standings(
        self, found: Sequence[PredictedCut], spans_mm: Mapping[str, float] | None = None
    ) -> tuple[LimitStanding, ...]:
        """Return how predicted cuts stand to each limit that a machine has, entered or not.

        ``spans_mm``: how far they reach along axes.
        """
        return limit_standings(found, self.limits, spans_mm)

    def notes(self, cuts: Sequence[AskedCut]) -> Iterable[str]:
        """Say from what an answer is, what is assumed, and what is far from the pair's cuts.

        Far are depths, feeds and operations that they do not hold.
        """
        if not self.known.own:
            name = f"{self.material} / {self.known.tool.name}"
            hint = near_words(name, self.learnt) if self.learnt else ""
            from autodb.wording.kept import said_again  # a pair that is learnt needs none

            start = self.known.behind.started_from
            yield phrase(
                "{machine} has no parameters of {pair}{hint}; predicted from {start}",
                machine=self.machine,
                pair=name,
                hint=hint,
                start=said_again(start or ""),
            )
        yield from _assumed(self.known, cuts)
        if self.states is not None:
            yield from _outside(self.states.usual, cuts, self.known.tool)
        yield from (one.words for one in self.beyond)
        if self.width.factor > 1.0:
            yield self.width.words(self.machine)
        yield from self.waiting


def prediction_basis_of(
    session: Session, owner: Owner, material: str, known: KnownPair
) -> PredictionBasis:
    """Read what else answers rest on about a pair of which this is known."""
    number = known.behind.parameters
    waiting = NONE_OPEN if number is None else open_causes(session, number)
    return PredictionBasis(
        machine=owner.name,
        limits=owner.limits,
        material=material,
        known=known,
        states=None if number is None else states_of_version(session, number),
        learnt=() if known.own else tuple(learnt_pairs(session, owner.id)),
        width=width_of_next(session, owner.id, (material, known.tool.name), learnt=known.own),
        open=waiting,
        undecided=None if number is None else undecided_cuts(session, number, waiting),
        apart=said_of_open(session, waiting),
        beyond=tuple(_used_beyond(session, known)),
    )


def _used_beyond(session: Session, known: KnownPair) -> Iterable[UsedBeyond]:
    """Give the calibrations that sensed forces behind an answer beyond the range of their cuts."""
    for row in used_beyond(session, (one.key for one in known.posterior.shared)):
        number = None if known.row is None else known.row.id
        yield UsedBeyond(row.component, row.id, row.axis, row.version, number)


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


def _open_ended(cuts: Sequence[JobCut]) -> Iterable[str]:
    """Say which cuts go to a diameter that is not stated: what they take is that of their start."""
    for number, cut in enumerate(cuts, start=1):
        if cut.operation in PROFILED and cut.end_diameter_mm is None:
            yield phrase(
                "{cut}: its torque and power are those at its start, {diameter}; state "
                "end_diameter_mm for their mean and end",
                cut=_cut_words(number, cut.name),
                diameter=amount_words(cut.diameter_mm or 0.0, "mm"),
            )


def _older(longest_s: float | None, cuts: Sequence[JobCut]) -> Iterable[str]:
    """Say which cuts have an older edge than any that a pair without wear was learnt from."""
    for number, cut in enumerate(cuts, start=1):
        if longest_s is not None and (cut.cutting_time_s or 0.0) > longest_s:
            yield phrase(
                "{cut}: no edge had cut for more than {longest}; its intervals leave room for the "
                "wear of an older one",
                cut=_cut_words(number, cut.name),
                longest=amount_words(longest_s, "s"),
            )


def _assumed(known: KnownPair, cuts: Sequence[AskedCut]) -> Iterable[str]:
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


def _outside(made: LearntFrom, cuts: Sequence[AskedCut], tool: ToolOf) -> Iterable[str]:
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
