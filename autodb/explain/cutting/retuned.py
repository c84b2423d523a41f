"""The simulation's own terms that the recording contradicts."""

import numpy as np
from numpy.typing import NDArray

from autodb.explain.answer import Cause, Value
from autodb.explain.cutting.fit import Fit, all_columns, inner_products, norms
from autodb.explain.cutting.laws import Columns
from autodb.explain.cutting.profile import value
from autodb.explain.cutting.table import Stack
from autodb.explain.suspects import Choice
from autodb.fitting import NORMAL_95
from autodb.sensing.axis_model import term_called

Array = NDArray[np.float64]

WORTH = 6.0
"""Evidence above which a re-tuning is told, beyond ln n for each column. Chosen."""


def retuned(
    stack: Stack, own: dict[str, Columns], choices: tuple[Choice, ...], fitted: Fit, component: int
) -> list[Cause]:
    """Return the own terms of one component whose coefficient changes, each judged as a whole."""
    columns = all_columns(own, choices)
    inner = inner_products(stack, columns)
    causes = []
    for number, name in enumerate(own):
        at = fitted.places[number]
        change = _change(own[name], fitted, at, component)
        if change.low * change.high > 0 and _worth(inner, at, stack.simulation.size) > WORTH:
            causes.append(_cause(stack, name, own[name], change, component))
    return causes


def _change(columns: Columns, fitted: Fit, at: slice, component: int) -> Value:
    """Return the change of one component's coefficient."""
    place = at.start + _place(columns, component)
    sd = float(np.sqrt(max(fitted.covariance[place, place], 0.0)))
    return value(float(fitted.coefficients[place]), NORMAL_95 * sd, "")


def _place(columns: Columns, component: int) -> int:
    return component if columns.mix.shape[2] > 1 else 0


def _worth(inner: Array, at: slice, rows: int) -> float:
    """Return the evidence that the columns ``at`` are needed beside the others."""
    norm = norms(inner)
    right, inner = inner[1:, 0] / norm, inner[1:, 1:] / np.outer(norm, norm)
    kept = np.array([i for i in range(len(norm)) if not at.start <= i < at.stop], dtype=np.intp)
    full = right @ np.linalg.pinv(inner, rcond=1e-9, hermitian=True) @ right
    part = inner[np.ix_(kept, kept)]
    less = right[kept] @ np.linalg.pinv(part, rcond=1e-9, hermitian=True) @ right[kept]
    return float(full - less - (at.stop - at.start) * np.log(rows))


def _cause(stack: Stack, name: str, columns: Columns, change: Value, component: int) -> Cause:
    """Return the entry of an own term whose coefficient changes by ``change``."""
    term, sign = term_called(name), float(stack.sign[component])
    column = columns.raw()[component, :, _place(columns, component)]
    peak, half = float(np.max(np.abs(column))), change.high - change.value
    had, turned = 1.0, 1.0
    if name != "shear":
        turned = sign
        had = float(stack.edge_N_mm[component]) if name == "edge_force" else 0.0
    unit = term.parameters[0].unit.replace("U", "N")
    now = value(had + turned * change.value, half, unit)
    if name == "shear" and now.value < 0:
        text = "Recording and simulation have opposite signs: look at the sensor's sign first."
    else:
        text = term.statement
    return Cause(
        term=name,
        kind="mistuned",
        confidence=0.99,
        statement=(
            f"{text} The simulation has {term.parameters[0].name} {had:.3g}; the recording says "
            f"{now.value:.3g} ({now.low:.3g} to {now.high:.3g})."
        ),
        parameters={
            "size": value(abs(change.value) * peak, half * peak, "N"),
            term.parameters[0].name: now,
        },
    )
