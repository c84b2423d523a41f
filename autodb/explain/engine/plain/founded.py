"""Named laws that plain rows need, whatever the colour of the noise.

A real mismatch is smooth: an autoregression predicts it one step ahead, so that white rows may
hold nothing of a load or a mass that anybody sees. And real laws are approximate: where noise is
small, a curve that bends with their errors is likelier than they are. The error on blocks left out
of the fit knows neither trap: a law that is missing lowers it in most blocks, by much. So the laws
are taken one by one that lower it most, static ones first; what acts on others (a lag, a gain) and
what must be searched for (a period, a stretch) may enter where no static law does, and a law that
the others make needless goes again.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.bench import WhiteRows
from autodb.explain.engine.candidates import Candidate, CandidateForm, Choice
from autodb.explain.engine.noise import PLAIN, Whitener
from autodb.explain.engine.normal import solved, solved_together
from autodb.explain.engine.plain.growing import (
    MOST,
    best_offer,
    completed,
    confined_one,
    grown,
    merged_laws,
    only_of_their_kind,
)
from autodb.explain.engine.plain.rows import NEEDED, PlainRows, rms_fall
from autodb.explain.engine.search import MARGIN
from autodb.explain.engine.tuning import BesideShapes, tuned

Array = NDArray[np.float64]

ROUNDS, FIRST_SCAN = 4, 10
"""Rounds of searching what laws leave, and the number that the first of them goes by."""
TWIN = 0.25
"""Share of a static law's squares that a shift of all that is recorded must not be able to give;
where it gives more the law has what both give: machines with a mass are more than such that are
logged early. Chosen."""
FEW = 2
"""Laws of which a curve that does more is another candidate beside them. Chosen."""
WHOLE = 0.1
"""Share by which the size of a shift may differ from that of what it shifts. Chosen."""


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

    def scanned(self, columns: Array, whitener: Whitener, number: int) -> list[Candidate]:
        """Return those that what columns (m, p) leave at the working rate points to."""


def founded(
    bench: WhiteRows, standing: Sequence[Candidate], field: Proposals
) -> tuple[Choice, ...]:
    """Return the named laws that plain rows clearly need: static ones, then any.

    What clips, shifts or signs all that is recorded is among them, too: the bench's columns are
    then seen through it. Further laws stand beside what those found may get wrong in passing. An
    account that begins with what is best alone is compared less what curves do more than.
    """
    named = [c for c in standing if c.named]
    static = [c for c in named if c.static]
    found = _continued(bench, named, _first(bench, named, static), field)
    curves = [c for c in standing if not c.named]
    if len(found) > 1 and not bench.through:
        rival = _continued(bench, named, _alone(bench, named, field), field)
        found = _better_account(bench, found, _surer_than_curves(bench, rival, curves) or rival)
    found = _likelier(bench, named, found, field)
    found = _surer_than_curves(bench, found, curves)
    found = only_of_their_kind(PlainRows(bench, [c.candidate for c in found], found), found)
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
        anew = {c.key: c for c in candidates}
        found = [replace(c, candidate=anew[c.candidate.key]) for c in found]
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

    A part of the account that was found is none of its rivals, nor is one that holds a shift in
    place of a static law that gives most of the same.
    """
    keys, instead = {c.candidate.key for c in rival}, [c for c in found if c.candidate.static]
    instead = [c for c in instead if c.candidate.key not in keys]
    part = keys <= {c.candidate.key for c in found}
    if part or any(_is_shift(c.candidate) and _twins(bench, c, instead) for c in rival):
        return list(found)
    whole = (PlainRows(bench, [c.candidate for c in a], a) for a in (found, rival))
    both = zip(whole, (found, rival), strict=True)
    like = next(filter(None, (confined_one(rows, account) for rows, account in both)), None)
    confined = [] if like is None else [like]
    squares, prices = [], []
    for account in (found, rival):
        held = {c.key: c for c in (*confined, *(choice.candidate for choice in account))}
        rows = PlainRows(bench, held.values(), account)
        squares.append(rows.squares(account, like=like))
        prices.append(sum(NEEDED + rows.richness(choice) for choice in account))
    return list(rival if rms_fall(*squares) > prices[1] - prices[0] else found)


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
    columns = bench.chosen([*_laws(static, found), *found])
    retuned, parts = bench.parts(found, PLAIN)
    if not found:
        retuned = np.zeros_like(retuned)
    terms = [c.candidate.known_as for c in found]
    acting = field.beside(retuned, list(zip(terms, parts, strict=True)))
    bench.forget(c.key for c in acting)
    looked = field.scanned(columns, PLAIN, FIRST_SCAN + number)
    made = {c.key: c for c in (*named, *acting, *looked) if c.named}
    made |= {c.candidate.key: c.candidate for c in found}
    return [_beside_twins(bench, c, found) for c in made.values()]


def _beside_twins(bench: WhiteRows, candidate: Candidate, found: Sequence[Choice]) -> Candidate:
    """Return a candidate; what shifts all that is recorded less what static laws found give of it,
    where it gives most of these and is no whole shift.

    In motion of one frequency friction that comes early is a mass, and what else is not simulated
    makes it so: a shift that is one shifts everything by its whole size.
    """
    if not _is_shift(candidate):
        return candidate
    static = [c for c in found if c.candidate.static]
    forms = (_less_twins(bench, Choice(candidate, n), static) for n in range(len(candidate.forms)))
    return replace(candidate, forms=tuple(forms))


def _is_shift(candidate: Candidate) -> bool:
    """Whether a candidate shifts all that is recorded, and does so beside other laws."""
    return not candidate.first and any(form.through is not None for form in candidate.forms)


