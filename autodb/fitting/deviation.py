"""Least squares where the law may deviate from the truth and the noise is coloured.

values = X·β + Σ_g Z_g·u_g + e, e an autoregression, u_g ~ N(0, τ_g²): the deviation columns Z_g
(smooth shapes that the law leaves out) get as much freedom as the data show that they need. The
variances τ_g² are found by restricted maximum likelihood (Patterson and Thompson 1971, Biometrika
58:545), β and u by Henderson's mixed-model equations (1975, Biometrics 31:423), e by the residual
of the saturated fit. Coefficients whose law is right are then as sharp as the noise allows, the
others as wide as the deviation makes them.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats
from scipy.linalg.lapack import dpotrf, dpotrs
from scipy.optimize import minimize
from scipy.signal import lfilter

from autodb.fitting.covariance import autoregression
from autodb.fitting.linear import triangle

Array = NDArray[np.float64]

LOG_RATIO = (-20.0, 25.0)
"""Range of ln(τ²/σ²): from no freedom to as much as the data can use."""
RIDGE = 1e-10
"""Added to the scaled inner products: a direction that no row shows gets the value 0 and a variance
10¹⁰ times that of a column seen whole, instead of no answer at all."""
SURE = 0.999
"""Blocks widen the covariance where chance would make them differ so much in 1 case of 1000."""


@dataclass(frozen=True)
class Deviating:
    """β then u (p + m,), their covariance (p + m, p + m), and the first p of both.

    ``sds`` (groups,): τ_g; ``whitener`` (order,): the autoregression of the noise;
    ``inflation`` (p,): how much wider the blocks of motion made each of the first p coefficients.
    """

    whole: Array
    whole_covariance: Array
    columns: int
    sds: Array
    whitener: Array
    inflation: Array

    @property
    def coefficients(self) -> Array:
        """β, (p,)."""
        return self.whole[: self.columns]

    @property
    def covariance(self) -> Array:
        """Covariance of β, (p, p)."""
        return self.whole_covariance[: self.columns, : self.columns]


@dataclass(frozen=True)
class _Equations:
    """Inner products of the white columns, scaled: Gᵀ·(β, u) = right."""

    gram: Array
    right: Array
    total: float
    scale: Array
    rows: int
    columns: int
    group: NDArray[np.intp]


def least_squares_with_deviation(
    design: Array,
    deviations: Sequence[Array],
    values: Array,
    *,
    blocks: NDArray[np.intp],
    order: int = 10,
) -> Deviating:
    """Fit values (n,) = design (n, p) · β + deviations (n, m_g) · u + coloured noise.

    ``blocks`` (n,): contiguous blocks of motion, 0 … G − 1. Where leaving them out one by one moves
    β by more than the model expects (beyond the 99.9 % point of χ²/(G − 1)), the covariance is
    widened to what the blocks show: the model misses something that differs between them. It is
    scaled so that ± 1.96 sd are 95 % of Student's t with G − 1 degrees of freedom: how noise and
    deviation vary is not known better than the blocks tell.
    """
    matrix = np.column_stack([design, *deviations])
    group = np.repeat(np.arange(len(deviations)), [z.shape[1] for z in deviations])
    whitener = _noise(matrix, values, order)
    white = _whitened(np.column_stack([matrix, values]), whitener)
    equations = _equations(white, design.shape[1], group)
    ratios = _variances(equations, len(deviations))
    whole, covariance, variance = _henderson(equations, ratios)
    inflation = _inflation(white, blocks[order:], equations, ratios, covariance)
    full = np.concatenate([inflation, np.ones(len(whole) - len(inflation))])
    full *= _few_blocks(int(blocks.max()) + 1)
    return Deviating(
        whole,
        covariance * np.outer(full, full),
        design.shape[1],
        np.sqrt(np.exp(ratios) * variance),
        whitener,
        inflation,
    )


def _noise(matrix: Array, values: Array, order: int) -> Array:
    reduced = triangle(matrix, values)
    k = reduced.columns
    found = np.linalg.lstsq(reduced.factor[:, :k], reduced.factor[:, k], rcond=1e-10)[0]
    residual = values - matrix @ (found / reduced.scale)
    return autoregression(residual, order)[0]


def _whitened(columns: Array, a: Array) -> Array:
    taps = np.concatenate([[1.0], -a])
    return np.asarray(lfilter(taps, [1.0], columns, axis=0)[len(a) :], dtype=np.float64)


def _equations(white: Array, columns: int, group: NDArray[np.intp]) -> _Equations:
    scale = np.sqrt(np.einsum("ij,ij->j", white[:, :-1], white[:, :-1]))
    scale = np.where(scale == 0, 1.0, scale)
    gram = white[:, :-1].T @ white[:, :-1] / np.outer(scale, scale)
    right = white[:, :-1].T @ white[:, -1] / scale
    total = float(white[:, -1] @ white[:, -1])
    return _Equations(gram, right, total, scale, len(white), columns, group)


def _ridge(equations: _Equations, log_ratios: Array) -> Array:
    """Return what τ² adds to the diagonal (p + m,), in scaled columns."""
    p = equations.columns
    u = np.exp(-log_ratios)[equations.group] / equations.scale[p:] ** 2
    return np.concatenate([np.full(p, RIDGE), u + RIDGE])


def _restricted_likelihood(equations: _Equations, log_ratios: Array) -> float:
    """Return −2 ln of the restricted likelihood, up to a constant, σ² profiled out."""
    p, free = equations.columns, equations.rows - equations.columns
    ridge = _ridge(equations, log_ratios)
    factor, failed = dpotrf(equations.gram + np.diag(ridge), clean=False)
    if failed:
        raise np.linalg.LinAlgError(f"the equations' minor {failed} is not positive definite")
    rss = equations.total - float(equations.right @ dpotrs(factor, equations.right)[0])
    determinant = 2.0 * float(np.sum(np.log(np.diag(factor))))
    determinant += 2.0 * float(np.sum(np.log(equations.scale[p:])))
    determinant += float(np.sum(log_ratios[equations.group]))
    return free * float(np.log(max(rss, 1e-300))) + determinant


def _variances(equations: _Equations, groups: int) -> Array:
    """Return ln(τ_g²/σ²) that make the restricted likelihood largest, from two starts."""
    if groups == 0:
        return np.empty(0)

    def misfit(log_ratios: NDArray[np.float64]) -> float:
        return _restricted_likelihood(equations, np.clip(log_ratios, *LOG_RATIO))

    found = [
        minimize(misfit, np.array([start] * groups), method="Nelder-Mead", tol=0.01)
        for start in (0.0, 8.0)
    ]
    best = min(found, key=lambda r: float(r.fun))
    return np.asarray(np.clip(best.x, *LOG_RATIO), dtype=np.float64)


def _henderson(equations: _Equations, log_ratios: Array) -> tuple[Array, Array, float]:
    """Return β and u, their covariance, and σ²."""
    matrix = equations.gram + np.diag(_ridge(equations, log_ratios))
    inverse = np.linalg.inv(matrix)
    scaled = inverse @ equations.right
    rss = equations.total - float(equations.right @ scaled)
    variance = max(rss, 0.0) / (equations.rows - equations.columns)
    scale = equations.scale
    return scaled / scale, inverse * variance / np.outer(scale, scale), variance


def _inflation(
    white: Array,
    blocks: NDArray[np.intp],
    equations: _Equations,
    log_ratios: Array,
    covariance: Array,
) -> Array:
    """Return how much wider (p,) leaving out blocks shows the coefficients to be, at least 1."""
    p = equations.columns
    edges = np.searchsorted(blocks, np.arange(blocks[0], blocks[-1] + 2))
    count = len(edges) - 1
    ridge = np.diag(_ridge(equations, log_ratios))
    left = np.empty((count, p))
    for g in range(count):
        part = white[edges[g] : edges[g + 1]]
        columns = part[:, :-1] / equations.scale
        gram = equations.gram - columns.T @ columns + ridge
        right = equations.right - columns.T @ part[:, -1]
        left[g] = np.linalg.lstsq(gram, right, rcond=1e-12)[0][:p] / equations.scale[:p]
    shown = (count - 1) / count * np.sum((left - left.mean(axis=0)) ** 2, axis=0)
    ratio = shown / np.diag(covariance)[:p]
    limit = stats.chi2.ppf(SURE, count - 1) / (count - 1)
    return np.where(ratio > limit, np.sqrt(np.maximum(ratio, 1.0)), 1.0)


def _few_blocks(count: int) -> float:
    """Return how much wider 1.96 sd must be when variances come from ``count`` blocks of motion.

    Student's t over the normal, at 97.5 %.
    """
    return float(stats.t.ppf(0.975, count - 1) / stats.norm.ppf(0.975))
