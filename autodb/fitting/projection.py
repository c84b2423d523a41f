"""Variable projection: linear coefficients solved exactly at every value of the shape parameters.

values ≈ design(shape) · coefficients. The shape is searched by Levenberg and Marquardt on the
problem from which the coefficients are projected out (Golub and Pereyra 1973; Kaufman 1975 for the
Jacobian); each step needs one block QR of [design, derivatives, values], so memory is that of the
design and cost is linear in rows.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.gaussian import Gaussian
from autodb.fitting.linear import CoefficientBounds, Triangle, solve, triangle

Array = NDArray[np.float64]
Design = Callable[[Array], Array]

MOST_STEPS = 500
STEP = float(np.finfo(np.float64).eps) ** (1.0 / 3.0)
"""Relative step of a central difference that balances truncation and rounding."""
SMALLEST_MOVE = 1e-12
"""The search ends where no shape parameter moves by this share of its size."""


class NotConverged(ValueError):  # noqa: N818 - the data's state, not a program error
    """The search for the shape parameters did not settle."""


@dataclass(frozen=True)
class Separable:
    """Coefficients (p,), shape (q,), Jacobian (n, p + q), residual (n,), all as weighted.

    ``held``: indices of coefficients and of shape parameters (from p on) that sit at a bound.
    """

    coefficients: Array
    shape: Array
    jacobian: Array
    residual: Array
    held: tuple[int, ...]

    @property
    def rss(self) -> float:
        """Residual sum of squares."""
        return float(self.residual @ self.residual)


@dataclass(frozen=True)
class ProjectionProblem:
    """What is fitted: ``design`` gives (n, p) of a shape (q,); ``root`` (n,) weighs the rows.

    ``typical`` (q,): the size of change that matters in each shape parameter. ``prior``: a
    posterior about (coefficients, shape), in units in which a weighted row has variance ``noise``.
    The search ends where three steps in a row lower the sum of squares by less than
    ``smallest_gain`` of it.
    """

    design: Design
    values: Array
    typical: Array
    shape_bounds: CoefficientBounds
    bounds: CoefficientBounds | None = None
    root: Array | None = None
    prior: Gaussian | None = None
    noise: float = 1.0
    smallest_gain: float = 1e-14


@dataclass(frozen=True)
class _Point:
    """A place in the search: everything that was computed there."""

    shape: Array
    design: Array
    reduced: Triangle
    coefficients: Array
    held: list[int]
    cost: float


def separable(problem: ProjectionProblem, start: Array) -> Separable:
    """Fit the coefficients and the shape from ``start`` (q,).

    Raises NotConverged after MOST_STEPS, or where the design is not finite at the start.
    """
    here = _point(problem, start)
    if here is None:
        raise NotConverged(f"the design is not finite at shape {start.tolist()}")
    damping, idle = 1e-3, 0
    for _ in range(MOST_STEPS):
        if not len(start):
            break
        gradient = shape_slopes(problem, here.shape, here.coefficients)
        step = _step(problem, here, gradient, damping)
        there = _point(problem, here.shape + step)
        size = np.abs(step) / np.maximum(np.abs(here.shape), problem.typical)
        if there is not None and there.cost <= here.cost:
            idle = idle + 1 if here.cost - there.cost <= problem.smallest_gain * here.cost else 0
            here, damping = there, max(damping / 10.0, 1e-15)
        else:
            damping *= 10.0
        if np.all(size <= SMALLEST_MOVE) or idle >= 3 or damping > 1e12:
            break
    else:
        raise NotConverged(f"shape parameters did not settle within {MOST_STEPS} steps")
    return _result(problem, here)


def best_start(problem: ProjectionProblem, starts: list[Array]) -> Array:
    """Return the start at which the coefficients alone fit best."""

    def cost(shape: Array) -> float:
        point = _point(problem, shape)
        return np.inf if point is None else point.cost

    return min(starts, key=cost)


def _weighted(problem: ProjectionProblem, columns: Array) -> Array:
    return columns if problem.root is None else columns * problem.root[:, None]


def _point(problem: ProjectionProblem, shape: Array) -> _Point | None:
    """Return what is computed at a shape; None where the design is not finite."""
    shape = np.clip(shape, problem.shape_bounds.lower, problem.shape_bounds.upper)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        design = problem.design(shape)
    if not np.isfinite(design).all():
        return None
    reduced = _with_prior(problem, triangle(design, problem.values, problem.root), shape)
    coefficients, held = solve(reduced, problem.bounds)
    p = reduced.columns
    left = reduced.factor[:, p] - reduced.factor[:, :p] @ (coefficients * reduced.scale)
    return _Point(shape, design, reduced, coefficients, held, float(left @ left))


def _prior_rows(problem: ProjectionProblem) -> tuple[Array, Array]:
    """Return rows (k, p + q) and right sides (k,) of the prior."""
    assert problem.prior is not None
    values, vectors = np.linalg.eigh(problem.prior.covariance)
    rows = vectors.T * np.sqrt(problem.noise / values)[:, None]
    return rows, rows @ problem.prior.mean


def _with_prior(problem: ProjectionProblem, reduced: Triangle, shape: Array) -> Triangle:
    """Return the triangle with the prior's rows for coefficients at this shape."""
    if problem.prior is None:
        return reduced
    rows, right = _prior_rows(problem)
    p = reduced.columns
    more = np.column_stack([rows[:, :p] / reduced.scale, right - rows[:, p:] @ shape])
    factor = np.linalg.qr(np.vstack([reduced.factor, more]), mode="r")
    return Triangle(np.asarray(factor), reduced.scale, reduced.rows, ())


