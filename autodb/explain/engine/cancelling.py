"""Effects that own terms and other effects take back but for what laws may be wrong by.

Dry friction, viscous friction and friction by direction are nearly one constant where an axis
hardly ever turns: their sum is known, none of them is. What is left of one beside the others is
what slow noise has of it, or what is wrong of the others' laws, and its size may be many times that
of all that was measured.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.fit import rms
from autodb.explain.engine.normal import columns_side_by_side, solved

Array = NDArray[np.float64]

WRONG_BY = 0.1
"""Share of itself by which a law may be wrong: real ones are known to a tenth at best. Chosen."""


def most_cancelled(
    effects: Sequence[Array], own: Array, difference: Array, *, named: Sequence[bool]
) -> int | None:
    """Return the number of the named effect (m,) of which the least is left, if that is none.

    ``own`` (m, k): the columns of own terms, ``difference`` (m,): all that is to be explained. Only
    an effect that is larger than that is mostly taken back.
    """
    sizes = np.array([rms(effect) for effect in effects])
    left = np.full(len(effects), np.inf)
    for number, effect in enumerate(effects):
        if not named[number] or sizes[number] <= rms(difference):
            continue
        others = columns_side_by_side(own, *effects[:number], *effects[number + 1 :])
        its = effect - others @ solved(others, effect)
        beside = [*np.delete(sizes, number), rms(effect - its)]
        left[number] = rms(its) / (WRONG_BY * float(np.linalg.norm(beside)))
    least = int(np.argmin(left)) if len(left) else 0
    return least if len(left) and left[least] < 1.0 else None
