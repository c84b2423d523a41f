"""Which effects do white rows hold? Sets of candidates, compared by their evidence.

Effects overlap, so sets are grown side by side (a beam) and compared as wholes: the effect that
looks best alone need not be in the best pair. A set's score is what it explains less what its
freedom costs and less 2·ln of the shapes and candidates that were looked through.

Effects that stand in for others: swaps that make a set likelier, and terms that look alike.
"""

from collections.abc import Collection, Iterable, Sequence
from copy import copy
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.candidates import Candidate, Choice
from autodb.explain.engine.evidence import Given, Products
from autodb.terms.vocabulary import all_terms

Array = NDArray[np.float64]

MARGIN = 8.0
"""Evidence above which a candidate is taken: a factor e⁴ against the odds of all. Chosen."""
ALIKE_DIGITS = 5
"""Decimals of evidence by which effects are told apart: of columns that say the same, such as a
drift and a gain of a force that is constant, the first counts, however a processor rounds."""
BEAM = 5
CLEARED = 8
"""Sets that weak members are taken out of: the best set left is not always of the best grown."""
MOST = 4
"""Effects in one set at most."""
FAINT = 0.01
"""An effect that explains less than this share of what those of its set do that have a shape (a
constant has none) is put down to the shape of the others, which no ladder holds exactly. Chosen."""
SIMPLE_ENOUGH = 0.8
"""Names come before families when they explain this share of what a set with families does."""
DETAIL, MISTAKEN = -1, -2
"""Rung numbers under which a candidate's detail, and what it may be mistaken for, are kept."""


@dataclass(frozen=True)
class FoundSet:
    """A set of effects, its score, and the evidence of each beside the others."""

    choices: tuple[Choice, ...] = ()
    score: float = 0.0
    evidence: tuple[float, ...] = ()

    @property
    def keys(self) -> tuple[str, ...]:
        """The candidates' keys."""
        return tuple(choice.candidate.key for choice in self.choices)

    def without(self, key: str) -> tuple[Choice, ...]:
        """Return the choices but that of one candidate, and those whose columns hold its term."""
        others = tuple(c for c in self.choices if c.candidate.key != key)
        gone = terms_of(self.choices) - terms_of(others)
        return tuple(c for c in others if not gone & c.candidate.holds)


@dataclass(frozen=True)
class Offer:
    """A candidate in its best shape beside a set, and its evidence after all penalties."""

    choice: Choice
    worth: float


