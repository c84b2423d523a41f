"""Coloured noise: an autoregression fitted to a residual makes it and the columns white."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

Array = NDArray[np.float64]

ORDER = 10


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


def autoregression(residual: Array, order: int = ORDER) -> Whitener:
    """Return the whitener of an autoregression fitted to a residual (n,) by least squares."""
    lagged = np.column_stack([residual[order - k : -k] for k in range(1, order + 1)])
    target = residual[order:]
    ridge = max(1e-9 * float(residual @ residual), 1e-300) * np.eye(order)
    coefficients = np.linalg.solve(lagged.T @ lagged + ridge, lagged.T @ target)
    return Whitener(np.asarray(coefficients, dtype=np.float64))
