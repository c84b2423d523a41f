"""Several sensors of one force become one answer: the best linear unbiased one of what they told.

Each tells a force and its standard deviation at every row, NaN where it does not sense. Where the
force was known, it was learnt by how much a sensor is off in the mean (bias), by what factor its
standard deviations are too small or large, and how far errors of several go together (correlation
R). With D = diag(factor · sd) of a row, C = D R D and the answer is

    F = Σ w_i (F_i − b_i),  w = C⁻¹1 / (1ᵀC⁻¹1),  var F = 1 / (1ᵀC⁻¹1)

so that a sensor that is not sure of a row, or says what another says, counts less there; none
counts against itself (w ≥ 0).
Source: Aitken 1935 (generalised least squares).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.fitting import NORMAL_95

Array = NDArray[np.float64]

ROWS = 200
"""Rows of each recording that are learnt from: it counts alike, however long it is."""
SHRUNK = 0.05
"""Share by which correlations are drawn to none: few recordings tell them. Chosen."""


@dataclass(frozen=True)
class Heard:
    """What sensors told of one recording's force: values and sds (n, k) N; NaN: not sensed."""

    value_N: Array
    sd_N: Array


@dataclass(frozen=True)
class Fusion:
    """How sensors (k,) of one component are put together; ``wider``: the factor on the answer's sd
    that makes 95 % hold.
    """

    names: tuple[str, ...]
    bias_N: Array
    factor: Array
    correlation: Array
    wider: float


@dataclass(frozen=True)
class Fused:
    """Force and its sd (n,) N, and by what weight each sensor (n, k) made it; NaN: none senses."""

    value_N: Array
    sd_N: Array
    weight: Array


def learn(names: Sequence[str], heard: Sequence[Heard], known_N: Sequence[Array]) -> Fusion:
    """Return how sensors go together, from recordings whose force (n,) N was known.

    Rows at which not all of them sense tell nothing of how they go together.
    """
    picked = [_picked(one, known) for one, known in zip(heard, known_N, strict=True)]
    off = np.concatenate([off for off, _ in picked])
    sd = np.concatenate([sd for _, sd in picked])
    bias = off.mean(axis=0)
    share = (off - bias) / sd
    factor = np.sqrt(np.mean(share**2, axis=0))
    share = share / factor
    correlation = (1.0 - SHRUNK) * (share.T @ share) / len(share)
    np.fill_diagonal(correlation, 1.0)
    begun = Fusion(tuple(names), bias, factor, correlation, 1.0)
    ratios = []
    for one, known in zip(heard, known_N, strict=True):
        made = fuse(begun, one)
        sensed = np.isfinite(made.value_N)
        off_N = np.abs(made.value_N - known)[sensed] / made.sd_N[sensed]
        ratios.append(np.quantile(off_N, np.linspace(0.005, 0.995, 100)))
    wider = float(np.quantile(np.concatenate(ratios), 0.95) / NORMAL_95)
    return Fusion(tuple(names), bias, factor, correlation, wider)


def _picked(heard: Heard, known_N: Array) -> tuple[Array, Array]:
    """Return errors and sds of some rows at which all sense."""
    all_ = np.flatnonzero(np.isfinite(heard.value_N).all(axis=1))
    rows = all_[np.linspace(0, len(all_) - 1, min(ROWS, len(all_))).astype(np.intp)]
    return heard.value_N[rows] - known_N[rows, None], heard.sd_N[rows]


def fuse(fusion: Fusion, heard: Heard) -> Fused:
    """Return the one answer of a recording."""
    count, sensors = heard.value_N.shape
    value, sd = np.full(count, np.nan), np.full(count, np.nan)
    weight = np.zeros((count, sensors))
    senses = np.isfinite(heard.value_N) & np.isfinite(heard.sd_N)
    for pattern in np.unique(senses, axis=0):
        kept = np.flatnonzero(pattern)
        if not len(kept):
            continue
        rows = np.flatnonzero((senses == pattern).all(axis=1))
        made = _put_together(fusion, heard, rows, kept)
        value[rows], sd[rows] = made[0], fusion.wider * made[1]
        weight[np.ix_(rows, kept)] = made[2]
    return Fused(value, sd, weight)


def _put_together(
    fusion: Fusion, heard: Heard, rows: NDArray[np.intp], kept: NDArray[np.intp]
) -> tuple[Array, Array, Array]:
    """Return value and sd (r,) and weights (r, k) of rows at which the same sensors sense."""
    at = np.ix_(rows, kept)
    sd = fusion.factor[kept] * heard.sd_N[at]
    correlation = fusion.correlation[np.ix_(kept, kept)]
    covariance = sd[:, :, None] * correlation * sd[:, None, :]
    one = np.linalg.solve(covariance, np.ones((len(rows), len(kept), 1)))[..., 0]
    weight = np.maximum(one, 0.0)  # what is told is not extrapolated
    weight /= weight.sum(axis=1, keepdims=True)
    value = np.sum(weight * (heard.value_N[at] - fusion.bias_N[kept]), axis=1)
    variance = np.einsum("ri,rij,rj->r", weight, covariance, weight)
    return value, np.sqrt(variance), weight