class CandidateSearch:
    """The candidates, and the products of their columns in every shape.

    ``faint``: share of what a set explains below which an effect of it is put down to the others;
    ``laws``: keys of what was found before, whose details are among the products, and
    ``explained`` by how much it let the sum of squares fall. ``begin``: effects that all sets grow
    from, and keep.
    """

    def __init__(
        self,
        products: Products,
        candidates: Iterable[Candidate],
        *,
        faint: float = FAINT,
        laws: Sequence[str] = (),
        explained: float = 0.0,
        begin: tuple[Choice, ...] = (),
    ) -> None:
        self.products = products
        self.laws = tuple(laws)
        self.explained_before = explained
        self.candidates = tuple(candidates)
        self.faint = faint
        self._barred: set[tuple[str, int]] = set()
        self._settled: dict[frozenset[str], FoundSet] = {}
        self._best: dict[tuple[Given, str], Offer | None] = {}
        self._singles = {s.key: self._of_one_column(s) for s in self.candidates}
        self._curves = {
            s.key: [i for i in range(len(s.forms)) if len(products.places[s.key, i]) != 1]
            for s in self.candidates
        }
        self.begin = self.scored(begin)

    def _of_one_column(
        self, candidate: Candidate
    ) -> tuple[list[Choice], NDArray[np.intp], NDArray[np.float64]]:
        """Return a candidate's shapes of one column, their places, and their penalties."""
        choices = [Choice(candidate, i) for i in range(len(candidate.forms))]
        choices = [c for c in choices if len(self.products.places[c.key]) == 1]
        places = [int(self.products.places[c.key][0]) for c in choices]
        penalties = np.array([self.penalty(c) for c in choices])
        return choices, np.array(places, dtype=np.intp), penalties

    def with_held(self, own: Sequence[int]) -> Self:
        """Return the search with some own columns left as they are, by their numbers."""
        held = copy(self)
        held.products = self.products.with_held(own)
        held._settled, held._best = {}, {}
        return held

    def bar(self, choice: Choice) -> None:
        """Offer a shape no more."""
        self._barred.add(choice.key)
        gone = choice.candidate.key
        self._settled = {keys: one for keys, one in self._settled.items() if gone not in keys}
        self._best = {at: offer for at, offer in self._best.items() if at[1] != gone}

    def best_shape(self, given: Given, candidate: Candidate) -> Offer | None:
        """Return a candidate in its shape with most evidence; None when none explains anything."""
        at = given, candidate.key
        if at not in self._best:
            self._best[at] = self._best_of_all(given, candidate)
        return self._best[at]

    def _best_of_all(self, given: Given, candidate: Candidate) -> Offer | None:
        best = self._best_single(given, candidate)
        given.work_out(self._of_curves(candidate))
        for key in self._of_curves(candidate):
            choice = Choice(candidate, key[1])
            gain = given.gain(choice.key, allowed=choice.shape.allowed)
            worth = gain.evidence - self.penalty(choice)
            if gain.full > 0 and (best is None or as_compared(worth) > as_compared(best.worth)):
                best = Offer(choice, worth)
        return best

    def _of_curves(self, candidate: Candidate) -> list[tuple[str, int]]:
        """Return the keys of the shapes of several columns that are offered."""
        keys = ((candidate.key, number) for number in self._curves[candidate.key])
        return [key for key in keys if key not in self._barred]

    def _best_single(self, given: Given, candidate: Candidate) -> Offer | None:
        """Return the best allowed of the shapes of one column, all worked out at once."""
        choices, places, penalties = self._singles[candidate.key]
        evidence, coefficients = given.single(places)
        worth = evidence - penalties
        for at in np.argsort(-np.round(worth, ALIKE_DIGITS), kind="stable"):
            choice, allowed = choices[at], choices[at].shape.allowed
            if choice.key in self._barred or coefficients[at] == 0.0:
                continue
            if allowed is None or allowed(coefficients[at : at + 1]):
                return Offer(choice, float(worth[at]))
        return None

    def offers(
        self, choices: tuple[Choice, ...], candidates: Sequence[Candidate] | None = None
    ) -> list[Offer]:
        """Return every candidate, or of some, that may join a set, each in its best shape."""
        given = self.products.given([c.key for c in choices])
        taken = {c.candidate.key for c in choices}
        barred = frozenset().union(*(c.candidate.excludes for c in choices)) if choices else set()
        open_ones = [
            s
            for s in candidates or self.candidates
            if s.key not in taken and s.term not in barred and s.holds <= terms_of(choices)
        ]
        anew = (s for s in open_ones if (given, s.key) not in self._best)
        given.work_out(key for candidate in anew for key in self._of_curves(candidate))
        found = (self.best_shape(given, candidate) for candidate in open_ones)
        return [offer for offer in found if offer is not None]

    def grown(self, found: FoundSet, candidates: Sequence[Candidate]) -> list[FoundSet]:
        """Return the sets with one more effect, worth it also where the others' shape is free."""
        free = self.with_detail(found.choices)
        sets = []
        for offer in self.offers(found.choices, candidates):
            if offer.worth < MARGIN:
                continue
            form = offer.choice.shape
            beside = free.gain(offer.choice.key, allowed=form.allowed).evidence
            first = not found.choices and not self.laws
            if beside - self.penalty(offer.choice) > MARGIN or first:
                sets.append((found.score + offer.worth, (*found.choices, offer.choice)))
        sets.sort(key=lambda scored: -as_compared(scored[0]))
        return [self.settled(choices) for _, choices in sets[: 2 * BEAM]]

    def with_detail(self, choices: tuple[Choice, ...]) -> Given:
        """Return the products with what the choices' shapes may get wrong projected out too."""
        details = [(key, DETAIL) for key in (*self.laws, *(c.candidate.key for c in choices))]
        held = [key for key in details if key in self.products.places]
        return self.products.given([*(c.key for c in choices), *held])

    def settled(self, choices: tuple[Choice, ...]) -> FoundSet:
        """Return the set with each effect in the shape that is best beside the others."""
        known = frozenset(choice.candidate.key for choice in choices)
        if known not in self._settled:
            self._settled[known] = self._shaped(choices)
        return self._settled[known]

    def _shaped(self, choices: tuple[Choice, ...]) -> FoundSet:
        for number, choice in enumerate(choices):
            others = (*choices[:number], *choices[number + 1 :])
            given = self.products.given([c.key for c in others])
            offer = self.best_shape(given, choice.candidate)
            if offer is not None:
                choices = (*choices[:number], offer.choice, *choices[number + 1 :])
        return self.scored(choices)

    def scored(self, choices: tuple[Choice, ...]) -> FoundSet:
        """Return the set with its score."""
        whole = self.products.given([]).rss - self.products.given([c.key for c in choices]).rss
        evidence, cost = [], 0.0
        for choice in choices:
            others = [c.key for c in choices if c.key != choice.key]
            gain = self.products.given(others).gain(choice.key)
            penalty = self.penalty(choice)
            evidence.append(gain.evidence - penalty)
            cost += gain.cost + penalty
        return FoundSet(choices, whole - cost, tuple(evidence))

    def best(self) -> FoundSet:
        """Return the set with the highest score of all that were grown, weak members taken out.

        Families over several signals hold many laws at once: a set of names that does nearly as
        well as one with families comes first, and families then only take what it leaves.
        """
        named = self._best_of([s for s in self.candidates if s.named])
        free = self._best_of(self.candidates)
        if all(c.candidate.named for c in free.choices):
            return max(named, free, key=_rank)
        if self.explained(named) < SIMPLE_ENOUGH * self.explained(free):
            return free
        grown = [self.cleared(found) for found in self.grown(named, self.candidates)]
        beside = [found for found in grown if set(found.keys) > set(named.keys)]
        return max([named, *beside], key=_rank)

    def explained(self, found: FoundSet) -> float:
        """Return by how much a set lets the sum of squares fall, over the noise variance."""
        none, all_ = self.products.given([]), self.products.given([c.key for c in found.choices])
        return none.rss - all_.rss

    def _best_of(self, candidates: Sequence[Candidate]) -> FoundSet:
        beam, seen = [self.begin], [self.begin]
        for _ in range(MOST):
            longer = {
                tuple(sorted(f.keys)): f for found in beam for f in self.grown(found, candidates)
            }
            beam = sorted(longer.values(), key=lambda f: -_rank(f))[:BEAM]
            seen += beam
        seen.sort(key=lambda f: -_rank(f))
        return max((self.cleared(found) for found in seen[:CLEARED]), key=_rank)

    def cleared(self, found: FoundSet) -> FoundSet:
        """Return the set without effects that are not worth it or too faint beside the others."""
        while found.choices:
            worth = self._worth(found)
            weakest = int(np.argmin(worth))
            if worth[weakest] > 0:
                return found
            found = self.settled(found.without(found.choices[weakest].candidate.key))
        return found

    def _worth(self, found: FoundSet) -> list[float]:
        """Return how far each effect is above its limits, over all shapes of the others; those
        that sets begin with stay.
        """
        worth = []
        held = zip(found.choices, found.evidence, strict=True)
        total = found.score - sum(worth for choice, worth in held if choice.candidate.exact)
        total += self.explained_before
        for choice in found.choices:
            if choice.candidate.key in self.begin.keys:
                worth.append(np.inf)
                continue
            free = self.with_detail(found.without(choice.candidate.key))
            gain = free.gain(choice.key)
            limit = max(MARGIN + self.penalty(choice), self.faint * total)
            worth.append(self._not_mistaken(found, choice, gain.evidence) - limit)
        return worth

    def _not_mistaken(self, found: FoundSet, choice: Choice, evidence: float) -> float:
        """Return an effect's evidence, beside what it may be mistaken for where that explains more
        beside it than it does itself.
        """
        key = (choice.candidate.key, MISTAKEN)
        if key not in self.products.places:
            return evidence
        if self.products.given([c.key for c in found.choices]).gain(key).evidence < evidence:
            return evidence
        others = [c.key for c in found.choices if c.key != choice.key]
        return min(evidence, self.products.given([*others, key]).gain(choice.key).evidence)

    def rivals(self, found: FoundSet, key: str) -> dict[str, float]:
        """Return, by candidate, by how much the set's score falls when it stands in for ``key``:
        the score without what holds that one.
        """
        others = found.without(key)
        if len(others) < len(found.choices) - 1:
            found = self.settled((*others, *(c for c in found.choices if c.candidate.key == key)))
        fall: dict[str, float] = {}
        for offer in self.offers(others):
            if offer.choice.candidate.key != key:
                swapped = self.settled((*others, offer.choice))
                fall[offer.choice.candidate.key] = found.score - swapped.score
        return fall

    def penalty(self, choice: Choice) -> float:
        """Return what looking through the choice's shapes and all candidates costs."""
        looked = choice.shape.tries * len(self.candidates)
        return 2.0 * float(np.log(looked)) + choice.candidate.bar


