"""Least squares with honest uncertainty: rank, covariance, priors, scores on what was left out."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


BLOCK_ROWS = 4096
"""Rows of a block of the factorisation: some hundred kilobytes at ten columns."""


@dataclass(frozen=True)
class Fit:
    """Coefficients (p,), covariance (p, p), residual (n,)."""

    coefficients: Array
    covariance: Array
    residual: Array

    @property
    def sd(self) -> Array:
        """Standard deviations of the coefficients, shape (p,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)), dtype=np.float64)


class Undetermined(ValueError):  # noqa: N818 - the data's state, not a program error
    """The data do not excite every column; ``columns`` are the indices that got no number."""

    def __init__(self, columns: list[int]) -> None:
        super().__init__(f"columns {columns} are not determined by the data")
        self.columns = columns


def least_squares(design: Array, values: Array, *, lags: int = 0) -> Fit:
    """Fit values (n,) = design (n, p) · coefficients by ordinary least squares.

    With ``lags`` > 0 the covariance is Newey and West's (Econometrica 55:703, 1987) with Bartlett
    weights up to that lag, right for residuals whose autocorrelation dies out by then; otherwise
    s² (XᵀX)⁻¹.

    Raises Undetermined, naming the columns, when the design is rank-deficient.
    """
    n, p = design.shape
    scale = np.linalg.norm(design, axis=0)
    empty = [int(i) for i in np.flatnonzero(scale == 0)]
    if empty:
        raise Undetermined(empty)
    triangle = _triangle(design, values, scale)
    u, s, vt = np.linalg.svd(triangle[:p, :p])
    weak = s < s[0] * 1e-9 * np.sqrt(n)
    if weak.any() or n <= p:
        share = np.abs(vt[weak] if weak.any() else vt[-1:]).max(axis=0)
        raise Undetermined([int(i) for i in np.flatnonzero(share > 0.1)])
    coefficients = (vt.T @ ((u.T @ triangle[:p, p]) / s)) / scale
    residual = values - design @ coefficients
    inverse = (vt.T / s**2) @ vt / np.outer(scale, scale)
    if lags > 0:
        meat = _newey_west(design * residual[:, None], lags)
        covariance = inverse @ meat @ inverse * (n / (n - p))
    else:
        covariance = inverse * float(residual @ residual) / (n - p)
    return Fit(coefficients, covariance, residual)


def _triangle(design: Array, values: Array, scale: Array) -> Array:
    """Return R (p + 1, p + 1) of the QR factors of [design / scale, values].

    Block by block, then of the blocks' triangles stacked (Demmel, Grigori, Hoemmen, Langou 2012,
    SIAM J. Sci. Comput. 34:A206, the sequential case): a block stays in the cache, and no second
    copy of the design is made.
    """
    p = design.shape[1]
    parts = [np.zeros((p + 1, p + 1))]  # fewer rows than columns still make a square
    for start in range(0, len(design), BLOCK_ROWS):
        rows = slice(start, start + BLOCK_ROWS)
        part = np.column_stack([design[rows] / scale, values[rows]])
        parts.append(np.asarray(np.linalg.qr(part, mode="r")))
    return np.asarray(np.linalg.qr(np.vstack(parts), mode="r"), dtype=np.float64)


def _newey_west(scores: Array, lags: int) -> Array:
    total = scores.T @ scores
    for lag in range(1, min(lags, len(scores) - 1) + 1):
        cross = scores[lag:].T @ scores[:-lag]
        total = total + (1.0 - lag / (lags + 1.0)) * (cross + cross.T)
    return np.asarray(total, dtype=np.float64)


def line(x: Array, y: Array) -> Fit:
    """Fit y = c0 + c1 x; coefficients are (c0, c1)."""
    return least_squares(np.column_stack([np.ones_like(x), x]), y)


def robust_line(x: Array, y: Array, *, rounds: int = 30) -> Array:
    """Return (c0, c1) of a line by Huber's weights at 1.345 robust standard deviations."""
    design = np.column_stack([np.ones_like(x), x])
    weights = np.ones_like(x)
    coefficients = np.zeros(2)
    for _ in range(rounds):
        root = np.sqrt(weights)
        coefficients = np.linalg.lstsq(design * root[:, None], y * root, rcond=None)[0]
        residual = y - design @ coefficients
        width = 1.345 * spread(residual)
        if width == 0:
            break
        weights = 1.0 / np.maximum(1.0, np.abs(residual) / width)
    return coefficients


def spread(values: Array) -> float:
    """Return the standard deviation that a normal sample of this median absolute deviation has."""
    return 1.4826 * float(np.median(np.abs(values - np.median(values))))


def leave_group_out(x: Array, y: Array, groups: NDArray[np.generic]) -> Array:
    """Return y − ŷ (n,) where ŷ comes from a line fitted without the row's own group."""
    errors = np.empty_like(y)
    for group in np.unique(groups):
        held = groups == group
        c0, c1 = line(x[~held], y[~held]).coefficients
        errors[held] = y[held] - (c0 + c1 * x[held])
    return errors


def r_squared(errors: Array, y: Array) -> float:
    """Return 1 − Σe²/Σ(y − ȳ)²; −inf when y does not vary."""
    total = float(np.sum((y - y.mean()) ** 2))
    return 1.0 - float(np.sum(errors**2)) / total if total > 0 else float("-inf")


def bootstrap_r_squared(
    errors: Array, y: Array, groups: NDArray[np.generic], *, draws: int = 4000, seed: int = 20
) -> tuple[float, float]:
    """Return the 95 % interval of R² over groups drawn with replacement (percentiles).

    Groups, not rows, are the independent units: rows of one tool share its errors.
    """
    rng = np.random.default_rng(seed)
    names = np.unique(groups)
    parts = np.array(
        [
            (np.sum(errors[groups == g] ** 2), np.sum(y[groups == g] ** 2),
             np.sum(y[groups == g]), np.sum(groups == g))
            for g in names
        ]
    )  # fmt: skip
    sums = parts[rng.integers(len(names), size=(draws, len(names)))].sum(axis=1)
    total = sums[:, 1] - sums[:, 2] ** 2 / sums[:, 3]
    with np.errstate(divide="ignore"):
        values = np.where(total > 0, 1.0 - sums[:, 0] / total, -np.inf)
    low, high = np.quantile(values, [0.025, 0.975], method="lower")
    return float(low), float(high)


@dataclass(frozen=True)
class Gaussian:
    """A normal belief about parameters: mean (p,), covariance (p, p)."""

    mean: Array
    covariance: Array


def update(prior: Gaussian, design: Array, values: Array, noise_sd: Array) -> Gaussian:
    """Return the posterior after values (n,) = design (n, p) · θ + noise of sd (n,), independent.

    Kalman form in p dimensions: Λ = Σ⁻¹ + XᵀWX, μ' = μ + Λ⁻¹ XᵀW (y − Xμ); cost linear in n.
    """
    weighted = design / noise_sd[:, None] ** 2
    precision = np.linalg.inv(prior.covariance) + design.T @ weighted
    covariance = np.linalg.inv(precision)
    mean = prior.mean + covariance @ (weighted.T @ (values - design @ prior.mean))
    return Gaussian(mean, 0.5 * (covariance + covariance.T))
