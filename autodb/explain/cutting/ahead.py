"""What the effects found in a table of cuts give in the cuts that come next.

Each goes on by the form that was fitted: wear by the cutting time of its edge, anew with an edge
that is changed (of an edge that was not seen, the mean of those that were), a drift along the clock,
a warm-up by what the machine does, a run of harder cuts if it reached the table's end. A curve keeps
its last value beyond what was seen.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.explain.cutting.carried import following
from autodb.explain.cutting.fit import fit
from autodb.explain.cutting.look import Looked
from autodb.explain.cutting.table import Conditions, conditions
from autodb.records import CutTable

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Ahead:
    """Forces expected in cuts that follow a table: ``force`` (C, m) and the sd of each [N].

    ``names`` of the components; ``sd`` is of scatter and of the fitted sizes, shapes held.
    """

    names: tuple[str, ...]
    force: Array
    sd: Array


def ahead(looked: Looked, table: CutTable, simulation: dict[str, Array]) -> Ahead:
    """Return what follows a table that was looked through: the simulation and what was found.

    ``table``: the conditions of the cuts that follow, in its columns as they were recorded before;
    ``simulation``: (m,) [N] of every component that was looked at. Where nothing was found it is
    the simulation as it is; else its own terms are re-tuned too, as in the corrected channel.

    Raises UnusableInput where a component or a condition is missing that was there before.
    """
    stack = looked.stack
    known = _same_edges(stack.known, conditions(table))
    _check(stack.names, stack.known, table, known, simulation)
    plain = np.stack([simulation[name] for name in stack.names])
    there = following(looked, known, plain)
    choices = looked.found.choices
    if not choices:
        return Ahead(stack.names, plain, there.stack.sd)
    found = fit(stack, looked.own, choices)
    columns = there.columns(choices)
    variance = np.einsum("cmp,pq,cmq->cm", columns, found.covariance, columns)
    sd = np.sqrt(there.stack.sd**2 + np.maximum(variance, 0.0))
    return Ahead(stack.names, plain + columns @ found.coefficients, sd)


def _same_edges(seen: Conditions, known: Conditions) -> Conditions:
    """Return conditions whose edges have the numbers that they had before, new ones further on."""
    if seen.edge is None or known.edge is None:
        return known
    number = {label: code for code, label in seen.edge_label.items()}
    for label in known.edge_label.values():
        number.setdefault(label, max(number.values()) + 1.0)
    edge = np.array([number[known.edge_label[float(code)]] for code in known.edge])
    return replace(known, edge=edge, edge_label={code: label for label, code in number.items()})


def _check(
    names: tuple[str, ...],
    seen: Conditions,
    table: CutTable,
    known: Conditions,
    simulation: dict[str, Array],
) -> None:
    for name in names:
        if name not in simulation:
            raise UnusableInput(f"{table.path}: no {name} of the simulation; it was there before")
    lacking = sorted(seen.recorded - known.recorded)
    if lacking:
        raise UnusableInput(
            f"{table.path}: no '{lacking[0]}' in every cut; the cuts before it have it"
        )