def shape_slopes(problem: ProjectionProblem, shape: Array, coefficients: Array) -> Array:
    """Return d(design · coefficients)/d shape, (n, q), by central differences."""
    found = np.empty((len(problem.values), len(shape)))
    for k in range(len(shape)):
        size = STEP * max(abs(float(shape[k])), float(problem.typical[k]))
        high, low = shape.copy(), shape.copy()
        high[k] = min(high[k] + size, problem.shape_bounds.upper[k])
        low[k] = max(low[k] - size, problem.shape_bounds.lower[k])
        change = (problem.design(high) - problem.design(low)) @ coefficients
        found[:, k] = change / (high[k] - low[k])
    return found


def _step(problem: ProjectionProblem, here: _Point, gradient: Array, damping: float) -> Array:
    """Return the damped step of the shape, with the free coefficients projected out."""
    p, q = len(here.coefficients), len(here.shape)
    free = [i for i in range(p) if i not in here.held]
    left = problem.values - here.design[:, here.held] @ here.coefficients[here.held]
    whole = triangle(np.column_stack([here.design[:, free], gradient]), left, problem.root)
    factor = whole.factor
    if problem.prior is not None:
        rows, right = _prior_rows(problem)
        right = right - rows[:, p:] @ here.shape - rows[:, here.held] @ here.coefficients[here.held]
        more = np.column_stack([rows[:, [*free, *range(p, p + q)]] / whole.scale, right])
        factor = np.asarray(np.linalg.qr(np.vstack([factor, more]), mode="r"))
    f = len(free)
    inner, right = factor[f : f + q, f : f + q], factor[f : f + q, f + q]
    blocked = _blocked(problem, here, inner.T @ right)
    inner = np.where(blocked[None, :], 0.0, inner)
    size = np.sqrt(np.sum(inner**2, axis=0))
    damped = np.vstack([inner, np.sqrt(damping) * np.diag(np.where(size > 0, size, 1.0))])
    move = np.linalg.lstsq(damped, np.concatenate([right, np.zeros(q)]), rcond=None)[0]
    return np.asarray(move / whole.scale[f:], dtype=np.float64)


def _blocked(problem: ProjectionProblem, here: _Point, downhill: Array) -> NDArray[np.bool_]:
    """Say which shape parameters sit at a bound and would go beyond it."""
    at_low = here.shape <= problem.shape_bounds.lower
    at_high = here.shape >= problem.shape_bounds.upper
    return (at_low & (downhill < 0)) | (at_high & (downhill > 0))


def _result(problem: ProjectionProblem, here: _Point) -> Separable:
    gradient = shape_slopes(problem, here.shape, here.coefficients)
    jacobian = np.column_stack([here.design, gradient])
    residual = problem.values - here.design @ here.coefficients
    edges = (here.shape <= problem.shape_bounds.lower) | (here.shape >= problem.shape_bounds.upper)
    p = len(here.coefficients)
    held = (*here.held, *(p + int(k) for k in np.flatnonzero(edges)))
    if problem.root is not None:
        residual = residual * problem.root
    return Separable(here.coefficients, here.shape, _weighted(problem, jacobian), residual, held)
