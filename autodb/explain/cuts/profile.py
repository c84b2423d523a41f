"""Parameters of a named effect with their intervals, everything else beside it left free."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.explain.answer.answer import IntervalValue
from autodb.explain.cuts.candidates.laws import LawColumns
from autodb.explain.cuts.cuts_fit import all_columns
from autodb.explain.cuts.stack import Stack
from autodb.explain.engine.candidates import Choice
from autodb.fitting import NORMAL_95

Array = NDArray[np.float64]

GRID = 25


def profiled_value(middle: float, half: float, unit: str) -> IntervalValue:
    """Return a value with an interval to both sides."""
    return IntervalValue(value=middle, low=middle - half, high=middle + half, unit=unit)


@dataclass(frozen=True)
class BesideEffect:
    """White rows after own terms and the other effects are projected out."""

    stack: Stack
    basis: Array
    left: Array

    @classmethod
    def others(
        cls, stack: Stack, own: dict[str, LawColumns], choices: tuple[Choice, ...],
        *, plus: Array | None = None,
    ) -> "BesideEffect":  # fmt: skip
        """Project out the columns of own terms and effects; ``plus`` (C, n) joins what is left."""
        empty = np.zeros((*stack.simulation.shape, 0))
        raw = [c.raw() for c in all_columns(own, choices)]
        white = stack.white(np.concatenate([empty, *raw], axis=2))
        norm = np.linalg.norm(white, axis=0)
        norm[norm == 0] = 1.0
        basis, size, _ = np.linalg.svd(white / norm, full_matrices=False)
        basis = basis[:, size > 1e-9 * size.max(initial=0.0)]
        difference = stack.difference
        if plus is not None:
            difference = difference + stack.white(plus[:, :, None])[:, 0]
        return cls(stack, basis, difference - basis @ (basis.T @ difference))

    def clear(self, columns: LawColumns) -> Array:
        """Return white columns (C·n, p) without what the others hold."""
        white = columns()
        return np.asarray(white - self.basis @ (self.basis.T @ white))

    def gain(self, columns: LawColumns) -> float:
        """Return how far the sum of squares falls by some columns."""
        clear = self.clear(columns)
        coefficients, *_ = np.linalg.lstsq(clear, self.left, rcond=1e-8)
        return float(self.left @ (clear @ coefficients))

    def coefficients(self, columns: LawColumns) -> tuple[Array, Array]:
        """Return coefficients (p,) and their standard deviations (p,)."""
        inner, right = self._products(columns)
        norm = np.sqrt(np.diag(inner))
        norm[norm == 0] = 1.0
        inner, right = inner / np.outer(norm, norm), right / norm
        inverse = np.linalg.pinv(inner, rcond=1e-9, hermitian=True)
        found = inverse @ right
        squares = float(self.left @ self.left - 2.0 * found @ right + found @ inner @ found)
        variance = squares / max(1, len(self.left) - self.basis.shape[1])
        return found / norm, np.sqrt(np.diag(inverse) * max(variance, 1.0)) / norm

    def _products(self, columns: LawColumns) -> tuple[Array, Array]:
        """Return the inner products of what others leave of columns (p, p), and with ``left``."""
        count, chunks = len(self.stack.names), self.stack.chunks
        basis = self.basis.reshape(count, -1, self.basis.shape[1])
        left = self.left.reshape(count, -1)
        width = columns.mix.shape[2]
        held, inner, right = (
            np.zeros((basis.shape[2], width)),
            np.zeros((width, width)),
            np.zeros(width),
        )
        for rows in chunks:
            held += basis[:, rows].reshape(-1, len(held)).T @ columns(rows)
        for rows in chunks:
            clear = columns(rows) - basis[:, rows].reshape(-1, len(held)) @ held
            inner += clear.T @ clear
            right += left[:, rows].ravel() @ clear
        return inner, right

    def profile(
        self, make: Callable[[float], LawColumns], low: float, high: float, unit: str
    ) -> IntervalValue:
        """Return the value of a shape that fits best, and where the fit is 3.84 worse."""
        grid = np.linspace(low, high, GRID)
        gains = np.array([self.gain(make(float(g))) for g in grid])
        at = int(np.argmax(gains))
        fine = np.linspace(grid[max(at - 1, 0)], grid[min(at + 1, GRID - 1)], GRID)
        more = np.array([self.gain(make(float(g))) for g in fine])
        grid, gains = np.concatenate([grid, fine]), np.concatenate([gains, more])
        order = np.argsort(grid, kind="stable")
        grid, gains = grid[order], gains[order]
        best = int(np.argmax(gains))
        inside = np.flatnonzero(gains >= gains[best] - NORMAL_95**2)
        return IntervalValue(
            value=float(grid[best]),
            low=float(_crossing(grid, gains, inside[0], -1, gains[best])),
            high=float(_crossing(grid, gains, inside[-1], 1, gains[best])),
            unit=unit,
        )


def _crossing(grid: Array, gains: Array, at: int, step: int, best: float) -> float:
    """Return where the gain falls below its limit beyond grid point ``at``."""
    beyond = at + step
    if not 0 <= beyond < len(grid):
        return float(grid[at])
    limit = best - NORMAL_95**2
    share = (gains[at] - limit) / max(gains[at] - gains[beyond], 1e-300)
    return float(grid[at] + np.clip(share, 0.0, 1.0) * (grid[beyond] - grid[at]))
