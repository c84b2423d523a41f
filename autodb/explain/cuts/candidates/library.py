"""All that the forces of a table may hold: own terms, and effects with a name or without one.

Effects without a name: the force depends on something that was recorded, by a smooth curve. Each
competes as a path of its own, with a higher bar: what has a name is not put down to them. A run of
cuts in other material and what comes round again are searched for in what a fit leaves, by
cumulative sums over bins of cuts; each edge of a run is then refined cut by cut between its
neighbours.
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
    nose_candidates,
    size_candidates,
    speed_candidates,
)
from autodb.explain.cuts.candidates.design import designed
from autodb.explain.cuts.candidates.laws import (
    Allowed,
    LawColumns,
    SmoothCurve,
    SpreadLaw,
    added,
    alike,
    along_edge,
    as_simulated,
    chip_factor,
    each,
    only,
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
from autodb.explain.cuts.stack import Stack
from autodb.explain.engine.candidates import UNKNOWN, Candidate, CandidateForm, product

Array = NDArray[np.float64]

BAR = 5.0
"""Evidence asked of a family of one variable beyond that of a named effect. Chosen."""
PAIR_BAR = 12.0
SINGLE, COARSE = 5, 3
MOST_PAIRED = 6
"""Variables that are paired at most."""
SIZE = "size"
"""What the coefficients of a plain law are called."""
CONFIRMED = 0.25
"""Share of its evidence by which squares of cuts left out fall with an effect, at least: with one
that is there they fall by about all of it. Chosen."""
CUTS_A_COLUMN = 3
"""Cuts that a table must have for each column of a shape. Chosen."""
BINS = 240
SHORTEST = 3
ALIKE = 0.3
"""Share of the strongest component's change that half of them at least have in other material."""
LONGEST = 0.6
"""Share of the cuts that a run may hold; a longer one is the usual state."""
FEWEST_TURNS, MOST_TURNS, STEP = 2.5, 100.0, 0.25
"""How often in the table something may come round, and how finely that is searched."""


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
    """Return the simulation's own columns: chip, edge and wear, free in each component."""
    known = stack.known
    one = values_of(np.ones(len(known)))
    own = {"shear": each(stack, chip_factor(stack, one))}
    has_edge = bool(stack.edge_N_mm.any()) if includes is None else "edge_force" in includes
    if has_edge:
        own["edge_force"] = each(stack, along_edge(stack))
    if includes is not None and "tool_wear" in includes and known.cutting_time_s is not None:
        even = per_depth(stack, values_of(known.cutting_time_s))
        own["tool_wear"] = each(stack, even if stack.wear is None else as_simulated(stack.worn))
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
    steps = [step_of_gain(stack, left, i, number) for i in range(len(stack.names))]
    several = steps if len(steps) > 1 else []
    return [_with_plain_forms(one) for one in (*several, *found) if one is not None]


