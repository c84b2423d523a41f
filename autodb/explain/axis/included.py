"""What a simulation's terms add to it beside those that it is always read off with."""

from collections.abc import Collection, Mapping

import numpy as np
from numpy.typing import NDArray

from autodb.explain.axis.read_off import READ_OFF, READ_WELL, ROWS
from autodb.fitting import NotConverged
from autodb.terms import Channel, Contribution, Factor, Term
from autodb.terms.channel import ChannelPart, channel_columns, linear_parameters, parts_over
from autodb.terms.fit import fit_parts
from autodb.terms.vocabulary import terms_on

Array = NDArray[np.float64]


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
