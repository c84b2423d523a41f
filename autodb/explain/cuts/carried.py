"""A table's cuts carried to other cuts that follow it: their simulation, their scatter, the laws.

What the simulation would give there is read off the table: the chip's part of each component goes
with powers of depth, thickness and speed, and so does the length that its edge acts on. A power
that the table does not show is that of a chip: its area, whatever the speed.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.explain.cuts.candidates.families import families, named_effects
from autodb.explain.cuts.candidates.laws import LawColumns
from autodb.explain.cuts.cut_search import FoundInCuts, own_columns_of_cuts
from autodb.explain.cuts.stack import Conditions, Stack
from autodb.explain.engine.candidates import Candidate, Choice
from autodb.explain.engine.telling import held_coefficients

Array = NDArray[np.float64]

SHOWN = 1e-3
"""Share of the widest spread of depth, thickness or speed, in logarithms, that shows a power."""


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
    made = [*named_effects(stack, frozenset(result.own)), *families(stack)]
    return Elsewhere(stack, own_columns_of_cuts(stack, list(result.own)), {s.key: s for s in made})


def _stack(table: Stack, known: Conditions, row: int) -> Stack:
    chip = _scaled(table.chip, table.known, known, row, area=True)
    length = _scaled(table.edge_mm, table.known, known, row, area=False)
    return _with(table, known, chip + table.edge_N_mm[:, None] * length, length)


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
