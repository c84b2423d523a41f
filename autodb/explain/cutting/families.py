"""Effects without a name: the force depends on something that was recorded, by a smooth curve.

Each competes as a path of its own, with a higher bar: what has a name is not put down to them.
"""

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from autodb.explain.cutting.laws import Curve, Law, added, alike, each, relative, values_of
from autodb.explain.cutting.table import Stack
from autodb.explain.suspects import UNKNOWN, Rung, Suspect

Array = NDArray[np.float64]

BAR = 5.0
"""Evidence asked of a family of one variable beyond that of a named effect. Chosen."""
PAIR_BAR = 12.0
SINGLE, COARSE = 5, 3
MOST_PAIRED = 6
"""Variables that are paired at most."""


def families(stack: Stack) -> list[Suspect]:
    """Return the unnamed effects: of one variable, of two together, of every other cut."""
    seen = {**stack.known.other, "cut": stack.known.number}
    singles = {name: values for name, values in seen.items() if len(np.unique(values)) > 2}
    found = [_single(stack, name, values) for name, values in singles.items()]
    found.append(_turns(stack))
    if len(stack.known) >= 60:
        paired = [n for n in singles if n not in ("chip.thickness", "tool.cutting_time")]
        for first, second in combinations(paired[:MOST_PAIRED], 2):
            found.append(_pair(stack, first, second, singles))
    return found


def _positive_scale(values: Array) -> Array:
    return np.log(values) if values.min() > 0 and values.max() > 4 * values.min() else values


def _single(stack: Stack, name: str, values: Array) -> Suspect:
    curve = Curve(_positive_scale(values), SINGLE)
    factor, offset = relative(stack, curve, curve.width), added(stack, curve, curve.width)
    rungs = (
        Rung(alike(stack, factor)),
        Rung(each(stack, factor)),
        Rung(each(stack, offset)),
    )
    detail = each(stack, factor)
    return Suspect(f"unknown {name}", UNKNOWN, rungs, (name,), detail=detail, bar=BAR)


def _turns(stack: Stack) -> Suspect:
    """Return what differs from cut to cut and comes back after two, three or four: pallets, say."""
    number = np.arange(len(stack.known))
    rungs = []
    for every in (2, 3, 4):
        member = 1.0 * (number[:, None] % every == np.arange(every - 1)[None, :])
        for make in (relative, added):
            law = make(stack, values_of(member), every - 1)
            shape = {"every": float(every)}
            rungs += [Rung(spread(stack, law), shape) for spread in (alike, each)]
    return Suspect("unknown in turns", UNKNOWN, tuple(rungs), ("cut",), bar=BAR)


def _pair(stack: Stack, first: str, second: str, seen: dict[str, Array]) -> Suspect:
    one = Curve(_positive_scale(seen[first]), COARSE + 1)
    two = Curve(_positive_scale(seen[second]), COARSE + 1)

    def shape(rows: slice) -> Array:
        columns = one(rows)[:, :, None] * two(rows)[:, None, :]
        return np.asarray(columns.reshape(len(columns), -1))

    law: Law = relative(stack, shape, one.width * two.width)
    key = f"unknown {first} × {second}"
    return Suspect(key, UNKNOWN, (Rung(alike(stack, law)),), (first, second), bar=PAIR_BAR)
