"""Which case a seed is: what is hidden follows from the seed alone, every third hides nothing.

Families of seeds have nothing in common: explanations are improved on DEVELOPMENT only, proved on
PROOF, and tested on FIXED.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from autodb.proofs.cases.axis.axis_cases import AXIS_KINDS, draw_axis_case
from autodb.proofs.cases.base.case import Case
from autodb.proofs.cases.cuts.cut_cases import CUT_KINDS, draw_table_case

DEVELOPMENT, PROOF, FIXED = 1, 2, 3
CLARITIES = (8.0, 20.0, 4.0)
NOTHING_EVERY = 3
TABLE_EVERY = 4
"""Of the cases that hide nothing every fourth is a table of cuts."""
Kinds = tuple[str, ...]


@dataclass(frozen=True)
class PlannedCase:
    """What is hidden, in a recording of an axis or a table of cuts, and how clearly it shows."""

    kinds: Kinds
    wanted: float
    table: bool = False


def _excluded(kinds: Kinds) -> bool:
    """Say whether kinds cannot be hidden together: the weight would be the size of both."""
    return {"gravity", "lost_sign"} <= set(kinds)


def _several(kinds: Kinds, number: int, count: int) -> list[Kinds]:
    """Draw ``count`` sets of so many named kinds, each kind about as often as any other."""
    rng = np.random.default_rng([41, number])
    named = [kind for kind in kinds if "outside" not in kind]
    sets = [one for one in combinations(named, number) if not _excluded(one)]
    seen = dict.fromkeys(named, 0)
    chosen = []
    for _ in range(count):
        order = [int(i) for i in rng.permutation(len(sets))]
        least = min(order, key=lambda i: sum(seen[kind] for kind in sets[i]))
        chosen.append(sets.pop(least))
        for kind in chosen[-1]:
            seen[kind] += 1
    return chosen


def _sets(kinds: Kinds, *, pairs: int, triples: int) -> list[Kinds]:
    """Each kind alone, then pairs and triples."""
    alone = [(kind,) for kind in kinds]
    return [*alone, *_several(kinds, 2, pairs), *_several(kinds, 3, triples)]


def _rounds() -> tuple[tuple[Kinds, bool], ...]:
    """What is hidden and whether in a table: all that the plan has, in an order drawn once."""
    axis = [(kinds, False) for kinds in _sets(AXIS_KINDS, pairs=20, triples=8)]
    sets = [*axis, *((kinds, True) for kinds in _sets(CUT_KINDS, pairs=8, triples=2))]
    return tuple(sets[i] for i in np.random.default_rng(42).permutation(len(sets)))


ROUND = _rounds()


def planned_case(number: int) -> PlannedCase:
    """Return what case ``number`` (1, 2, ...) hides.

    Every third hides nothing; the others go through ROUND, each at the next of CLARITIES in the
    next round.
    """
    before = (number - 1) // NOTHING_EVERY
    if number % NOTHING_EVERY == 0:
        clarity = CLARITIES[before % len(CLARITIES)]
        return PlannedCase((), clarity, before % TABLE_EVERY == TABLE_EVERY - 1)
    turn, at = divmod(number - 1 - before, len(ROUND))
    kinds, table = ROUND[at]
    return PlannedCase(kinds, CLARITIES[(turn + at) % len(CLARITIES)], table)


def draw_concealed(seed: int, *, family: int = PROOF, asked: PlannedCase | None = None) -> Case:
    """The case of a seed, 1, 2, ...; ``asked`` hides something else than the plan says.

    >>> draw(3).hidden
    ()
    """
    plan = asked or planned_case(seed)
    drawn = draw_table_case if plan.table else draw_axis_case
    return drawn(seed, plan.kinds, plan.wanted, family=family)


def fixed_cases(count: int = 60) -> Iterator[Case]:
    """The first of 60 cases for tests and, the first 30 of them, for comparisons.

    The rule: seeds 1 to 60 of FIXED hide what the plan says, with clarity 20 and 8 in turn. So one
    of three hides nothing, the others what stands first in ROUND: none was chosen by its outcome.
    """
    for seed in range(1, count + 1):
        plan = replace(planned_case(seed), wanted=20.0 if seed % 2 else 8.0)
        yield draw_concealed(seed, family=FIXED, asked=plan)
