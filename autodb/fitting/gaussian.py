"""Normal beliefs about parameters and how data change them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

NORMAL_95 = 1.959964
"""Half width of a normal 95 % interval in standard deviations."""


@dataclass(frozen=True)
class Gaussian:
    """A normal belief about parameters: mean (p,), covariance (p, p)."""

    mean: Array
    covariance: Array


def update(prior: Gaussian, design: Array, values: Array, noise_sd: Array) -> Gaussian:
    """Return the posterior after values (n,) = design (n, p) · θ + noise of sd (n,), independent.

    Kalman form in p dimensions: Λ = (1 + Σ XᵀWX)⁻¹ Σ, μ' = μ + Λ XᵀW (y − Xμ); cost linear in n.
    What the prior is sure of, a variance of zero, stays as it is.
    """
    weighted = design / noise_sd[:, None] ** 2
    size = np.sqrt(np.diag(prior.covariance))
    unit = np.where(size > 0, size, 1.0)
    known = prior.covariance / np.outer(unit, unit)
    told = design.T @ weighted * np.outer(unit, unit)
    covariance = np.linalg.solve(np.eye(len(unit)) + known @ told, known) * np.outer(unit, unit)
    covariance = 0.5 * (covariance + covariance.T)
    covariance[size == 0.0] = covariance[:, size == 0.0] = 0.0
    mean = prior.mean + covariance @ (weighted.T @ (values - design @ prior.mean))
    return Gaussian(mean, covariance)
