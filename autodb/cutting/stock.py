"""Stock of a turned part: the radius of its surface over z, lowered by every pass.

Cells between edges in z hold a radius at either end, straight in between, so that cones and square
shoulders on an edge are exact; in front of the last edge there is nothing, behind the first a
cylinder goes on.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

TINY_MM = 1e-9
"""A distance that is none: what is left of arithmetic."""


@dataclass(frozen=True)
class Stock:
    """A stock: edges of cells in z, (n + 1,), rising, and radii at either end of each, (n,), mm.

    ``behind_mm`` is its radius behind the first edge, towards the chuck.
    """

    edges_mm: Array
    low_mm: Array
    high_mm: Array
    behind_mm: float

    def divided(self, at_mm: Array, *, cell_mm: float) -> "Stock":
        """Return the same stock in cells of at most a length, with an edge at every place given.

        The stock reaches to the lowest of these places at least, to the highest as nothing.
        """
        ends = np.concatenate([self.edges_mm, at_mm])
        even = np.arange(ends.min(), ends.max(), cell_mm)
        edges = np.unique(np.concatenate([ends, even]))
        middle = 0.5 * (edges[1:] + edges[:-1])
        cell = np.searchsorted(self.edges_mm, middle) - 1
        return Stock(
            edges, self._in_cell(cell, edges[:-1]), self._in_cell(cell, edges[1:]), self.behind_mm
        )

    def _in_cell(self, cell: NDArray[np.int_], z_mm: Array) -> Array:
        """Return the radius at places taken to lie in cells; −1 lies behind the first edge."""
        inside = np.clip(cell, 0, self.low_mm.size - 1)
        start, end = self.edges_mm[inside], self.edges_mm[inside + 1]
        share = (z_mm - start) / (end - start)
        radius = self.low_mm[inside] + share * (self.high_mm[inside] - self.low_mm[inside])
        behind = np.where(cell < 0, self.behind_mm, radius)
        return np.where(cell >= self.low_mm.size, 0.0, behind)

    def radius_mm(self, z_mm: Array) -> Array:
        """Return the radius of the surface at z, (n,), mm; at a shoulder the smaller one."""
        lower = self._in_cell(np.searchsorted(self.edges_mm, z_mm, side="left") - 1, z_mm)
        upper = self._in_cell(np.searchsorted(self.edges_mm, z_mm, side="right") - 1, z_mm)
        return np.minimum(lower, upper)

    def face_mm(self, z_mm: float, x_mm: Array, *, rise: float = 0.0) -> Array:
        """Return to where, going away from the chuck from z, each radius x is in the stock, (n,).

        z itself where it is not; ``z_mm`` is an edge. ``rise``: of a line that begins at x, mm of
        radius for one of z.
        """
        first = int(np.searchsorted(self.edges_mm, z_mm))
        places = np.repeat(self.edges_mm[first:], 2)[1:]
        ends = np.column_stack([self.low_mm[first:], self.high_mm[first:]]).ravel()
        ends -= rise * (places[:-1] - z_mm)
        least = np.minimum.accumulate(np.append(ends, 0.0))
        out = np.searchsorted(-least, -x_mm, side="left")
        before = np.maximum(out - 1, 0)
        drop = least[before] - least[out]
        share = np.divide(least[before] - x_mm, drop, out=np.zeros_like(x_mm), where=drop > 0)
        return np.where(out > 0, places[before] + share * (places[out] - places[before]), z_mm)

    def edge_mm(
        self, z_mm: Array, x_mm: Array, *, lean: float, after: "Stock", from_mm: Array
    ) -> Array:
        """Return up to which radius an edge is in the stock, its tip at z and x, (n,), mm.

        The edge leans back by ``lean``, mm along the axis for one of radius: it leaves the stock at
        the first r above x with R(z + lean (r − x)) ≤ r, and within the last cell at its far end.
        Beyond ``from_mm`` (n,) the stock is what is left of it: ``after``, of the same cells.
        """
        outer = np.maximum(self.radius_mm(z_mm), x_mm)
        if lean <= 0.0:
            return outer
        found, begins = np.full_like(x_mm, np.nan), x_mm.copy()
        cell = np.searchsorted(self.edges_mm, z_mm, side="right") - 1
        for ahead in range(self.low_mm.size):
            at = cell + ahead
            inside = (at >= 0) & (at < self.low_mm.size)
            here = np.clip(at, 0, self.low_mm.size - 1)
            beyond = self.edges_mm[here] >= from_mm - TINY_MM
            radius = np.where(beyond, after.high_mm[here], self.high_mm[here])
            radius = np.where(inside, radius, np.where(at < 0, self.behind_mm, 0.0))
            ends = x_mm + np.maximum(self.edges_mm[here + 1] - z_mm, 0.0) / lean
            leaves = np.isnan(found) & ((ends >= radius) | ~inside)
            found[leaves] = np.clip(np.maximum(radius, begins), x_mm, outer)[leaves]
            begins = ends
            if not np.isnan(found).any():
                break
        return np.where(np.isnan(found), outer, found)

    def turned(self, z_mm: Array, x_mm: Array) -> "Stock":
        """Return the stock with its radius lowered to x along z, both (m,), z rising, on edges."""
        first, last = np.searchsorted(self.edges_mm, [z_mm[0], z_mm[-1]])
        to = np.maximum(np.interp(self.edges_mm[first : last + 1], z_mm, x_mm), 0.0)
        low, high = self.low_mm.copy(), self.high_mm.copy()
        low[first:last] = np.minimum(low[first:last], to[:-1])
        high[first:last] = np.minimum(high[first:last], to[1:])
        return replace(self, low_mm=low, high_mm=high)

    def faced(self, z_mm: float, x_mm: float) -> "Stock":
        """Return the stock with its radius lowered to x from z, an edge, to its face at x."""
        end_mm = float(self.face_mm(z_mm, np.array([max(x_mm, 0.0)]))[0])
        if end_mm <= z_mm:
            return self
        last = min(int(np.searchsorted(self.edges_mm, end_mm)), self.low_mm.size)
        return self.turned(np.array([z_mm, self.edges_mm[last]]), np.array([x_mm, x_mm]))

    def grazed(self, z_mm: float, x_mm: float, *, rise: float) -> "Stock":
        """Return the stock lowered from z, an edge, to a line that rises from x to its surface."""
        end_mm = float(self.face_mm(z_mm, np.array([max(x_mm, 0.0)]), rise=rise)[0])
        if end_mm <= z_mm:
            return self
        last = min(int(np.searchsorted(self.edges_mm, end_mm)), self.low_mm.size)
        to_mm = self.edges_mm[last]
        ends = np.array([x_mm, x_mm + rise * (to_mm - z_mm)])
        return self.turned(np.array([z_mm, to_mm]), ends)

    def put(self, cells: NDArray[np.bool_], other: "Stock") -> "Stock":
        """Return the stock with some cells (n,) as they are in another one of the same cells."""
        low, high = np.where(cells, other.low_mm, self.low_mm), other.high_mm
        return replace(self, low_mm=low, high_mm=np.where(cells, high, self.high_mm))

    def volume_mm3(self, *, from_mm: float) -> float:
        """Return the volume in front of z: V = Σ π h (a² + a b + b²)/3 of the cells, mm³.

        Cones of height h with radii a and b at their ends.
        """
        span_mm = float(np.ptp(np.append(self.edges_mm, from_mm)))
        whole = self.divided(np.array([from_mm]), cell_mm=span_mm)
        first = int(np.searchsorted(whole.edges_mm, from_mm))
        a, b = whole.low_mm[first:], whole.high_mm[first:]
        return float(np.pi / 3 * np.sum(np.diff(whole.edges_mm)[first:] * (a * a + a * b + b * b)))


def nothing_around(bored: Stock, outer: Stock, *, mirror_mm: float) -> NDArray[np.bool_]:
    """Return in which cells, (n,), a bore, mirrored about a radius, has no work around it.

    So in front of a face that was cut back. Both are of the same cells.
    """
    hole_mm = mirror_mm - np.maximum(bored.low_mm, bored.high_mm)
    return np.asarray(np.maximum(outer.low_mm, outer.high_mm) <= hole_mm + TINY_MM)


def hollow_mm3(outer: Stock, inner: Stock, *, from_mm: float) -> float:
    """Return the volume in front of z between two surfaces, mm³: none where the inner is larger.

    So a bore that is longer than what a face has left.
    """
    edges = np.concatenate([outer.edges_mm, inner.edges_mm, [from_mm]])
    around, bore = (one.divided(edges, cell_mm=float(np.ptp(edges))) for one in (outer, inner))
    bore = replace(
        bore,
        low_mm=np.minimum(bore.low_mm, around.low_mm),
        high_mm=np.minimum(bore.high_mm, around.high_mm),
    )
    return around.volume_mm3(from_mm=from_mm) - bore.volume_mm3(from_mm=from_mm)


def bar(radius_mm: float, *, face_mm: float = 0.0) -> Stock:
    """Return a cylinder from its face towards the chuck.

    Its cell is as long as it is thick; it goes on behind.
    """
    return profile(np.array([face_mm - radius_mm, face_mm]), np.array([radius_mm, radius_mm]))


def profile(z_mm: Array, radius_mm: Array) -> Stock:
    """Return a stock with a radius at each z, (n,), rising, straight in between.

    A z that stands twice is a square shoulder. Raises ValueError where z falls or radii are < 0.
    """
    steps = np.diff(z_mm)
    if steps.size == 0 or np.any(steps < 0) or np.any(radius_mm < 0):
        raise ValueError("a profile needs two places, z rising, radii of at least 0")
    cells = steps > 0
    edges = np.append(z_mm[:-1][cells], z_mm[-1])
    low_mm, high_mm = radius_mm[:-1][cells], radius_mm[1:][cells]
    return Stock(edges, low_mm, high_mm, float(low_mm[0]))
