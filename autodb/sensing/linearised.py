"""The shape of an axis' parts by variable projection, and the linear problem around it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb import fitting
from autodb.errors import UnusableInput
from autodb.sensing.prepared import Prepared
from autodb.terms import Contribution, Parameter
from autodb.terms.channel import Part, coefficients, columns, free_shape, reshaped

Array = NDArray[np.float64]


def shaped(rows: Prepared, parts: tuple[Part, ...]) -> tuple[Part, ...]:
    """Return the parts with their free shape parameters fitted by variable projection."""
    wanted = free_shape(parts)
    if not wanted:
        return parts
    problem = _problem(rows, parts, _design(rows, parts))
    start = np.array([part.shape[p.name] for part, p in wanted])
    for k, (_, parameter) in enumerate(wanted):
        if len(parameter.starts) > 1:
            tries = [np.where(np.arange(len(start)) == k, s, start) for s in parameter.starts]
            start = fitting.best_start(problem, tries)
    try:
        return reshaped(parts, fitting.separable(problem, start).shape)
    except fitting.NotConverged as error:
        names = ", ".join(f"{part.key} {p.name}" for part, p in wanted)
        raise UnusableInput(f"{rows.path}: {names}: {error}; fewer terms would work") from None


def _problem(rows: Prepared, parts: tuple[Part, ...], design: fitting.Design) -> fitting.Problem:
    wanted = free_shape(parts)
    linear = [p for _, p in coefficients(parts)]
    return fitting.Problem(
        design=design,
        values=rows.effort,
        typical=np.array([_typical(p, part.shape[p.name]) for part, p in wanted]),
        shape_bounds=_bounds([p for _, p in wanted]),
        bounds=_bounds(linear),
    )


def _bounds(parameters: Sequence[Parameter]) -> fitting.Bounds:
    return fitting.Bounds(
        np.array([p.lower for p in parameters]), np.array([p.upper for p in parameters])
    )


def _typical(parameter: Parameter, start: float) -> float:
    return max(abs(start), *(abs(s) for s in parameter.starts), 1e-6) * 1e-3


def _design(rows: Prepared, parts: tuple[Part, ...]) -> fitting.Design:
    """Return the reduced columns as a function of the free shape parameters.

    Contributions without a free shape are reduced once, unless a part modifies columns.
    """
    plain = all(isinstance(part.term, Contribution) for part in parts)
    fixed = [part for part in parts if plain and not part.free]
    kept = rows.reduced(columns(fixed, rows.inputs)) if fixed else None
    place = [part in fixed for part, _ in coefficients(parts)]

    def design(shape: Array) -> Array:
        now = reshaped(parts, shape)
        if kept is None:
            return rows.reduced(columns(now, rows.inputs))
        moving = [part for part in now if part.free]
        if not moving:
            return kept
        whole = np.empty((len(rows.effort), len(place)))
        whole[:, place] = kept
        whole[:, ~np.array(place)] = rows.reduced(columns(moving, rows.inputs))
        return whole

    return design


@dataclass(frozen=True)
class Linearised:
    """The problem around the fitted shape: every parameter enters by a column, (m, p + q).

    ``target`` (m,) is the effort with the shape's own part added, so that parameters come out as
    they are and not as changes; ``names``: part and parameter of each column.
    """

    columns: Array
    target: Array
    names: tuple[tuple[Part, Parameter], ...]

    @property
    def parts(self) -> tuple[Part, ...]:
        """The parts that the names are of."""
        return tuple({part.key: part for part, _ in self.names}.values())


def linearised(rows: Prepared, parts: tuple[Part, ...]) -> Linearised:
    wanted = free_shape(parts)
    design = _design(rows, parts)
    shape = np.array([part.shape[p.name] for part, p in wanted])
    base = design(shape)
    weights, _ = fitting.solve(fitting.triangle(base, rows.effort))
    slopes = fitting.slopes(_problem(rows, parts, design), shape, weights)
    names = (*coefficients(parts), *wanted)
    return Linearised(np.column_stack([base, slopes]), rows.effort + slopes @ shape, names)
