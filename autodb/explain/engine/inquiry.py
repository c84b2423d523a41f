"""The inquiry into one channel: noise, candidates, scans of what is left, and the set that stands.

The noise comes first from a model that holds every candidate at once, so that nothing that is
missing is taken for noise; then from what the accepted set leaves, so that nothing that is noise is
taken for missing. A set is accepted when it stands before both, and predicts stretches left out.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce
from operator import add
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.bench import WhiteRows
from autodb.explain.engine.cancelling import most_cancelled
from autodb.explain.engine.candidates import Candidate, Choice
from autodb.explain.engine.fit import BLOCKS, FOLDS, fold_of_block
from autodb.explain.engine.noise import Noise, Whitener
from autodb.explain.engine.normal import normal
from autodb.explain.engine.plain.founded import FoundedLaw, fitted_laws, founded
from autodb.explain.engine.plain.rows import BEYOND, PlainRows, range_of
from autodb.explain.engine.prior import coefficient_costs
from autodb.explain.engine.search import DETAIL, MARGIN, CandidateSearch, FoundSet
from autodb.explain.engine.tuning import BesideShapes, tuned
from autodb.explain.engine.weighing import unweighed

Array = NDArray[np.float64]

ROUNDS = 5
HARM = 1.02
PLAINLY = 0.7
"""Share of the squares on plain rows left out, below which an effect is no noise. Chosen."""


class CandidateSource(Protocol):
    """Where candidates come from."""

    def standing(self) -> list[Candidate]:
        """Return those that every inquiry begins with."""

    def beside(self, retuned: Array, parts: list[tuple[str, Array]]) -> list[Candidate]:
        """Return those that act on other effects, built anew beside what has been found.

        ``retuned`` (n,): the change of the simulation's own terms; ``parts``: term and (n,) each.
        """

    def scanned(self, columns: Array, whitener: Whitener, number: int) -> list[Candidate]:
        """Return those that what columns (m, p) leave at the working rate points to."""

    def completed(self, bench: WhiteRows, retuned: Array, parts: list[tuple[str, Array]]) -> Self:
        """Return those of a simulation that holds what was found too."""


@dataclass(frozen=True)
class Inquiry:
    """What an inquiry found: the set, the search that holds its rivals, and the noise.

    ``bench``: the rows that the set was searched for in; ``laws``: those that plain rows need,
    which are own columns there; ``rows``: plain rows of all that was tried.
    """

    found: FoundSet
    search: CandidateSearch
    whitener: Whitener
    variance: float
    considered: dict[str, float]
    bench: WhiteRows
    laws: tuple[FoundedLaw, ...] = ()
    rows: PlainRows | None = None

    @property
    def founded(self) -> tuple[Choice, ...]:
        """The laws that plain rows need."""
        return tuple(law.choice for law in self.laws)

    @property
    def choices(self) -> tuple[Choice, ...]:
        """Everything found, the laws that plain rows need first."""
        return (*self.founded, *self.found.choices)

    @property
    def plain_noise(self) -> Noise:
        """The filter that leaves rows as they are, and the variance that slow noise gives a row."""
        whitener, variance = unweighed(self.noise)
        slow = 0.0 if self.rows is None else self.rows.slow * self.rows.mean_of
        return whitener, max(variance, slow)

    @property
    def noise(self) -> Noise:
        """The filter that makes the noise white, and the variance of a white row."""
        return self.whitener, self.variance


def inquire(bench: WhiteRows, field: CandidateSource) -> Inquiry:
    """Return what the bench's rows hold: laws that plain rows need, then what white rows show
    beside a simulation that is complete with them.
    """
    standing = field.standing()
    laws = founded(bench, standing, field)
    own, fitted = fitted_laws(bench, laws)
    whole = bench
    if laws:
        whole = bench.completed({law.choice.candidate.key: law.effect for law in fitted})
        terms = [(law.choice.candidate.term, law.effect) for law in fitted]
        field = field.completed(whole, bench.own_columns() @ own, terms)
    inquiry = inquire_beside(whole, field, LawsBefore(bench, laws))
    pool = {c.key: c for c in (*inquiry.search.candidates, *standing)}
    found = (*laws, *inquiry.found.choices)
    pool |= {c.candidate.key: c.candidate for c in found}
    on_laws = frozenset(c.candidate.key for c in laws)
    acting = [c.candidate for c in inquiry.found.choices if c.candidate.acts]
    rows = PlainRows(bench, pool.values(), found, dict.fromkeys((a.key for a in acting), on_laws))
    inquiry = replace(inquiry, rows=rows)
    variance = inquiry.plain_noise[1]
    sized = (replace(law, covariance=variance * law.covariance) for law in fitted)
    return replace(inquiry, laws=tuple(sized))


@dataclass(frozen=True)
class LawsBefore:
    """The laws that were found before, and the rows that they were found in."""

    bench: WhiteRows
    laws: tuple[Choice, ...] = ()

    def details(self, bench: WhiteRows) -> dict[tuple[str, int], Array]:
        """Return what each law may get wrong in shape, (m, p)."""
        return {(c.candidate.key, DETAIL): bench.detail(c.candidate) for c in self.laws}

    def explained(self, bench: WhiteRows, noise: Noise) -> float:
        """Return by how much the laws let the white sum of squares fall, over the variance.

        Laws without a shape to get wrong count nothing.
        """
        if all(choice.candidate.exact for choice in self.laws):
            return 0.0
        whitener, variance = noise
        first, then = (whitener(one.reduced_difference) for one in (self.bench, bench))
        return max(0.0, float(first @ first - then @ then) / variance)


def inquire_beside(bench: WhiteRows, field: CandidateSource, before: LawsBefore) -> Inquiry:
    """Return the set of candidates that white rows hold beside the bench's own columns."""
    candidates = {s.key: s for s in field.standing()}
    whitener, variance = _saturated(bench, field, candidates)
    found = FoundSet()
    considered: dict[str, float] = {}
    accounts: list[tuple[Inquiry, tuple[Choice, ...]]] = []
    for number in range(ROUNDS):
        if found.choices:
            found = _renewed(bench, field, found, candidates, (whitener, variance))
        fitted = bench.chosen(found.choices)
        _take(bench, candidates, field.scanned(fitted, whitener, number))
        noise = whitener, variance
        blocks = bench.blocks(candidates.values()) | before.details(bench)
        search = CandidateSearch(
            bench.products(blocks, noise),
            candidates.values(),
            laws=[choice.candidate.key for choice in before.laws],
            explained=before.explained(bench, noise),
        )
        considered = considered or {o.choice.candidate.key: o.worth for o in search.offers(())}
        last, found = found, _predicting(bench, search, noise)
        account = Inquiry(found, search, whitener, variance, considered, bench)
        accounts.append((account, bench.through))
        if not found.choices or (number and found.keys == last.keys):
            accounts = accounts[-1:]
            break
        for key in [k for k, s in candidates.items() if s.scanned and k not in found.keys]:
            del candidates[key]
        whitener, variance = bench.noise(bench.chosen(found.choices, detail=True))
    seen_alike = [account for account, through in accounts if through == bench.through]
    standing = [
        replace(one, found=stands(bench, one.found, one.search, one.noise)) for one in seen_alike
    ]
    return min(standing, key=lambda one: _outlier_test(bench, one))


