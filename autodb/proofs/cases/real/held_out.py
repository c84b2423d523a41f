"""Plain least squares, and its error over blocks of the recording that it has not seen."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.cases.real.real_axis import Array

BLOCKS = 8
"""Contiguous parts, each of them predicted from the others."""
DEPENDENT = 1e-9
"""Share of a singular value of the largest below which a direction is not fitted."""


def block_numbers(rows: int) -> NDArray[np.intp]:
    """Return the number of each row's block (n,)."""
    return np.arange(rows) * BLOCKS // rows


def fitted_sizes(columns: Array, y: Array) -> Array:
    """Return coefficients (k,) of columns (k, n), however their scales differ."""
    if not len(columns):
        return np.zeros(0)
    scale = np.linalg.norm(columns, axis=1)
    scale[scale == 0.0] = 1.0
    found = np.linalg.lstsq((columns / scale[:, None]).T, y, rcond=DEPENDENT)[0]
    return np.asarray(found / scale, dtype=np.float64)


@dataclass(frozen=True)
class HeldOut:
    """Squared errors of each block, (BLOCKS,), and how many rows there are."""

    squares: Array
    rows: int

    @property
    def rms(self) -> float:
        """Return the error over all blocks, in the unit of the channel."""
        return float(np.sqrt(self.squares.sum() / self.rows))


@dataclass(frozen=True)
class Blocks:
    """Columns (k, n) and an effort y (n,) as products of each block.

    What is fitted without a block is then a difference of sums. ``scale`` (k,) evens columns out.
    """

    scale: Array
    gram: Array
    moments: Array
    squares: Array
    rows: int

    @classmethod
    def of(cls, columns: Array, y: Array) -> "Blocks":
        """Sum up products in each block."""
        number = block_numbers(len(y))
        starts = np.searchsorted(number, np.arange(BLOCKS))
        scale = np.linalg.norm(columns, axis=1) if len(columns) else np.zeros(0)
        scale[scale == 0.0] = 1.0
        parts = np.split(columns / scale[:, None], starts[1:], axis=1)
        ys = np.split(y, starts[1:])
        pairs = list(zip(parts, ys, strict=True))
        return cls(
            scale,
            np.array([part @ part.T for part, _ in pairs]),
            np.array([part @ own for part, own in pairs]),
            np.array([own @ own for own in ys]),
            len(y),
        )

    def held_out(self, picked: list[int]) -> HeldOut:
        """Return the error of some of the columns, each block predicted from the others."""
        if not picked:
            return HeldOut(self.squares, self.rows)
        pick = np.ix_(range(BLOCKS), picked, picked)
        gram, moments = self.gram[pick], self.moments[:, picked]
        left = gram.sum(axis=0) - gram
        beside = moments.sum(axis=0) - moments
        inverse = np.linalg.pinv(left, rcond=DEPENDENT, hermitian=True)
        found = np.einsum("bij,bj->bi", inverse, beside)
        squares = (
            self.squares
            - 2.0 * np.einsum("bi,bi->b", found, moments)
            + np.einsum("bi,bij,bj->b", found, gram, found)
        )
        return HeldOut(np.maximum(squares, 0.0), self.rows)


def held_out(columns: Array, y: Array) -> HeldOut:
    """Return the error of columns (k, n) on an effort y (n,), each block from the others."""
    return Blocks.of(columns, y).held_out(list(range(len(columns))))
