"""What is known of the edge that a cut was made with: what its file states, or what was counted.

A person records an edge change (``autodb.agent.operate.changed_edges``). From it on the edge has a
name of its own, and how long it had cut before each cut is counted (``counted_edges``).
"""

from collections.abc import Mapping
from typing import Any

from sqlalchemy import ColumnElement, case

from autodb.pairs.engaged import CUTTING_TIME, EDGE
from autodb.store import models

Conditions = Mapping[str, Any]


def recorded_conditions(cut: models.Cut) -> Conditions:
    """Return the conditions of a cut, with the edge that a recorded change gave its tool."""
    change = cut.edge_change
    if change is None:
        return cut.conditions
    stated = {name: value for name, value in cut.conditions.items() if name != CUTTING_TIME}
    counted = {} if cut.edge_used_s is None else {CUTTING_TIME: cut.edge_used_s}
    return {**stated, EDGE: _called(change, _label(cut.conditions)), **counted}


def edge_label(cut: models.Cut) -> str | None:
    """Return what a cut's edge is called; None: nobody said."""
    return _label(recorded_conditions(cut))


def cut_before_s(cut: models.Cut) -> float | None:
    """Return for how long a cut's edge had cut before it, s; None: it is not known."""
    used = recorded_conditions(cut).get(CUTTING_TIME)
    return None if used is None else float(used)


def cut_before_column(cut: Any = models.Cut) -> ColumnElement[Any]:
    """Return what ``cut_before_s`` does as a column of a query of cuts."""
    stated = cut.conditions[CUTTING_TIME].as_float()
    return case((cut.edge_change_id.is_(None), stated), else_=cut.edge_used_s)


def _label(conditions: Conditions) -> str | None:
    label = conditions.get(EDGE)
    return label if label is None or isinstance(label, str) else f"{label:g}"


def _called(change: models.ChangedEdge, label: str | None) -> str:
    """Return the name of a changed edge: no other change has it."""
    return f"{label or ''} of {change.at[:10]} {change.at[11:16]} ({change.id})".lstrip()