def terms_of(choices: Iterable[Choice]) -> frozenset[str]:
    """Return the terms of some choices, and the keys of those without a name."""
    return frozenset(c.candidate.known_as for c in choices)


def as_compared(evidence: float) -> float:
    """Return evidence as it is compared: what columns that say the same differ by is no more."""
    return round(evidence, ALIKE_DIGITS)


def _rank(found: FoundSet) -> float:
    return as_compared(found.score)


MOST_SWAPS = 3


def settled_set(
    search: CandidateSearch,
    found: FoundSet,
    *,
    held: Collection[str] = (),
    names_first: bool = False,
) -> FoundSet:
    """Return the set after every swap that raises its score, as few as there are.

    ``held``: keys of effects that are not swapped; ``names_first``: none without a name takes the
    place of one with a name that does nearly as well.
    """
    for _ in range(MOST_SWAPS):
        better = _better(search, found, held, names_first=names_first)
        if better is None:
            return found
        found = better
    return found


def _better(
    search: CandidateSearch, found: FoundSet, held: Collection[str], *, names_first: bool
) -> FoundSet | None:
    by_key = {s.key: s for s in search.candidates}
    for key in [key for key in found.keys if key not in held]:
        falls = search.rivals(found, key)
        if not falls:
            continue
        rival = min(falls, key=lambda k: as_compared(falls[k]))
        if as_compared(falls[rival]) < 0:
            given = search.products.given([c.key for c in found.without(key)])
            offer = search.best_shape(given, by_key[rival])
            if offer is not None:
                swapped = search.settled((*found.without(key), offer.choice))
                if _rank(swapped) > _rank(found) and not (
                    names_first and _nearly_named(search, found, swapped)
                ):
                    return swapped
    return None


def _nearly_named(search: CandidateSearch, found: FoundSet, swapped: FoundSet) -> bool:
    """Whether a swap takes a name for what has none, and the names did nearly as well."""
    names = [sum(c.candidate.named for c in one.choices) for one in (found, swapped)]
    enough = search.explained(found) >= SIMPLE_ENOUGH * search.explained(swapped)
    return names[1] < names[0] and enough


def alike_terms(name: str) -> frozenset[str]:
    """Return the terms that look like one, or that one of these looks like."""
    found = {name}
    terms = all_terms()
    for _ in terms:
        more = {t.name for t in terms if found & set(t.alike)}
        more |= {other for t in terms if t.name in found for other in t.alike}
        if more <= found:
            break
        found |= more
    return frozenset(found - {name})
