"""Scatter of the forces of a cut: its standard deviation, and what components share of it.

It is what a rich model leaves, of columns over all cuts and of two that each edge has for its own
cuts. Those of two edges have no row in common: they are orthogonal, at most two of them are not
zero in a row, and they are projected out edge by edge. A table of 100 000 cuts by 2 500 edges has
5 000 of them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import qr

from autodb.explain.cuts.candidates.laws import LawColumns
from autodb.explain.cuts.stack import Conditions, Stack

Array = NDArray[np.float64]

SHARES = np.geomspace(0.05, 20.0, 16)
"""Values of a/(b·rms F) that are tried: scatter from relative to constant."""
LIKELY = 1.0
"""The ratio that is likeliest beforehand, within a factor e: constant and relative scatter are of
one size. Chosen; it steadies short tables."""
LEAST_LEFT = 0.05
"""Of a row that its own fit follows, no less than this share counts as scatter."""
FAR, SEEN = 6.0, 0.944
"""Squares beyond this many variances count as so many; a normal one then has this mean."""
ENOUGH = 20
"""Cuts from which on outliers are distinguished from the others."""
SHRUNK = 20.0
"""Cuts that the correlation of components is pulled towards none by: chosen."""
FINEST = 1e-3
"""Scatter is this share of the usual force at least. Chosen: dynamometers are linear to a tenth of
a per cent at best. A recording that is its simulation, or a law of it, has none of its own."""
NONE = 1e-300
"""Sum of squares of scatter where there is none."""
LOCAL = 3
"""A rich model has at most one column for this many cuts."""
STEPS = 4
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


def with_noise(
    stack: Stack, found: Sequence[LawColumns] | None = None, *, own: Sequence[LawColumns] = ()
) -> tuple[Stack, float]:
    """Return the stack with scatter estimated, and its degrees of freedom.

    What a rich model leaves is taken for scatter: sd² = a² + b²F² by component with one ratio of a
    to b, correlated between components. Scatter that goes on from cut to cut counts as more of it:
    its sd is raised by √((1 + ρ)/(1 − ρ)), ρ beyond what chance gives. ``found``: further columns,
    of what was found; without any the difference may hold far more than scatter, and nothing is
    said of what goes together. ``own``: columns that are free anyhow, beside force and depth.
    """
    count, n = stack.simulation.shape
    left = np.empty_like(stack.simulation)
    sd = np.ones_like(left)
    freedom = np.empty(count)
    rich = _rich(stack)
    for i in range(count):
        design, edges = _design(stack, rich, i, [*own, *(found or ())])
        difference = stack.recording[i] - stack.simulation[i]
        sd[i] = np.maximum(np.abs(stack.simulation[i]), 1e-3 * np.abs(stack.simulation[i]).max())
        sd[i] *= _spread(stack, i, sd[i])
        weight = np.ones(n)
        for _ in range(STEPS):
            left[i], leverage = residual(design, edges, difference, sd[i] / weight)
            freedom[i] = max(1.0, n - float(leverage.sum()))
            squares = left[i] ** 2 / np.maximum(1.0 - leverage, LEAST_LEFT)
            if n >= ENOUGH:
                squares = np.minimum(squares, FAR * sd[i] ** 2) / SEEN
            sd[i] = _sd(squares, stack.simulation[i])
            weight = np.minimum(1.0, np.sqrt(FAR) * sd[i] / np.maximum(np.abs(left[i]), 1e-300))
    if found is None:
        return replace(stack, sd=sd), float(freedom.sum())
    z = left / sd
    norm = np.sqrt(np.maximum(np.sum(z**2, axis=1), NONE))
    correlation = (z @ z.T) / np.outer(norm, norm)
    correlation = (n * correlation + SHRUNK * np.eye(count)) / (n + SHRUNK)
    mixing = np.linalg.inv(np.linalg.cholesky(correlation))
    raised = np.sqrt(_persistence(z))
    return replace(stack, sd=sd * raised, mixing=mixing), float(freedom.sum())


def _spread(stack: Stack, component: int, shape: Array) -> float:
    """Return a first size of the scatter: the root mean square of the difference over a shape."""
    difference = (stack.recording - stack.simulation)[component]
    return max(float(np.sqrt(np.mean((difference / shape) ** 2))), FINEST)


def _persistence(z: Array) -> float:
    """Return (1 + ρ)/(1 − ρ) of rows (C, n), ρ the correlation of neighbours beyond chance."""
    if z.shape[1] < 5:
        return 1.0
    rho = float(np.sum(z[:, 1:] * z[:, :-1]) / max(np.sum(z**2), NONE))
    rho = min(0.98, max(0.0, rho - 2.0 / np.sqrt(z.size)))
    return float((1.0 + rho) / (1.0 - rho))


def _sd(squares: Array, force: Array) -> Array:
    """Return √(a² + b²F²) (n,), likeliest over the ratio a/b for squares of scatter (n,)."""
    best, found = np.inf, np.ones_like(squares)
    usual = float(np.sqrt(np.mean(force**2)))
    for share in SHARES:
        shape = (share * usual) ** 2 + force**2
        scale = max(float(np.mean(squares / shape)), 1e-300)
        cost = float(np.mean(np.log(shape))) * len(squares) + len(squares) * np.log(scale)
        cost += 0.5 * np.log(share / LIKELY) ** 2
        if cost < best:
            best, found = cost, np.sqrt(scale * shape)
    return np.asarray(np.maximum(found, FINEST * usual + 1e-12), dtype=np.float64)


def _design(
    stack: Stack, rich: list[Array], component: int, found: Sequence[LawColumns]
) -> tuple[Array, OfEdges]:
    """Return the columns (n, p) of one component, and those of edges; one for LOCAL cuts at most.

    The likeliest columns come first, those of edges last.
    """
    force, depth = stack.simulation[component], stack.known.depth_mm
    columns = [force, depth]
    further = [c.of(component) for c in found]
    columns += [c for block in further for c in block.T if np.any(c)]
    columns += [(depth if number % 2 else force) * c for number, c in enumerate(rich)]
    known = 2 + sum(block.shape[1] for block in further)
    most = max(min(known, len(force) // 2), len(force) // LOCAL - 1)
    turns = (force, depth) if len(rich) % 2 == 0 else (depth, force)
    return np.column_stack(columns[:most]), of_edges(stack.known, turns, most - len(columns))


def _rich(stack: Stack) -> list[Array]:
    """Return shapes over cuts by turns of the force and of the depth, the likeliest first."""
    known = stack.known
    ordered = over_range(np.arange(len(known), dtype=np.float64))
    shapes: list[Array] = [ordered]
    time = stack.wear_goes_with
    shapes.append(ordered if time is None else over_range(time))
    for name in ("cutting.feed", "cutting.speed", "cutting.depth"):
        if name in known.other:
            along = over_range(np.log(known.other[name]))
            shapes += [along, along**2]
    if time is not None:
        shapes += [over_range(time), over_range(time) ** 2]
    if len(known) > 60:
        shapes += [c for c in _bumps(ordered, 12).T for _ in (0, 1)]
    if "z.position" in known.other:
        shapes += [over_range(known.other["z.position"])] * 2
    if len(known) > 60 and "cutting.speed" in known.other:
        shapes += list(_bumps(over_range(np.log(known.other["cutting.speed"])), 5).T)
    return shapes


def _bumps(values: Array, count: int) -> Array:
    """Return ``count`` Gaussian bumps over −1 to 1, (n, count)."""
    centres = np.linspace(-1.0, 1.0, count)
    width = 2.0 / (count - 1)
    return np.asarray(np.exp(-0.5 * ((values[:, None] - centres) / width) ** 2))


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
