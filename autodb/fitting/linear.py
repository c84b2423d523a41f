"""Weighted, bounded linear least squares by block QR, with a rank check and robust weights."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr, solve_triangular

from autodb.fitting.covariance import bartlett

Array = NDArray[np.float64]

BLOCK_ROWS = 4096
"""Rows of a block of the factorisation: some hundred kilobytes at ten columns."""
RANK = 64.0 * float(np.finfo(np.float64).eps)
"""Singular values of scaled columns below RANK·√n of the largest hold rounding errors only.
NIST's Filip polynomial, which data in double precision do determine, has 2e-10."""
SMALLEST_NORM = 1e-150
"""A column smaller than this is empty: its square is no number to compute with."""
HUBER_ROUNDS = 50


@dataclass(frozen=True)
class LinearFit:
    """Coefficients (p,), covariance (p, p), residual (n,), indices of coefficients at a bound."""

    coefficients: Array
    covariance: Array
    residual: Array
    at_bound: tuple[int, ...] = ()

    @property
    def sd(self) -> Array:
        """Standard deviations of the coefficients, shape (p,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)), dtype=np.float64)


class Undetermined(ValueError):  # noqa: N818 - the data's state, not a program error
    """The data do not excite every column; ``columns`` are the indices that got no number."""

    def __init__(self, columns: list[int]) -> None:
        super().__init__(f"columns {columns} are not determined by the data")
        self.columns = columns


@dataclass(frozen=True)
class CoefficientBounds:
    """Lowest and highest value of each coefficient, (p,); ±inf where there is none."""

    lower: Array
    upper: Array

    def holds(self, values: Array) -> bool:
        """Say whether every value lies within."""
        return bool(np.all(values >= self.lower) and np.all(values <= self.upper))


@dataclass(frozen=True)
class Triangle:
    """R (k + 1, k + 1) of the QR factors of [design / scale, values], and the scale (k,).

    Everything that a least-squares fit needs of n rows; ``rows`` is their number.
    """

    factor: Array
    scale: Array
    rows: int
    empty: tuple[int, ...] = field(default=())

    @property
    def columns(self) -> int:
        """Number of columns of the design."""
        return len(self.scale)


def least_squares(
    design: Array,
    values: Array,
    *,
    weights: Array | None = None,
    bounds: CoefficientBounds | None = None,
    lags: int = 0,
) -> LinearFit:
    """Fit values (n,) = design (n, p) · coefficients by least squares, weighted and bounded.

    ``weights`` (n,): inverse variances up to a common factor. A coefficient at its bound is held
    there: its variance is 0 and the others' are those of the problem without it.

    With ``lags`` > 0 the covariance is Newey and West's (Econometrica 55:703, 1987) with Bartlett
    weights up to that lag, right for residuals whose autocorrelation dies out by then; otherwise
    s² (XᵀWX)⁻¹.

    Raises Undetermined, naming the columns, when the design is rank-deficient.
    """
    root = None if weights is None else np.sqrt(weights)
    reduced = triangle(design, values, root)
    check_rank(reduced)
    coefficients, held = solve(reduced, bounds)
    if not held:
        coefficients = coefficients + _correction(reduced, design, values, coefficients, weights)
    residual = values - design @ coefficients
    white = residual if root is None else residual * root
    free = [i for i in range(design.shape[1]) if i not in held]
    dof = len(design) - len(free)
    bread = inverse_gram(reduced, free)
    if lags > 0:
        covariance = bread @ bartlett(design, white, lags, root=root) @ bread * (len(design) / dof)
    else:
        covariance = bread * float(white @ white) / dof
    return LinearFit(coefficients, covariance, residual, tuple(held))


def triangle(design: Array, values: Array, root: Array | None = None) -> Triangle:
    """Return the triangle of [design (n, k), values (n,)], each row times ``root`` (n,).

    Block by block, then of the blocks' triangles stacked (Demmel, Grigori, Hoemmen, Langou 2012,
    SIAM J. Sci. Comput. 34:A206, the sequential case): a block stays in the cache, and no second
    copy of the design is made.
    """
    k = design.shape[1]
    weighed = design if root is None else design * root[:, None]
    scale = np.sqrt(np.einsum("ij,ij->j", weighed, weighed))
    empty = tuple(int(i) for i in np.flatnonzero(scale < SMALLEST_NORM))
    scale = np.where(scale < SMALLEST_NORM, 1.0, scale)
    parts = [np.zeros((k + 1, k + 1))]  # fewer rows than columns still make a square
    for start in range(0, len(design), BLOCK_ROWS):
        rows = slice(start, start + BLOCK_ROWS)
        part = np.empty((len(design[rows]), k + 1))
        np.divide(design[rows], scale, out=part[:, :k])
        part[:, empty] = 0.0
        part[:, k] = values[rows]
        if root is not None:
            part *= root[rows, None]
        parts.append(np.asarray(np.linalg.qr(part, mode="r")))
    return Triangle(np.asarray(np.linalg.qr(np.vstack(parts), mode="r")), scale, len(design), empty)


def check_rank(reduced: Triangle) -> None:
    """Raise Undetermined with the columns that the rows do not determine."""
    if reduced.empty:
        raise Undetermined(list(reduced.empty))
    p = reduced.columns
    _, s, vt = np.linalg.svd(reduced.factor[:p, :p])
    weak = s < s[0] * RANK * np.sqrt(reduced.rows)
    if weak.any() or reduced.rows <= p:
        share = np.abs(vt[weak] if weak.any() else vt[-1:]).max(axis=0)
        raise Undetermined([int(i) for i in np.flatnonzero(share > 0.1)])


def spanning(design: Array) -> list[int]:
    """Return indices of columns (n, p) that span what all of them span, none to spare."""
    reduced = triangle(design, np.zeros(len(design)))
    factor, order = qr(reduced.factor[:, : reduced.columns], mode="r", pivoting=True)
    size = np.abs(np.diag(factor))
    return sorted(int(i) for i in order[size > size[0] * RANK * np.sqrt(reduced.rows)])


def orthonormal_basis(columns: Array, *, least: float) -> Array:
    """Return orthonormal columns (n, k) that span what columns (n, p), of any size, span.

    Directions in which the columns, each over its norm, have less than ``least`` of what they have
    in their first are left out: k ≤ p.
    """
    norm = np.linalg.norm(columns, axis=0)
    basis, size, _ = np.linalg.svd(columns / np.where(norm > 0, norm, 1.0), full_matrices=False)
    return np.asarray(basis[:, size > least * size.max(initial=0.0)])


def solve(reduced: Triangle, bounds: CoefficientBounds | None = None) -> tuple[Array, list[int]]:
    """Return the coefficients (p,) and the indices of those held at a bound.

    Directions that the rows do not determine get nothing (the shortest solution).
    """
    p = reduced.columns
    inner, right = reduced.factor[:p, :p], reduced.factor[:p, p]
    u, s, vt = np.linalg.svd(inner)
    keep = s > s[0] * RANK * np.sqrt(reduced.rows)
    plain = (vt[keep].T @ ((u.T @ right)[keep] / s[keep])) / reduced.scale
    if bounds is None or bounds.holds(plain):
        return np.asarray(plain, dtype=np.float64), []
    from scipy.optimize import lsq_linear

    limits = (bounds.lower * reduced.scale, bounds.upper * reduced.scale)
    found = lsq_linear(inner, right, bounds=limits, method="bvls")
    return found.x / reduced.scale, [int(i) for i in np.flatnonzero(found.active_mask)]


def _correction(
    reduced: Triangle, design: Array, values: Array, coefficients: Array, weights: Array | None
) -> Array:
    """Return what one step of the corrected semi-normal equations adds (Björck 1987).

    RᵀR δ = Xᵀ W (y − Xb): rounding of the factorisation is taken out where residuals are large.
    """
    p = reduced.columns
    left = values - design @ coefficients
    score = design.T @ (left if weights is None else left * weights) / reduced.scale
    half = solve_triangular(reduced.factor[:p, :p], score, trans="T")
    return np.asarray(solve_triangular(reduced.factor[:p, :p], half) / reduced.scale)


def inverse_gram(reduced: Triangle, free: list[int]) -> Array:
    """Return (XᵀWX)⁻¹ of the columns ``free`` (p, p), zero for the others."""
    p = reduced.columns
    inverse = np.zeros((p, p))
    if not free:
        return inverse
    _, s, vt = np.linalg.svd(reduced.factor[:p, free], full_matrices=False)
    scale = reduced.scale[free]
    inverse[np.ix_(free, free)] = (vt.T / s**2) @ vt / np.outer(scale, scale)
    return inverse


def huber_weights(residual: Array, *, sds: float = 1.345) -> Array:
    """Return Huber's weights (n,): 1 within ``sds`` robust standard deviations, falling outside.

    1.345 keeps 95 % of the efficiency at normal noise (Huber 1981). All 1 where the spread is 0.
    """
    width = sds * spread(residual)
    if width == 0:
        return np.ones_like(residual)
    return np.asarray(1.0 / np.maximum(1.0, np.abs(residual) / width), dtype=np.float64)


def robust_least_squares(
    design: Array,
    values: Array,
    *,
    weights: Array | None = None,
    bounds: CoefficientBounds | None = None,
    lags: int = 0,
    sds: float = 1.345,
) -> LinearFit:
    """Fit as ``least_squares`` does, with rows far off counting less (Huber's loss, reweighted).

    Iterated until no coefficient moves by 1e-8 of its standard deviation. The covariance is that of
    the last weighted fit.
    """
    fit = least_squares(design, values, weights=weights, bounds=bounds, lags=lags)
    base = np.ones(len(values)) if weights is None else weights
    for _ in range(HUBER_ROUNDS):
        now = base * huber_weights(fit.residual * np.sqrt(base), sds=sds)
        new = least_squares(design, values, weights=now, bounds=bounds, lags=lags)
        moved = np.abs(new.coefficients - fit.coefficients)
        fit = new
        if np.all(moved <= 1e-8 * np.maximum(fit.sd, 1e-300)):
            break
    return fit


def spread(values: Array) -> float:
    """Return the standard deviation that a normal sample of this median absolute deviation has."""
    return 1.4826 * float(np.median(np.abs(values - np.median(values))))
