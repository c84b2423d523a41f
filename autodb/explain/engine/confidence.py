"""How sure is a finding? One definition for what is missing and for what is mistuned.

The probability of an account among those that recording and simulation leave open: another effect
in its place, nothing in its place, and something outside the vocabulary, which the best family
without a name stands for. Each counts by its evidence, 2 ln of a likelihood with its penalties,

    P = 1 / (1 + Σ exp(−fall / 2T)),   fall = evidence of this account − that of the other

T is a temper: laws are never exact, so that likelihoods of real data claim too much. For the same
reason a family, which follows whatever a law gets wrong, has to do better than the law by a share
of what the law explains (a discrepancy as of Kennedy and O'Hagan 2001, J. R. Stat. Soc. B 63:425).
An effect that is missing is compared in the set that it was found in; an own term of the simulation
that is mistuned is compared with accounts that leave it as the simulation has it.
"""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from autodb.explain.engine.candidates import UNKNOWN, Candidate, Choice
from autodb.explain.engine.plain import (
    ALONE,
    BLOCKS,
    DISCREPANCY,
    NEEDED,
    PlainRows,
    beside,
    rms_fall,
)
from autodb.explain.engine.search import MARGIN, CandidateSearch, FoundSet, as_compared

Array = NDArray[np.float64]

TEMPER = 3.0
"""Evidence counts this many times less than likelihoods do. Chosen of 2 to 6 on virtual axes (seeds
1001 to 1062 of `autodb prove explain-outside`): with it the mean confidence is the share that is
right."""
SUREST = 0.99
"""More is never claimed. Chosen: what nobody thought of is never less probable."""
RARE = 2.0 * TEMPER * float(np.log(10.0))
"""Evidence by which what soaks up any misfit, or holds the law and more, is a rarer rival of a
static law. Chosen: odds of ten."""
UNSURE = 0.89
"""More is not claimed of an effect without which plain rows are predicted about as well."""
AS_LIKELY = TEMPER
"""Evidence that a rival is not this much less of is about as likely: at least 0.6 times. Chosen on
half of the cases of published tables (places 1 to 300 of `autodb prove force-tables`)."""
NEAR = 20.0
"""A rival whose evidence is not this much less is an alternative: odds of e¹⁰ of likelihoods, which
laws of another form than the truth may use up. Chosen."""
SWAPS = 4
"""Effects that are tried in the place of one beside own terms that are held: the likeliest."""
RARER = MARGIN
"""Evidence by which a named effect has to do better than a change of an own term: a number that the
simulation has is off more often than a term that it lacks is there. Chosen: as for any effect."""


@dataclass(frozen=True)
class Standing:
    """Of one account: how probable it is, and the names that would do nearly as well.

    ``near``: these names, the nearest first;
    ``by_name``: evidence by which it is ahead of the best account of each other name; ``nothing``:
    of nothing in its place; ``instead``: what would stand there, of names that were tried so.
    ``rivalled``: something in its place, with a name or without one, is about as likely in white
    rows, or likelier.
    """

    confidence: float
    near: tuple[str, ...]
    by_name: Mapping[str, float]
    nothing: float
    instead: Mapping[str, Choice] = field(default_factory=dict)
    rivalled: bool = False

    def of(self, names: Iterable[str]) -> float:
        """Return the probability of its name or one of others."""
        weights = {name: account_weight(fall) for name, fall in self.by_name.items()}
        whole = 1.0 + account_weight(self.nothing) + sum(weights.values())
        return (1.0 + sum(weights.get(name, 0.0) for name in names)) / whole


def account_weight(fall: float) -> float:
    """Return the probability of an account over that of the one whose evidence is ``fall`` more.

    An account that was not taken counts for no more than the one that was.
    """
    return float(np.exp(-0.5 * max(fall, 0.0) / TEMPER))