def named_effects(stack: Stack, own: frozenset[str]) -> list[Candidate]:
    """Return the named effects that a table can show; ``own``: terms that are re-tuned."""
    found = [
        *edge_force_candidates(stack, own), *size_candidates(stack), *speed_candidates(stack),
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


@dataclass(frozen=True)
class Over:
    """A variable that something may come round in, by name, and how it is read (n,)."""

    name: str
    of: Callable[[Stack], Array]


ROUND = (Over("cut", lambda stack: stack.row), Over("t", lambda stack: stack.known.t_s))


def run_of_cuts(stack: Stack, left: Array, number: int) -> Candidate | None:
    """Return the run in which a factor on all forces explains most of what a fit leaves (C, n)."""
    n = len(stack.known)
    weight = stack.mixing.T @ stack.mixing
    force, rest = stack.simulation / stack.sd, left / stack.sd
    cross = np.concatenate([[0.0], np.cumsum(np.sum(force * (weight @ rest), axis=0))])
    power = np.concatenate([[0.0], np.cumsum(np.sum(force * (weight @ force), axis=0))])
    if n < 2 * SHORTEST:
        return None
    start, end = _strongest_run(cross, power)
    return hard_spot_of_cuts(stack, start, end, number, tries=min(n, BINS))


def hard_spot_of_cuts(stack: Stack, start: int, end: int, number: int, *, tries: int) -> Candidate:
    """Return the candidate of harder or softer material in the rows from start to before end.

    In cuts that follow the table it goes on where it reached the table's end.
    """
    cuts = stack.frame.known.number
    shape = {"first": float(cuts[start]), "last": float(cuts[end - 1])}
    inside, hump, ends = _courses(stack, start, end)
    made = [
        spread(stack, make(stack, values_of(course)))
        for course, make in ((inside, relative), (hump, relative), (inside, chip_factor))
        for spread in (alike, each)
    ]
    forms = tuple(CandidateForm(c, shape, tries=tries, allowed=_on_all(c)) for c in made)
    free = np.column_stack([inside, hump, ends])
    return Candidate(
        f"hard_spot {number}", "hard_spot", forms, ("cut",),
        detail=each(stack, relative(stack, values_of(free), 3)),
        interval=(shape["first"], shape["last"]),
        anew=lambda other: hard_spot_of_cuts(other, start, end, number, tries=tries),
    )  # fmt: skip


def _courses(stack: Stack, start: int, end: int) -> tuple[Array, Array, Array]:
    """Return 1 inside a run, a hump over it, and 1 in its first and its last cut, (n,) each."""
    row, goes_on = stack.row, end == len(stack.frame.known)
    seen = (row >= start) & (row < end)
    hump = np.where(seen, np.sin(np.pi * (row - start + 0.5) / (end - start)), 0.0)
    ends = (row == start) | (row == end - 1)
    inside = seen | (goes_on & (row >= end))
    return inside.astype(np.float64), np.asarray(hump), ends.astype(np.float64)


def step_of_gain(stack: Stack, left: Array, component: int, number: int) -> Candidate:
    """Return the step of one component's factor that explains most of what a fit leaves (C, n)."""
    force = stack.simulation[component] / stack.sd[component]
    rest = left[component] / stack.sd[component]
    cross = np.concatenate([[0.0], np.cumsum(force * rest)])
    power = np.concatenate([[0.0], np.cumsum(force**2)])
    n = len(force)
    starts = np.arange(SHORTEST, n - SHORTEST + 1)
    start = int(starts[np.argmax(_fall(cross, power, starts, np.array(n)))])
    return gain_step(stack, component, start, number)


def gain_step(stack: Stack, component: int, start: int, number: int) -> Candidate:
    """Return the candidate of another factor on one component from a row of the table on."""
    t = stack.frame.known.t_s
    after = np.asarray(stack.row >= start, dtype=np.float64)
    columns = only(stack, relative(stack, values_of(after)), component)
    shape = {"at": float((t[start] - t[0]) / max(float(t[-1] - t[0]), 1e-300))}
    forms = (CandidateForm(columns, shape, tries=min(len(t), BINS)),)
    key = f"gain {stack.names[component]} {number}"
    return Candidate(
        key, "gain", forms, ("t",), anew=lambda other: gain_step(other, component, start, number)
    )


def _on_all(columns: LawColumns) -> Allowed:
    """Return whether a factor of each component goes the same way in most of them."""

    def allowed(coefficients: Array) -> bool:
        most = coefficients[np.argmax(np.abs(coefficients) * columns.strength)]
        return bool(np.median(coefficients / most) > ALIKE)

    return allowed


def _strongest_run(cross: Array, power: Array) -> tuple[int, int]:
    n = len(cross) - 1
    edges = np.unique(np.linspace(0, n, min(BINS, n) + 1).astype(np.intp))
    gains = _fall_in_run(cross, power, edges[:, None], edges[None, :])
    i, j = np.unravel_index(int(np.argmax(gains)), gains.shape)
    start, end = int(edges[i]), int(edges[j])
    reach = int(np.ceil(n / len(edges))) + 1
    for _ in range(3):
        starts = np.arange(max(0, start - reach), min(end - SHORTEST, start + reach) + 1)
        start = int(starts[np.argmax(_fall_in_run(cross, power, starts, np.array(end)))])
        ends = np.arange(max(start + SHORTEST, end - reach), min(n, end + reach) + 1)
        end = int(ends[np.argmax(_fall_in_run(cross, power, np.array(start), ends))])
    return start, end


def _fall_in_run(
    cross: Array, power: Array, start: NDArray[np.intp], end: NDArray[np.intp]
) -> Array:
    """Return the fall of the sum of squares by a factor in a run that is one; −∞ for others."""
    n, span = len(cross) - 1, end - start
    outside = (span < SHORTEST) | (span > LONGEST * n)
    return np.asarray(np.where(outside, -np.inf, _fall(cross, power, start, end)))


def _fall(cross: Array, power: Array, start: NDArray[np.intp], end: NDArray[np.intp]) -> Array:
    """Return the fall of the sum of squares by a factor from start to end, all forces free too."""
    inside = power[end] - power[start]
    rest = np.maximum(inside * (1.0 - inside / power[-1]), 1e-9 * power[-1])
    return np.asarray((cross[end] - cross[start]) ** 2 / rest)


def comes_round(stack: Stack, left: Array, over: Over, number: int) -> Candidate | None:
    """Return the factor on all forces that is periodic in a variable and explains most."""
    n, values = len(stack.known), over.of(stack)
    if n < 24:
        return None
    force, rest = stack.simulation / stack.sd, left / stack.sd
    cross, power = np.sum(force * rest, axis=0), np.sum(force**2, axis=0)
    span = float(np.ptp(values))
    best, found, design = 0.0, 0.0, designed(stack)
    turn = 2j * np.pi * (values - values.min()) / span
    wave, step = np.exp(FEWEST_TURNS * turn), np.exp(STEP * turn)
    for count in np.arange(FEWEST_TURNS, min(MOST_TURNS, n / 2.5), STEP):
        waves = np.stack([wave.real, wave.imag])
        inner = (waves * power) @ waves.T
        right = waves @ cross
        gain = float(right @ np.linalg.solve(inner + 1e-9 * np.trace(inner) * np.eye(2), right))
        if gain > best and not design.holds(waves.T):
            best, found = gain, float(count)
        wave *= step
    return periodic(stack, over, found, number) if best else None


def periodic(stack: Stack, over: Over, turns: float, number: int) -> Candidate:
    """Return the candidate of a factor that comes round so many times in the table."""
    seen = over.of(stack.frame)
    span = float(np.ptp(seen))
    angle = 2.0 * np.pi * turns * (over.of(stack) - seen.min()) / span
    law = relative(stack, values_of(np.column_stack([np.cos(angle), np.sin(angle)])), 2)
    shape = {"period": span / turns}
    forms = tuple(CandidateForm(s(stack, law), shape, tries=len(seen)) for s in (alike, each))
    key = f"unknown periodic {over.name} {number}"
    return Candidate(
        key, UNKNOWN, forms, (over.name,), bar=BAR,
        anew=lambda other: periodic(other, over, turns, number),
    )  # fmt: skip
