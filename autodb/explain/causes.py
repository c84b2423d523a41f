"""Accepted columns become causes: a name, its parameters with intervals, a sentence."""

import re

import numpy as np
from numpy.typing import NDArray

from autodb.explain import search
from autodb.explain.answer import Cause, Value
from autodb.explain.axis import NAMED, simulation_terms
from autodb.explain.fit import Estimate
from autodb.explain.noise import Whitener
from autodb.explain.state import State, gram_of
from autodb.sensing.axis_model import term_called
from autodb.terms import Term

Array = NDArray[np.float64]

ALIKE = {
    "position": ("spring", "cogging"),
    "direction × position": ("position_friction",),
    "time": ("sensor_drift",),
    "direction × time": ("warmup", "gain"),
    "speed": ("stribeck",),
    "direction × speed": ("asymmetry",),
    "way since reversal": ("presliding", "backlash"),
    "ripple": ("cogging", "position_friction"),
    "offset over cuts": ("sensor_drift",),
    "component": ("gain",),
    "run of cuts": ("hard_spot",),
    "cut number": ("sensor_drift", "tool_wear"),
}
"""Effects of the vocabulary that have such a shape: what an `unknown` could be."""
RETUNED = 0.01
"""Relative change of one of the simulation's own terms below which it is not called mistuned."""
SIMPLE_ENOUGH = 0.9
"""Simple causes come before rich ones when they explain this share of what the rich ones do."""
NORMAL_95 = 1.959964


def _value(value: float, sd: float, unit: str) -> Value:
    half = NORMAL_95 * sd
    return Value(value=value, low=value - half, high=value + half, unit=unit)


def plain_key(key: str) -> str:
    """Return a block's key without the number of its proposal.

    >>> plain_key("ripple 3")
    'ripple'
    """
    return re.sub(r" \d+$", "", key)


def named_cause(state: State, key: str, index: int, fitted: Estimate, unit: str) -> Cause:
    """Return the entry of a named block whose first coefficient is at ``index``."""
    block, term = state.blocks[key], term_called(state.blocks[key].term)
    value, sd = float(fitted.coefficients[index]), float(fitted.sd[index])
    peak = abs(value) * float(np.max(np.abs(block.columns[:, 0])))
    half = NORMAL_95 * sd * float(np.max(np.abs(block.columns[:, 0])))
    main = term.parameters[0]
    parameters = {
        "size": Value(value=peak, low=peak - half, high=peak + half, unit=unit),
        main.name: _value(value, sd, main.unit.replace("U", unit)),
    }
    if key in state.intervals:
        step_s = state.factor * float(np.median(np.diff(state.t_s)))
        for name, edge in zip(("start", "end"), state.intervals[key], strict=True):
            parameters[name] = _value(edge, step_s, "s")
    rivals, sure = _rivals(state, key)
    alternatives = tuple(dict.fromkeys([*term.alike, *rivals]))
    size = parameters["size"]
    return Cause(
        term=term.name,
        kind="missing",
        confidence=sure / (1 + len(term.alike)),
        statement=(
            f"{term.statement} The simulation leaves it out: {size.value:.3g} {unit} "
            f"({size.low:.3g} to {size.high:.3g})."
        ),
        parameters=parameters,
        alternatives=alternatives,
        variables=block.variables,
        to_tell_apart=_to_tell_apart(term) if alternatives else None,
    )


def _to_tell_apart(term: Term) -> str:
    return term.told_apart_by or f"Record {term.excited_by}."


def _rivals(state: State, key: str) -> tuple[tuple[str, ...], float]:
    """Return the terms nearly as good when ``key`` was chosen, and the probability of ``key``.

    A family that did better than a law because it holds the law and more is no rival of it.
    """
    at_choice = state.chosen[key]
    values = {
        k: v for k, v in at_choice.items() if v <= at_choice[key] or _name(state, k) != "unknown"
    }
    near = [k for k, v in values.items() if v > values[key] - search.MARGIN]
    names = {_name(state, k) for k in near} - {_name(state, key)}
    return tuple(sorted(names)), search.confidence(values, key)


