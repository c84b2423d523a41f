"""Effects that stand in for others: swaps that make a set likelier, and terms that look alike."""

from autodb.explain.engine.search import CandidateSearch, FoundSet
from autodb.terms import TERMS

MOST_SWAPS = 3


def settled_set(search: CandidateSearch, found: FoundSet) -> FoundSet:
    """Return the set after every swap that raises its score, as few as there are."""
    for _ in range(MOST_SWAPS):
        better = _better(search, found)
        if better is None:
            return found
        found = better
    return found


def _better(search: CandidateSearch, found: FoundSet) -> FoundSet | None:
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
