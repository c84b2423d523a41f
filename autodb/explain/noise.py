"""Coloured noise: an autoregression fitted to a residual makes it and the columns white."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

Array = NDArray[np.float64]

ORDER = 25
"""0.1 s at 250 Hz: white noise on slow noise has a long inverse. Chosen."""
TABLE = 2048
"""Frequencies, from 0 to half the rate, at which a filter's response is kept."""


@dataclass(frozen=True)
class Whitener:
    """x_t − Σ a_k x_{t−k}: an all-zero filter; the first ``len(a)`` rows are dropped."""

    coefficients: Array

    def __call__(self, values: Array) -> Array:
        """Return the whitened columns of ``values`` (n, k), shape (n − order, k)."""
        if values.shape[-1] == 0:
            return values[len(self.coefficients) :]
        taps = np.concatenate([[1.0], -self.coefficients])
        return np.asarray(lfilter(taps, [1.0], values, axis=0)[len(self.coefficients) :])

    def adjoint(self, values: Array, rows: int) -> Array:
        """Return the transposed filter of white values (n − order,) at all ``rows``."""
        order = len(self.coefficients)
        padded = np.concatenate([np.zeros(order), values])[:rows]
        taps = np.concatenate([[1.0], -self.coefficients])
        return np.asarray(lfilter(taps, [1.0], padded[::-1])[::-1], dtype=np.float64)

    def power(self, cycles_a_row: Array) -> Array:
        """Return the filter's squared response at frequencies in cycles a row, from a table."""
        taps = np.concatenate([[1.0], -self.coefficients])
        table = np.abs(np.fft.rfft(taps, n=2 * TABLE)) ** 2
        folded = np.abs((np.asarray(cycles_a_row) + 0.5) % 1.0 - 0.5)
        return np.asarray(np.interp(folded * 2 * TABLE, np.arange(TABLE + 1), table))


Noise = tuple[Whitener, float]
"""The filter that makes a noise white, and the variance of a white row."""


def autoregression(residual: Array, order: int = ORDER) -> Whitener:
    """Return the whitener of an autoregression fitted to a residual (n,) by least squares."""
    lagged = np.column_stack([residual[order - k : -k] for k in range(1, order + 1)])
    target = residual[order:]
    ridge = max(1e-9 * float(residual @ residual), 1e-300) * np.eye(order)
    coefficients = np.linalg.solve(lagged.T @ lagged + ridge, lagged.T @ target)
    return Whitener(np.asarray(coefficients, dtype=np.float64))
