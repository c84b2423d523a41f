"""How a law stands by the error of plain rows left out, beside each that might be in its place."""

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtr

from autodb.explain.engine.candidates import Candidate, Choice
from autodb.explain.engine.plain.rows import (
    ALONE,
    BLOCKS,
    DISCREPANCY,
    NEEDED,
    PlainRows,
    beside,
    rms_fall,
)
from autodb.explain.engine.standing import NEAR, TEMPER, Standing, standing

Array = NDArray[np.float64]

RARE = 2.0 * TEMPER * float(np.log(10.0))
"""Evidence by which what soaks up any misfit, or holds the law and more, is a rarer rival of a
static law. Chosen: odds of ten."""
UNSURE = 0.89
"""More is not claimed of an effect without which plain rows are predicted about as well."""


def of_plain(
    rows: PlainRows, choices: Sequence[Choice], choice: Choice, *, but: Collection[str] = ()
) -> Standing:
    """Return how the name of one of the choices stands by the error on plain rows left out.

    Each rival, and nothing, is fitted in its place; the odds are those that the mean of the
    differences over blocks has the other sign, by Student's t. A static law is compared with named
    laws alone: a curve follows what real laws get wrong. What acts on others, or was searched for,
    soaks that up too: it is a rarer rival of a static law, which is judged among its like, and has
    to do better than curves itself.
    The best of more forms does well by chance so many times more often. What acts on an effect, and
    was built on it, is none of its rivals: it holds it.
    A rival that explains something else, or nothing, is none: without it the odds are better, but
    no name is surer than UNSURE that does not stand beside them all. Between two laws of one
    column, or that differ by no more than real effects leave a law by, nothing decides but which
    is more usual.
    """
    like = choice.candidate
    if like.static:
        choices = [c for c in choices if c.candidate.static or c.candidate.first]
    whole = rows.squares(choices, like=like)
    others = [c for c in choices if c.key != choice.key]
    taken = {c.candidate.key for c in choices}
    none = rows.squares(others, like=like)
    by_name: dict[str, float] = {}
    like_it: dict[str, float] = {}
    instead: dict[str, Choice] = {}
    as_good: set[str] = set()
    for candidate in rows.candidates:
        curve = choice.candidate.static and not candidate.named
        same = candidate.term in (choice.candidate.term, *but)
        of_it = choice.candidate.key in rows.acts_on.get(candidate.key, ())
        if candidate.key in taken or same or curve or of_it:
            continue
        offer = rows.with_one_more(beside(others, candidate), candidate, like=like)
        if offer is None:
            continue
        alike = like.static and rows.own_share([*others, offer[1], choice]) <= ALONE
        richer = max(0.0, rows.richness(offer[1]) - rows.richness(choice))
        fall = _ahead(choice, offer, none, whole, richer=richer, alike=alike)
        if richer > 0.0 and candidate.named and float(offer[0].sum()) <= float(whole.sum()):
            as_good.add(candidate.term)
        if fall < by_name.get(candidate.term, np.inf):
            by_name[candidate.term], instead[candidate.term] = fall, offer[1]
        does = rms_fall(none, offer[0]) >= NEEDED
        if does and not rows.has_its_own(others, choice, offer[1]):
            like_it[candidate.term] = min(fall, like_it.get(candidate.term, np.inf))
    nothing = _fall(none - whole, ranks=like.static)
    found, alone = standing(by_name, nothing=nothing), standing(like_it, nothing=nothing)
    sure = max(found.confidence, min(alone.confidence, UNSURE))
    return replace(
        found, confidence=sure, near=alone.near, instead=instead, as_good=frozenset(as_good)
    )


