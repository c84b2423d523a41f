"""Laws join one by one while they lower the error of rows left out, and go again where needless.

Each in its best form, in most blocks, by more than slow noise would; of two that say the same the
more usual one.
"""

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.candidates import Candidate, Choice
from autodb.explain.engine.plain.rows import (
    ALONE,
    BLOCKS,
    DISCREPANCY,
    FEWEST,
    NEEDED,
    PlainRows,
    beside,
    rms_fall,
)
from autodb.explain.engine.search import MARGIN, terms_of

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
"""Blocks, of BLOCKS, of which each must be predicted better with it. Chosen."""
MOST = 5
"""Laws at most."""


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
        offers = [_worth_it(rows, found, c) for c in among if c.key not in taken]
        longer = _with_next(rows, found, [offer for offer in offers if offer is not None])
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
        law = max(usual, key=lambda choice: choice.candidate.usual, default=best)
        return only_of_their_kind(rows, [*others, law])
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
    like = law.candidate
    none, whole = (float(rows.squares(c, like=like).sum()) for c in (others, [*others, law]))
    enough = whole + DISCREPANCY * (none - whole)
    return [
        choice
        for choice in usual
        if rows.own_share([*others, law, choice]) <= ALONE
        or float(rows.squares([*others, choice], like=like).sum()) <= enough
    ]


def _worth_it(
    rows: PlainRows, found: Sequence[Choice], candidate: Candidate
) -> tuple[float, Choice] | None:
    """Return by what share the held-out rms falls with a candidate, and it, where that is enough:
    in its best form, or in one that asks for less, as the drift of one sensor and not of all.
    """
    for frugal in (False, True):
        fall, choice = best_offer(rows, found, candidate, frugal=frugal)
        if choice is None:
            return None
        if fall >= GAIN + rows.asked_more(choice):
            return fall, choice
        if rows.asked_more(choice) == 0.0:
            return None
    return None


def best_offer(
    rows: PlainRows, found: Sequence[Choice], candidate: Candidate, *, frugal: bool = False
) -> tuple[float, Choice | None]:
    """Return by what share the held-out rms falls with a candidate, and it in its best form.

    Nothing where it falls in too few folds, or by no more than slow noise would let it by chance:
    of that a real machine's other effects pass for much, so that a static law that lowers it
    clearly needs no more.
    """
    others = beside(found, candidate)
    offer = rows.with_one_more(others, candidate, frugal=frugal)
    if offer is None:
        others = rows.of_their_kind_beside(others, candidate)
        again = len(others) < len(found)
        offer = rows.with_one_more(others, candidate, frugal=frugal) if again else None
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
    acting = rows.acts_in([*others, offer[1]], len(others), like=candidate)
    if not (told or plain) or not in_most_blocks(before, after, acting):
        return 0.0, None
    return fall, offer[1]


def in_most_blocks(before: Array, after: Array, acting: NDArray[np.bool_]) -> bool:
    """Whether squares (BLOCKS,) fall in most blocks, or clearly beside those in which they fall
    most: while an axis goes one way, own terms give what is missing, and the law can add nothing.

    ``acting``: blocks in which the law adds something; others count where these are too few.
    """
    if acting.sum() >= FEWEST:
        before, after = before[acting], after[acting]
    most = -(-IN_BLOCKS * len(before) // BLOCKS)
    others = np.argsort(after - before)[len(before) - most :]
    falls = int(np.sum(after < before)) >= most
    return falls or rms_fall(before[others], after[others]) >= CLEAR


def pruned(rows: PlainRows, choices: Sequence[Choice]) -> list[Choice]:
    """Return the choices without those that the others do as well without, or that are beside these
    no more of their kind: a dip of friction that has become a rise.

    What acts on others holds what they add, and a stretch is laid where they leave the most: beside
    these a static law stays, unless what acts does not hold it and it does nothing.
    """
    found = only_of_their_kind(rows, choices)
    while len(found) > 1:
        loss = [np.inf if _is_held(c, found) else _loss(rows, found, c) for c in found]
        if any(c.candidate.acts or c.candidate.interval is not None for c in found):
            loss = [
                np.inf if c.candidate.static and one > 0.0 else one
                for c, one in zip(found, loss, strict=True)
            ]
        least = int(np.argmin(loss))
        if loss[least] >= NEEDED:
            break
        del found[least]
    return found


def _is_held(law: Choice, found: Sequence[Choice]) -> bool:
    """Whether a static law is one of those that another scales."""
    return law.candidate.static and any(law.candidate.term in c.candidate.holds for c in found)


def only_of_their_kind(rows: PlainRows, choices: Sequence[Choice]) -> list[Choice]:
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
        like = confined_one(rows, found)
        whole, taken = rows.squares(found, like=like), {c.candidate.key for c in found}
        best, instead = 0.0, found
        for pair in combinations(found, 2):
            others = [c for c in found if c not in pair]
            for candidate in rows.candidates:
                if candidate.key in taken or not _stands_in(candidate, others, pair):
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


def _stands_in(candidate: Candidate, others: Sequence[Choice], pair: Sequence[Choice]) -> bool:
    """Whether a candidate may take the place of two laws beside others: what scales what others add
    holds these, and can do without none.
    """
    gone = terms_of(pair) - terms_of(others)
    if any(gone & one.holds for one in (candidate, *(c.candidate for c in others))):
        return False
    allowed = len(beside(others, candidate)) == len(others)
    return allowed and candidate.named and not candidate.first


def _loss(rows: PlainRows, found: Sequence[Choice], gone: Choice) -> float:
    """Return by what share the held-out rms rises without one of the choices."""
    others = [c for c in found if c.key != gone.key]
    without, whole = rows.without_and_with(others, gone, like=gone.candidate)
    return -rms_fall(whole, without)


def confined_one(rows: PlainRows, choices: Sequence[Choice]) -> Candidate | None:
    """Return the first candidate of some choices that is confined to a stretch, if one is."""
    return next((c.candidate for c in choices if rows.confined(c.candidate)), None)


def completed(rows: PlainRows, found: Sequence[Choice]) -> list[Choice]:
    """Return the choices with one more law of any kind, then static ones anew.

    What acts on others joins only where it does more than a static law that is itself too faint to
    be clearly needed: then white rows tell which of them it is.
    """
    static = [c for c in rows.candidates if c.static]
    others = [c for c in rows.candidates if not c.static]
    more = grown(rows, found, others, most=1)
    taken = {c.candidate.key for c in found}
    new = [c for c in more if c.candidate.key not in taken]
    if new and new[0].candidate.acts and _does_as_well(rows, found, new[0], static):
        more = list(found)
    return grown(rows, more, static)


def _does_as_well(
    rows: PlainRows, found: Sequence[Choice], law: Choice, static: Sequence[Candidate]
) -> bool:
    """Whether a static law does as well beside the choices as another law, within NEEDED."""
    like, taken = law.candidate, {c.candidate.key for c in found}
    whole = rows.squares([*beside(found, like), law], like=like)
    offers = (
        rows.with_one_more(beside(found, candidate), candidate, like=like)
        for candidate in static
        if candidate.key not in taken
    )
    return any(offer is not None and rms_fall(offer[0], whole) < NEEDED for offer in offers)
