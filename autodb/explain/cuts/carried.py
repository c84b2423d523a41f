"""A table's cuts carried to other cuts that follow it, and what the effects found give there.

What the simulation would give there is read off the table: the chip's part of each component goes
with powers of depth, thickness and speed, and so does the length that its edge acts on. A power
that the table does not show is that of a chip: its area, whatever the speed.

Each effect goes on by the form that was fitted: wear by the cutting time of its edge, anew with an
edge that is changed (of an edge that was not seen, the mean of those that were), a drift along the
clock, a warm-up by what the machine does, a run of harder cuts if it reached the table's end. A
curve keeps its last value beyond what was seen.

Sizes that the table hardly holds would run away there, so that two things have a prior:
edges of one table wear alike but for a spread, and the simulation's own terms are nearly right.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.explain.cuts.candidates.laws import LawColumns
from autodb.explain.cuts.candidates.library import of_forces
from autodb.explain.cuts.cut_search import FoundInCuts
from autodb.explain.cuts.fit import CutsFit, fit_cuts
from autodb.explain.cuts.stack import Conditions, Stack, table_conditions
from autodb.explain.engine.candidates import Candidate, Choice
from autodb.explain.engine.telling import held_coefficients
from autodb.records.tables import CutTable
from autodb.wording import phrase

Array = NDArray[np.float64]

SHOWN = 1e-3
"""Share of the widest spread of depth, thickness or speed, in logarithms, that shows a power."""
ALIKE = 0.5
"""Standard deviation of an edge's rate of wear over the edges' mean. Chosen: lives of tools scatter
by so much, and a rate that a table holds is not moved by it."""
RETUNED = 0.1
"""Standard deviation of what a simulation's own terms are wrong by, a share of each. Chosen."""


@dataclass(frozen=True)
class Elsewhere:
    """Cuts that follow a table, with the effects that are built anew for them."""

    stack: Stack
    own: dict[str, LawColumns]
    candidates: dict[str, Candidate]

    def columns(self, choices: tuple[Choice, ...]) -> Array:
        """Return the columns (C, m, p) of own terms and of a set [N per coefficient]."""
        built = [self._law(choice).raw() for choice in choices]
        return np.concatenate([*(c.raw() for c in self.own.values()), *built], axis=2)

    def _law(self, choice: Choice) -> LawColumns:
        candidate = choice.candidate
        anew = (
            self.candidates[candidate.key] if candidate.anew is None else candidate.anew(self.stack)
        )
        law = anew.forms[choice.form].law
        assert isinstance(law, LawColumns)  # every candidate of a cut table is made of laws
        return law


@dataclass(frozen=True)
class CutsAccount:
    """A set of effects and own terms fitted to a table: what they give on other cuts.

    ``columns`` (C, m, p), ``coefficients`` (p,), ``root`` (p, p) with root·rootᵀ their covariance.
    """

    columns: Array
    coefficients: Array
    root: Array

    @property
    def force(self) -> Array:
        """What is added to the simulation, (C, m) [N]."""
        return np.asarray(self.columns @ self.coefficients)

    @property
    def free(self) -> Array:
        """What one standard deviation of each direction of the coefficients adds, (C, m, p)."""
        return np.asarray(self.columns @ self.root)


def fit_cuts_account(
    result: FoundInCuts, choices: tuple[Choice, ...], there: Elsewhere
) -> CutsAccount:
    """Fit a set to the table and carry it to other cuts; shapes are held."""
    here = Elsewhere(result.stack, result.own, {c.candidate.key: c.candidate for c in choices})
    built = [c.shape.law.raw() for c in choices if isinstance(c.shape.law, LawColumns)]
    raw = np.concatenate([*(c.raw() for c in here.own.values()), *built], axis=2)
    stack = result.stack
    coefficients, root = held_coefficients(stack.white(raw), stack.difference, variance=1.0)
    return CutsAccount(there.columns(choices), coefficients, root)


