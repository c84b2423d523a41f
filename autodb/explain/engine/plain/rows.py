"""Rows as they are, in blocks: how well do laws predict those that their fit did not see?"""

from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.bench import RowsSource
from autodb.explain.engine.candidates import Candidate, CandidateForm, Choice, of_its_kind
from autodb.explain.engine.fit import Folds, block_edges
from autodb.explain.engine.noise import slow_variance
from autodb.explain.engine.normal import Normal, columns_side_by_side
from autodb.explain.engine.prior import own_deviations
from autodb.explain.engine.search import MISTAKEN
from autodb.explain.engine.working import reduced

Array = NDArray[np.float64]
Index = NDArray[np.intp]

BLOCKS = 8
"""Contiguous parts of a recording that are left out of the fit in turn."""
NEEDED = 0.02
"""Share by which the held-out rms must rise without a law for it to stay; a law of more columns
than another must lower it by so much more for each. Chosen."""
ALONE = 1e-3
"""Share of a law's squares that the others must not be able to give: less than that and it is they
in other sizes. Chosen."""
DISCREPANCY = 0.03
"""Share of what a law explains by which real effects leave it (measured on real axes)."""
OWN = 0.5
"""Share of the squares that a law takes away, which it must take away beside a rival, too, for them
to be effects of two kinds. Chosen."""
QUIET = 0.05
"""Share of the rms that an effect has in all blocks, below which it is silent in one. Chosen."""
HALF = 0.5
"""Share of the peak of an effect from which on rows are within its stretch. Chosen."""
BEYOND = 1.5
"""No contribution is larger than this times the range of the difference. Chosen."""
ROWS = 8000
"""Rows at most, means of more: laws that are clearly needed are seen in fewer. Chosen."""
DEALT = 5
"""Smaller blocks a fold is made of, at least, where an effect is confined to a stretch. Chosen."""
FEWEST = 5
"""Blocks in which a law must act for these to be judged alone. Chosen."""
ELSEWHERE = 0.05
"""Share of a law's squares beside the blocks that it is confined to, at most. Chosen."""
SHARED = 8
"""A gap between a block left out and the rows fitted on takes this part of a block at most."""


