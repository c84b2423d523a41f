"""Effects without a name: the force depends on something that was recorded, by a smooth curve.

Each competes as a path of its own, with a higher bar: what has a name is not put down to them.

The effects of the vocabulary that cutting forces may hold, each with its ladder of shapes.
"""

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from autodb.explain.cuts.candidates.cutting import (
    band_candidates,
    deflection_candidates,
    depth_candidates,
    edge_force_candidates,
    nose_candidates,
    size_candidates,
    speed_candidates,
)
from autodb.explain.cuts.candidates.laws import (
    SmoothCurve,
    SpreadLaw,
    added,
    alike,
    each,
    relative,
    values_of,
)
from autodb.explain.cuts.candidates.over_time import (
    drift_candidates,
    gain_candidates,
    warming_candidates,
    wear_candidates,
)
from autodb.explain.cuts.stack import Stack
from autodb.explain.engine.candidates import UNKNOWN, Candidate, CandidateForm

Array = NDArray[np.float64]

BAR = 5.0
"""Evidence asked of a family of one variable beyond that of a named effect. Chosen."""
PAIR_BAR = 12.0
SINGLE, COARSE = 5, 3
MOST_PAIRED = 6
"""Variables that are paired at most."""


def families(stack: Stack) -> list[Candidate]:
    """Return the unnamed effects: of one variable, of two together, of every other cut."""
    singles = [n for n, values in _seen(stack.frame).items() if len(np.unique(values)) > 2]
    found = [_single(stack, name) for name in singles]
    found.append(_turns(stack))
    if len(stack.frame.known) >= 60:
        paired = [n for n in singles if n not in ("chip.thickness", "tool.cutting_time")]
        for first, second in combinations(paired[:MOST_PAIRED], 2):
            found.append(_pair(stack, first, second))
    return found


def _seen(stack: Stack) -> dict[str, Array]:
    return {**stack.known.other, "cut": stack.known.number}


def _over(stack: Stack, name: str, count: int) -> SmoothCurve:
    """Return the curve over a variable, or over its logarithm where it varies by much."""
    values, like = _seen(stack)[name], _seen(stack.frame)[name]
    if like.min() > 0 and like.max() > 4 * like.min():
        return SmoothCurve(np.log(values), count, np.log(like))
    return SmoothCurve(values, count, like)


def _single(stack: Stack, name: str) -> Candidate:
    curve = _over(stack, name, SINGLE)
    factor, offset = relative(stack, curve, curve.width), added(stack, curve, curve.width)
    forms = (
        CandidateForm(alike(stack, factor)),
        CandidateForm(each(stack, factor)),
        CandidateForm(each(stack, offset)),
    )
    detail = each(stack, factor)
    return Candidate(f"unknown {name}", UNKNOWN, forms, (name,), detail=detail, bar=BAR)


def _turns(stack: Stack) -> Candidate:
    """Return what differs from cut to cut and comes back after two, three or four: pallets, say."""
    number = stack.row
    forms = []
    for every in (2, 3, 4):
        member = 1.0 * (number[:, None] % every == np.arange(every - 1)[None, :])
        for make in (relative, added):
            law = make(stack, values_of(member), every - 1)
            shape = {"every": float(every)}
            forms += [CandidateForm(spread(stack, law), shape) for spread in (alike, each)]
    return Candidate("unknown in turns", UNKNOWN, tuple(forms), ("cut",), bar=BAR)


def _pair(stack: Stack, first: str, second: str) -> Candidate:
    one, two = _over(stack, first, COARSE + 1), _over(stack, second, COARSE + 1)

    def shape(rows: slice) -> Array:
        columns = one(rows)[:, :, None] * two(rows)[:, None, :]
        return np.asarray(columns.reshape(len(columns), -1))

    law: SpreadLaw = relative(stack, shape, one.width * two.width)
    key = f"unknown {first} × {second}"
    return Candidate(
        key, UNKNOWN, (CandidateForm(alike(stack, law)),), (first, second), bar=PAIR_BAR
    )


def named_effects(stack: Stack, own: frozenset[str]) -> list[Candidate]:
    """Return the named effects that a table can show; ``own``: terms that are re-tuned."""
    found = [
        *edge_force_candidates(stack, own), *size_candidates(stack), *speed_candidates(stack),
        *band_candidates(stack), *wear_candidates(stack, own), *depth_candidates(stack),
        *nose_candidates(stack), *deflection_candidates(stack), *drift_candidates(stack),
        *gain_candidates(stack), *warming_candidates(stack),
    ]  # fmt: skip
    return [candidate for candidate in found if candidate.forms]
