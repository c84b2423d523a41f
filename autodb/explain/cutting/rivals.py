"""How sure is a name? The scores of the sets in which another effect stands in its place."""

from dataclasses import dataclass

import numpy as np

from autodb.explain.search import Found, Search
from autodb.explain.suspects import UNKNOWN, Choice
from autodb.terms import TERMS

NEAR = 20.0
"""A rival whose set scores less than this below the best cannot be told apart: a likelihood ratio
of e¹⁰, that laws of another form than the truth may use up. Chosen."""
TEMPER = 3.0
"""Scores count this many times less than likelihoods do, for the same reason. Chosen."""
CEILING = 0.99
MOST_SWAPS = 3


@dataclass(frozen=True)
class Standing:
    """Of one effect of a set: the probability of its name, and the terms nearly as good.

    ``like``: the probability of its name or one of those that are known to look like it.
    """

    confidence: float
    near: tuple[str, ...]
    like: float


def settled(search: Search, found: Found) -> Found:
    """Return the set after every swap that raises its score, as few as there are."""
    for _ in range(MOST_SWAPS):
        better = _better(search, found)
        if better is None:
            return found
        found = better
    return found


def _better(search: Search, found: Found) -> Found | None:
    by_key = {s.key: s for s in search.suspects}
    for key in found.keys:
        falls = search.rivals(found, key)
        if not falls:
            continue
        rival = min(falls, key=lambda k: falls[k])
        if falls[rival] < 0:
            given = search.products.given([c.key for c in found.without(key)])
            offer = search.best_shape(given, by_key[rival])
            if offer is not None:
                swapped = search.settled((*found.without(key), offer.choice))
                if swapped.score > found.score:
                    return swapped
    return None


def standing(search: Search, found: Found, choice: Choice) -> Standing:
    """Return how sure the name of one effect of a set is; nothing at all is a rival too."""
    term = {s.key: s.term for s in search.suspects}
    falls = search.rivals(found, choice.suspect.key)
    by_term: dict[str, float] = {}
    for key, fall in falls.items():
        if term[key] != choice.suspect.term:
            by_term[term[key]] = min(fall, by_term.get(term[key], np.inf))
    place = found.keys.index(choice.suspect.key)
    nothing = max(0.0, found.evidence[place])
    weight = {t: float(np.exp(-max(f, 0.0) / (2.0 * TEMPER))) for t, f in by_term.items()}
    none = float(np.exp(-nothing / (2.0 * TEMPER)))
    whole = 1.0 + none + sum(weight.values())
    alike = alike_terms(choice.suspect.term)
    like = (1.0 + sum(w for t, w in weight.items() if t in alike)) / whole
    near = [t for t in sorted(by_term, key=lambda t: by_term[t]) if by_term[t] < NEAR]
    return Standing(min(CEILING, 1.0 / whole), tuple(t for t in near if t != UNKNOWN), like)


def alike_terms(name: str) -> frozenset[str]:
    """Return the terms that look like one, or that one of these looks like."""
    found = {name}
    for _ in TERMS:
        more = {t.name for t in TERMS if found & set(t.alike)}
        more |= {other for t in TERMS if t.name in found for other in t.alike}
        if more <= found:
            break
        found |= more
    return frozenset(found - {name})
