"""Columns that are there in the cuts of one edge only, two for an edge, projected out edge by edge.

Those of two edges have no row in common: they are orthogonal, and at most two of them are not zero
in a row. A table of 100 000 cuts by 2 500 edges has 5 000 of them.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import qr

from autodb.explain.cuts.stack import Conditions

Array = NDArray[np.float64]

FEW = 12
"""Cuts an edge, on average, from which on edges have columns of their own."""
ROUND_OFF = 1e-12
"""Share of columns' norm, before anything is projected out, that is put down to rounding.

Columns that depend on each other leave some 1e-15 of it. Smooth columns that do not, come down to
1e-9 without a gap on the way: a higher limit would decide by a hair which of them count.
"""


@dataclass(frozen=True)
class OfEdges:
    """Two columns (n, 2), each one column for every edge; ``edge`` (n,) numbers the edges."""

    edge: NDArray[np.intp]
    columns: Array

    def basis(self, sd: Array) -> sparse.csr_array:
        """Return orthonormal columns (n, 2E) that span those of E edges over the sd (n,)."""
        first, second = (self._unit(column, 0.0) for column in (self.columns / sd[:, None]).T)
        for _ in range(2):  # once more takes off what rounding left of the first
            second = second - first * self._sums(first * second)
        values = np.column_stack([first, self._unit(second, ROUND_OFF)])
        ends = np.arange(0, 2 * len(sd) + 1, 2)
        places = 2 * self.edge[:, None] + np.arange(2)
        shape = (len(sd), 2 * int(self.edge.max()) + 2)
        return sparse.csr_array((values.ravel(), places.ravel(), ends), shape=shape)

    def _sums(self, values: Array) -> Array:
        """Return the sum of values (n,) over the cuts of each cut's edge, (n,)."""
        return np.asarray(np.bincount(self.edge, values)[self.edge])

    def _unit(self, column: Array, least: float) -> Array:
        """Return a column of unit norm in every edge; 0 where its norm is ``least`` or less."""
        norm = np.sqrt(self._sums(column**2))
        there = norm > least
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


def residual(design: Array, edges: OfEdges, difference: Array, sd: Array) -> tuple[Array, Array]:
    """Return what a weighted fit leaves (n,), and the leverage of every row on its own fit (n,).

    Fitted are the columns of a design (n, p) and those of edges.
    """
    own = edges.basis(sd)
    weighted = np.divide(design, sd[:, None], order="F")
    norm = np.linalg.norm(weighted, axis=0)
    norm[norm == 0] = 1.0
    weighted /= norm
    frame, triangle = qr(_cleared(weighted, own), mode="economic", overwrite_a=True)
    turned, size, _ = np.linalg.svd(triangle)
    basis = frame @ turned[:, size > ROUND_OFF]
    rest = _cleared((difference / sd)[:, None], own)[:, 0]
    rest = rest - basis @ (basis.T @ rest)
    leverage = np.sum(basis**2, axis=1) + np.asarray(own.multiply(own).sum(axis=1))
    return np.asarray(sd * rest), np.asarray(leverage)


def _cleared(columns: Array, basis: sparse.csr_array) -> Array:
    """Take off columns (n, p), in place, what an orthonormal basis (n, q) holds of them."""
    for _ in range(2):  # once more takes off what rounding left
        columns -= np.asarray(basis @ (basis.T @ columns))
    return columns


def over_range(values: Array) -> Array:
    """Return values over −1 to 1."""
    low, high = float(values.min()), float(values.max())
    return np.asarray(2.0 * (values - low) / max(high - low, 1e-300) - 1.0, dtype=np.float64)
