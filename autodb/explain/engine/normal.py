"""Normal equations: sums of products of rows, which add up over stretches of a recording."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

HELD = 1e-9
"""Share of the best held direction, columns of one size, below which rows do not hold one."""


def columns_side_by_side(*blocks: Array) -> Array:
    """Return columns (n,) or blocks of them (n, p) side by side, each contiguous in memory.

    Filters and products then run along memory.
    """
    widths = [1 if block.ndim == 1 else block.shape[1] for block in blocks]
    ends = np.cumsum(widths)
    rows = np.empty((int(ends[-1]), len(blocks[0])))
    for block, end, width in zip(blocks, ends, widths, strict=True):
        rows[end - width : end] = block.T
    return rows.T


@dataclass(frozen=True)
class Normal:
    """Products of columns with each other, (p, p), and with what they are fitted to, (p,)."""

    inner: Array
    right: Array

    def __add__(self, other: "Normal") -> "Normal":
        """Return the products of both rows."""
        return Normal(self.inner + other.inner, self.right + other.right)

    def inverse(self, weight: Array | None = None) -> Array:
        """Return the inverse of the products, (p, p); directions that are not held have none.

        ``weight`` (p,): what a squared coefficient costs, None: nothing.
        """
        inner = self.inner if weight is None else self.inner + np.diag(weight)
        norm = np.sqrt(np.maximum(np.diag(inner), 0.0))  # sums less sums round below none
        norm = np.where(norm > 0, norm, 1.0)
        scale = np.outer(norm, norm)
        values, vectors = np.linalg.eigh(inner / scale)
        sizes = np.abs(values)
        held = sizes > HELD * sizes.max(initial=0.0)
        vectors = vectors[:, held]
        return np.asarray((vectors / values[held]) @ vectors.T / scale)

    def solved(self, weight: Array | None = None) -> Array:
        """Return least-squares coefficients (p,); directions that are not held get none."""
        return np.asarray(self.inverse(weight) @ self.right)


def normal(design: Array, right: Array) -> Normal:
    """Return the products of columns (n, p) with each other and with rows (n,)."""
    return Normal(design.T @ design, design.T @ right)


def solved(design: Array, right: Array, *, weight: Array | None = None) -> Array:
    """Return least-squares coefficients (p,) of columns (n, p) for rows (n,)."""
    return normal(design, right).solved(weight)


def solved_together(design: Array, right: Array) -> Array:
    """Return least-squares coefficients (p, k) of columns (n, p) for k columns (n, k)."""
    return np.asarray(Normal(design.T @ design, design.T @ right).inverse() @ (design.T @ right))