def standing(by_name: Mapping[str, float], *, nothing: float) -> Standing:
    """Return how an account stands beside rivals; ``nothing``: its evidence over none at all."""
    odds = account_weight(nothing) + sum(account_weight(fall) for fall in by_name.values())
    near = sorted((fall, name) for name, fall in by_name.items() if fall < NEAR and name != UNKNOWN)
    return Standing(
        min(SUREST, 1.0 / (1.0 + odds)), tuple(name for _, name in near), by_name, nothing
    )


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
    others = [c for c in choices if c is not choice]
    taken = {c.candidate.key for c in choices}
    none = rows.squares(others, like=like)
    by_name: dict[str, float] = {}
    like_it: dict[str, float] = {}
    instead: dict[str, Choice] = {}
    for candidate in rows.candidates:
        curve = choice.candidate.static and not candidate.named
        same = candidate.term in (choice.candidate.term, *but)
        of_it = choice.candidate.key in rows.acts_on.get(candidate.key, ())
        if candidate.key in taken or same or curve or of_it:
            continue
        offer = rows.with_one_more(beside(others, candidate), candidate, like=like)
        if offer is None:
            continue
        richer = max(0.0, rows.richness(offer[1]) - rows.richness(choice))
        off = 0.0 if candidate.named else DISCREPANCY * np.maximum(none - whole, 0.0)
        fall = _fall(offer[0] * (1.0 + richer) ** 2 + off - whole, ranks=like.static)
        more = offer[1].shape.tries / choice.shape.tries
        fall += 2.0 * TEMPER * max(0.0, float(np.log(more)))
        alike = like.static and rows.own_share([*others, offer[1], choice]) <= ALONE
        as_well = alike or _as_well(none, whole, offer[0], like, candidate)
        if as_well and candidate.static and not richer:
            fall = max(fall, 0.0) + 2.0 * TEMPER * float(np.log(like.usual / candidate.usual))
        holds_it = richer > 0.0 and alike
        if like.static and (holds_it or not candidate.static):
            fall = max(fall, 0.0) + RARE
        if fall < by_name.get(candidate.term, np.inf):
            by_name[candidate.term], instead[candidate.term] = fall, offer[1]
        does = rms_fall(none, offer[0]) >= NEEDED
        if does and not rows.has_its_own(others, choice, offer[1]):
            like_it[candidate.term] = min(fall, like_it.get(candidate.term, np.inf))
    nothing = _fall(none - whole, ranks=like.static)
    found, alone = standing(by_name, nothing=nothing), standing(like_it, nothing=nothing)
    sure = max(found.confidence, min(alone.confidence, UNSURE))
    return replace(found, confidence=sure, near=alone.near, instead=instead)


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
    by_mean = float(student.logcdf(ahead, freedom) - student.logsf(ahead, freedom))
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


def of_both(plain: Standing, white: Standing) -> Standing:
    """Return how a law stands whose rivals have to do as well by plain rows and by evidence."""
    falls = {name: max(fall, white.by_name.get(name, fall)) for name, fall in plain.by_name.items()}
    found = standing(falls, nothing=plain.nothing)
    return replace(
        plain,
        confidence=max(plain.confidence, found.confidence),
        near=tuple(name for name in plain.near if falls[name] < NEAR),
        by_name=falls,
        rivalled=any(fall < AS_LIKELY for fall in white.by_name.values()),
    )


def with_laws(
    search: CandidateSearch,
    found: FoundSet,
    choice: Choice,
    *,
    rows: PlainRows,
    laws: Sequence[Choice],
) -> Standing:
    """Return how the name of one effect of a set that begins with laws of plain rows stands: a law
    by these first, what stands beside laws by both.
    """
    white = of_missing(search, found, choice)
    if choice in laws:
        return of_both(of_plain(rows, laws, choice), white)
    if not choice.candidate.named:
        return white
    return beside_plain(white, rows, found.without(choice.candidate.key), choice)


def of_missing(
    search: CandidateSearch, found: FoundSet, choice: Choice, *, but: Collection[str] = ()
) -> Standing:
    """Return how the name of one effect of a set stands, ``but`` for some other names.

    Its rivals leave the own terms free as it does; one without a name may also stand beside a
    simulation that is right as it is, where the name needs own terms that are not.
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
        self._best = max(beside_laws, 0.0) + self.search.scored(self.kept).score

    def swaps(
        self, choice: Choice, name: str | None = None, *, asked: bool = False
    ) -> list[tuple[str, float]]:
        """Return the likeliest effects in the place of one, and by how much evidence falls.

        From the set as it is best: with the change of the own columns, or without. ``asked``: of
        families what is asked before one is told is asked here, too.
        """
        others = tuple(c for c in self.kept if c is not choice)
        offers = [
            offer
            for offer in self.search.offers(others)
            if offer.choice.candidate.key != choice.candidate.key
            and name in (None, offer.choice.candidate.term)
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
        return self.worth > 0.0 and self.standing.confidence > 0.5

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
