"""Named laws that plain rows need, whatever the colour of the noise.

A real mismatch is smooth: an autoregression predicts it one step ahead, so that white rows may
hold nothing of a load or a mass that anybody sees. And real laws are approximate: where noise is
small, a curve that bends with their errors is likelier than they are. The error on blocks left out
of the fit knows neither trap: a law that is missing lowers it in most blocks, by much. So the laws
are taken one by one that lower it most, static ones first; what acts on others (a lag, a gain) and
what must be searched for (a period, a stretch) may enter where no static law does, and a law that
the others make needless goes again.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.bench import WhiteRows
from autodb.explain.engine.candidates import Candidate, Choice
from autodb.explain.engine.noise import PLAIN, Whitener
from autodb.explain.engine.plain import (
    ALONE,
    BLOCKS,
    DISCREPANCY,
    NEEDED,
    PlainRows,
    beside,
    rms_fall,
)
from autodb.explain.engine.search import MARGIN
from autodb.explain.engine.tuning import BesideShapes, tuned

Array = NDArray[np.float64]

GAIN = 0.04
"""Share by which the held-out rms must fall with a law: by chance, on recordings of real axes that
nothing was missing in, a column lowered it by 4.5 % at most."""
BESIDE_ITSELF = 3.0
"""Slow noise counts as so much more where what it might pass for was taken out of it: of what holds
nothing a search takes out the strongest. Chosen on synthetic recordings of noise alone."""
CLEAR = 2.0 * GAIN
"""Share that is clear, for a law with nothing to search for. Chosen."""
IN_BLOCKS = 6
"""Blocks of which each must be predicted better with it. Chosen."""
MOST = 5
"""Laws at most."""
ROUNDS, FIRST_SCAN = 4, 10
"""Rounds of searching what laws leave, and the number that the first of them goes by."""


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
        able = [(f, c) for f, c in offers if c and f >= GAIN + rows.asked_more(c)]
        longer = _with_next(rows, found, able)
        if longer is None:
            break
        found = longer
    return pruned(rows, found)


def _with_next(
    rows: PlainRows, found: Sequence[Choice], able: Sequence[tuple[float, Choice]]
) -> list[Choice] | None:
    """Return the choices with the offer that lowers the rms most for its columns, or what is more
    usual and says the same; none that would take the place of such a one.
    """
    for _, best in sorted(able, key=lambda offer: rows.richness(offer[1]) - offer[0]):
        others = beside(found, best.candidate)
        kept = {c.candidate.key for c in others}
        if _more_usual(rows, others, best, [c for c in found if c.candidate.key not in kept]):
            continue
        usual = _more_usual(rows, others, best, [c for _, c in able])
        return [*others, max(usual, key=lambda choice: choice.candidate.usual, default=best)]
    return None


def _more_usual(
    rows: PlainRows, others: Sequence[Choice], law: Choice, among: Sequence[Choice]
) -> list[Choice]:
    """Return those laws that more machines have than one, and that say the same beside others:
    its columns give theirs, or they do as well but for what real effects leave a law by.

    Where an axis moves one way only, friction by direction gives friction that grows with speed; a
    spring does as well as a weight that turns by less than half a turn.
    """
    usual = [
        choice
        for choice in among
        if choice.candidate.usual > law.candidate.usual
        and len(beside(others, choice.candidate)) == len(others)
    ]
    if not usual:
        return []
    none, whole = (float(rows.squares(c).sum()) for c in (others, [*others, law]))
    enough = whole + DISCREPANCY * (none - whole)
    return [
        choice
        for choice in usual
        if rows.own_share([*others, law, choice]) <= ALONE
        or float(rows.squares([*others, choice]).sum()) <= enough
    ]


def _offered(
    rows: PlainRows, found: Sequence[Choice], candidate: Candidate
) -> tuple[float, Choice | None]:
    """Return by what share the held-out rms falls with a candidate, and it in its best form.

    Nothing where it falls in too few folds, or by no more than slow noise would let it by chance:
    of that a real machine's other effects pass for much, so that a static law that lowers it
    clearly needs no more.
    """
    others = beside(found, candidate)
    offer = rows.with_one_more(others, candidate)
    if offer is None:
        return 0.0, None
    if len(others) < len(found):
        before, after = rows.squares(found, like=candidate), offer[0]
    else:
        before, after = rows.without_and_with(others, offer[1], like=candidate)
    chance = MARGIN + 2.0 * float(np.log(offer[1].shape.tries))
    slow = min(rows.slow, BESIDE_ITSELF * rows.slow_beside(offer[1]))
    told = float(before.sum() - after.sum()) > chance * slow
    fall = rms_fall(before, after)
    plain = candidate.static and fall >= CLEAR
    if not (told or plain) or not in_most_blocks(before, after):
        return 0.0, None
    return fall, offer[1]


def in_most_blocks(before: Array, after: Array) -> bool:
    """Whether squares (BLOCKS,) fall in most blocks, or clearly beside those in which they fall
    most: while an axis goes one way, own terms give what is missing, and the law can add nothing.
    """
    others = np.argsort(after - before)[BLOCKS - IN_BLOCKS :]
    falls = int(np.sum(after < before)) >= IN_BLOCKS
    return falls or rms_fall(before[others], after[others]) >= CLEAR


def pruned(rows: PlainRows, choices: Sequence[Choice]) -> list[Choice]:
    """Return the choices without those that the others do as well without, or that are beside these
    no more of their kind: a dip of friction that has become a rise.

    What acts on others holds what they add: beside it a static law stays.
    """
    found = _of_their_kind(rows, choices)
    while len(found) > 1:
        acted_on = any(c.candidate.acts for c in found)
        loss = [np.inf if c.candidate.static and acted_on else _loss(rows, found, c) for c in found]
        least = int(np.argmin(loss))
        if loss[least] >= NEEDED:
            break
        del found[least]
    return found


def _of_their_kind(rows: PlainRows, choices: Sequence[Choice]) -> list[Choice]:
    """Return the choices without those, the last first, that have coefficients of another kind."""
    found = list(choices)
    while not all(of_kind := rows.of_their_kind(found)):
        del found[len(found) - 1 - of_kind[::-1].index(False)]
    return found


def merged_laws(rows: PlainRows, choices: Sequence[Choice]) -> list[Choice]:
    """Return the choices with one law in the place of two wherever it does as well as both: a
    static one within NEEDED, one that soaks up any misfit if it does better.
    """
    found = list(choices)
    while len(found) > 1:
        like = confined_one(found)
        whole, taken = rows.squares(found, like=like), {c.candidate.key for c in found}
        best, instead = 0.0, found
        for pair in combinations(found, 2):
            others = [c for c in found if c not in pair]
            for candidate in rows.candidates:
                if candidate.key in taken or not _stands_in(candidate, others):
                    continue
                offer = rows.with_one_more(others, candidate, like=like)
                if offer is None or _more_usual(rows, others, offer[1], pair):
                    continue
                richer = rows.richness(offer[1]) - sum(map(rows.richness, pair))
                asked = max(richer, 0.0) - NEEDED * candidate.static
                fall = rms_fall(whole, offer[0]) - asked
                if fall > best:
                    best, instead = fall, [*others, offer[1]]
        if instead is found:
            break
        found = instead
    return found


def _stands_in(candidate: Candidate, others: Sequence[Choice]) -> bool:
    """Whether a candidate may take the place of laws beside others."""
    allowed = len(beside(others, candidate)) == len(others)
    return allowed and candidate.named and not candidate.first


def _loss(rows: PlainRows, found: Sequence[Choice], gone: Choice) -> float:
    """Return by what share the held-out rms rises without one of the choices."""
    others = [c for c in found if c is not gone]
    without, whole = rows.without_and_with(others, gone, like=gone.candidate)
    return -rms_fall(whole, without)


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
    bench: WhiteRows, choices: Sequence[Choice]
) -> tuple[Array, tuple[FoundedLaw, ...]]:
    """Return own terms' changes (k,), and laws fitted beside them on plain rows of variance 1."""
    rows = PlainRows(bench, [c.candidate for c in choices], choices)
    own, values, covariances = rows.fitted(choices)
    return own, tuple(
        FoundedLaw(choice, bench.built(choice.shape), coefficients, covariance / rows.mean_of)
        for choice, coefficients, covariance in zip(choices, values, covariances, strict=True)
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
    """Return the named laws that plain rows clearly need: static ones, then any.

    What clips, shifts or signs all that is recorded is among them, too: the bench's columns are
    then seen through it. Further laws stand beside what those found may get wrong in passing.
    """
    named = [c for c in standing if c.named]
    static = [c for c in named if c.static]
    found = _continued(bench, named, _first(bench, named, static), field)
    if len(found) > 1 and not bench.through:
        found = _better_account(
            bench, found, _continued(bench, named, _alone(bench, named, field), field)
        )
    found = _surer_than_curves(bench, found, [c for c in standing if not c.named])
    found = _of_their_kind(PlainRows(bench, [c.candidate for c in found], found), found)
    kept = [c for c in found if c.candidate.first]
    if bench.through and not kept:
        bench.look_through(kept)
    return tuple(found)


def _continued(
    bench: WhiteRows, named: Sequence[Candidate], found: Sequence[Choice], field: Proposals
) -> list[Choice]:
    """Return the laws with all further ones that plain rows clearly need beside them."""
    found = list(found)
    for number in range(ROUNDS):
        candidates = _anew(bench, named, found, field, number)
        rows = PlainRows(bench.loosened(found), candidates)
        before = {c.candidate.key for c in found}
        found = merged_laws(rows, completed(rows, found))
        if {c.candidate.key for c in found} == before:
            break
        found = [c if c.candidate.key in before else _tuned(bench, found, c) for c in found]
    return found


def _alone(bench: WhiteRows, named: Sequence[Candidate], field: Proposals) -> list[Choice]:
    """Return the law that predicts best alone, of any kind but those that come first anyway, and
    the other static laws where it is one, so that they are complete before further kinds join;
    none where none is needed.
    """
    candidates = [c for c in _anew(bench, named, [], field, ROUNDS) if not c.first]
    rows = PlainRows(bench, candidates)
    best = grown(rows, [], candidates, most=1)
    if all(c.candidate.static and not c.candidate.coarse for c in best):
        return grown(rows, best, [c for c in candidates if c.static])
    return [_tuned(bench, [], choice) for choice in best]


def _better_account(
    bench: WhiteRows, found: Sequence[Choice], rival: Sequence[Choice]
) -> list[Choice]:
    """Return the account that predicts better, each column counted as it is when a law joins.

    A part of the account that was found is none of its rivals.
    """
    if {c.candidate.key for c in rival} <= {c.candidate.key for c in found}:
        return list(found)
    like = confined_one([*found, *rival])
    confined = [] if like is None else [like]
    squares, prices = [], []
    for account in (found, rival):
        held = {c.key: c for c in (*confined, *(choice.candidate for choice in account))}
        rows = PlainRows(bench, held.values(), account)
        squares.append(rows.squares(account, like=like))
        prices.append(sum(NEEDED + rows.richness(choice) for choice in account))
    return list(rival if rms_fall(*squares) > prices[1] - prices[0] else found)


def confined_one(choices: Sequence[Choice]) -> Candidate | None:
    """Return the first candidate of some choices that is confined to a stretch, if one is."""
    return next((c.candidate for c in choices if c.candidate.interval is not None), None)


def _anew(
    bench: WhiteRows,
    named: Sequence[Candidate],
    found: Sequence[Choice],
    field: Proposals,
    number: int,
) -> list[Candidate]:
    """Return the named candidates, what acts on others beside what was found, and what scans of the
    residual of all static laws point to.

    Where nothing was found, own terms would take up what is missing: they act as simulated.
    """
    static = [c for c in named if c.static]
    left = bench.left(bench.chosen([*_laws(static, found), *found]))
    retuned, parts = bench.parts(found, PLAIN)
    if not found:
        retuned = np.zeros_like(retuned)
    terms = [c.candidate.term for c in found]
    acting = field.beside(retuned, list(zip(terms, parts, strict=True)))
    bench.forget(c.key for c in acting)
    looked = field.scanned(left, PLAIN, FIRST_SCAN + number)
    made = {c.key: c for c in (*named, *acting, *looked) if c.named}
    return list((made | {c.candidate.key: c.candidate for c in found}).values())


def _surer_than_curves(
    bench: WhiteRows, found: Sequence[Choice], curves: Sequence[Candidate]
) -> list[Choice]:
    """Return the laws, less what is not static and of which a curve in its place does more.

    A curve that does something else leaves a law its own.
    """
    kept = list(found)
    if all(choice.candidate.static for choice in kept):
        return kept
    rows = PlainRows(bench, [*curves, *(c.candidate for c in kept)], kept)
    for choice in [c for c in kept if not c.candidate.static]:
        others, like = [c for c in kept if c is not choice], choice.candidate
        offers = [rows.with_one_more(others, curve, like=like) for curve in curves]
        whole = float(rows.squares(kept, like=like).sum())
        better = [o[1] for o in offers if o and float(o[0].sum()) < whole]
        if not all(rows.has_its_own(others, choice, curve) for curve in better):
            kept = others
    return kept


def _first(
    bench: WhiteRows, named: Sequence[Candidate], static: Sequence[Candidate]
) -> list[Choice]:
    """Return the static laws, beside what changes all that is recorded where that alone predicts
    better than all of them: they are then seen through it. It has a mark of its own in what was
    recorded, which static laws would show by coincidence only.
    """
    found, laws = _static_laws(bench, static)
    acting = [c for c in named if c.first]
    rows = PlainRows(bench, [*laws, *acting])
    offers = [_offered(rows, [], c) for c in acting]
    _, best = max(offers, key=lambda offer: offer[0], default=(0.0, None))
    if best is None or rms_fall(rows.squares(found), rows.squares([best])) < 0.0:
        return found
    acts = _tuned(bench, [], best)
    bench.look_through([acts])
    return _static_laws(bench, static, [acts])[0]


def _static_laws(
    bench: WhiteRows, static: Sequence[Candidate], acting: Sequence[Choice] = ()
) -> tuple[list[Choice], list[Candidate]]:
    """Return the static laws found beside what acts on all, and all static candidates with these.

    From the first coarse law on, shapes are tuned anew before the next law is looked for: else that
    one makes up for what they get wrong.
    """
    found, laws = list(acting), {c.key: c for c in static}
    shaped: list[str] = []
    for _ in range(MOST):
        before, among = [c.candidate.key for c in found], list(laws.values())
        rows = PlainRows(bench, [*among, *(c.candidate for c in acting)])
        more = grown(rows, found, among, most=1 if shaped else MOST)
        with_shape = [c for c in more if c.candidate.coarse and c.shape.within]
        found = more if shaped or not with_shape else more[: more.index(with_shape[0]) + 1]
        if not with_shape or [c.candidate.key for c in found] == before:
            break
        for number, choice in enumerate(found):
            if choice in with_shape:
                found[number] = _tuned(bench, found, choice)
                shaped.append(choice.candidate.key)
                laws[shaped[-1]] = found[number].candidate
    kept = {c.candidate.key for c in found}
    bench.forget(key for key in shaped if key not in kept)
    return found, [laws[c.key] if c.key in kept else c for c in static]


def _tuned(bench: WhiteRows, found: Sequence[Choice], choice: Choice) -> Choice:
    """Return a choice with the values of its form at their best on plain rows, as its only form."""
    others = [c for c in found if c is not choice]
    best = tuned(choice, BesideShapes(bench, others, (PLAIN, 1.0))).choice
    bench.forget([choice.candidate.key])
    return Choice(replace(choice.candidate, forms=(best.shape,)), 0)


def _laws(static: Sequence[Candidate], found: Sequence[Choice]) -> list[Choice]:
    """Return the static laws in their first form but for those found."""
    taken = {c.candidate.key for c in found}
    return [Choice(c, 0) for c in static if c.key not in taken and c.forms and c.forms[0].names]


def completed(rows: PlainRows, found: Sequence[Choice]) -> list[Choice]:
    """Return the choices with one more law of any kind, then static ones anew."""
    static = [c for c in rows.candidates if c.static]
    others = [c for c in rows.candidates if not c.static]
    return grown(rows, grown(rows, found, others, most=1), static)
