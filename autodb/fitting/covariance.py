"""Covariance of least squares whose residuals are correlated in time, or whose model is not exact.

Ordinary least squares keeps its coefficients; what changes is the middle of
(XᵀX)⁻¹ · M · (XᵀX)⁻¹, M the covariance of Xᵀe.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

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


def _upto(order: int) -> range:
    return range(order + 1)


def of_autoregression(design: Array, a: Array, variance: float) -> Array:
    """Return M (p, p) = Xᵀ Γ X for noise of an autoregression a (k,) with innovation variance.

    Γ = σ² A⁻¹ A⁻ᵀ with A the lower-banded matrix of 1 and −a: the columns run through 1/A
    backwards in time, and M is their product.
    """
    taps = np.concatenate([[1.0], -a])
    p = design.shape[1]
    filtered = np.empty_like(design)
    for i in range(p):
        filtered[:, i] = lfilter([1.0], taps, design[::-1, i])
    return np.asarray(variance * (filtered.T @ filtered), dtype=np.float64)


def jackknife(design: Array, values: Array, blocks: NDArray[np.intp]) -> Array:
    """Return the covariance (p, p) of the coefficients by leaving out one block after the other.

    ``blocks`` (n,): the block of each row, 0 … G − 1. (G − 1)/G Σ (β₋g − β̄)(β₋g − β̄)ᵀ
    (Quenouille, Tukey; conservative by Efron and Stein 1981): blocks that the model fits
    differently widen it, whatever the reason. Directions that a block alone determines make it
    large: minimum-norm solutions are used there.
    """
    count = int(blocks.max()) + 1
    scale = np.sqrt(np.einsum("ij,ij->j", design, design))
    order = np.argsort(blocks, kind="stable")
    edges = np.searchsorted(blocks[order], np.arange(count + 1))
    grams, rights = [], []
    for g in range(count):
        rows = order[edges[g] : edges[g + 1]]
        part = design[rows] / scale
        grams.append(part.T @ part)
        rights.append(part.T @ values[rows])
    whole, right = np.sum(grams, axis=0), np.sum(rights, axis=0)
    left = np.array(
        [
            np.linalg.lstsq(whole - g, right - r, rcond=1e-10)[0]
            for g, r in zip(grams, rights, strict=True)
        ]
    )
    off = (left - left.mean(axis=0)) / scale
    return np.asarray((count - 1) / count * (off.T @ off), dtype=np.float64)