def elsewhere(result: FoundInCuts, known: Conditions, row: int) -> Elsewhere:
    """Return cuts that follow a table, like the cut in a row of it but for their conditions."""
    return _built(result, _stack(result.stack, known, row))


def following(result: FoundInCuts, known: Conditions, simulation: Array) -> Elsewhere:
    """Return cuts that follow a table and whose simulation (C, m) [N] is given."""
    table = result.stack
    length = _scaled(table.edge_mm, table.known, known, 0, area=False)
    return _built(result, _with(table, known, simulation, length))


def _built(result: FoundInCuts, stack: Stack) -> Elsewhere:
    library = of_forces(list(result.own))
    made = {candidate.key: candidate for candidate in library.candidates(stack)}
    return Elsewhere(stack, library.own(stack), made)


def _stack(table: Stack, known: Conditions, row: int) -> Stack:
    chip = _scaled(table.chip, table.known, known, row, area=True)
    length = _scaled(table.edge_mm, table.known, known, row, area=False)
    worn = np.zeros_like(chip) if table.wear is None else table.wear.force(known)
    return _with(table, known, chip + table.edge_N_mm[:, None] * length + worn, length)


def _with(table: Stack, known: Conditions, simulation: Array, length: Array) -> Stack:
    """Return other cuts than a table's, by their simulation and what of the edge acts (C, m)."""
    return replace(
        table, known=known, recording=simulation, simulation=simulation, edge_mm=length,
        sd=_scatter(table, simulation), like=table,
    )  # fmt: skip


def _logs(known: Conditions) -> Array:
    """Return the logarithms of depth, thickness and speed (n, 3), 0 for what is not known."""
    zero = np.zeros(len(known))
    thickness, speed = known.thickness_mm, known.speed_m_min
    return np.column_stack(
        [
            np.log(known.depth_mm),
            zero if thickness is None else np.log(thickness),
            zero if speed is None else np.log(speed),
        ]
    )


def _scaled(values: Array, seen: Conditions, known: Conditions, row: int, *, area: bool) -> Array:
    """Return values (C, n) of a table on other cuts (C, m), by powers from the cut in a row."""
    logs, usual = _logs(seen), np.array([1.0, float(area), 0.0])
    step = _logs(known) - logs[row]
    made = np.empty((len(values), len(known)))
    for i, force in enumerate(values):
        there = force != 0
        rise = logs[there] - logs[there].mean(axis=0)
        rest = np.log(np.abs(force[there])) - logs[there] @ usual
        powers = np.linalg.lstsq(rise, rest - rest.mean(), rcond=SHOWN)[0]
        made[i] = force[row] * np.exp(step @ (usual + powers))
    return made


def _scatter(table: Stack, simulation: Array) -> Array:
    """Return the scatter (C, m) of other forces: sd² = a² + b²F² as in the table."""
    made = np.empty_like(simulation)
    for i, force in enumerate(table.simulation**2):
        low, high = int(np.argmin(force)), int(np.argmax(force))
        variance, spread = table.sd[i] ** 2, max(float(force[high] - force[low]), 1e-300)
        slope = max(0.0, float(variance[high] - variance[low]) / spread)
        made[i] = np.sqrt(np.maximum(variance[low] + slope * (simulation[i] ** 2 - force[low]),
                                     variance.min()))  # fmt: skip
    return made


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
    for (name, columns), at in zip(result.own.items(), found.places, strict=False):
        if columns.sd is not None:  # held in the fit
            continue
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
            raise UnusableInput(
                phrase(
                    "{file}: no {name} of the simulation; it was there before",
                    file=table.path,
                    name=name,
                )
            )
    lacking = sorted(seen.recorded - known.recorded)
    if lacking:
        raise UnusableInput(
            phrase(
                "{file}: no '{lacking}' in every cut; the cuts before it have it",
                file=table.path,
                lacking=lacking[0],
            )
        )
