"""Coloured noise: an autoregression fitted to a residual makes it and the columns white."""

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.signal import lfilter

Array = NDArray[np.float64]

ORDER = 25
"""0.1 s at 250 Hz: white noise on slow noise has a long inverse. Chosen."""
BLOCK = 32
"""Rows that are filtered at once: many columns as a product of matrices, which is faster."""
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
        order = len(self.coefficients)
        if values.ndim == 1 or len(values) < BLOCK + order:
            return self._filtered(values)
        white = np.empty((len(values) - order, values.shape[1]))
        blocks = len(white) // BLOCK
        rows = sliding_window_view(values, BLOCK + order, axis=0)[: blocks * BLOCK : BLOCK]
        done = white[: blocks * BLOCK].reshape(blocks, BLOCK, -1)
        np.matmul(self._banded(), rows.transpose(0, 2, 1), out=done)
        if blocks * BLOCK < len(white):
            white[blocks * BLOCK :] = self._filtered(values[blocks * BLOCK :])
        return white

    def _filtered(self, values: Array) -> Array:
        taps = np.concatenate([[1.0], -self.coefficients])
        return np.asarray(lfilter(taps, [1.0], values, axis=0)[len(self.coefficients) :])

    def _banded(self) -> Array:
        """Return the matrix (BLOCK, BLOCK + order) that filters BLOCK rows at once."""
        taps = np.concatenate([-self.coefficients[::-1], [1.0]])
        banded = np.zeros((BLOCK, BLOCK + len(self.coefficients)))
        for row in range(BLOCK):
            banded[row, row : row + len(taps)] = taps
        return banded

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
