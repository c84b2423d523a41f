"""Fit what was found in a waveform again, where it is no small change of a law.

How far teeth stand out is fitted to the waveform as they cut, how far the depth is off slice by
slice, where a stretch of other material begins and ends by moving its ends. A chatter is one
vibration: each component feels it by its own share and phase, no more.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from autodb.explain.engine.candidates import Candidate, CandidateForm, Choice
from autodb.explain.engine.normal import solved
from autodb.explain.engine.search import FoundSet
from autodb.explain.waves.candidates import deeper, nudged
from autodb.explain.waves.fit import BesideWaves, WhitenedNoise, WhiteWaves, fit_waves
from autodb.explain.waves.scans import (
    BINS,
    LONGEST,
    SHORTEST,
    hard_spot_of_waves,
    harder_stretch,
)
from autodb.explain.waves.sensors import SENSING
from autodb.explain.waves.teeth import StandsOut, contrasts
from autodb.explain.waves.world import SimulatedWaves, form, on_each

Array = NDArray[np.float64]

ROWS = 3000
"""Rows of the middle of a cut that teeth are fitted to."""
MOVED = 0.2
"""Share of a stretch by which its ends are moved at first, either way; halved down to a bin."""
COST = 2.0
"""What a coefficient costs that is to predict: Akaike 1974."""
STILL = 0.02
"""Share by which teeth stand out otherwise, from which on their columns are built anew."""
SMALLEST_MM = 2e-4
SCALING = frozenset({"gain", "crosstalk"})
"""What scales or mixes the force that is sensed."""
SHARES_OF = frozenset({"hard_spot", "deflection"})
"""What is a share of the force that teeth make."""
ANOTHER_FORCE = 0.002
"""Share by which the force that is sensed is another, from which on columns are built anew.
Chosen."""
DEPTH = "depth_error"
REACH = 0.4
"""Share of the error that the search found by which it is looked for to either side."""
STEPS = 20


def seen_anew(
    world: SimulatedWaves, bench: WhiteWaves, found: FoundSet, quiet: WhitenedNoise
) -> tuple[SimulatedWaves, bool]:
    """Return the world as what was found has it, and whether its columns are others by now."""
    world, moved = _stood_out(world, bench, found)
    world, otherwise = with_sensed_force(world, bench, found.choices, quiet)
    moved |= otherwise
    if DEPTH not in found.keys:
        return replace(world, deeper_mm=None), moved or world.deeper_mm is not None
    error_mm = fitted_error(world, bench, found, quiet)
    before = world.deeper_mm or 0.0
    moved |= abs(error_mm - before) > STILL * abs(error_mm)
    return replace(world, deeper_mm=error_mm), moved


def with_sensed_force(
    world: SimulatedWaves, bench: WhiteWaves, choices: Sequence[Choice], quiet: WhitenedNoise
) -> tuple[SimulatedWaves, bool]:
    """Return the world with the force that is sensed as it was found, and whether it is another by
    now: a scale and crosstalk act on all of it, on what the simulation leaves out too, harder
    material and a mill that gives way on all that teeth make.
    """
    terms = [c.candidate.term for c in choices]
    if not SCALING & set(terms):
        still = replace(world, cutting=None, lacking=None, gained=None)
        return still, world.lacking is not None
    fit = fit_waves(bench, choices, quiet)
    none = np.zeros_like(bench.difference)
    parts = {term: none.copy() for term in (*SCALING, *SHARES_OF, "force")}
    for number, choice in enumerate(choices):
        term = choice.candidate.term
        if term in parts or choice.candidate.key.split(" ")[0] not in SENSING:
            parts[term if term in parts else "force"] += fit.part(number)
    cutting = fit.columns[..., : fit.own] @ fit.coefficients[: fit.own] + parts["force"]
    lacking = cutting + sum((parts[term] for term in SHARES_OF), start=none)
    before = none if world.lacking is None else world.lacking
    now = replace(world, cutting=cutting, lacking=lacking, gained=parts["gain"])
    moved = np.sum((lacking - before) ** 2) > ANOTHER_FORCE**2 * np.sum(now.sensed**2)
    return now, bool(moved)


def _stood_out(
    world: SimulatedWaves, bench: WhiteWaves, found: FoundSet
) -> tuple[SimulatedWaves, bool]:
    """Return the world with teeth standing out as found, and whether they do otherwise by now."""
    if "runout" not in found.keys:
        return replace(world, out=None), world.out is not None
    known = () if world.out is None else found.without("runout")
    columns = bench.chosen(known)
    out = fitted_out(world, bench.difference, columns)
    before = np.zeros(len(out.mm)) if world.out is None else np.array(world.out.mm)
    now = np.array(out.mm)
    moved = np.max(np.abs(now - before)) > STILL * max(float(np.max(np.abs(now))), SMALLEST_MM)
    return (replace(world, out=out), True) if moved else (world, False)


def fitted_out(world: SimulatedWaves, difference: Array, columns: Array) -> StandsOut:
    """Return how far teeth stand out, beside columns (C, n, p) that are free.

    Where a tooth cuts nothing, the next one finds its chip or, as simulations have it, does not:
    what fits better.
    """
    some, rows = _middle(world)
    target, free = difference[:, rows].ravel(), columns[:, rows].reshape(-1, columns.shape[-1])
    tried = [_fitted_teeth(some, target, free, missed=missed) for missed in (True, False)]
    return min(tried, key=lambda one: one[1])[0]


def _fitted_teeth(
    world: SimulatedWaves, target: Array, free: Array, *, missed: bool
) -> tuple[StandsOut, float]:
    """Return how far teeth stand out, and the sum of squares that is left."""
    teeth = world.waves.teeth
    z = teeth.mill.teeth
    shape = contrasts(z)
    base = teeth.forces(world.waves.law.whole)

    def out(values: Array) -> StandsOut:
        return StandsOut(tuple((shape @ values).tolist()), missed)

    def left(values: Array) -> Array:
        made = world.waves.seen(teeth.forces(world.waves.law.whole, out(values)) - base)
        rest = target - made.ravel()
        return np.asarray(rest - free @ solved(free, rest))

    def slopes(values: Array) -> Array:
        more = nudged(world, out(values)).reshape(-1, z) @ shape
        return np.asarray(free @ np.column_stack([solved(free, one) for one in more.T]) - more)

    start = np.zeros(z - 1) if world.out is None else shape.T @ np.array(world.out.mm)
    found = least_squares(left, start, jac=slopes, x_scale=teeth.mill.feed_mm, max_nfev=25)
    return out(found.x), float(2.0 * found.cost)


def _middle(world: SimulatedWaves) -> tuple[SimulatedWaves, NDArray[np.intp]]:
    """Return the world at ROWS rows in the middle of the work."""
    inside = np.flatnonzero(world.waves.teeth.engaged > 0.0)
    rows = inside[max(0, (len(inside) - ROWS) // 2) :][:ROWS]
    return world.at(rows), rows


def fitted_error(
    world: SimulatedWaves, bench: WhiteWaves, found: FoundSet, quiet: WhitenedNoise
) -> float:
    """Return the error of depth, mm, that fits best beside own terms and other effects.

    A simulation's slices come into the work one by one, so that what fits is rough over the error:
    it is tried step by step, then by finer steps about the best.
    """
    beside = BesideWaves(bench, found.without(DEPTH), quiet)
    choice = next(c for c in found.choices if c.candidate.key == DEPTH)
    about = float(beside.fitted(bench.columns(choice.key, choice.shape))[0][0])
    if "error" in choice.shape.shape:
        about = choice.shape.shape["error"]
    reach = REACH * about
    for _ in range(2):
        tried = about + reach * np.linspace(-1.0, 1.0, STEPS + 1)
        gains = [beside.gain(deeper(world, float(e))[:, :, None]) for e in tried]
        about, reach = float(tried[int(np.argmax(gains))]), 2.0 * reach / STEPS
    return about


def sharpened(
    world: SimulatedWaves, bench: WhiteWaves, found: FoundSet, quiet: WhitenedNoise
) -> dict[str, Candidate]:
    """Return the stretches that were found, by key, with the ends that explain most.

    A scan sees steps, in a grid; ends that rise slowly are elsewhere.
    """
    return {
        choice.candidate.key: _sharpened(world, BesideWaves(bench, others, quiet), choice)
        for choice in found.choices
        if choice.candidate.term == "hard_spot" and choice.candidate.interval is not None
        for others in [found.without(choice.candidate.key)]
    }


def _sharpened(world: SimulatedWaves, beside: BesideWaves, choice: Choice) -> Candidate:
    inside = world.waves.t_s[world.engaged > 0.0]
    whole = float(inside[-1] - inside[0])
    interval = choice.candidate.interval
    assert interval is not None
    start, end = interval
    best, reach = _stretch_gain(world, beside, start, end, choice.form), MOVED * (end - start)
    while reach > whole / BINS:
        tried = [
            (start + a * reach, end + b * reach) for a, b in product((-1, 0, 1), repeat=2) if a or b
        ]
        tried = [
            (a, b) for a, b in tried if SHORTEST * whole < b - a < LONGEST * whole
            and a >= inside[0] - reach and b <= inside[-1] + reach
        ]  # fmt: skip
        gains = [_stretch_gain(world, beside, a, b, choice.form) for a, b in tried]
        at = int(np.argmax(gains)) if gains else -1
        if at >= 0 and gains[at] > best:
            best, (start, end) = gains[at], tried[at]
        else:
            reach *= 0.5
    return hard_spot_of_waves(world, start, end, choice.candidate.key)


def _stretch_gain(
    world: SimulatedWaves, beside: BesideWaves, start_s: float, end_s: float, number: int
) -> float:
    return beside.gain(harder_stretch(world, start_s, end_s, number))


def as_one(
    world: SimulatedWaves, bench: WhiteWaves, found: FoundSet, quiet: WhitenedNoise
) -> tuple[Choice, ...]:
    """Return what was found, each chatter with one slow course of size and phase for all.

    A tone's slow courses a_j(t) in the components j are w_j e(t), w_j complex: the matrix of their
    coefficients is of rank one. Of the ladder's courses that one is taken that would predict best.
    """
    return tuple(
        _as_one(
            world,
            BesideWaves(bench, found.without(choice.candidate.key), quiet),
            bench,
            choice,
            quiet,
        )
        if choice.candidate.term == "chatter"
        else choice
        for choice in found.choices
    )


def _as_one(
    world: SimulatedWaves,
    beside: BesideWaves,
    bench: WhiteWaves,
    choice: Choice,
    quiet: WhitenedNoise,
) -> Choice:
    candidate, made = choice.candidate, []
    for number, shape in enumerate(candidate.forms):
        columns = bench.columns((candidate.key, number), shape)
        course = shared_course(columns, beside.fitted(columns)[0], np.array(quiet.sd))
        both = on_each(world, course)
        freedom = columns.shape[-1] // len(columns) + 2 * (len(columns) - 1)
        made.append((beside.gain(both) - COST * freedom, form(both, shape.shape)))
    return Choice(_steadied(candidate, max(made, key=lambda one: one[0])[1]), 0)


def _steadied(candidate: Candidate, shape: CandidateForm) -> Candidate:
    return Candidate(f"{candidate.key} as one", candidate.term, (shape,), candidate.variables)


def shared_course(columns: Array, coefficients: Array, sd: Array) -> Array:
    """Return the course that all components share, and the same a quarter turn on (n, 2).

    ``columns`` (C, n, C · 2 K) of cosines, then sines, by K slow functions, ``coefficients``
    (C · 2 K,) fitted to them, ``sd`` (C,) of white rows.
    """
    count = len(columns)
    cosine, sine = np.moveaxis(coefficients.reshape(count, 2, -1), 1, 0)
    slow = np.linalg.svd((cosine - 1j * sine) / sd[:, None])[2][0]
    mixed = np.block([[slow.real[:, None], slow.imag[:, None]],
                      [-slow.imag[:, None], slow.real[:, None]]])  # fmt: skip
    return np.asarray(columns[0, :, : 2 * len(slow)] @ mixed)
