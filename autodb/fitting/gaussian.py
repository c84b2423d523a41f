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

    Kalman form in p dimensions: Λ = Σ⁻¹ + XᵀWX, μ' = μ + Λ⁻¹ XᵀW (y − Xμ); cost linear in n.
    """
    weighted = design / noise_sd[:, None] ** 2
    precision = np.linalg.inv(prior.covariance) + design.T @ weighted
    covariance = np.linalg.inv(precision)
    mean = prior.mean + covariance @ (weighted.T @ (values - design @ prior.mean))
    return Gaussian(mean, 0.5 * (covariance + covariance.T))
