"""Noise of a channel: slow first-order autoregressive noise plus white noise, and its whitening."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ChannelNoise:
    """Slow noise of sd ``slow``, white of sd ``white``; ``rho``: the slow one's correlation.

    It is that from one sample to the next. One of the two sds may be 0, not both.
    """

    slow: float
    rho: float
    white: float

    def draw(self, rng: np.random.Generator, size: int) -> Array:
        """One noise series (size,), stationary from its first sample."""
        from scipy.signal import lfilter

        fresh = self.slow * np.sqrt(1.0 - self.rho**2) * rng.standard_normal(size)
        fresh[0] = self.slow * rng.standard_normal()
        slow = lfilter([1.0], [1.0, -self.rho], fresh)
        return np.asarray(slow + self.white * rng.standard_normal(size), dtype=np.float64)

    def whitened(self, values: Array) -> Array:
        """Values (..., n) such that this noise among them would be white with sd 1.

        Their sum is an ARMA(1, 1) process, e_i - rho e_(i-1) = u_i + theta u_(i-1): theta and the
        sd of u follow from variance and first covariance of the left side. The first sample is
        divided by the whole sd: exact without white noise, else right after some 1/(1 + theta)
        samples. Source: Box, Jenkins, Reinsel 1994, Time series analysis, ch. 3.4.
        """
        from scipy.signal import lfilter

        theta, sd = self._moving_average()
        left = values.copy()
        left[..., 1:] -= self.rho * values[..., :-1]
        left[..., 0] *= sd / np.hypot(self.slow, self.white)
        return np.asarray(lfilter([1.0], [1.0, theta], left, axis=-1) / sd, dtype=np.float64)

    def _moving_average(self) -> tuple[float, float]:
        """Return theta in (-1, 0] and the sd of u."""
        variance = self.slow**2 * (1.0 - self.rho**2) + self.white**2 * (1.0 + self.rho**2)
        covariance = -self.rho * self.white**2
        if covariance == 0.0:
            return 0.0, float(np.sqrt(variance))
        half = variance / (2.0 * covariance)
        theta = half + np.sqrt(half**2 - 1.0)
        return float(theta), float(np.sqrt(covariance / theta))
