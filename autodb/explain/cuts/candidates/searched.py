"""Effects of a table of cuts that are searched for in what a fit leaves.

A run of cuts in other material, a component whose sensor changes or comes back, and what comes
round again: by cumulative sums over bins of cuts, each edge of a run then refined cut by cut
between its neighbours.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.explain.cuts.candidates.laws import (
    Allowed,
    LawColumns,
    added,
    alike,
    chip_factor,
    each,
    only,
    relative,
    values_of,
)
from autodb.explain.cuts.stack import Stack, designed
from autodb.explain.engine.candidates import UNKNOWN, Candidate, CandidateForm

Array = NDArray[np.float64]

BAR = 5.0
"""Evidence asked of a family of one variable beyond that of a named effect. Chosen."""
BINS = 240
SHORTEST = 3
ALIKE = 0.3
"""Share of the strongest component's change that half of them at least have in other material."""
LONGEST = 0.6
"""Share of the cuts that a run may hold; a longer one is the usual state."""
FEWEST_OF_A_RUN, LONGEST_OF_ONE = 12, 0.3
"""Cuts of a table at least in which a component's factor may come and go, and the share of them in
which it may: a longer run is found where it drifts. Chosen."""
FEWEST_TURNS, MOST_TURNS, STEP = 2.5, 100.0, 0.25
"""How often in the table something may come round, and how finely that is searched."""


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


def steps_of_gain(stack: Stack, left: Array, component: int, number: int) -> list[Candidate]:
    """Return the step of one component's factor that explains most of what a fit leaves (C, n), and
    the run in which it is another one and comes back: a plug that was loose, say.
    """
    n = len(stack.known)
    cross, power = _summed(stack, stack.simulation[component], left[component], component)
    found = [gain_step(stack, component, _strongest_step(cross, power), number)]
    if n >= FEWEST_OF_A_RUN:
        run = _strongest_run(cross, power, longest=LONGEST_OF_ONE)
        found.append(gain_run(stack, component, *run, number))
    return found


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


def step_of_zero(stack: Stack, left: Array, component: int, number: int) -> Candidate:
    """Return the step of one component's zero point that explains most of what a fit leaves (C, n):
    an amplifier that was reset, say. Where forces differ, a factor is no such step.
    """
    ones = np.ones(len(stack.known))
    cross, power = _summed(stack, ones, left[component], component)
    return zero_step(stack, component, _strongest_step(cross, power), number)


def zero_step(stack: Stack, component: int, start: int, number: int) -> Candidate:
    """Return the candidate of another zero point of one component from a row of the table on."""
    t = stack.frame.known.t_s
    after = np.asarray(stack.row >= start, dtype=np.float64)
    columns = only(stack, added(stack, values_of(after)), component)
    shape = {"at": float((t[start] - t[0]) / max(float(t[-1] - t[0]), 1e-300))}
    forms = (CandidateForm(columns, shape, tries=min(len(t), BINS)),)
    return Candidate(
        f"sensor_drift {stack.names[component]} at once {number}", "sensor_drift", forms, ("t",),
        anew=lambda other: zero_step(other, component, start, number),
    )  # fmt: skip


def _summed(stack: Stack, shape: Array, left: Array, component: int) -> tuple[Array, Array]:
    """Return the sums up to each row of a component's shape (n,) times what a fit leaves (n,) and
    of its squares, each over the scatter, (n + 1,).
    """
    scaled, rest = shape / stack.sd[component], left / stack.sd[component]
    products = (scaled * rest, scaled**2)
    cross, power = (np.concatenate([[0.0], np.cumsum(values)]) for values in products)
    return cross, power


def _strongest_step(cross: Array, power: Array) -> int:
    n = len(cross) - 1
    starts = np.arange(SHORTEST, n - SHORTEST + 1)
    return int(starts[np.argmax(_fall(cross, power, starts, np.array(n)))])


def gain_run(stack: Stack, component: int, start: int, end: int, number: int) -> Candidate:
    """Return the candidate of another factor on one component in the rows from start to before end;
    in cuts that follow the table it has come back.
    """
    cuts = stack.frame.known.number
    inside = np.asarray((stack.row >= start) & (stack.row < end), dtype=np.float64)
    columns = only(stack, relative(stack, values_of(inside)), component)
    shape = {"first": float(cuts[start]), "last": float(cuts[end - 1])}
    forms = (CandidateForm(columns, shape, tries=min(len(cuts), BINS)),)
    return Candidate(
        f"gain {stack.names[component]} for a while {number}", "gain", forms, ("cut",),
        interval=(shape["first"], shape["last"]),
        anew=lambda other: gain_run(other, component, start, end, number),
    )  # fmt: skip


def _on_all(columns: LawColumns) -> Allowed:
    """Return whether a factor of each component goes the same way in most of them."""

    def allowed(coefficients: Array) -> bool:
        most = coefficients[np.argmax(np.abs(coefficients) * columns.strength)]
        return bool(np.median(coefficients * np.sign(most)) > ALIKE * np.abs(most))

    return allowed


def _strongest_run(cross: Array, power: Array, *, longest: float = LONGEST) -> tuple[int, int]:
    n = len(cross) - 1
    edges = np.unique(np.linspace(0, n, min(BINS, n) + 1).astype(np.intp))
    gains = _fall_in_run(cross, power, edges[:, None], edges[None, :], longest)
    i, j = np.unravel_index(int(np.argmax(gains)), gains.shape)
    start, end = int(edges[i]), int(edges[j])
    reach = int(np.ceil(n / len(edges))) + 1
    for _ in range(3):
        starts = np.arange(max(0, start - reach), min(end - SHORTEST, start + reach) + 1)
        start = int(starts[np.argmax(_fall_in_run(cross, power, starts, np.array(end), longest))])
        ends = np.arange(max(start + SHORTEST, end - reach), min(n, end + reach) + 1)
        end = int(ends[np.argmax(_fall_in_run(cross, power, np.array(start), ends, longest))])
    return start, end


def _fall_in_run(
    cross: Array,
    power: Array,
    start: NDArray[np.intp],
    end: NDArray[np.intp],
    longest: float,
) -> Array:
    """Return the fall of the sum of squares by a factor in a run that is one; −∞ for others."""
    n, span = len(cross) - 1, end - start
    outside = (span < SHORTEST) | (span > longest * n)
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