class PlainRows:
    """A difference, own columns and forms of candidates in blocks of plain rows.

    Plain laws of named candidates and what these may be mistaken for, curves of those without a
    name, and what was chosen (``held``). ``acts_on``: by key of a candidate that acts on others,
    the keys of those that it was built on.
    """

    def __init__(
        self,
        bench: RowsSource,
        candidates: Iterable[Candidate],
        held: Sequence[Choice] = (),
        acts_on: Mapping[str, frozenset[str]] = MappingProxyType({}),
    ) -> None:
        self.candidates = tuple(candidates)
        self.acts_on = acts_on
        self._terms = tuple(bench.own)
        self._simulated = np.where(np.isfinite(bench.own_sizes), bench.own_sizes, 0.0)
        self._difference = bench.reduced_difference
        own = bench.chosen(())
        keys = [
            (c.key, number)
            for c in self.candidates
            for number, form in enumerate(c.forms)
            if form.names or not c.named or (c.key, number) in {h.key for h in held}
        ]
        forms = {c.key: c.forms for c in self.candidates}
        blocks = {key: bench.columns(key, forms[key[0]][key[1]]) for key in keys}
        for c in self.candidates:
            if c.mistaken is not None:
                key = (c.key, MISTAKEN)
                blocks[key] = bench.columns(key, CandidateForm(c.mistaken))
        ends = np.cumsum([1 + own.shape[1], *(block.shape[1] for block in blocks.values())])
        self._places = {key: np.arange(ends[i], ends[i + 1]) for i, key in enumerate(blocks)}
        self._own = np.arange(1, 1 + own.shape[1])
        rows = columns_side_by_side(self._difference, own, *blocks.values())
        self.mean_of = -(-len(rows) // ROWS)
        rows = reduced(rows, self.mean_of)
        self._difference = rows[:, 0]
        self._peak = np.abs(rows).max(axis=0)
        self.range = range_of(self._difference)
        gap = min(-(-bench.gap * len(rows) // len(own)), len(rows) // BLOCKS // SHARED)
        self._edges = block_edges(len(rows), BLOCKS, bench.progress)
        self._folds = Folds(rows, gap, blocks=BLOCKS, folds=BLOCKS, progress=bench.progress)
        self._dealt: dict[int, Folds] = {}
        self._in_time, self._apart = bench.gap > 0, bench.apart
        self._slow_of: dict[tuple[str, int], float] = {}
        self._weight = np.zeros(rows.shape[1])
        self._rows = rows
        self._weigh(bench.own_sizes)

    def _weigh(self, own_sizes: Array) -> None:
        """Draw own terms to what the simulation says, as far as slow noise of what all static laws
        leave allows, unless it was fitted to these rows; loose columns to none, as far as their
        size in all rows allows: a block that is left out may alone hold the speeds of one.
        """
        self.slow = self._slow([])
        loose, whole = ~np.isfinite(own_sizes), self._folds.whole
        own = self._own[~loose]
        given = float(self._solved(own) @ whole[own, 0]) if self._in_time else np.inf
        size = own_deviations(own_sizes, given=given, of=float(whole[0, 0]))
        if loose.any():
            size[loose] = np.abs(self._solved(self._all_static([]))[: len(size)][loose])
        self._weight[self._own] = self.slow / np.maximum(size, 1e-300) ** 2

    def _slow(self, choices: Sequence[Choice]) -> float:
        """Return the variance that slow noise gives a row, beside all static laws and choices."""
        at = self._all_static(choices)
        left = self._difference - self._rows[:, at] @ self._solved(at)
        return max(slow_variance(left), float(np.mean(left**2)), 1e-300)

    def _all_static(self, choices: Sequence[Choice]) -> Index:
        """Return the places of own columns, all static laws in their first form, and choices."""
        static = [(c.key, 0) for c in self.candidates if c.static and (c.key, 0) in self._places]
        keys = dict.fromkeys((*static, *(c.key for c in choices)))
        return np.concatenate([self._own, *(self._places[key] for key in keys)]).astype(np.intp)

    def slow_beside(self, choice: Choice) -> float:
        """Return the variance that slow noise gives a row where a choice is no part of it."""
        if choice.key not in self._slow_of:
            self._slow_of[choice.key] = self._slow([choice])
        return self._slow_of[choice.key]

    def _at(self, choices: Sequence[Choice]) -> Index:
        return np.concatenate([self._own, *(self._places[c.key] for c in choices)]).astype(np.intp)

    def fitted(self, choices: Sequence[Choice]) -> tuple[Array, list[Array], list[Array]]:
        """Return own terms' changes (k,), each choice's coefficients (p,), and their covariance
        (p, p) where noise of a plain row is 1.
        """
        at = self._at(choices)
        inverse = self._inverse(at)
        values = inverse @ self._folds.whole[at, 0]
        places = np.split(
            np.arange(len(at)),
            np.cumsum([len(self._own), *(len(self._places[c.key]) for c in choices)])[:-1],
        )
        own, *of_choices = [values[p] for p in places]
        return own, of_choices, [inverse[np.ix_(p, p)] for p in places[1:]]

    def _solved(self, at: Index) -> Array:
        return np.asarray(self._inverse(at) @ self._folds.whole[at, 0])

    def _inverse(self, at: Index, *, weight: float = 1.0) -> Array:
        whole = self._folds.whole
        return Normal(whole[np.ix_(at, at)], whole[at, 0]).inverse(weight * self._weight[at])

    def squares(self, choices: Sequence[Choice], *, like: Candidate | None = None) -> Array:
        """Return the sum of squares of each fold, predicted by a fit to the others, (BLOCKS,).

        A fold is a contiguous block; where one is to be ``like`` an effect that is confined to a
        stretch, it is many small ones, so that each fold holds a part of the stretch.
        """
        at = self._at(choices)
        return self._folds_like(like).by_fold(at, self._weight[at])

    def confined(self, candidate: Candidate) -> bool:
        """Whether an effect is confined to a stretch, or does next to all in few of the blocks."""
        return self._parts_of(candidate) > 1

    def _folds_like(self, like: Candidate | None) -> Folds:
        parts = 1 if like is None else self._parts_of(like)
        if parts == 1:
            return self._folds
        if parts not in self._dealt:
            self._dealt[parts] = Folds(self._rows, 0, blocks=parts * BLOCKS, folds=BLOCKS)
        return self._dealt[parts]

    def _parts_of(self, candidate: Candidate) -> int:
        """Return how many blocks a fold is made of, so that each holds a part of what an effect
        does: one where that is done in many of the contiguous ones, or comes and goes too seldom
        for each to see it anew, as in rows that are no course of time (those have no gap), or has
        a shape that was searched for, which follows what neighbours have in common.
        """
        forms = range(len(candidate.forms))
        first = next((n for n in forms if (candidate.key, n) in self._places), None)
        if first is None:
            return 1
        column = np.abs(self._rows[:, self._places[candidate.key, first][0]])
        if candidate.interval is not None:
            inside = int(np.count_nonzero(column > HALF * column.max()))
            return min(max(DEALT, len(column) // max(inside, 1)), len(column) // BLOCKS)
        searched = not candidate.static or candidate.forms[first].tries > 1
        parts = np.split(column, self._edges[1:-1])
        held = np.cumsum(np.sort([part @ part for part in parts])[::-1])
        few = 1 + int(np.count_nonzero(held < (1.0 - ELSEWHERE) * held[-1]))
        comes = int(np.count_nonzero(np.diff(column**2 > np.mean(column**2), prepend=False))) // 2
        if searched or not self._in_time or few >= FEWEST or comes < FEWEST:
            return 1
        return min(max(DEALT, -(-2 * BLOCKS // few)), len(column) // BLOCKS)

    def acts_in(
        self, choices: Sequence[Choice], number: int, *, like: Candidate | None = None
    ) -> NDArray[np.bool_]:
        """Return in which folds one of the choices adds something, (BLOCKS,): what acts where the
        axis moves says nothing of a block in which it stands.
        """
        at, values = self._places[choices[number].key], self.coefficients(choices)[number]
        inner = self._folds_like(like).test[:, at[:, None], at]
        squares = np.einsum("i,fij,j->f", values, inner, values)
        return np.asarray(squares > QUIET**2 * squares.mean())

    def without_and_with(
        self, others: Sequence[Choice], choice: Choice, *, like: Candidate | None = None
    ) -> tuple[Array, Array]:
        """Return the squares by fold without a choice beside others, and with it: beside what it
        may be mistaken for, too, where that predicts better in its place and leaves it less to do.
        """
        folds, at, own = self._folds_like(like), self._at(others), self._places[choice.key]

        def squares(*more: Index) -> Array:
            every = np.concatenate([at, *more])
            return folds.by_fold(every, self._weight[every])

        without, whole = squares(), squares(own)
        mistaken = self._places.get((choice.candidate.key, MISTAKEN))
        if mistaken is None:
            return without, whole
        instead, both = squares(mistaken), squares(mistaken, own)
        if instead.sum() >= whole.sum() or rms_fall(instead, both) > rms_fall(without, whole):
            return without, whole
        return instead, both

    def contribution(self, choices: Sequence[Choice], number: int) -> Array:
        """Return what one of the choices adds beside the others, (m,)."""
        coefficients = self.coefficients(choices)[number]
        return np.asarray(self._rows[:, self._places[choices[number].key]] @ coefficients)

    def coefficients(self, choices: Sequence[Choice]) -> list[Array]:
        """Return each choice's coefficients, fitted on all rows."""
        return self.fitted(choices)[1]

    def evidence(self, choices: Sequence[Choice], choice: Choice) -> float:
        """Return by how much the held-out squares fall with one of the choices, over the variance
        that slow noise gives a row.
        """
        others = [c for c in choices if c.key != choice.key]
        without, whole = (self.squares(c, like=choice.candidate) for c in (others, choices))
        return float(without.sum() - whole.sum()) / self.slow

    def physical(self, choices: Sequence[Choice]) -> bool:
        """Whether each choice has what it needs and a sign that it may have, and none is larger
        than all that was measured."""
        terms = {*self._terms, *(c.candidate.term for c in choices)}
        if not all(self._allowed(choices, self.coefficients(choices))):
            return False
        for choice, values in zip(choices, self.coefficients(choices), strict=True):
            if choice.candidate.needs and not choice.candidate.needs & terms:
                return False
            if self._peak_of(choice, values) > BEYOND * self.range:
                return False
        return self.own_share(choices) > ALONE

    def of_their_kind(self, choices: Sequence[Choice]) -> list[bool]:
        """Whether each choice has coefficients that it may have, a positive sign say, and makes a
        law of its kind with the others and own terms.
        """
        own, fitted, _ = self.fitted(choices)
        allowed = self._allowed(choices, fitted)
        if all(choice.candidate.part_of is None for choice in choices):
            return allowed
        parts = [
            self._rows[:, self._places[c.key]] @ v for c, v in zip(choices, fitted, strict=True)
        ]
        simulated = self._rows[:, self._own] * (self._simulated + own)
        every = [*zip(self._terms, simulated.T, strict=True)]
        every += zip((c.candidate.known_as for c in choices), parts, strict=True)
        return [
            ok and of_its_kind(choice, part, every)
            for ok, choice, part in zip(allowed, choices, parts, strict=True)
        ]

    def of_their_kind_beside(self, choices: Sequence[Choice], candidate: Candidate) -> list[Choice]:
        """Return the choices without those that are no law of their kind beside a candidate in the
        form that predicts best with them: the dip of friction that a ripple had been taken for.
        """
        forms = [Choice(candidate, number) for number in range(len(candidate.forms))]
        forms = [one for one in forms if one.key in self._places]
        if not choices or not forms:
            return list(choices)
        every = [[*choices, one] for one in forms]
        best = min(every, key=lambda some: float(self.squares(some, like=candidate).sum()))
        *kinds, its = self.of_their_kind(best)
        return [one for one, of_kind in zip(choices, kinds, strict=True) if of_kind or not its]

    @staticmethod
    def _allowed(choices: Sequence[Choice], fitted: Sequence[Array]) -> list[bool]:
        return [
            choice.shape.allowed is None or choice.shape.allowed(values)
            for choice, values in zip(choices, fitted, strict=True)
        ]

    def _peak_of(self, choice: Choice, values: Array) -> float:
        """Return the most that a choice adds with coefficients, anywhere."""
        at = self._places[choice.key]
        if len(at) == 1:
            return float(abs(values[0]) * self._peak[at[0]])
        return float(np.max(np.abs(self._rows[:, at] @ values)))

    def own_share(self, choices: Sequence[Choice]) -> float:
        """Return the least share of a column of the last choice that the others cannot give."""
        at = self._at(choices)
        last = len(at) - len(self._places[choices[-1].key])
        others, own = at[:last], at[last:]
        whole = self._folds.whole
        given = whole[np.ix_(others, own)]
        left = np.diag(whole)[own] - np.sum(given * (self._inverse(others, weight=0.0) @ given), 0)
        return float(np.min(left / np.maximum(np.diag(whole)[own], 1e-300)))

    def has_its_own(self, others: Sequence[Choice], choice: Choice, rival: Choice) -> bool:
        """Whether a choice beside others explains something else than a rival in its place: beside
        the rival, too, it takes OWN of the squares away that it takes without it.
        """
        like = choice.candidate
        sets: tuple[list[Choice], ...] = ([], [choice], [rival], [rival, choice])
        none, its, rivals, both = (
            float(self.squares([*others, *one], like=like).sum()) for one in sets
        )
        return rivals - both > OWN * (none - its) > 0.0

    def richness(self, choice: Choice) -> float:
        """Return the share by which the held-out rms must fall for a choice's further columns."""
        further = len(self._places[choice.key]) - 1
        return self._price * (further - choice.candidate.phased)

    @property
    def _price(self) -> float:
        """Share of the held-out rms for a further column: NEEDED, since rows that follow each other
        in time hold less than as many others; of those at most what Schwarz (1978) asks of them.
        """
        if not self._apart:
            return NEEDED
        count = len(self._difference)
        return min(NEEDED, 0.5 * float(np.log(count)) / count)

    def asked_more(self, choice: Choice) -> float:
        """Return the share by which the held-out rms must fall further for a choice to be taken at
        all: nothing, where each of its columns has a meaning of its own.
        """
        del choice
        return 0.0

    def with_one_more(
        self,
        choices: Sequence[Choice],
        candidate: Candidate,
        *,
        like: Candidate | None = None,
        frugal: bool = False,
    ) -> tuple[Array, Choice] | None:
        """Return the squares by fold with a candidate in its best form, and the choice; nothing
        where that makes no law of its kind with the others, for then a worse one is no better.

        ``like``: the candidate that folds are chosen for, None: this one. ``frugal``: what a form's
        further columns are asked for counts.
        """
        like, least = like or candidate, np.inf
        before = float(self.squares(choices, like=like).sum()) if frugal else 1.0
        best: tuple[Array, Choice] | None = None
        for number in range(len(candidate.forms)):
            choice = Choice(candidate, number)
            if choice.key not in self._places:
                continue
            squares = self.squares([*choices, choice], like=like)
            left = float(squares.sum())
            if frugal:
                left = float(np.sqrt(left / max(before, 1e-300))) + self.asked_more(choice)
            if left < least and self.physical([*choices, choice]):
                best, least = (squares, choice), left
        if best is None or not all(self.of_their_kind([*choices, best[1]])):
            return None
        return best


def range_of(difference: Array) -> float:
    """Return the range of a difference (n,), or how far it is from none where that is more."""
    return max(float(np.ptp(difference)), float(np.abs(difference).max()))


def beside(choices: Sequence[Choice], candidate: Candidate) -> list[Choice]:
    """Return the choices that a candidate may stand beside."""
    return [c for c in choices if c.candidate.term not in candidate.excludes]


def rms_fall(before: Array, after: Array) -> float:
    """Return the share by which the rms over all blocks falls; none where nothing was left."""
    whole = float(before.sum())
    return 1.0 - float(np.sqrt(after.sum() / whole)) if whole > 0.0 else 0.0
