"""Semi-inverse: sensed forces and the cuts' geometry become a pair's parameters, with covariance.

Two kinds of error stay apart: each cut's own scatter, and the calibration's, which all cuts sensed
with it share. The shared part enters as nuisance parameters (the errors of the line's c0 and c1,
with the calibration's covariance), so more cuts never make it smaller (physics reference, 7).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.cutting import law
from autodb.fitting import Gaussian, update

Array = NDArray[np.float64]

ROUNDS = 5


@dataclass(frozen=True)
class SensedCuts:
    """Cuts of one pair as one calibration felt one component: arrays (n,), ``common`` (n, 2)."""

    feed_mm: Array
    depth_mm: Array
    force_N: Array
    sd_N: Array
    common: Array
    calibration_covariance: Array


@dataclass(frozen=True)
class Parameters:
    """Belief about (K_c, K_e), the share of force that scatters from cut to cut, and n."""

    belief: Gaussian
    process_share: float
    n_cuts: int


def learn(cuts: SensedCuts, *, prior: Gaussian = law.PRIOR) -> Parameters:
    """Return the posterior of one component's parameters after the cuts.

    F = K_c a_p f + K_e a_p + process + sensing + common·δ, δ ~ N(0, calibration covariance). The
    process' standard deviation is a share of the force, found from what the residuals scatter
    beyond the sensing sd; posterior and share are iterated.
    """
    design = np.column_stack([law.design(cuts.feed_mm, cuts.depth_mm), cuts.common])
    start = Gaussian(
        np.concatenate([prior.mean, np.zeros(2)]),
        _block(prior.covariance, cuts.calibration_covariance),
    )
    share = 0.0
    for _ in range(ROUNDS):
        noise = np.sqrt(cuts.sd_N**2 + (share * cuts.force_N) ** 2)
        posterior = update(start, design, cuts.force_N, noise)
        residual = cuts.force_N - design @ posterior.mean
        share = _process_share(residual, cuts)
    belief = Gaussian(posterior.mean[:2], posterior.covariance[:2, :2])
    return Parameters(belief, share, len(cuts.force_N))


def _block(a: Array, b: Array) -> Array:
    whole = np.zeros((len(a) + len(b), len(a) + len(b)))
    whole[: len(a), : len(a)] = a
    whole[len(a) :, len(a) :] = b
    return whole


def _process_share(residual: Array, cuts: SensedCuts) -> float:
    """Return √((Σr²/(n−2) − mean sd²)/mean F²); 0 where sensing alone explains the residuals."""
    n = len(residual)
    if n <= 2:
        return 0.0
    excess = float(np.sum(residual**2)) / (n - 2) - float(np.mean(cuts.sd_N**2))
    return float(np.sqrt(max(0.0, excess) / np.mean(cuts.force_N**2)))
