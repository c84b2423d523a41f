"""How sure is a finding, of what is missing and of what is mistuned, by white rows and by both?"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.candidates import UNKNOWN, Candidate, Choice
from autodb.explain.engine.plain.odds import beside_plain, of_both, of_plain
from autodb.explain.engine.plain.rows import DISCREPANCY, PlainRows
from autodb.explain.engine.search import MARGIN, CandidateSearch, FoundSet, as_compared
from autodb.explain.engine.standing import Standing, standing

Array = NDArray[np.float64]

SWAPS = 4
"""Effects that are tried in the place of one beside own terms that are held: the likeliest."""
LIKELIER_THAN_NOT = 0.5
"""Probability above which another size of what the simulation has is said: likelier than not."""
RARER = MARGIN
"""Evidence by which a named effect has to do better than a change of an own term: a number that the
simulation has is off more often than a term that it lacks is there. Chosen: as for any effect."""


def with_laws(
    search: CandidateSearch,
    found: FoundSet,
    choice: Choice,
    *,
    rows: PlainRows,
    laws: Sequence[Choice],
    many: bool = False,
) -> Standing:
    """Return how the name of one effect of a set that begins with laws of plain rows stands: a law
    by these first, what stands beside laws by both. ``many``: as of ``of_both``.
    """
    white = of_missing(search, found, choice)
    if choice in laws:
        return of_both(of_plain(rows, laws, choice), white, many=many)
    if not choice.candidate.named:
        return white
    return beside_plain(white, rows, found.without(choice.candidate.key), choice)


def of_missing(
    search: CandidateSearch, found: FoundSet, choice: Choice, *, but: Collection[str] = ()
) -> Standing:
    """Return how the name of one effect of a set stands, ``but`` for some other names.

    Its rivals leave the own terms free as it does; one without a name may also stand beside a
    simulation that is right as it is, where the name needs own terms that are not. Not so one that
    says the same: its columns are the name's and changes of own terms, under another name.
    """
    by_key = {s.key: s for s in search.candidates}
    falls = search.rivals(found, choice.candidate.key)
    found_by = [
        (by_key[key].term, fall - _asked_more(by_key[key], choice)) for key, fall in falls.items()
    ]
    if choice.candidate.named:
        held = _Held(search, found, range(len(search.products.own)))
        found_by += held.swaps(choice, UNKNOWN, asked=True)
    off = DISCREPANCY * _explained(search, found, choice) if choice.candidate.named else 0.0
    by_name: dict[str, float] = {}
    for name, fall in found_by:
        if name not in (choice.candidate.term, *but):
            beyond = fall + off if name == UNKNOWN else fall
            by_name[name] = min(beyond, by_name.get(name, np.inf))
    return standing(by_name, nothing=found.evidence[found.keys.index(choice.candidate.key)])


def _asked_more(rival: Candidate, choice: Choice) -> float:
    """Return what a rival with a name was asked for more than a choice: laws that plain rows chose
    are asked for nothing in white ones, which makes them no likelier than others.
    """
    return rival.bar - choice.candidate.bar if rival.named and choice.candidate.named else 0.0


def _explained(search: CandidateSearch, found: FoundSet, choice: Choice) -> float:
    """Return by how much an effect lets the sum of squares fall beside the others of its set."""
    others = [c.key for c in found.without(choice.candidate.key)]
    return search.products.given(others).gain(choice.key).full


class _Held:
    """A set beside own columns that are left as the simulation has them.

    ``own``: their numbers; ``ways``: places of further columns of theirs, which a choice holds.
    """

    def __init__(
        self,
        search: CandidateSearch,
        found: FoundSet,
        own: Sequence[int],
        ways: NDArray[np.intp] | None = None,
    ) -> None:
        places = search.products.own[list(own)]
        self.kept = found.choices
        if ways is not None:
            places = np.concatenate([places, ways])
            self.kept = tuple(c for c in found.choices if not _holds(search, c, ways))
        self.search = search.with_held(own)
        keys = [choice.key for choice in self.kept]
        looked = 2.0 * float(np.log(max(len(search.products.own), 1)))
        plain, free = self.search.products.given(keys), self.search.with_detail(self.kept)
        beside_laws = plain.gain_of(places).evidence - looked
        self.worth = min(beside_laws, free.gain_of(places).evidence - looked)
        """Evidence that the columns change beside the set, whatever its laws get wrong in shape."""
        self.variables: tuple[str, ...] = ()
        self.free = search.products.freed()
        self._best = max(beside_laws, 0.0) + self.search.scored(self.kept).score

    def swaps(
        self, choice: Choice, name: str | None = None, *, asked: bool = False
    ) -> list[tuple[str, float]]:
        """Return the likeliest effects in the place of one, and by how much evidence falls.

        From the set as it is best: with the change of the own columns, or without. ``asked``: of
        families what is asked before one is told is asked here, too.
        """
        others = tuple(c for c in self.kept if c.key != choice.key)
        offers = [
            offer
            for offer in self.search.offers(others)
            if offer.choice.candidate.key != choice.candidate.key
            and name in (None, offer.choice.candidate.term)
        ]
        if asked:
            offers = [
                offer for offer in offers if not self._says_the_same(offer.choice, choice, others)
            ]
        offers.sort(key=lambda offer: -as_compared(offer.worth))
        falls = []
        for offer in offers[:SWAPS]:
            candidate = offer.choice.candidate
            fall = self._best - self.search.settled((*others, offer.choice)).score
            falls.append(
                (candidate.term, fall if candidate.named or asked else fall - candidate.bar)
            )
        return falls

    def _says_the_same(self, rival: Choice, choice: Choice, others: Sequence[Choice]) -> bool:
        """Whether a choice gives a rival, but for what real effects leave of laws, where own terms
        are free: as a curve over three speeds is a chip, its softening and a band of speeds.
        """
        beside = [one.key for one in others]
        left, after = (
            self.free.given(keys).left_of(rival.key) for keys in (beside, [*beside, choice.key])
        )
        return after <= DISCREPANCY * left

    def joined(self) -> list[tuple[str, float]]:
        """Return every effect beside the set, and by how much evidence falls with it.

        What is asked of a family before it is told is not asked of it here: that a number is off is
        said only where it is likelier than something nobody thought of.
        """
        return [
            (
                candidate.term,
                self.worth - offer.worth + (-candidate.bar if not candidate.named else RARER),
            )
            for offer in self.search.offers(self.kept)
            for candidate in [offer.choice.candidate]
        ]


@dataclass(frozen=True)
class Mistuned:
    """Whether own terms are mistuned: evidence beyond what is asked of any effect, how sure.

    ``variables``: what the family without a name depends on that would do in its place.
    """

    worth: float
    standing: Standing
    variables: tuple[str, ...]

    @property
    def told(self) -> bool:
        """Whether it is said: it has evidence, and is likelier than not."""
        return self.worth > 0.0 and self.standing.confidence > LIKELIER_THAN_NOT

    @property
    def either(self) -> bool:
        """Whether there is as much evidence, but what is off may be another thing."""
        return self.worth > 0.0 and not self.told


def of_mistuned(
    search: CandidateSearch,
    found: FoundSet,
    own: Sequence[int],
    *,
    ways: NDArray[np.intp] | None = None,
    but: Collection[str] = (),
) -> Mistuned:
    """Return how a change of own columns stands beside accounts without it.

    ``own``: numbers of the columns among the simulation's; ``ways``: places of further columns of
    the same term among the products, which a choice holds; ``but``: names that are no others.
    Without the change the set is kept, its
    families free to take it up; or every other candidate is added; or an effect of the set, which
    may be there only with the change, is swapped.
    """
    held = _Held(search, found, own, ways)
    found_by = held.joined()
    for choice in held.kept:
        if choice.candidate.named:
            found_by += held.swaps(choice)
    by_name: dict[str, float] = {}
    for name, fall in found_by:
        if name not in but:
            by_name[name] = min(fall, by_name.get(name, np.inf))
    return Mistuned(held.worth - MARGIN, standing(by_name, nothing=held.worth), held.variables)


def _holds(search: CandidateSearch, choice: Choice, places: NDArray[np.intp]) -> bool:
    return bool(np.isin(search.products.places[choice.key], places).any())