@dataclass(frozen=True)
class _LessTwins:
    """Columns of a law less what those of other laws give of them beside own terms."""

    law: Callable[..., Array]
    twins: tuple[Choice, ...]
    bench: WhiteRows

    def __call__(self, **shape: float) -> Array:
        whole = CandidateForm(self.law, shape=shape).build()
        own = self.bench.chosen(()).shape[1]
        beside = self.bench.chosen(self.twins)
        along = solved_together(beside, self.bench.reduce(whole))[own:]
        given = np.hstack([self.bench.built(choice.shape) for choice in self.twins])
        return np.asarray(whole - given @ along)


def _less_twins(bench: WhiteRows, shift: Choice, static: Sequence[Choice]) -> CandidateForm:
    form = shift.shape
    law = form.law.law if isinstance(form.law, _LessTwins) else form.law
    whole = replace(form, law=law)
    twins = _twins(bench, Choice(replace(shift.candidate, forms=(whole,)), 0), static)
    return replace(form, law=_LessTwins(law, twins, bench)) if twins else whole


def _twins(bench: WhiteRows, shift: Choice, static: Sequence[Choice]) -> tuple[Choice, ...]:
    """Return the static laws that a shift gives most of; none of one that is whole beside them."""
    own, built = bench.chosen(()), bench.columns(shift.key, shift.shape)
    both = np.hstack([own, built])
    twins = tuple(c for c in static if _left_of(bench, c, both) < TWIN * _left_of(bench, c, own))
    share = solved(np.hstack([bench.chosen(twins), built]), bench.reduced_difference)[-1]
    whole = shift.shape.through is not None and abs(share - 1.0) < WHOLE
    return () if whole else twins


def _left_of(bench: WhiteRows, choice: Choice, columns: Array) -> float:
    """Return the squares of a choice's columns that others (m, p) cannot give."""
    its = bench.columns(choice.key, choice.shape)
    return float(np.sum((its - columns @ solved_together(columns, its)) ** 2))


def _likelier(
    bench: WhiteRows, named: Sequence[Candidate], found: Sequence[Choice], field: Proposals
) -> list[Choice]:
    """Return the laws, each that acts on others, or what acts on these and plain rows do not tell
    from it, as white rows are likelier: friction that falls as it warms, or a gain that does.
    """
    kept = list(found)
    for number, choice in enumerate(found):
        like, others = choice.candidate, [c for c in kept if c is not kept[number]]
        if bench.through or not like.acts or choice.shape.through is not None:
            continue
        rivals = [
            c
            for c in _anew(bench, named, others, field, ROUNDS)
            if c.acts and not c.first and c.term != like.term and c.term in like.excludes
        ]
        rows = PlainRows(bench, [*rivals, *(c.candidate for c in kept)], kept)
        whole = rows.squares(kept, like=like)
        offers = [rows.with_one_more(others, c, like=like) for c in rivals]
        near = [o[1] for o in offers if o and rms_fall(whole, o[0]) > -NEEDED]
        tuned_near = [_tuned(bench, others, one) for one in near]
        gains = [_log_odds(bench, [*others, one], kept) for one in tuned_near]
        if max(gains, default=0.0) > MARGIN:
            kept[number] = tuned_near[int(np.argmax(gains))]
    return kept


def _log_odds(bench: WhiteRows, account: Sequence[Choice], rival: Sequence[Choice]) -> float:
    """Return twice the log of how much likelier white rows are with an account than with a rival,
    noise of any colour fitted to either.
    """
    left = [bench.innovation(bench.chosen(choices)) for choices in (account, rival)]
    return len(bench.reduced_difference) * float(np.log(left[1] / left[0]))


def _surer_than_curves(
    bench: WhiteRows, found: Sequence[Choice], curves: Sequence[Candidate]
) -> list[Choice]:
    """Return the laws, less what is not static and of which a curve in its place does more; none
    where one curve alone does more than all that are left: what has no name several make up.

    A curve that does something else leaves a law its own. Loads of a stretch of time do not count
    among several: no curve gives these.
    """
    kept = list(found)
    if all(choice.candidate.static for choice in kept):
        return kept
    rows = PlainRows(bench, [*curves, *(c.candidate for c in kept)], kept)
    for choice in [c for c in kept if not c.candidate.static]:
        others, like = [c for c in kept if c.key != choice.key], choice.candidate
        offers = [rows.with_one_more(others, curve, like=like) for curve in curves]
        whole = float(rows.squares(kept, like=like).sum())
        better = [o[1] for o in offers if o and float(o[0].sum()) < whole]
        if not all(rows.has_its_own(others, choice, curve) for curve in better):
            kept = others
    lasting = [c for c in kept if c.candidate.interval is None]
    return [] if len(lasting) > FEW and _does_more(rows, curves, kept) else kept


def _does_more(rows: PlainRows, curves: Sequence[Candidate], account: Sequence[Choice]) -> bool:
    """Return whether one of some curves alone predicts better than an account."""
    like = confined_one(rows, account)
    whole = float(rows.squares(account, like=like).sum())
    alone = (rows.with_one_more([], curve, like=like) for curve in curves)
    return any(offer is not None and float(offer[0].sum()) < whole for offer in alone)


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
    offers = [best_offer(rows, [], c) for c in acting]
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
    others = [c for c in found if c.key != choice.key]
    best = tuned(choice, BesideShapes(bench, others, (PLAIN, 1.0))).choice
    bench.forget([choice.candidate.key])
    return Choice(replace(choice.candidate, forms=(best.shape,)), 0)


def _laws(static: Sequence[Candidate], found: Sequence[Choice]) -> list[Choice]:
    """Return the static laws in their first form but for those found."""
    taken = {c.candidate.key for c in found}
    return [Choice(c, 0) for c in static if c.key not in taken and c.forms and c.forms[0].names]