def _name(state: State, key: str) -> str:
    """Return the term of a candidate, also of a stretch of load that was proposed and dropped."""
    if key in state.blocks:
        return state.blocks[key].term
    return "external_load" if key.startswith("external_load") else "unknown"


def unknown_cause(
    state: State, shapes: list[str], *, part: Array, share: float, unit: str
) -> Cause:
    """Return one entry for all families without a name; ``part`` (n,) is their contribution.

    ``share``: what they explain of the energy that the named and own terms leave.
    """
    keys = " and ".join(plain_key(key) for key in shapes)
    peak = float(np.quantile(np.abs(part), 0.999))
    alike = tuple(dict.fromkeys(a for k in shapes for a in ALIKE.get(plain_key(k), ())))
    variables = tuple(dict.fromkeys(v for k in shapes for v in state.blocks[k].variables))
    return Cause(
        term="unknown",
        kind="missing",
        confidence=max(search.confidence(state.chosen[k], k) for k in shapes),
        statement=(
            f"{100 * share:.0f} % of what the named terms leave depends on {keys}; no law that is "
            f"known here fits it. It reaches {peak:.3g} {unit}."
        ),
        parameters={"size": Value(value=peak, low=peak, high=peak, unit=unit)},
        alternatives=alike,
        variables=variables,
    )


def retuned(
    state: State, fitted: Estimate, simulation: Array, whitener: Whitener, unit: str
) -> list[Cause]:
    """Return the simulation's own terms whose coefficient the recording contradicts.

    A family without a name can imitate an own term and hide it, or hold what would otherwise be
    put down to it: the families are left out only where re-tuning does nearly all without them.
    """
    named = {name: state.own[name] for name in NAMED if name in state.own}
    if not named:
        return []
    have = simulation_terms(simulation, named)
    gram = gram_of(state, whitener, detail=False)
    alone, together = gram.columns(state.named()), gram.columns(state.active)
    retuning_does_it = gram.total - gram.rss(alone) > SIMPLE_ENOUGH * (
        gram.total - gram.rss(together)
    )
    base = alone if retuning_does_it else together
    full = gram.rss(base)
    first_own = len(fitted.coefficients) - state.own_matrix().shape[1]
    threshold = np.log(gram.rows) + 2 * np.log(len(state.blocks)) + search.MARGIN
    causes: list[Cause] = []
    for position, name in enumerate(state.own):
        if name not in named:
            continue
        change = float(fitted.coefficients[first_own + position])
        worth = gram.rows * np.log(gram.rss([c for c in base if c != position]) / full)
        if worth < threshold or abs(change) < RETUNED * abs(have.get(name, 0.0)):
            continue
        new = _value(have.get(name, 0.0) + change, float(fitted.sd[first_own + position]), "")
        peak = float(np.max(np.abs(named[name])))
        causes.append(_mistuned(name, have.get(name, 0.0), new, peak, unit))
    return causes


def _mistuned(name: str, have: float, new: Value, peak: float, unit: str) -> Cause:
    """Return the entry of a term that the simulation has with another coefficient."""
    main = term_called(name).parameters[0]
    unit_of = main.unit.replace("U", unit)
    now = new.model_copy(update={"unit": unit_of})
    half = (new.high - new.value) * peak
    size = abs(new.value - have) * peak
    return Cause(
        term=name,
        kind="mistuned",
        confidence=0.99,
        statement=(
            f"The simulation has {name} with {main.name} {have:.4g} {unit_of}; the recording says "
            f"{now.value:.4g} ({now.low:.4g} to {now.high:.4g})."
        ),
        parameters={
            "size": Value(value=size, low=size - half, high=size + half, unit=unit),
            main.name: now,
        },
    )