def _outlier_test(bench: WhiteRows, account: Inquiry) -> float:
    """Return N·ln of the innovations' variance that an account leaves, and its costs.

    It tells accounts apart that were reached with different noise, where rounds do not settle.
    """
    found, search = account.found, account.search
    cost = search.explained(found) - found.score
    left = bench.innovation(bench.chosen(found.choices))
    return search.products.rows * float(np.log(left)) + cost


def _saturated(bench: WhiteRows, field: CandidateSource, candidates: dict[str, Candidate]) -> Noise:
    """Return the noise that a model of everything leaves, of what scans point to as well.

    A ripple in time would else be taken for noise of its colour.
    """
    whitener = bench.whitener_of(bench.left(bench.everything(list(candidates.values()))))
    _take(bench, candidates, field.scanned(bench.chosen(()), whitener, 0))
    return bench.noise(bench.everything(list(candidates.values())))


def _take(bench: WhiteRows, candidates: dict[str, Candidate], new: Sequence[Candidate]) -> None:
    """Put candidates in the place of those of their keys."""
    bench.forget(s.key for s in new)
    candidates.update({s.key: s for s in new})


def _renewed(
    bench: WhiteRows,
    field: CandidateSource,
    found: FoundSet,
    candidates: dict[str, Candidate],
    noise: Noise,
) -> FoundSet:
    """Return the set with effects that change others built anew on what has been found.

    What clips, shifts or signs all that is recorded is tuned and then held: everything else is seen
    through it.
    """
    retuned, parts = bench.parts(found.choices, noise[0])
    terms = [c.candidate.known_as for c in found.choices]
    held = [_held(bench, found, c, noise) for c in found.choices if c.shape.through is not None]
    _take(bench, candidates, field.beside(retuned, list(zip(terms, parts, strict=True))))
    if held or bench.through:
        bench.look_through(held)
    _take(bench, candidates, [choice.candidate for choice in held])
    at = {choice.candidate.key: choice for choice in held}
    choices = (
        at.get(c.candidate.key, Choice(candidates[c.candidate.key], c.form)) for c in found.choices
    )
    return replace(found, choices=tuple(choices))


