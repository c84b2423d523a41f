"""Columns that are there in the cuts of one edge only, two for an edge, projected out edge by edge.

Those of two edges have no row in common: they are orthogonal, and are never written out. A table of
100 000 cuts by 2 500 edges has 5 000 of them.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.explain.cutting.table import Conditions

Array = NDArray[np.float64]

FEW = 12
"""Cuts an edge, on average, from which on edges have columns of their own."""
ALIKE = 1e-8
"""Share of a column's norm below which what another leaves of it counts as nothing."""


@dataclass(frozen=True)
class OfEdges:
    """Two columns (n, 2), each one column for every edge; ``edge`` (n,) numbers the edges."""

    edge: NDArray[np.intp]
    columns: Array

    def basis(self, sd: Array) -> Array:
        """Return columns (n, 2) over the sd (n,), of unit norm and orthogonal in every edge."""
        first, second = (self._unit(c, c) for c in (self.columns / sd[:, None]).T)
        left = second - first * self._sums(first * second)
        return np.column_stack([first, self._unit(left, second)])

    def cleared(self, columns: Array, basis: Array) -> Array:
        """Return columns (n, p) without what a basis (n, 2) holds of them in every edge."""
        left = np.array(columns, order="F")
        for one in basis.T:
            for number in range(left.shape[1]):
                left[:, number] -= one * self._sums(one * left[:, number])
        return left

    def _sums(self, values: Array) -> Array:
        """Return the sum of values (n,) over the cuts of each cut's edge, (n,)."""
        return np.asarray(np.bincount(self.edge, values)[self.edge])

    def _unit(self, column: Array, whole: Array) -> Array:
        """Return a column of unit norm in every edge; 0 where hardly anything of it is left."""
        norm, before = np.sqrt(self._sums(column**2)), np.sqrt(self._sums(whole**2))
        there = norm > ALIKE * np.maximum(before, 1e-300)
        return np.asarray(np.where(there, column / np.where(there, norm, 1.0), 0.0))


def of_edges(known: Conditions, scales: tuple[Array, Array], most: int) -> OfEdges:
    """Return a rise with cutting time of each of two scales (n,) for every edge but the first.

    ``most`` columns at most, the first edges' first; none in tables with few cuts for an edge.
    """
    time, edges = known.cutting_time_s, known.edges
    columns = np.zeros((len(known), 2))
    if time is None or known.edge is None or len(known) <= FEW * len(edges):
        return OfEdges(np.zeros(len(known), dtype=np.intp), columns)
    edge = np.searchsorted(edges, known.edge)
    risen = over_range(time)
    for number, scale in enumerate(scales):
        there = (edge > 0) & (2 * (edge - 1) + number < most)
        columns[:, number] = np.where(there, scale * risen, 0.0)
    return OfEdges(edge, columns)


def over_range(values: Array) -> Array:
    """Return values over −1 to 1."""
    low, high = float(values.min()), float(values.max())
    return np.asarray(2.0 * (values - low) / max(high - low, 1e-300) - 1.0, dtype=np.float64)
