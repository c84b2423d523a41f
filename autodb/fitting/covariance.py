"""Covariance of least squares whose residuals are correlated in time, or whose model is not exact.

Ordinary least squares keeps its coefficients; what changes is the middle of
(XᵀX)⁻¹ · M · (XᵀX)⁻¹, M the covariance of Xᵀe.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CHUNK_ROWS = 1 << 16


def bartlett(design: Array, residual: Array, lags: int, *, root: Array | None = None) -> Array:
    """Return M (p, p) of Newey and West with Bartlett weights 1 − lag/(lags + 1).

    Computed as Σ_t S_t S_tᵀ / (lags + 1), S_t the sum of the scores x·e over a window of lags + 1
    rows at every place, ends included: the same number at a cost that does not grow with ``lags``.
    ``root`` (n,) weighs the rows of the design; ``residual`` (n,) is weighed already.
    """
    window = lags + 1
    n, p = design.shape
    total = np.zeros((p, p))
    for start in range(0, n + lags, CHUNK_ROWS):
        stop = min(start + CHUNK_ROWS, n + lags)
        first = max(0, start - lags)
        rows = slice(first, min(stop, n))
        scores = design[rows] * residual[rows, None]
        if root is not None:
            scores *= root[rows, None]
        sums = np.vstack([np.zeros((1, p)), np.cumsum(scores, axis=0)])
        ends = np.minimum(np.arange(start, stop) + 1, n) - first
        begins = np.maximum(np.arange(start, stop) + 1 - window, 0) - first
        moving = sums[ends] - sums[begins]
        total += moving.T @ moving
    return total / window


def autoregression(residual: Array, order: int) -> tuple[Array, float]:
    """Return (a (order,), innovation variance) of e_t = Σ a_k e_{t−k} + u_t, by least squares."""
    n = len(residual)
    lagged = np.array(
        [
            [float(residual[order - i : n - i] @ residual[order - j : n - j]) for j in _upto(order)]
            for i in _upto(order)
        ]
    )
    ridge = max(1e-12 * lagged[0, 0], 1e-300) * np.eye(order)
    a = np.linalg.solve(lagged[1:, 1:] + ridge, lagged[1:, 0])
    rest = lagged[0, 0] - float(a @ lagged[1:, 0])
    return np.asarray(a, dtype=np.float64), max(rest, 0.0) / (n - 2 * order)


def long_run_variance(residual: Array, *, order: int = 10) -> float:
    """Return n times the variance of the mean of n correlated rows: σ²_u / (1 − Σ a_k)²."""
    a, variance = autoregression(residual, order)
    return variance / (1.0 - float(a.sum())) ** 2


def given_one(covariance: Array, k: int) -> Array:
    """Return the covariance (p, p) given parameter k."""
    slope = covariance[:, k] / covariance[k, k]
    given = covariance - np.outer(slope, covariance[k])
    given[k], given[:, k] = 0.0, 0.0
    return given


def _upto(order: int) -> range:
    return range(order + 1)
