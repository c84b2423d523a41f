"""What a simulation's terms add to it beside those that it is always read off with."""

from collections.abc import Collection, Mapping

import numpy as np
from numpy.typing import NDArray

from autodb.explain.axis.read_off import READ_OFF, READ_WELL, ROWS
from autodb.fitting.projection import NotConverged
from autodb.signals.waves import strongest_wave
from autodb.terms.channel import ChannelPart, channel_columns, linear_parameters, parts_over
from autodb.terms.fit import fit_parts
from autodb.terms.term import Channel, Contribution, Factor, Term
from autodb.terms.vocabulary import terms_on

Array = NDArray[np.float64]

RIPPLES, STEPS = 32, 3
"""Ripples over position at most, and Newton's steps for all periods after each. Chosen."""
FEWEST_WAVES = 1.0
"""Waves over the travel, of a ripple that a constant and a slope cannot be taken for."""
RIPPLED = 0.9
"""Share of a simulation that its ripples and other terms give at least: motion may be known
roughly. Chosen."""
TAKEN = 0.02
"""Share of what is left that one more ripple takes at least. Chosen: six times 2 ln(1000) / 4000,
what the strongest of a thousand takes of white noise in 4000 rows."""


def included_parts(
    simulation: Array, inputs: Mapping[str, Array], channel: Channel, includes: Collection[str]
) -> dict[str, Array]:
    """Return what each included term adds to a simulation (n,), by its name, (n,) each.

    All of them are fitted to the simulation together, with their shape. None where one of them has
    no law that can be (a shape without starts, earlier rows that it remembers), or where together
    they give less than READ_WELL of the simulation.
    """
    laws = [term for name, term in terms_on(channel).items() if name in includes]
    if READ_OFF.issuperset(t.name for t in laws) or not all(map(_can_be_fitted, laws)):
        return {}
    parts = [part for term in laws for part in _parts(term, inputs)]
    if not linear_parameters(parts):
        return {}
    rows = slice(None, None, max(1, len(simulation) // ROWS))
    seen = {name: values[rows] for name, values in inputs.items()}
    right = simulation[rows]
    try:
        fit = fit_parts(parts, seen, right, sd=np.ones_like(right))
    except NotConverged:
        return {}
    left = right - channel_columns(fit.parts, seen) @ fit.linear
    if np.sum(left**2) > (1.0 - READ_WELL) * np.sum(right**2):
        return {}
    return _shares(fit.parts, fit.linear, inputs)


def _can_be_fitted(term: Term) -> bool:
    adds = isinstance(term, Contribution | Factor) and not term.remembers
    return adds and all(p.starts or p.given for p in term.shape)


def _parts(term: Term, inputs: Mapping[str, Array]) -> list[ChannelPart]:
    """Return a term's parts where a search begins; a place that is given in the travel's middle."""
    low, high = float(inputs["position"].min()), float(inputs["position"].max())
    start = {p.name: p.starts[0] if p.starts else 0.5 * (low + high) for p in term.shape}
    free = tuple(p.name for p in term.shape if not p.given)
    return parts_over(term, inputs, start, free)


def _shares(
    parts: Collection[ChannelPart], linear: Array, inputs: Mapping[str, Array]
) -> dict[str, Array]:
    """Return what each term adds: contributions alone, then what each factor changes in turn."""
    adding = [part for part in parts if isinstance(part.term, Contribution)]
    columns = channel_columns(adding, inputs) * linear
    found: dict[str, Array] = {}
    for number, (part, _) in enumerate(linear_parameters(adding)):
        found[part.term.name] = found.get(part.term.name, 0.0) + columns[:, number]
    before, model = columns.sum(axis=1), list(adding)
    for part in parts:
        if isinstance(part.term, Factor):
            model.append(part)
            now = channel_columns(model, inputs) @ linear
            found[part.term.name], before = now - before, now
    return {name: added for name, added in found.items() if name not in READ_OFF}


def ripples_over_position(
    simulation: Array, position: Array, others: Mapping[str, Array]
) -> Array | None:
    """Return the sum of sines over position, (n,), that a simulation (n,) has beside ``others``.

    ``others``: columns (n,) of its further terms, with any coefficients, beside a constant. A
    simulation has no noise, so that one sine after the other is taken, the strongest first, the
    periods of all tuned together. None where they and the others give less than RIPPLED of it.
    """
    rows = slice(None, None, max(1, len(simulation) // ROWS))
    right, place = simulation[rows], position[rows]
    base = np.column_stack([np.ones_like(right), *(column[rows] for column in others.values())])
    whole, turns = float(np.sum(right**2)), np.zeros(0)
    left = right - base @ np.linalg.lstsq(base, right, rcond=None)[0]
    for _ in range(RIPPLES):
        found = strongest_wave(place, left, np.ones_like, fewest=FEWEST_WAVES)
        if found is None:
            return None
        more = np.append(turns, 2.0 * np.pi * found[0] / np.ptp(place))
        now = _tuned_turns(more, place, base, right)
        if np.sum(now[2] ** 2) >= (1.0 - TAKEN) * np.sum(left**2):
            break
        turns, sizes, left = now
    if not len(turns) or np.sum(left**2) > (1.0 - RIPPLED) * whole:
        return None
    return np.asarray(_sines(turns, position) @ sizes)


def _tuned_turns(
    turns: Array, place: Array, base: Array, right: Array
) -> tuple[Array, Array, Array]:
    """Return angular frequencies (r,) over position after Newton's steps, the sines' coefficients
    (2r,) and what is left (n,).
    """
    best = _with_sines(turns, place, base, right)
    for _ in range(STEPS):
        sizes, left = best
        cosine, sine = np.split(sizes, 2)
        angle = np.outer(place, turns)
        slopes = (place - place.mean())[:, None] * (sine * np.cos(angle) - cosine * np.sin(angle))
        columns = np.column_stack([base, _sines(turns, place), slopes])
        moved = turns + np.linalg.lstsq(columns, left, rcond=None)[0][-len(turns) :]
        now = _with_sines(moved, place, base, right)
        if np.sum(now[1] ** 2) >= np.sum(left**2):
            break
        turns, best = moved, now
    return turns, *best


def _with_sines(turns: Array, place: Array, base: Array, right: Array) -> tuple[Array, Array]:
    """Return the sines' coefficients beside the base, and what is left."""
    columns = np.column_stack([base, _sines(turns, place)])
    found = np.asarray(np.linalg.lstsq(columns, right, rcond=None)[0], dtype=np.float64)
    return found[base.shape[1] :], np.asarray(right - columns @ found)


def _sines(turns: Array, place: Array) -> Array:
    """Return cosines, then sines of each angular frequency (r,) over a place (n,): (n, 2r)."""
    angle = np.outer(place, turns)
    return np.concatenate([np.cos(angle), np.sin(angle)], axis=1)
