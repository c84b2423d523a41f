"""Which case a seed is: what is hidden follows from the seed alone, every third hides nothing.

Two families of seeds have nothing in common: explanations are improved on DEVELOPMENT only, and
proved on PROOF.
"""

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from autodb.virtual.concealed.axis_cases import AXIS_KINDS, draw_axis
from autodb.virtual.concealed.case import Case

DEVELOPMENT, PROOF = 1, 2
CLARITIES = (8.0, 20.0, 4.0)
CLEARER = (60.0, 200.0)
"""Real machines are often as clear as this; the plan has CLARITIES, these are there to be asked."""
NOTHING_EVERY = 3


@dataclass(frozen=True)
class Planned:
    """What is hidden, and how clearly each effect shows."""

    kinds: tuple[str, ...]
    wanted: float


def _excluded(kinds: tuple[str, ...]) -> bool:
    """Say whether kinds cannot be hidden together: a weight that is the size of both, or twice
    what no identifier stands for."""
    return {"gravity", "lost_sign"} <= set(kinds) or sum("outside" in kind for kind in kinds) > 1


def _several(kinds: tuple[str, ...], number: int, count: int, seed: int) -> list[tuple[str, ...]]:
    """Draw ``count`` sets of so many kinds, each kind about as often as any other."""
    rng = np.random.default_rng([seed, number])
    sets = [one for one in combinations(kinds, number) if not _excluded(one)]
    seen = dict.fromkeys(kinds, 0)
    chosen = []
    for _ in range(count):
        order = rng.permutation(len(sets))
        best = min(order, key=lambda i: sum(seen[kind] for kind in sets[i]))
        chosen.append(sets.pop(int(best)))
        for kind in chosen[-1]:
            seen[kind] += 1
    return chosen


def _axis_sets() -> list[tuple[str, ...]]:
    """Each kind alone, 20 pairs, 8 triples."""
    named = tuple(kind for kind in AXIS_KINDS if "outside" not in kind)
    alone = [(kind,) for kind in AXIS_KINDS]
    return [*alone, *_several(named, 2, 20, 41), *_several(named, 3, 8, 41)]


def _shuffled(sets: list[tuple[str, ...]], seed: int) -> tuple[tuple[str, ...], ...]:
    return tuple(sets[i] for i in np.random.default_rng(seed).permutation(len(sets)))


AXIS_SETS = _shuffled(_axis_sets(), 42)


def planned(number: int) -> Planned:
    """Return what case ``number`` (1, 2, ...) hides.

    Every third hides nothing; the others go through AXIS_SETS, at the next of CLARITIES each round.
    """
    if number % NOTHING_EVERY == 0:
        return Planned((), CLARITIES[number // NOTHING_EVERY % len(CLARITIES)])
    place = number - 1 - (number - 1) // NOTHING_EVERY
    turn, at = divmod(place, len(AXIS_SETS))
    return Planned(AXIS_SETS[at], CLARITIES[(turn + at) % len(CLARITIES)])


def draw(seed: int, *, family: int = PROOF, asked: Planned | None = None) -> Case:
    """The case of a seed, 1, 2, ...; ``asked`` hides something else than the plan says.

    >>> draw(3).hidden
    ()
    """
    plan = asked or planned(seed)
    return draw_axis(seed, plan.kinds, plan.wanted, family=family)
