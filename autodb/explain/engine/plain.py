"""Named laws that plain rows need: held-out least squares, whatever the colour of the noise.

A real mismatch is smooth: an autoregression predicts it one step ahead, so that white rows may hold
nothing of a load or a mass that anybody sees. And real laws are approximate: where noise is small, a
curve that bends with their errors is likelier than they are. The error on blocks left out of the fit
knows neither trap: a law that is missing lowers it in most blocks, by much. So the laws are taken one
by one that lower it most, static ones first; what acts on others (a lag, a gain) and what must be
searched for (a period, a stretch) may enter where no static law does, and a law that the others make
needless goes again.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.bench import WhiteRows
from autodb.explain.engine.candidates import Candidate, Choice
from autodb.explain.engine.fit import Folds
from autodb.explain.engine.noise import PLAIN, Whitener
from autodb.explain.engine.normal import HELD, columns_side_by_side
from autodb.explain.engine.search import MARGIN
from autodb.explain.engine.tuning import BesideShapes, tuned
from autodb.explain.engine.working import reduced

Array = NDArray[np.float64]
Index = NDArray[np.intp]

BLOCKS = 8
"""Contiguous parts of a recording that are left out of the fit in turn."""
GAIN = 0.04
"""Share by which the held-out rms must fall with a law: by chance, on recordings of real axes that
nothing was missing in, a column lowered it by 4.5 % at most (physics reference, section 10)."""
IN_BLOCKS = 6
"""Blocks of which each must be predicted better with it. Chosen."""
BETTER = 0.05
"""Share by which what changes all that is recorded must lower the held-out rms below that of all
static laws to come before them. Chosen."""
NEEDED = 0.02
"""Share by which the held-out rms must rise without a law for it to stay."""
MOST = 5
"""Laws at most."""
OWN_SD = 0.25
"""Relative standard deviation of the simulation's own terms: what a simulation says of itself is
worth something. Chosen of none, 0.25 and free on real recordings (physics reference, section 10)."""
ALONE = 1e-3
"""Share of a law's squares that the others must not be able to give: less than that and it is they
in other sizes. Chosen."""
HALF = 0.5
"""A column times its inverse is 1 at least; less than this where rows do not hold it at all."""
BEYOND = 1.5
"""No contribution is larger than this times the range of what was measured. Chosen."""
ROWS = 8000
"""Rows at most, means of more: laws that are clearly needed are seen in fewer. Chosen."""
DEALT = 5
"""Smaller blocks a fold is made of, at least, where an effect is confined to a stretch. Chosen."""
SHARED = 8
"""A gap between a block left out and the rows fitted on takes this part of a block at most."""
ROUNDS, FIRST_SCAN = 4, 10
"""Rounds of searching what laws leave, and the number that the first of them goes by."""
SLOW = 64
"""Parts over which means are taken to see slow noise."""
CHI_SQUARE_MEDIAN = 0.455
"""Median of a squared standard normal: few parts that hold a stretch of something count little."""


class PlainRows:
    """A difference, own columns and forms of candidates in blocks of plain rows.

    Plain laws of named candidates, curves of those without a name, and what was chosen (``held``).
    """

    def __init__(
        self, bench: WhiteRows, candidates: Iterable[Candidate], held: Sequence[Choice] = ()
    ) -> None:
        self.candidates = tuple(candidates)
        self._terms = frozenset(bench.own)
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
        ends = np.cumsum([1 + own.shape[1], *(block.shape[1] for block in blocks.values())])
        self._places = {key: np.arange(ends[i], ends[i + 1]) for i, key in enumerate(keys)}
        self._own = np.arange(1, 1 + own.shape[1])
        rows = columns_side_by_side(self._difference, own, *blocks.values())
        self.mean_of = -(-len(rows) // ROWS)
        rows = reduced(rows, self.mean_of)
        self._difference = rows[:, 0]
        self._peak = np.abs(rows).max(axis=0)
        self.range = max(float(np.ptp(self._difference)), float(np.abs(self._difference).max()))
        gap = min(-(-bench.gap * len(rows) // len(own)), len(rows) // BLOCKS // SHARED)
        self._folds = Folds(rows, gap, blocks=BLOCKS, folds=BLOCKS)
        self._dealt: dict[int, Folds] = {}
        self._weight = np.zeros(rows.shape[1])
        self._rows = rows
        self._weigh(bench.own_sizes)

    def _weigh(self, own_sizes: Array) -> None:
        """Draw own terms to what the simulation says, as far as slow noise of what all static laws
        leave allows.
        """
        first = [(c.key, 0) for c in self.candidates if c.static and (c.key, 0) in self._places]
        at = np.concatenate([self._own, *(self._places[key] for key in first)]).astype(np.intp)
        left = self._difference - self._rows[:, at] @ self._solved(at)
        sums = np.array([part.sum() for part in np.array_split(left, min(SLOW, len(left)))])
        lasting = float(np.median(sums**2)) / CHI_SQUARE_MEDIAN * len(sums) / len(left)
        self.slow = max(lasting, float(np.mean(left**2)), 1e-300)
        size = np.maximum(np.abs(OWN_SD * own_sizes), 1e-300)
        self._weight[self._own] = self.slow / size**2

    def _at(self, choices: Sequence[Choice]) -> Index:
        return np.concatenate([self._own, *(self._places[c.key] for c in choices)]).astype(np.intp)

    def fitted(self, choices: Sequence[Choice]) -> tuple[list[Array], list[Array]]:
        """Return each choice's coefficients (p,), and their covariance (p, p) where noise of a
        plain row is 1.
        """
        at = self._at(choices)
        inverse = self._inverse(at)
        values = inverse @ self._folds.whole[at, 0]
        places = np.split(np.arange(len(at)), np.cumsum([len(self._own), *(
            len(self._places[c.key]) for c in choices)])[:-1])[1:]
        return [values[p] for p in places], [inverse[np.ix_(p, p)] for p in places]

    def _solved(self, at: Index) -> Array:
        return np.asarray(self._inverse(at) @ self._folds.whole[at, 0])

    def _inverse(self, at: Index, *, weight: float = 1.0) -> Array:
        inner = self._folds.whole[np.ix_(at, at)] + weight * np.diag(self._weight[at])
        norm = np.sqrt(np.maximum(np.diag(inner), 1e-300))
        scale = np.outer(norm, norm)
        return np.asarray(np.linalg.pinv(inner / scale, rcond=HELD, hermitian=True) / scale)

    def squares(self, choices: Sequence[Choice], *, like: Candidate | None = None) -> Array:
        """Return the sum of squares of each fold, predicted by a fit to the others, (BLOCKS,).

        A fold is a contiguous block; where one is to be ``like`` an effect that is confined to a
        stretch, it is many small ones, so that each fold holds a part of the stretch.
        """
        at = self._at(choices)
        return self._folds_like(like).by_fold(at, self._weight[at])

    def _folds_like(self, like: Candidate | None) -> Folds:
        if like is None or like.interval is None:
            return self._folds
        column = self._rows[:, self._places[like.key, 0][0]]
        inside = int(np.count_nonzero(np.abs(column) > HALF * np.abs(column).max()))
        parts = min(max(DEALT, len(column) // max(inside, 1)), len(column) // BLOCKS)
        if parts not in self._dealt:
            self._dealt[parts] = Folds(self._rows, 0, blocks=parts * BLOCKS, folds=BLOCKS)
        return self._dealt[parts]

    def contribution(self, choices: Sequence[Choice], number: int) -> Array:
        """Return what one of the choices adds beside the others, (m,)."""
        coefficients = self.coefficients(choices)[number]
        return np.asarray(self._rows[:, self._places[choices[number].key]] @ coefficients)

    def coefficients(self, choices: Sequence[Choice]) -> list[Array]:
        """Return each choice's coefficients, fitted on all rows."""
        return self.fitted(choices)[0]

    def physical(self, choices: Sequence[Choice]) -> bool:
        """Whether each choice has what it needs and a sign that it may have, and none is larger
        than all that was measured."""
        terms = self._terms | {c.candidate.term for c in choices}
        for choice, values in zip(choices, self.coefficients(choices), strict=True):
            if choice.candidate.needs and not choice.candidate.needs & terms:
                return False
            allowed = choice.shape.allowed
            if allowed is not None and not allowed(values):
                return False
            if np.min(np.abs(values) * self._peak[self._places[choice.key]]) > BEYOND * self.range:
                return False
        return self.own_share(choices) > ALONE

    def own_share(self, choices: Sequence[Choice]) -> float:
        """Return the least share of a column of the last choice that the others cannot give."""
        at = self._at(choices)
        last = np.arange(len(at) - len(self._places[choices[-1].key]), len(at))
        inner = self._folds.whole[np.ix_(at, at)]
        inverse = self._inverse(at, weight=0.0)
        spread = np.diag(inverse)[last] * np.diag(inner)[last]
        return float(1.0 / spread.max()) if np.all(spread > HALF) else 0.0

    def richness(self, choice: Choice) -> float:
        """Return the share by which the held-out rms must fall for a choice's further columns."""
        return NEEDED * (len(self._places[choice.key]) - 1)

    def with_one_more(
        self, choices: Sequence[Choice], candidate: Candidate, *, like: Candidate | None = None
    ) -> tuple[Array, Choice] | None:
        """Return the squares by fold with a candidate in its best form, and the choice.

        ``like``: the candidate that folds are chosen for, None: this one.
        """
        best: tuple[Array, Choice] | None = None
        for number in range(len(candidate.forms)):
            choice = Choice(candidate, number)
            if choice.key not in self._places:
                continue
            squares = self.squares([*choices, choice], like=like or candidate)
            if best is not None and squares.sum() >= best[0].sum():
                continue
            if self.physical([*choices, choice]):
                best = squares, choice
        return best


