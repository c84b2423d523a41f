"""The shape of an axis' parts by variable projection, and the linear problem around it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.fitting.covariance import long_run_variance
from autodb.fitting.linear import solve, triangle
from autodb.fitting.projection import (
    Design,
    NotConverged,
    ProjectionProblem,
    best_start,
    separable,
    shape_slopes,
)
from autodb.sensing.drives.moves.prepared import Prepared
from autodb.terms.channel import (
    ChannelPart,
    channel_columns,
    free_shape,
    linear_parameters,
    reshaped,
)
from autodb.terms.fit import bounds_of, prior_of, shape_step
from autodb.terms.term import Contribution, TermParameter
from autodb.wording import phrase

Array = NDArray[np.float64]

SMALLEST_GAIN = 1e-9
"""Share of the sum of squares that a step must win: far below what a standard deviation would."""


def shaped(rows: Prepared, parts: tuple[ChannelPart, ...]) -> tuple[ChannelPart, ...]:
    """Return the parts with their free shape parameters fitted by variable projection."""
    wanted = free_shape(parts)
    if not wanted:
        return parts
    problem = _problem(rows, parts, _design(rows, parts), believed=True)
    start = np.array([part.shape[p.name] for part, p in wanted])
    for k, (_, parameter) in enumerate(wanted):
        if len(parameter.starts) > 1:
            tries = [np.where(np.arange(len(start)) == k, s, start) for s in parameter.starts]
            start = best_start(problem, tries)
    try:
        return reshaped(parts, separable(problem, start).shape)
    except NotConverged as error:
        names = ", ".join(f"{part.key} {p.name}" for part, p in wanted)
        raise UnusableInput(
            phrase(
                "{file}: {names}: {error}; use fewer terms",
                file=rows.path,
                names=names,
                error=error,
            )
        ) from None


def _problem(
    rows: Prepared, parts: tuple[ChannelPart, ...], design: Design, *, believed: bool
) -> ProjectionProblem:
    """Return the separable problem; ``believed``: with the priors of the parameters.

    Their weight against the rows is that of the residual's long-run variance, because the noise is
    correlated from row to row.
    """
    wanted = free_shape(parts)
    linear, free = [p for _, p in linear_parameters(parts)], [p for _, p in wanted]
    start = np.array([part.shape[p.name] for part, p in wanted])
    weights, noise = np.zeros(len(linear)), 1.0
    if believed:
        base = design(start)
        weights, _ = solve(triangle(base, rows.effort))
        noise = long_run_variance(rows.effort - base @ weights)
    return ProjectionProblem(
        design=design,
        values=rows.effort,
        typical=np.array([shape_step(p, s) for p, s in zip(free, start, strict=True)]),
        shape_bounds=bounds_of(free),
        bounds=bounds_of(linear),
        prior=prior_of(linear, weights, free, start) if believed else None,
        noise=noise,
        smallest_gain=SMALLEST_GAIN,
    )


def _design(rows: Prepared, parts: tuple[ChannelPart, ...]) -> Design:
    """Return the reduced columns as a function of the free shape parameters.

    Contributions without a free shape are reduced once, unless a part modifies columns.
    """
    plain = all(isinstance(part.term, Contribution) for part in parts)
    fixed = [part for part in parts if plain and not part.free]
    kept = rows.reduced(channel_columns(fixed, rows.inputs)) if fixed else None
    place = [part in fixed for part, _ in linear_parameters(parts)]

    def design(shape: Array) -> Array:
        now = reshaped(parts, shape)
        if kept is None:
            return rows.reduced(channel_columns(now, rows.inputs))
        moving = [part for part in now if part.free]
        if not moving:
            return kept
        whole = np.empty((len(rows.effort), len(place)))
        whole[:, place] = kept
        whole[:, ~np.array(place)] = rows.reduced(channel_columns(moving, rows.inputs))
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
    names: tuple[tuple[ChannelPart, TermParameter], ...]

    @property
    def parts(self) -> tuple[ChannelPart, ...]:
        """The parts that the names are of."""
        return tuple({part.key: part for part, _ in self.names}.values())


def linearised(rows: Prepared, parts: tuple[ChannelPart, ...]) -> Linearised:
    """Return the linear problem around the shape that the parts have."""
    wanted = free_shape(parts)
    design = _design(rows, parts)
    shape = np.array([part.shape[p.name] for part, p in wanted])
    base = design(shape)
    weights, _ = solve(triangle(base, rows.effort))
    slopes = shape_slopes(_problem(rows, parts, design, believed=False), shape, weights)
    names = (*linear_parameters(parts), *wanted)
    return Linearised(np.column_stack([base, slopes]), rows.effort + slopes @ shape, names)