def _held(bench: WhiteRows, found: FoundSet, choice: Choice, noise: Noise) -> Choice:
    """Return a choice tuned beside the others, of a candidate that has this one shape only."""
    beside = BesideShapes(bench, found.without(choice.candidate.key), noise)
    return Choice(replace(choice.candidate, forms=(tuned(choice, beside).choice.shape,)), 0)


def stands(bench: WhiteRows, found: FoundSet, search: CandidateSearch, noise: Noise) -> FoundSet:
    """Return the set without effects that noise of another colour would explain as well.

    For each effect the noise is fitted anew without it: N·ln of the ratio of the innovations'
    variances is twice the gain of the log-likelihood, noise and coefficients both at their best.
    No noise explains what plain rows left out show (``PLAINLY``).
    """
    while found.choices:
        plain = held_out_sums(bench, found.choices, noise)[1]
        worth = [
            np.inf
            if plain < PLAINLY * held_out_sums(bench, found.without(c.candidate.key), noise)[1]
            else _beside_noise(bench, found, c, search)
            for c in found.choices
        ]
        weakest = int(np.argmin(worth))
        if worth[weakest] > MARGIN:
            return found
        found = search.settled(found.without(found.choices[weakest].candidate.key))
    return found


def _beside_noise(
    bench: WhiteRows, found: FoundSet, choice: Choice, search: CandidateSearch
) -> float:
    others = found.without(choice.candidate.key)
    with_it = bench.innovation(bench.chosen(found.choices))
    without = bench.innovation(bench.chosen(others))
    gain = search.products.given([c.key for c in others]).gain(choice.key)
    rows = search.products.rows
    return rows * float(np.log(without / with_it)) - gain.cost - search.penalty(choice)