def beside(choices: Sequence[Choice], candidate: Candidate) -> list[Choice]:
    """Return the choices that a candidate may stand beside."""
    return [c for c in choices if c.candidate.term not in candidate.excludes]


def rms_fall(before: Array, after: Array) -> float:
    """Return the share by which the rms over all blocks falls."""
    return 1.0 - float(np.sqrt(after.sum() / max(before.sum(), 1e-300)))


def grown(
    rows: PlainRows,
    choices: Sequence[Choice],
    among: Sequence[Candidate],
    *,
    most: int = MOST,
) -> list[Choice]:
    """Return the choices with every further law that is clearly needed, the largest first.

    ``most``: of further laws.
    """
    found = list(choices)
    for _ in range(min(most, MOST - len(found))):
        taken = {c.candidate.key for c in found}
        offers = [_offered(rows, found, c) for c in among if c.key not in taken]
        able = [(fall - rows.richness(best), best) for fall, best in offers if fall >= GAIN and best]
        if not able:
            break
        _, best = max(able, key=lambda offer: offer[0])
        found = [*beside(found, best.candidate), best]
    return pruned(rows, found)


def _offered(
    rows: PlainRows, found: Sequence[Choice], candidate: Candidate
) -> tuple[float, Choice | None]:
    """Return by what share the held-out rms falls with a candidate, and it in its best form.

    Nothing where it falls in too few folds, or by no more than slow noise would let it by chance.
    """
    offer = rows.with_one_more(beside(found, candidate), candidate)
    if offer is None:
        return 0.0, None
    before = rows.squares(found, like=candidate)
    chance = MARGIN + 2.0 * float(np.log(offer[1].shape.tries))
    told = float(before.sum() - offer[0].sum()) > chance * rows.slow
    if not told or int(np.sum(offer[0] < before)) < IN_BLOCKS:
        return 0.0, None
    return rms_fall(before, offer[0]), offer[1]


