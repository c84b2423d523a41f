"""Mass on a dynamometer and the sensor's matrix from what it reads at rest in tilts.

At a rest r, component i of the reading is

    y_ir = (m − b_r (1 + e)) S_i · p_r + zero_i + w_i(t_r),

p what a kilogram adds there, b the work that is not on the table, as it was weighed, 0 where it is
on it, e the error of that weighing, zero one with the work and one without, and w what wanders
within a recording: noise that forgets, with covariance
sd² exp(−|Δt|/τ), whose τ and sd are those of the largest restricted likelihood of the rests (H. D.
Patterson, R. Thompson, Biometrika 58 (1971) 545); independent errors are among them. Rests
determine the products m S alone: without a weighed mass a gain that all components share stays as
calibrated, and with the mass it is off. Each mass and S by Gauss and Newton, S with a prior.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SHARE_SD, GAIN_SD = 0.03, 0.005
"""Standard deviations of what a component reads of another (that of ``terms.table.crosstalk``),
and of its own sensitivity, before any move. Chosen."""
WEIGHED_SD = 0.001
"""Standard deviation of a weighed mass, of it. Chosen: a shop's scale reads 10 g of 10 kg."""
FORGETS_S = (0.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0)
"""Times τ that are tried; 0: rests err independently. Chosen."""
STEPS = 6
"""Of Gauss and Newton to mass and matrix, whose product is what rests determine."""
WITHIN = 8
"""Points of a rest that its mean is taken over, in the covariance of means."""


@dataclass(frozen=True)
class Weighing:
    """Rests with one zero.

    ``per_kg`` (n, 3): what a kilogram adds, m/s²; ``read_N`` (n, 3); ``begin_s``, ``end_s`` (n,):
    when each rests, in the ``number``-th recording (n,); ``less_kg``: what was taken off the table,
    as weighed; 0: the work is on it.
    """

    per_kg: Array
    read_N: Array
    begin_s: Array
    end_s: Array
    number: NDArray[np.intp]
    less_kg: float = 0.0

    def covariance(self, forgets_s: float) -> Array:
        """Return the covariance (n, n) of the means over rests of noise of variance 1."""
        if forgets_s == 0.0:
            return np.eye(len(self.begin_s))
        share = (np.arange(WITHIN) + 0.5) / WITHIN
        at = (self.begin_s[:, None] + share * (self.end_s - self.begin_s)[:, None]).ravel()
        whole = np.exp(-np.abs(at[:, None] - at) / forgets_s)
        count = len(self.begin_s)
        means = whole.reshape(count, WITHIN, count, WITHIN).mean(axis=(1, 3))
        return np.asarray(means * (self.number[:, None] == self.number))


@dataclass(frozen=True)
class Whitened:
    """Rests whose errors are independent, without the part that a zero explains.

    ``per_kg`` (n, 3), ``read_N`` (n, 3), ``less_kg`` (n,); ``free``: how many are independent;
    ``volume``: the logarithm of the covariance's determinant and of that of the zeros.
    """

    per_kg: Array
    read_N: Array
    less_kg: Array
    free: int
    volume: float


def weigh(rests: Sequence[Weighing]) -> tuple[float, Array, Array]:
    """Return mass kg, matrix (3, 3), and the covariance (10, 10) of both, the matrix row by row.

    The mass is that with the work on the table. Of each zero some rests are tilted, and one is not.
    """
    seen = max((_whitened(rests, one) for one in FORGETS_S), key=_likelihood)
    mass, matrix, error = _first_mass(seen), np.eye(3), 0.0
    prior_sd = np.where(np.eye(3) > 0.0, GAIN_SD, SHARE_SD).ravel()
    known = np.diag(np.concatenate([[0.0], prior_sd**-2, [WEIGHED_SD**-2]]))
    noise = _noise(seen)
    for _ in range(STEPS):
        held = mass - seen.less_kg * (1.0 + error)
        by_mass = seen.per_kg @ matrix.T
        left = seen.read_N - held[:, None] * by_mass
        slopes = np.zeros((len(left), 3, 11))
        slopes[:, :, 0] = by_mass
        for i in range(3):
            slopes[:, i, 1 + 3 * i : 4 + 3 * i] = held[:, None] * seen.per_kg
        slopes[:, :, 10] = -seen.less_kg[:, None] * by_mass
        inner = np.einsum("rij,i,rik->jk", slopes, 1.0 / noise, slopes) + known
        right = np.einsum("rij,i,ri->j", slopes, 1.0 / noise, left)
        right[1:] -= np.diag(known)[1:] * np.concatenate([(matrix - np.eye(3)).ravel(), [error]])
        step = np.linalg.solve(inner, right)
        mass, error = mass + float(step[0]), error + float(step[10])
        matrix = matrix + step[1:10].reshape(3, 3)
    return mass, matrix, np.linalg.inv(inner)[:10, :10]


def _whitened(rests: Sequence[Weighing], forgets_s: float) -> Whitened:
    """Return all rests with errors of variance 1, if they forget so."""
    parts, volume = [], 0.0
    for one in rests:
        root = np.linalg.cholesky(one.covariance(forgets_s))
        per_kg, read_N = np.linalg.solve(root, one.per_kg), np.linalg.solve(root, one.read_N)
        zero = np.linalg.solve(root, np.ones(len(root)))
        length = float(zero @ zero)
        kept = [values - np.outer(zero, zero @ values) / length for values in (per_kg, read_N)]
        parts.append((*kept, np.full(len(root), one.less_kg)))
        volume += 2.0 * float(np.sum(np.log(np.diag(root)))) + float(np.log(length))
    per_kg, read_N, less_kg = (np.concatenate(some) for some in zip(*parts, strict=True))
    return Whitened(per_kg, read_N, less_kg, len(less_kg) - len(rests), volume)


def _columns(seen: Whitened) -> Array:
    """Return the columns (n, 3 or 6) of m S_i, and of S_i where a weighed mass is off."""
    if not np.any(seen.less_kg):
        return seen.per_kg
    return np.column_stack([seen.per_kg, -seen.less_kg[:, None] * seen.per_kg])


def _noise(seen: Whitened) -> Array:
    """Return the variance (3,) of each component's errors, its own best m S taken off."""
    columns = _columns(seen)
    rest = seen.read_N - columns @ (np.linalg.pinv(columns) @ seen.read_N)
    free = max(seen.free - np.linalg.matrix_rank(columns), 1)
    return np.asarray(np.maximum(np.sum(rest**2, axis=0) / free, 1e-12))


def _likelihood(seen: Whitened) -> float:
    """Return the restricted log likelihood of the rests, all components together."""
    columns = _columns(seen)
    singular = np.linalg.svd(columns, compute_uv=False)
    large = singular[singular > 1e-9 * max(float(singular[0]), 1e-300)]
    free = seen.free - len(large)
    if free < 1:
        return -np.inf
    noise = np.log(_noise(seen)).sum()
    return -0.5 * float(free * noise + 3.0 * (seen.volume + 2.0 * np.sum(np.log(large))))


def _first_mass(seen: Whitened) -> float:
    """Return the mass (kg) of a sensor whose matrix is 1, with the work on it."""
    whole = seen.read_N + seen.less_kg[:, None] * seen.per_kg
    return float(np.sum(seen.per_kg * whole) / np.sum(seen.per_kg**2))
