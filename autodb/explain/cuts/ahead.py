"""What the effects found in a table of cuts give in the cuts that come next.

Each goes on by the form that was fitted: wear by the cutting time of its edge, anew with an edge
that is changed (of an edge that was not seen, the mean of those that were), a drift along the
clock, a warm-up by what the machine does, a run of harder cuts if it reached the table's end. A
curve keeps its last value beyond what was seen.

Sizes that the table hardly holds would run away there, so that two things have a prior:
edges of one table wear alike but for a spread, and the simulation's own terms are nearly right.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.explain.cuts.carried import following
from autodb.explain.cuts.cut_search import FoundInCuts
from autodb.explain.cuts.fit import CutsFit, fit_cuts
from autodb.explain.cuts.stack import Conditions, table_conditions
from autodb.records import CutTable

Array = NDArray[np.float64]

ALIKE = 0.5
"""Standard deviation of an edge's rate of wear over the edges' mean. Chosen: lives of tools scatter
by so much, and a rate that a table holds is not moved by it."""
RETUNED = 0.1
"""Standard deviation of what a simulation's own terms are wrong by, a share of each. Chosen."""


@dataclass(frozen=True)
class Ahead:
    """Forces expected in cuts that follow a table: ``force`` (C, m) and the sd of each [N].

    ``names`` of the components; ``sd`` is of scatter and of the fitted sizes, shapes held.
    """

    names: tuple[str, ...]
    force: Array
    sd: Array


def ahead(result: FoundInCuts, table: CutTable, simulation: dict[str, Array]) -> Ahead:
    """Return what follows a table that was searched: the simulation and what was found.

    ``table``: the conditions of the cuts that follow, in its columns as they were recorded before;
    ``simulation``: (m,) [N] of every component that was searched. Where nothing was found it is
    the simulation as it is; else its own terms are re-tuned too, as in the corrected channel.

    Raises UnusableInput where a component or a condition is missing that was there before.
    """
    stack = result.stack
    known = _same_edges(stack.known, table_conditions(table))
    _check(stack.names, stack.known, table, known, simulation)
    plain = np.stack([simulation[name] for name in stack.names])
    there = following(result, known, plain)
    choices = result.found.choices
    if not choices:
        return Ahead(stack.names, plain, there.stack.sd)
    coefficients, covariance = _with_prior(result, fit_cuts(stack, result.own, choices))
    columns = there.columns(choices)
    variance = np.einsum("cmp,pq,cmq->cm", columns, covariance, columns)
    sd = np.sqrt(there.stack.sd**2 + np.maximum(variance, 0.0))
    return Ahead(stack.names, plain + columns @ coefficients, sd)


def _with_prior(result: FoundInCuts, found: CutsFit) -> tuple[Array, Array]:
    """Return coefficients (p,) and covariance (p, p) of a fit with these priors.

    With C the covariance of the fit and Λ the precision of the posterior, whose mean costs nothing:
    (1 + CΛ)⁻¹ of both.
    """
    precision = np.zeros_like(found.covariance)
    for name, at in zip(result.own, found.places, strict=False):
        size = _of_own(result, name, found.coefficients[at])
        precision[at, at] = np.diag(1.0 / (RETUNED * size) ** 2)
    places = found.places[len(result.own) :]
    for choice, at in zip(result.found.choices, places, strict=True):
        edges = int(choice.shape.shape.get("edges", 0))
        if edges > 1:
            precision[at, at] = _alike(found, at, edges)
    factor = np.eye(len(precision)) + found.covariance @ precision
    both = np.column_stack([found.coefficients, found.covariance])
    solved = np.asarray(np.linalg.solve(factor, both), dtype=np.float64)
    return solved[:, 0], solved[:, 1:]


def _of_own(result: FoundInCuts, name: str, coefficients: Array) -> Array:
    """Return the size of an own term whose coefficients are shares or, of an edge, N/mm."""
    if name != "edge_force":
        return np.ones_like(coefficients)
    size = np.abs(result.stack.edge_N_mm)
    return np.asarray(np.where(size > 0, size, float(size.max()) or 1.0))


def _alike(found: CutsFit, at: slice, edges: int) -> Array:
    """Return the precision of edges' rates around their mean, of every column of a rate's shape."""
    coefficients = found.coefficients[at].reshape(edges, -1)
    weight = 1.0 / np.maximum(np.diag(found.covariance)[at], 1e-300).reshape(edges, -1)
    mean = np.sum(weight * coefficients, axis=0) / np.sum(weight, axis=0)
    scale = 1.0 / np.maximum(ALIKE * np.abs(mean), 1e-12) ** 2
    apart = np.eye(edges) - 1.0 / edges
    return np.asarray(np.kron(apart, np.diag(scale)))


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