def pruned(rows: PlainRows, choices: Sequence[Choice]) -> list[Choice]:
    """Return the choices without those that the others do as well without."""
    found = list(choices)
    while len(found) > 1:
        loss = [_loss(rows, found, gone) for gone in found]
        least = int(np.argmin(loss))
        if loss[least] >= NEEDED:
            break
        del found[least]
    return found


def _loss(rows: PlainRows, found: Sequence[Choice], gone: Choice) -> float:
    """Return by what share the held-out rms rises without one of the choices."""
    others = [c for c in found if c is not gone]
    like = gone.candidate
    return -rms_fall(rows.squares(found, like=like), rows.squares(others, like=like))


@dataclass(frozen=True)
class FoundedLaw:
    """A law that plain rows need: its columns (n, p) at every row, their coefficients (p,) and
    covariance (p, p).
    """

    choice: Choice
    columns: Array
    coefficients: Array
    covariance: Array

    @property
    def effect(self) -> Array:
        """What it adds, (n,)."""
        return np.asarray(self.columns @ self.coefficients)


def fitted_laws(
    bench: WhiteRows, choices: Sequence[Choice], variance: float
) -> tuple[FoundedLaw, ...]:
    """Return laws fitted beside each other and own terms on plain rows of a variance."""
    rows = PlainRows(bench, [c.candidate for c in choices], choices)
    return tuple(
        FoundedLaw(choice, bench.built(choice.shape), values, variance * covariance / rows.mean_of)
        for choice, values, covariance in zip(choices, *rows.fitted(choices), strict=True)
    )


