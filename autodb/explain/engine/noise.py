"""Coloured noise: an autoregression fitted to a residual makes it and the columns white."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.intp]

ORDER = 25
"""0.1 s at 250 Hz: white noise on slow noise has a long inverse. Chosen."""
BLOCK = 64
"""Rows that are filtered at once, as a product of matrices, which is faster; at least ``ORDER``."""
TABLE = 2048
"""Frequencies, from 0 to half the rate, at which a filter's response is kept."""
SLOW_PARTS = (16, 32, 64)
"""Numbers of parts over which sums are taken to see slow noise. Chosen."""
CHI_SQUARE_MEDIAN = 0.455
"""Median of a squared standard normal: few parts that hold a stretch of something count little."""


@dataclass(frozen=True)
class Whitener:
    """x_t − Σ a_k x_{t−k}: an all-zero filter; the first ``len(a)`` rows are dropped.

    ``linked``: which of the others are kept, where rows do not all follow each other; None: all.
    """

    coefficients: Array
    linked: Index | None = None

    def __call__(self, values: Array) -> Array:
        """Return the whitened columns of ``values`` (n,) or (n, k), shape (n − order, k)."""
        if values.ndim > 1:
            return self.side_by_side([values])
        white = self._filtered(values)
        return white if self.linked is None else white[self.linked]

    @property
    def unbroken(self) -> "Whitener":
        """The same filter, of rows that all follow each other."""
        return Whitener(self.coefficients)

    def places(self, rows: int) -> Index:
        """Return the row, of so many, that each white row stands at."""
        every = np.arange(len(self.coefficients), rows)
        return every if self.linked is None else every[self.linked]

    def side_by_side(self, blocks: Sequence[Array]) -> Array:
        """Return the whitened columns of blocks (n, k) as one (n − order, Σk), each column
        contiguous in memory.
        """
        columns = [column for block in blocks for column in block.T]
        white = np.empty((len(columns), len(blocks[0]) - len(self.coefficients)))
        banded = self._banded()
        for row, column in zip(white, columns, strict=True):
            self._fill(row, np.ascontiguousarray(column), banded)
        return white.T if self.linked is None else white[:, self.linked].T

    def _fill(self, white: Array, values: Array, banded: Array) -> None:
        """Write the whitened ``values`` (n,) to ``white`` (n − order,), BLOCK rows at a time."""
        order = len(self.coefficients)
        blocks = max(0, len(values) // BLOCK - 1)
        here = values[: blocks * BLOCK].reshape(blocks, BLOCK)
        beyond = values[BLOCK : (blocks + 1) * BLOCK].reshape(blocks, BLOCK)[:, :order]
        done = white[: blocks * BLOCK].reshape(blocks, BLOCK)
        np.matmul(here, banded[:, :BLOCK].T, out=done)
        done += beyond @ banded[:, BLOCK:].T
        white[blocks * BLOCK :] = self._filtered(values[blocks * BLOCK :])

    def _filtered(self, values: Array) -> Array:
        return np.convolve(values, np.concatenate([[1.0], -self.coefficients]), mode="valid")

    def _banded(self) -> Array:
        """Return the matrix (BLOCK, BLOCK + order) that filters BLOCK rows at once."""
        taps = np.concatenate([-self.coefficients[::-1], [1.0]])
        banded = np.zeros((BLOCK, BLOCK + len(self.coefficients)))
        for row in range(BLOCK):
            banded[row, row : row + len(taps)] = taps
        return banded

    def adjoint(self, values: Array, rows: int) -> Array:
        """Return the transposed filter of white values (n − order,) at all ``rows``."""
        from scipy.signal import lfilter

        padded = np.zeros(rows)
        padded[self.places(rows)] = values
        taps = np.concatenate([[1.0], -self.coefficients])
        return np.asarray(lfilter(taps, [1.0], padded[::-1])[::-1], dtype=np.float64)

    def power(self, cycles_a_row: Array) -> Array:
        """Return the filter's squared response at frequencies in cycles a row, from a table."""
        taps = np.concatenate([[1.0], -self.coefficients])
        table = np.abs(np.fft.rfft(taps, n=2 * TABLE)) ** 2
        folded = np.abs((np.asarray(cycles_a_row) + 0.5) % 1.0 - 0.5)
        return np.asarray(np.interp(folded * 2 * TABLE, np.arange(TABLE + 1), table))


PLAIN = Whitener(np.zeros(0))
"""The filter that leaves rows as they are."""
Noise = tuple[Whitener, float]
"""The filter that makes a noise white, and the variance of a white row."""


def fitted_whitener(
    residual: Array, order: int = ORDER, *, linked: Index | None = None
) -> Whitener:
    """Return the whitener of an autoregression fitted to a residual (n,) by least squares.

    ``linked``: which of the rows but the first ``order`` follow those before without a gap.
    """
    lagged = np.column_stack([residual[order - k : -k] for k in range(1, order + 1)])
    target = residual[order:]
    if linked is not None:
        lagged, target = lagged[linked], target[linked]
    ridge = max(1e-9 * float(residual @ residual), 1e-300)
    coefficients = np.linalg.solve(lagged.T @ lagged + ridge * np.eye(order), lagged.T @ target)
    return Whitener(np.asarray(coefficients, dtype=np.float64), linked)


def slow_variance(left: Array) -> float:
    """Return the variance of a row that slow noise seems to have, in sums over parts of rows (n,),
    the most of SLOW_PARTS.
    """
    found = []
    for parts in SLOW_PARTS:
        sums = np.array([part.sum() for part in np.array_split(left, min(parts, len(left)))])
        found.append(float(np.median(sums**2)) / CHI_SQUARE_MEDIAN * len(sums) / len(left))
    return max(found)
