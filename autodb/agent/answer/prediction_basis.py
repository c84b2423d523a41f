"""What answers about a machine's pair rest on, read at once: each answer is then calculated."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from sqlalchemy.orm import Session

from autodb.agent.answer import in_state
from autodb.agent.answer.in_state import States, states_of_version
from autodb.agent.answer.notes import (
    AskedCut,
    UsedBeyond,
    said_of_geometry,
    said_of_older_edges,
    said_of_open_ends,
    said_of_ranges,
    said_of_states,
    said_of_terms,
)
from autodb.agent.answer.undecided_causes import (
    NONE_OPEN,
    OpenCauses,
    open_causes,
    said_of_open,
    undecided_cuts,
)
from autodb.agent.learn.known import Behind, KnownPair
from autodb.agent.matching.past_predictions import width_of_next
from autodb.agent.rows.calibrations import used_beyond
from autodb.agent.rows.catalogue import refuse_other_geometry
from autodb.agent.rows.machines import Owner
from autodb.agent.rows.posteriors import learnt_pairs
from autodb.errors import near_words
from autodb.files.job_cut import JobCut
from autodb.files.machine import AxisLimits
from autodb.forward.cut_figures import CutFigures, cut_figures
from autodb.forward.limits import (
    Exceeding,
    LimitStanding,
    exceeding,
    exceeding_and_standings,
    limit_standings,
)
from autodb.forward.prediction import PredictedCut, ToolOf
from autodb.forward.scored import AS_STATED, Width
from autodb.forward.widening import (
    UndecidedCuts,
    chance_as_old,
    holding_too,
    mean_of_both,
    wider,
    with_room_for_wear,
)
from autodb.pairs.engaged import CUTTING_TIME
from autodb.store import models
from autodb.wording import phrase


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
        if lot is None:
            return self
        known = replace(self.known, posterior=replace(self.known.posterior, lot=lot))
        return replace(self, known=known)

    def of_known_power(self) -> "PredictionBasis":
        """Return what answers rest on were the power that wear grows with known as it is."""
        posterior = self.known.posterior
        if posterior.wear is None:
            return self
        wear = replace(posterior.wear, power_sd=0.0)
        posterior = replace(posterior, terms=replace(posterior.terms, wear=wear))
        return replace(self, known=replace(self.known, posterior=posterior))

    def with_tool(self, stated: Mapping[str, float]) -> "PredictionBasis":
        """Return what answers rest on where this is stated of the tool, and nobody said before.

        Raises UnusableInput where it is known otherwise.
        """
        known = self.known.tool
        refuse_other_geometry(known.name, known.numbers, stated)
        tool = ToolOf(known.name, {**known.numbers, **stated})
        return replace(self, known=replace(self.known, tool=tool))

    def predict(
        self, cuts: Sequence[JobCut], *, aged: bool = False
    ) -> tuple[tuple[PredictedCut, ...], list[models.CuttingParameters]]:
        """Predict cuts, each in its process state; return them, and the states' parameters.

        ``aged``: their edges are as old as they state; else one that is older than any that was
        seen may have been changed. Raises UnusableInput where the tool cannot make one.
        """
        made, used = in_state.predict_in_states(
            self.known.posterior, self.known.tool, self.states, cuts
        )
        found = self.widened(made, [cut.conditions(self.known.tool.diameter_mm) for cut in cuts])
        return found if aged else self._with_new_edges(cuts, found), used

    def _with_new_edges(
        self, cuts: Sequence[JobCut], found: tuple[PredictedCut, ...]
    ) -> tuple[PredictedCut, ...]:
        """Return predicted cuts, of those whose edge may have been changed with a new one's."""
        older = [
            number
            for number, (cut, one) in enumerate(zip(cuts, found, strict=True))
            if one.state is None and self._is_older(cut)
        ]
        if not older:
            return found
        told = [cuts[number] for number in older]
        new, since = (
            self.predict([_as_used(cut, used_s) for cut, used_s in zip(told, ages, strict=True)])[0]
            for ages in ([0.0] * len(told), [self._since_change_s(cut) for cut in told])
        )
        held = {
            number: mean_of_both(holding_too(found[number], fresh), other, self._as_old(cut))
            for number, cut, fresh, other in zip(older, told, new, since, strict=True)
        }
        return tuple(held.get(number, one) for number, one in enumerate(found))

    def _as_old(self, cut: JobCut) -> float:
        """Return how probable a cut's edge is as old as is said."""
        return chance_as_old(cut.cutting_time_s or 0.0, seen_s=self._oldest_s)

    def _since_change_s(self, cut: JobCut) -> float:
        """Return for how long a cut's edge has cut if it was changed when as old as the oldest."""
        return min((cut.cutting_time_s or 0.0) - self._oldest_s, self._oldest_s)

    @property
    def _oldest_s(self) -> float:
        """The longest that an edge had cut of those that wear was learnt of; none: no bound."""
        wear = self.known.posterior.wear
        return float("inf") if wear is None else wear.reference_s

    def _is_older(self, cut: JobCut) -> bool:
        """Say whether a cut's edge is older than any that wear was learnt of."""
        return (cut.cutting_time_s or 0.0) > self._oldest_s

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
        exceeds, limits = exceeding_and_standings([found], self.limits)
        return LookedUp(
            material=self.material,
            tool=self.known.tool.name,
            cut=found,
            behind=self.known.behind,
            notes=self.said([cut], [found]),
            exceeds=exceeds,
            limits=limits,
            figures=cut_figures(found),
        )

    def said(self, cuts: Sequence[JobCut], found: Sequence[PredictedCut]) -> tuple[str, ...]:
        """Say what a planner has to know of predicted cuts."""
        return (
            *self.notes(cuts),
            *said_of_open_ends(cuts),
            *said_of_older_edges(self.longest_s, cuts),
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
        yield from said_of_geometry(self.known, cuts)
        if self.states is not None:
            yield from said_of_ranges(self.states.usual, cuts, self.known.tool)
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


def _as_used(cut: JobCut, used_s: float) -> JobCut:
    return cut.model_copy(update={"cutting_time_s": used_s})
