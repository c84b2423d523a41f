"""The simulation's own terms that the recording contradicts."""

from collections.abc import Collection, Mapping
from functools import partial

import numpy as np

from autodb.explain.answer.answer import Cause, IntervalValue
from autodb.explain.cuts.candidates.laws import LawColumns
from autodb.explain.cuts.cut_search import FoundInCuts
from autodb.explain.cuts.fit import CutsFit, profiled_value
from autodb.explain.engine.confidence import Mistuned, Standing, of_mistuned
from autodb.explain.engine.entries import own_term_entries
from autodb.fitting import NORMAL_95
from autodb.terms.vocabulary import term_called


def mistuned_of_cuts(result: FoundInCuts) -> dict[str, Mistuned]:
    """Return how sure it is of each own term that it is off, in all components together."""
    return {name: _judged(result, [name]) for name in result.own}


def _judged(result: FoundInCuts, names: Collection[str]) -> Mistuned:
    places, first = list[int](), 0
    for name, columns in result.own.items():
        after = first + columns.mix.shape[2]
        places += range(first, after) if name in names else ()
        first = after
    return of_mistuned(result.search, result.found, places)


def retuned_of_cuts(
    result: FoundInCuts,
    own: Mapping[str, Mistuned],
    fitted: CutsFit,
    component: int,
    *,
    beside: Collection[Cause],
) -> list[Cause]:
    """Return the own terms of one component whose coefficient changes, as ``mistuned_of_cuts``.

    ``beside``: what else is said of the component.
    """
    causes = {}
    for number, (name, columns) in enumerate(result.own.items()):
        change = _change(columns, fitted, fitted.places[number], component)
        if change.low * change.high > 0:
            causes[name] = _cause(result, name, change, component, own[name].standing)
    return own_term_entries(own, causes, beside=beside, jointly=partial(_judged, result))


def _change(columns: LawColumns, fitted: CutsFit, at: slice, component: int) -> IntervalValue:
    """Return the change of one component's coefficient."""
    place = at.start + _place(columns, component)
    sd = float(np.sqrt(max(fitted.covariance[place, place], 0.0)))
    return profiled_value(float(fitted.coefficients[place]), NORMAL_95 * sd, "")


def _place(columns: LawColumns, component: int) -> int:
    return component if columns.mix.shape[2] > 1 else 0


def _cause(
    result: FoundInCuts, name: str, change: IntervalValue, component: int, sure: Standing
) -> Cause:
    """Return the entry of an own term whose coefficient changes by ``change``."""
    stack, columns = result.stack, result.own[name]
    term, sign = term_called(name), float(stack.sign[component])
    column = columns.raw()[component, :, _place(columns, component)]
    peak, half = float(np.max(np.abs(column))), change.high - change.value
    had, turned = 1.0, 1.0
    if name != "shear":
        turned = sign
        had = float(stack.edge_N_mm[component]) if name == "edge_force" else 0.0
    unit = term.parameters[0].unit.replace("U", "N")
    now = profiled_value(had + turned * change.value, half, unit)
    if name == "shear" and now.value < 0:
        text = "Recording and simulation have opposite signs; check the sensor's sign first."
    else:
        text = term.statement
    return Cause(
        term=name,
        kind="mistuned",
        confidence=sure.confidence,
        statement=(
            f"{text} The simulation has {term.parameters[0].name} {had:.3g}; the recording says "
            f"{now.value:.3g} ({now.low:.3g} to {now.high:.3g})."
        ),
        parameters={
            "size": profiled_value(abs(change.value) * peak, half * peak, "N"),
            term.parameters[0].name: now,
        },
        alternatives=sure.near,
    )