class Proposals(Protocol):
    """Where candidates come from that stand beside static laws."""

    def beside(self, retuned: Array, parts: list[tuple[str, Array]]) -> list[Candidate]:
        """Return those that act on other effects, built anew beside what has been found."""

    def scanned(self, left: Array, whitener: Whitener, number: int) -> list[Candidate]:
        """Return those that what is left (m,) at the working rate points to."""


def founded(
    bench: WhiteRows, standing: Sequence[Candidate], field: Proposals
) -> tuple[Choice, ...]:
    """Return the named laws that plain rows clearly need: static ones, then any."""
    named = [c for c in standing if c.named]
    static = [c for c in named if c.static]
    found = _first(bench, named, static)
    for number in range(ROUNDS):
        left = bench.left(bench.chosen([*_laws(static, found), *found]))
        retuned, parts = bench.parts(found, PLAIN)
        acting = field.beside(retuned, [(c.candidate.term, p) for c, p in zip(found, parts)])
        looked = [c for c in field.scanned(left, PLAIN, FIRST_SCAN + number) if c.named]
        moved = {c.key: c for c in (*named, *(c for c in acting if c.named), *looked)}
        bench.forget(c.key for c in acting)
        moved |= {c.candidate.key: c.candidate for c in found}
        rows = PlainRows(bench, moved.values())
        before = {c.candidate.key for c in found}
        found = completed(rows, found)
        if {c.candidate.key for c in found} == before:
            break
        found = [
            one if one.candidate.key in before else _tuned(bench, found, one) for one in found
        ]
    return tuple(_surer_than_curves(bench, found, [c for c in standing if not c.named]))


def _surer_than_curves(
    bench: WhiteRows, found: Sequence[Choice], curves: Sequence[Candidate]
) -> list[Choice]:
    """Return the laws, less what is not static and does no better than a curve in its place."""
    kept = list(found)
    if all(choice.candidate.static for choice in kept):
        return kept
    rows = PlainRows(bench, [*curves, *(c.candidate for c in kept)], kept)
    for choice in [c for c in kept if not c.candidate.static]:
        others, like = [c for c in kept if c is not choice], choice.candidate
        offers = [rows.with_one_more(others, curve, like=like) for curve in curves]
        best = min((float(o[0].sum()) for o in offers if o), default=np.inf)
        if best < float(rows.squares(kept, like=like).sum()):
            kept = others
    return kept


def _first(
    bench: WhiteRows, named: Sequence[Candidate], static: Sequence[Candidate]
) -> list[Choice]:
    """Return the static laws, beside what changes all that is recorded where that alone predicts
    better than all of them: they are then seen through it.
    """
    found = grown(PlainRows(bench, static), [], static)
    acting = [c for c in named if c.first]
    rows = PlainRows(bench, [*static, *acting])
    offers = [_offered(rows, [], c) for c in acting]
    _, best = max(offers, key=lambda offer: offer[0], default=(0.0, None))
    if best is None or rms_fall(rows.squares(found), rows.squares([best])) < BETTER:
        return found
    best = _tuned(bench, [], best)
    bench.look_through([best])
    rows = PlainRows(bench, [*static, best.candidate])
    return grown(rows, [best], static)


def _tuned(bench: WhiteRows, found: Sequence[Choice], choice: Choice) -> Choice:
    """Return a choice with the values of its form at their best on plain rows, as its only form."""
    beside = BesideShapes(bench, [c for c in found if c is not choice], (PLAIN, 1.0))
    best = tuned(choice, beside).choice
    bench.forget([choice.candidate.key])
    return Choice(replace(choice.candidate, forms=(best.shape,)), 0)


def _laws(static: Sequence[Candidate], found: Sequence[Choice]) -> list[Choice]:
    """Return the static laws in their first form but for those found."""
    taken = {c.candidate.key for c in found}
    return [
        Choice(c, 0) for c in static if c.key not in taken and c.forms and c.forms[0].names
    ]


def completed(rows: PlainRows, found: Sequence[Choice]) -> list[Choice]:
    """Return the choices with one more law of any kind, then static ones anew."""
    static = [c for c in rows.candidates if c.static]
    others = [c for c in rows.candidates if not c.static]
    return grown(rows, grown(rows, found, others, most=1), static)
