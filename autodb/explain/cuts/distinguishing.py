"""The cuts on which two explanations of a table of cuts would differ most for the scatter there is.

Both are fitted to the table and carried to cuts that follow it, where `explain.engine.telling` says
how far they differ in all components together. A trial that changes one thing comes before one that
changes two; where nothing may be changed, cuts of the table are made again at its end.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from autodb.explain.cuts.candidates.laws import LawColumns
from autodb.explain.cuts.carried import CutsAccount, Elsewhere, elsewhere, fit_cuts_account
from autodb.explain.cuts.cut_search import FoundInCuts
from autodb.explain.cuts.stack import (
    THIN_CHIP_MM,
    Conditions,
    Stack,
    tells_edge_from_size,
)
from autodb.explain.cuts.trials import CutTrial, joined_trials, paired, plain_trials, usual
from autodb.explain.engine.candidates import Choice
from autodb.explain.engine.search import FoundSet
from autodb.explain.engine.telling import (
    NEAREST,
    SEPARATES,
    Separation,
    called,
    odds,
    sentence,
    stand_in,
)
from autodb.wording import significant, stored_msgid

Array = NDArray[np.float64]
Rows = NDArray[np.intp]
Own = Callable[[Stack], dict[str, LawColumns]]

EDGE_OR_SIZE = {"edge_force", "size_effect"}
"""Terms that only a thin chip separates."""
TIMES = (1, 3, 10)
"""How often a cut is made again, the fewest first. Chosen."""

SCATTER = stored_msgid("scatter is {size} a cut; together {count} standard deviations")
THINNER = stored_msgid(
    "Cuts with a chip of {size} or less would separate {one} from {other}; none of them is close "
    "to these."
)


@dataclass(frozen=True)
class Parted:
    """A trial that separates two accounts, by how much, in which component, and its scatter."""

    trial: CutTrial
    gap: Separation
    component: str
    scatter: float


@dataclass(frozen=True)
class Trials:
    """The trials that can follow a table, as cuts in one stack."""

    result: FoundInCuts
    trials: Sequence[CutTrial]

    @cached_property
    def cuts(self) -> Elsewhere:
        """All cuts of all trials."""
        known = self.result.stack.known
        return elsewhere(self.result, joined_trials([t.known for t in self.trials]), usual(known))

    def best(self, first: tuple[Choice, ...], second: tuple[Choice, ...]) -> Parted | None:
        """Return the trial on which two sets differ most, None where none separates them."""
        if not self.trials:
            return None
        accounts = [
            fit_cuts_account(self.result, choices, self.cuts) for choices in (first, second)
        ]
        thin = _terms(first) ^ _terms(second) == EDGE_OR_SIZE
        able = [
            p
            for p in self._parted(*accounts)
            if p.gap.odds > SEPARATES and (not thin or tells_edge_from_size(p.trial.known))
        ]
        return max(able, key=lambda parted: parted.gap.odds, default=None)

    def _parted(self, one: CutsAccount, two: CutsAccount) -> list[Parted]:
        free = np.concatenate([one.free, two.free], axis=2)
        difference = (one.force - two.force)[:, :, None]
        stack = self.cuts.stack
        both = np.concatenate([difference, free], axis=2)
        white = stack.white(both).reshape(both.shape)
        ends = np.cumsum([0, *(len(t.known) for t in self.trials)])
        return [
            self._gap(trial, both[:, at], white[:, at], stack.sd[:, at])
            for trial, at in zip(self.trials, map(slice, ends, ends[1:]), strict=False)
        ]

    def _gap(self, trial: CutTrial, both: Array, white: Array, sd: Array) -> Parted:
        """Return how far two accounts differ on a trial; columns: the difference, then the free."""
        flat = white.reshape(-1, white.shape[2])
        gained, taken = odds(flat[:, 1:], flat[:, 0])
        left = np.abs(both[:, :, 0] - both[:, :, 1:] @ taken)
        i = int(np.argmax(np.max(left / sd, axis=1)))
        gap = Separation(
            words=trial.words,
            odds=gained,
            distance=float(np.sqrt(gained / len(flat))),
            peak=float(left[i].max()),
        )
        return Parted(trial, gap, self.cuts.stack.names[i], float(sd[i].mean()))


def _terms(choices: tuple[Choice, ...]) -> set[str]:
    return {choice.candidate.term for choice in choices}


@dataclass(frozen=True)
class Teller:
    """Trials that would distinguish the effects found in a table from their rivals.

    ``rounds`` of trials are tried in their order; ``unit`` of the channels.
    """

    result: FoundInCuts
    rounds: Sequence[Trials]
    unit: str = "N"

    def distinguishing(self, choice: Choice, name: str, rivals: Sequence[str]) -> str | None:
        """Return the cuts that distinguish a found effect, called ``name``, from its nearest
        rivals.

        None where it has none, or where no trial of the library separates it from any.
        """
        lines = []
        for rival in rivals[:NEAREST]:
            best = self.best(choice, rival)
            if best is not None:
                lines.append(self.line(best, (name, rival)))
            elif {name, rival} == EDGE_OR_SIZE:
                lines.append(THINNER.format(size=f"{THIN_CHIP_MM:g} mm", one=name, other=rival))
        return " ".join(lines) if lines else None

    def line(self, best: Parted, names: tuple[str, str]) -> str:
        """Return a trial and how far what is called by two names would differ there, in words."""
        where = best.component if len(self.result.stack.names) > 1 else ""
        noise = SCATTER.format(
            size=f"{significant(best.scatter, 2)} {self.unit}",
            count=significant(np.sqrt(best.gap.odds), 2),
        )
        return sentence(best.gap, names, self.unit, noise, channel=where)

    def best(self, choice: Choice, rival: str) -> Parted | None:
        """Return the trial that distinguishes a found effect from a rival, None where none does."""
        other = self.instead(choice, rival)
        if other is None:
            return None
        return self.between(self.result.found.choices, other.choices)

    def between(self, first: tuple[Choice, ...], second: tuple[Choice, ...]) -> Parted | None:
        """Return the trial of the first round that has one which separates two sets, or None."""
        tried = (trials.best(first, second) for trials in self.rounds)
        return next((parted for parted in tried if parted is not None), None)

    def instead(self, choice: Choice, rival: str) -> FoundSet | None:
        """Return the best set in which a term stands in for an effect, in each component it may."""
        search, key = self.result.search, choice.candidate.key
        candidates = called(search, rival, but=key)
        swap = stand_in(search, self.result.found, key, candidates)
        if swap is None:
            return None
        found = swap[0]
        for _ in candidates[1:]:
            more = [offer for offer in search.offers(found.choices, candidates) if offer.worth > 0]
            if not more:
                break
            best = max(more, key=lambda offer: offer.worth)
            found = search.settled((*found.choices, best.choice))
        return found


def after_forces(result: FoundInCuts) -> Teller:
    """Return what distinguishes effects in forces by cuts that follow the table."""
    known = result.stack.known
    return Teller(result, (Trials(result, plain_trials(known)), Trials(result, paired(known))))


@dataclass(frozen=True)
class Again(Trials):
    """Trials that are cuts of the table themselves: ``rows`` of all of them, one after the other.

    Simulation and scatter are those of the rows; ``own`` builds the columns that are free anyhow.
    """

    rows: Rows
    own: Own

    @cached_property
    def cuts(self) -> Elsewhere:
        """All cuts of all trials."""
        table, rows = self.result.stack, self.rows
        simulation = table.simulation[:, rows]
        stack = replace(
            table,
            known=_after(table.known, rows),
            recording=simulation,
            simulation=simulation,
            edge_mm=table.edge_mm[:, rows],
            sd=table.sd[:, rows],
            like=table,
        )
        return Elsewhere(stack, self.own(stack), {})


def made_again(result: FoundInCuts, own: Own, *, unit: str) -> Teller:
    """Return what distinguishes effects by the table's cuts made again, those of each condition.

    Every effect must say how it is built ``anew``.
    """
    known = result.stack.known
    first = _one_of_each(result.stack)
    rounds = [
        Again(
            result,
            [_trial(known, row, times) for row in first],
            np.repeat(first, times),
            own,
        )
        for times in TIMES
    ]
    return Teller(result, rounds, unit)


def _one_of_each(stack: Stack) -> Rows:
    """Return the first row of each simulated rise, to three digits."""
    size = float(np.max(np.abs(stack.simulation)))
    _, first = np.unique(np.round(stack.simulation[0] / size, 3), return_index=True)
    return np.sort(first)


def _trial(known: Conditions, row: int, times: int) -> CutTrial:
    often = "once more" if times == 1 else f"{times} times more"
    words = f"Make cut {known.number[row]:g} {often} at the end"
    return CutTrial(words, _after(known, np.full(times, row)))


def _after(known: Conditions, rows: Rows) -> Conditions:
    """Return the conditions of some rows made after the last one, with the last edge."""
    count = 1.0 + np.arange(len(rows))
    step_s = float(np.median(np.diff(known.t_s)))

    def like(values: Array | None) -> Array | None:
        return None if values is None else values[rows]

    def last(values: Array | None) -> Array | None:
        return None if values is None else np.full(len(rows), values[-1])

    return replace(
        known,
        number=known.number[-1] + count,
        t_s=known.t_s[-1] + step_s * count,
        depth_mm=known.depth_mm[rows],
        thickness_mm=like(known.thickness_mm),
        speed_m_min=like(known.speed_m_min),
        edge=last(known.edge),
        cutting_time_s=last(known.cutting_time_s),
        land_mm=last(known.land_mm),
        other={name: values[rows] for name, values in known.other.items()},
    )
