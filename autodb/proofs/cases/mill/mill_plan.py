"""Which milled cut a seed is: every third hides nothing, the others each kind, pairs and triples.

A recording has tens of thousands of rows, so that a clarity of 20 is a run-out of a ten-thousandth
of a millimetre: 100 stands for what a shop would call plain.
"""

from itertools import combinations

import numpy as np

from autodb.proofs.cases.mill.mill_cases import MillCase, draw_mill_case
from autodb.proofs.cases.mill.mill_families import MILL_KINDS
from autodb.proofs.cases.plan import NOTHING_EVERY, PROOF, Kinds, PlannedCase

CLARITIES = (8.0, 20.0, 4.0, 100.0)
PAIRS, TRIPLES = 12, 5
NAMELESS = "outside"


def _several(number: int, count: int) -> list[Kinds]:
    """Draw ``count`` sets of so many named kinds, each kind about as often as any other."""
    rng = np.random.default_rng([43, number])
    named = [kind for kind in MILL_KINDS if NAMELESS not in kind]
    sets, seen = list(combinations(named, number)), dict.fromkeys(named, 0)
    chosen = []
    for _ in range(count):
        order = [int(i) for i in rng.permutation(len(sets))]
        least = min(order, key=lambda i: sum(seen[kind] for kind in sets[i]))
        chosen.append(sets.pop(least))
        for kind in chosen[-1]:
            seen[kind] += 1
    return chosen


def _round() -> tuple[Kinds, ...]:
    """What is hidden, all that the plan has, in an order drawn once."""
    alone = [(kind,) for kind in MILL_KINDS]
    sets = [*alone, *_several(2, PAIRS), *_several(3, TRIPLES)]
    return tuple(sets[i] for i in np.random.default_rng(44).permutation(len(sets)))


ROUND = _round()


def planned_mill(number: int) -> PlannedCase:
    """Return what case ``number`` (1, 2, ...) hides: ROUND, each at the next clarity in the next.

    >>> planned_mill(3).kinds
    ()
    """
    before = (number - 1) // NOTHING_EVERY
    if number % NOTHING_EVERY == 0:
        return PlannedCase((), CLARITIES[before % len(CLARITIES)])
    turn, at = divmod(number - 1 - before, len(ROUND))
    return PlannedCase(ROUND[at], CLARITIES[(turn + at) % len(CLARITIES)])


def draw_planned_mill(seed: int, *, family: int = PROOF) -> MillCase:
    """The milled cut of a seed, 1, 2, ..."""
    plan = planned_mill(seed)
    return draw_mill_case(seed, plan.kinds, plan.wanted, family=family)
