"""All that the forces of a table may hold: own terms, and effects with a name or without one.

Effects without a name: the force depends on something that was recorded, by a smooth curve. Each
competes as a path of its own, with a higher bar: what has a name is not put down to them.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from autodb.explain.cuts.candidates.cutting import (
    band_candidates,
    deflection_candidates,
    depth_candidates,
    edge_force_candidates,
    log_speed,
    nose_candidates,
    size_candidates,
    speed_candidates,
)
from autodb.explain.cuts.candidates.laws import (
    LawColumns,
    SmoothCurve,
    SpreadLaw,
    added,
    alike,
    along_edge,
    as_simulated,
    chip_factor,
    each,
    per_depth,
    relative,
    values_of,
)
from autodb.explain.cuts.candidates.over_time import (
    drift_candidates,
    gain_candidates,
    warming_candidates,
    wear_candidates,
)
from autodb.explain.cuts.candidates.searched import (
    BAR,
    ROUND,
    comes_round,
    run_of_cuts,
    step_of_zero,
    steps_of_gain,
)
from autodb.explain.cuts.stack import Stack, designed
from autodb.explain.engine.candidates import UNKNOWN, Candidate, CandidateForm, product
from autodb.explain.engine.prior import OWN_SD

Array = NDArray[np.float64]

PAIR_BAR = 12.0
SINGLE, COARSE = 5, 3
MOST_PAIRED = 6
"""Variables that are paired at most."""
SIZE = "size"
"""What the coefficients of a plain law are called."""
CONFIRMED = 0.25
"""Share of its evidence by which squares of cuts left out fall with an effect, at least: with one
that is there they fall by about all of it. Chosen."""
EXPONENT_SD = 0.05
"""Standard deviation that a simulated exponent of the speed has at least. Chosen: half of that of
the term before anything was cut."""
CUTS_A_COLUMN = 3
"""Cuts that a table must have for each column of a shape. Chosen."""


@dataclass(frozen=True)
class Library:
    """What the channels of a table may hold: columns of their own, and effects.

    ``proposals`` are effects that must be searched for in what a fit leaves (C, n), by round;
    ``levels``: names of own columns that no force or depth holds, so that they count in scatter;
    ``confirmed``: share of an effect's evidence by which squares of cuts left out fall with it, at
    least.
    """

    own: Callable[[Stack], dict[str, LawColumns]]
    candidates: Callable[[Stack], list[Candidate]]
    proposals: Callable[[Stack, Array, int], list[Candidate]]
    levels: tuple[str, ...] = ()
    confirmed: float = 0.0


def own_columns_of_cuts(stack: Stack, includes: list[str] | None) -> dict[str, LawColumns]:
    """Return the simulation's own columns, free in each component: chip, edge and wear, and what
    the exponent of a softening is off by, which is likely little.
    """
    known = stack.known
    one = values_of(np.ones(len(known)))
    own = {"shear": each(stack, chip_factor(stack, one))}
    has_edge = bool(stack.edge_N_mm.any()) if includes is None else "edge_force" in includes
    if has_edge:
        own["edge_force"] = each(stack, along_edge(stack))
    worn = stack.wear_goes_with
    if includes is not None and "tool_wear" in includes and worn is not None:
        even = per_depth(stack, values_of(worn))
        own["tool_wear"] = each(stack, even if stack.wear is None else as_simulated(stack.worn))
    if stack.exponents is not None:
        further = each(stack, chip_factor(stack, values_of(-log_speed(stack))))
        own["speed_softening"] = replace(
            further, sd=np.hypot(OWN_SD * stack.exponents, EXPONENT_SD)
        )
    return own


def of_forces(includes: list[str] | None) -> Library:
    """Return what forces may hold beside a simulation that has the terms ``includes``."""

    def candidates(stack: Stack) -> list[Candidate]:
        own = frozenset(own_columns_of_cuts(stack, includes))
        return _within_reach(stack, [*named_effects(stack, own), *families(stack)])

    return Library(
        lambda stack: own_columns_of_cuts(stack, includes),
        candidates,
        _proposals,
        confirmed=CONFIRMED,
    )


def _within_reach(stack: Stack, effects: list[Candidate]) -> list[Candidate]:
    """Return effects in the shapes that so few cuts can tell: with as many columns as cuts every
    table is followed exactly, and which shape does it best is a rounding.
    """
    most = len(stack.frame.known) // CUTS_A_COLUMN
    found = []
    for effect in effects:
        forms = tuple(one for one in effect.forms if _law(one).width <= most)
        found += [replace(effect, forms=forms)] if forms else []
    return found


def _proposals(stack: Stack, left: Array, number: int) -> list[Candidate]:
    found = [
        run_of_cuts(stack, left, number),
        *(comes_round(stack, left, over, number) for over in ROUND),
    ]
    components = range(len(stack.names)) if len(stack.names) > 1 else ()
    several = [one for i in components for one in steps_of_gain(stack, left, i, number)]
    zeros = [step_of_zero(stack, left, i, number) for i in range(len(stack.names))]
    return [_with_plain_forms(one) for one in (*several, *zeros, *found) if one is not None]


def named_effects(stack: Stack, own: frozenset[str]) -> list[Candidate]:
    """Return the named effects that a table can show; ``own``: terms that are re-tuned."""
    found = [
        *edge_force_candidates(stack, own), *size_candidates(stack), *speed_candidates(stack, own),
        *band_candidates(stack), *wear_candidates(stack, own), *depth_candidates(stack),
        *nose_candidates(stack), *deflection_candidates(stack), *drift_candidates(stack),
        *gain_candidates(stack), *warming_candidates(stack),
    ]  # fmt: skip
    return [_with_plain_forms(candidate) for candidate in found if candidate.forms]


def _with_plain_forms(candidate: Candidate) -> Candidate:
    """Return a candidate whose forms that are no curves are known as plain laws, of a size each."""
    if not candidate.named:
        return candidate
    forms = [replace(one, names=(SIZE,)) if _is_plain(one) else one for one in candidate.forms]
    return replace(candidate, forms=tuple(forms))


def _is_plain(form: CandidateForm) -> bool:
    return _law(form).width == 1 or ("edges" in form.shape and "curved" not in form.shape)


def _law(form: CandidateForm) -> SpreadLaw:
    assert isinstance(form.law, LawColumns)  # every candidate of a cut table is made of laws
    return form.law.law


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
    """Return what differs from cut to cut and comes back after two, three or four: pallets, say.

    Not where a setting of the cuts comes back with it, as in a full design cut in its order.
    """
    number = stack.row
    forms = []
    design = designed(stack.frame)
    for every in (2, 3, 4):
        member = 1.0 * (number[:, None] % every == np.arange(every - 1)[None, :])
        if design.holds(1.0 * (stack.frame.row[:, None] % every == np.arange(every))):
            continue
        for make in (relative, added):
            law = make(stack, values_of(member), every - 1)
            shape = {"every": float(every)}
            forms += [CandidateForm(spread(stack, law), shape) for spread in (alike, each)]
    return Candidate("unknown in turns", UNKNOWN, tuple(forms), ("cut",), bar=BAR)


def _pair(stack: Stack, first: str, second: str) -> Candidate:
    one, two = _over(stack, first, COARSE + 1), _over(stack, second, COARSE + 1)
    law = relative(stack, lambda rows: product(one(rows), two(rows)), one.width * two.width)
    key = f"unknown {first} × {second}"
    return Candidate(
        key, UNKNOWN, (CandidateForm(alike(stack, law)),), (first, second), bar=PAIR_BAR
    )