def _predicting(bench: WhiteRows, search: CandidateSearch, noise: Noise) -> FoundSet:
    """Return the best set of which every effect helps to predict stretches left out of the fit, and
    is of its kind and not much larger than all that it may explain, and that own terms and the
    others do not cancel: such a one stands against another like it.

    A shape that fails is barred, and the search goes on with simpler ones.
    """
    most = BEYOND * range_of(bench.reduced_difference)
    while True:
        found = search.best()
        if not found.choices:
            return found
        unlike = bench.of_another_kind(found.choices, noise[0])
        if unlike is not None:
            for number in range(len(unlike.candidate.forms)):
                search.bar(Choice(unlike.candidate, number))
            continue
        sizes = _sizes(bench, found.choices, noise)
        largest = int(np.argmax(sizes))
        if sizes[largest] > most:
            search.bar(found.choices[largest])
            continue
        cancelled = _cancelled(bench, found.choices, noise)
        if cancelled is not None:
            search.bar(cancelled)
            continue
        whole = held_out_sums(bench, found.choices, noise)
        worth = [
            _helped(held_out_sums(bench, found.without(c.candidate.key), noise), whole)
            for c in found.choices
        ]
        weakest = int(np.argmin(worth))
        if worth[weakest] > 0:
            return found
        search.bar(found.choices[weakest])


def _sizes(bench: WhiteRows, choices: Sequence[Choice], noise: Noise) -> list[float]:
    """Return the most that each choice adds; of a family, which may hold own terms in other sizes,
    the most beyond these.
    """
    parts = bench.parts(choices, noise[0])[1]
    added = (
        part if choice.candidate.named else bench.beyond_own(part)
        for choice, part in zip(choices, parts, strict=True)
    )
    return [float(np.abs(part).max()) for part in added]


def _cancelled(bench: WhiteRows, choices: Sequence[Choice], noise: Noise) -> Choice | None:
    """Return the choice that own terms and the others cancel, if there is one."""
    number = most_cancelled(
        [bench.reduce(part)[:, 0] for part in bench.parts(choices, noise[0])[1]],
        bench.chosen(()),
        bench.reduced_difference,
        named=[choice.candidate.named for choice in choices],
    )
    return None if number is None else choices[number]


def _helped(without: tuple[float, float], whole: tuple[float, float]) -> float:
    """Return by what share white squares fall with an effect; negative where plain ones rise.

    White rows tell best whether an effect is there; plain ones whether its correction does harm,
    which slow noise lets it do by HARM without meaning anything.
    """
    if whole[1] > HARM * without[1]:
        return 1.0 - whole[1] / without[1]
    return 1.0 - whole[0] / without[0]


def held_out_sums(bench: WhiteRows, choices: Sequence[Choice], noise: Noise) -> tuple[float, float]:
    """Return sums of white and of plain squares on blocks, each predicted by a fit of the others.

    A coefficient of a named effect, or of a loose column, that the others do not hold is drawn to
    none, as far as its size in all blocks allows: a block that alone shows an effect says nothing
    against it. A family without a name is drawn to none as in the final fit.
    """
    whitener = noise[0]
    columns, difference = bench.chosen(choices), bench.reduced_difference
    white, target = whitener(columns), whitener(difference)
    block = fold_of_block(BLOCKS, FOLDS)[np.arange(len(target)) * BLOCKS // len(target)]
    folds = [normal(white[block == fold], target[block == fold]) for fold in range(FOLDS)]
    size = reduce(add, folds).solved()
    weight = float(np.var(target - white @ size)) / np.maximum(size**2, 1e-300)
    widths = [bench.columns(c.key, c.shape).shape[1] for c in choices]
    named = np.repeat([c.candidate.named for c in choices], widths).astype(bool)
    weight[: bench.firm] = 0.0
    family = ~np.concatenate([np.ones(len(bench.own), dtype=bool), named])
    if family.any():
        weight[family] = coefficient_costs(bench, choices, noise)[family]
    order = len(difference) - len(target)
    squares = plain = 0.0
    for fold in range(FOLDS):
        test = block == fold
        others = reduce(add, (one for number, one in enumerate(folds) if number != fold))
        fitted = others.solved(weight)
        squares += float(np.sum((target[test] - white[test] @ fitted) ** 2))
        plain += float(np.sum((difference[order:][test] - columns[order:][test] @ fitted) ** 2))
    return squares, plain
