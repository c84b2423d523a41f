"""Noise of a recorded channel."""

import numpy as np

from autodb.proofs.machines.lathe.process import Array


def coloured(rng: np.random.Generator, size: int, sd: float, rho: float) -> Array:
    """First-order autoregressive noise of the stated standard deviation, stationary."""
    noise = rng.standard_normal(size) * sd
    fresh = np.sqrt(1.0 - rho**2)
    for i in range(1, size):
        noise[i] = rho * noise[i - 1] + fresh * noise[i]
    return noise