def _ahead(
    choice: Choice,
    rival: tuple[Array, Choice],
    none: Array,
    whole: Array,
    *,
    richer: float,
    alike: bool,
) -> float:
    """Return by how much evidence a law is ahead of a rival in its place.

    ``rival``: with its squares (BLOCKS,), as ``none`` with neither and ``whole`` with the law;
    ``richer``: by what its columns are asked for more; ``alike``: one gives the other's column.
    """
    like, candidate = choice.candidate, rival[1].candidate
    off = 0.0 if candidate.named else DISCREPANCY * np.maximum(none - whole, 0.0)
    fall = _fall(rival[0] * (1.0 + richer) ** 2 + off - whole, ranks=like.static)
    more = rival[1].shape.tries / choice.shape.tries
    fall += 2.0 * TEMPER * max(0.0, float(np.log(more)))
    as_well = alike or _as_well(none, whole, rival[0], like, candidate)
    if as_well and candidate.static and not (richer and alike):
        fall = max(fall, 0.0) + 2.0 * TEMPER * float(np.log(like.usual / candidate.usual))
    if like.static and ((richer > 0.0 and alike) or not candidate.static):
        fall = max(fall, 0.0) + RARE
    return fall


def _as_well(none: Array, whole: Array, its: Array, like: Candidate, candidate: Candidate) -> bool:
    """Whether of two laws one of which more machines have the squares differ by no more than real
    effects leave a law by.
    """
    explained = max(float(none.sum() - min(whole.sum(), its.sum())), 0.0)
    near = abs(float(its.sum() - whole.sum())) <= DISCREPANCY * explained
    return like.static and like.usual != candidate.usual and near


def _fall(differences: Array, *, ranks: bool) -> float:
    """Return the evidence that differences of squares (BLOCKS,) are above none in the middle.

    By Student's t; with ``ranks`` also by signed ranks (Wilcoxon 1945), whichever is surer: one
    block in which a rival is far off says nothing for it.
    """
    sd = float(np.std(differences, ddof=1)) / np.sqrt(len(differences))
    ahead = float(np.mean(differences)) / max(sd, 1e-300)
    freedom = len(differences) - 1
    with np.errstate(divide="ignore"):
        by_mean = float(np.log(stdtr(freedom, ahead)) - np.log(stdtr(freedom, -ahead)))
    if not ranks:
        return 2.0 * TEMPER * by_mean
    order = np.argsort(np.argsort(np.abs(differences))) + 1
    total = int(order[differences > 0].sum())
    at_least = SIGNED_RANKS[total:].sum()
    by_rank = float(np.log((1.0 - at_least + SIGNED_RANKS[total]) / at_least))
    return 2.0 * TEMPER * max(by_mean, by_rank)


def _signed_ranks(count: int) -> Array:
    """Return the probability of each sum of the ranks of positive signs, of so many at random."""
    chances = np.ones(1)
    for rank in range(1, count + 1):
        longer = np.zeros(len(chances) + rank)
        longer[: len(chances)] += 0.5 * chances
        longer[rank:] += 0.5 * chances
        chances = longer
    return chances


SIGNED_RANKS = _signed_ranks(BLOCKS)


def beside_plain(
    white: Standing, rows: PlainRows, laws: Sequence[Choice], choice: Choice
) -> Standing:
    """Return how an effect that white rows hold beside some laws stands where plain rows have a
    say, too.
    """
    choices = [*laws, choice]
    like = choice.candidate
    if rms_fall(rows.squares(laws, like=like), rows.squares(choices, like=like)) < NEEDED:
        return replace(white, confidence=min(white.confidence, UNSURE))
    plain = of_plain(rows, choices, choice)
    return replace(white, confidence=min(white.confidence, plain.confidence))


def of_both(plain: Standing, white: Standing, *, many: bool) -> Standing:
    """Return how a law stands whose rivals have to do as well by plain rows and by evidence.

    Where one of more columns predicts rows left out as well, all that it is behind by there is what
    these are asked for: evidence asks for that itself, and of ``many`` rows says how it stands.
    """
    as_good = plain.as_good if many else frozenset()
    falls = {
        name: white.by_name.get(name, fall)
        if name in as_good
        else max(fall, white.by_name.get(name, fall))
        for name, fall in plain.by_name.items()
    }
    found = standing(falls, nothing=plain.nothing)
    sure, near = max(plain.confidence, found.confidence), plain.near
    if as_good:
        sure, near = found.confidence, found.near
    return replace(
        plain,
        confidence=sure,
        near=tuple(name for name in near if falls[name] < NEAR),
        by_name=falls,
        rivalled=white.confidence <= UNSURE,
    )
