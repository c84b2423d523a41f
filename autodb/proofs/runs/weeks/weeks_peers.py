"""Other ways to predict a cut from all of its pair's cuts so far: least squares, neighbours, trees.

Each sees what autodb has sensed and what the shop wrote down of those cuts (n, 4): the logarithms
of feed, depth of cut and cutting speed, and the cutting time of the edge, s. Kienzle's line is that
of ``curve_peers``, with a power of the speed. Trees see all four, boosted (Friedman 2001) on the
logarithm of the force per mm of depth.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.runs.pairs.curve_peers import DEPTH, kienzle_with_speed

Array = NDArray[np.float64]
Way = Callable[[Array, Array, Array], Array]

NEIGHBOURS = 5
TREES, RATE, LEAF = 100, 0.1, 4  # usual numbers for so few rows; chosen
SPLITS = 8  # values of a column that a split is tried at


def by_squares(cuts: Array, force_N: Array, asked: Array) -> Array:
    """Return what Kienzle's line through all cuts so far expects (m,)."""
    return kienzle_with_speed(cuts[:, :3], force_N, asked[:, :3])


def by_neighbours(cuts: Array, force_N: Array, asked: Array) -> Array:
    """Return the mean force per mm of depth of the nearest cuts, times the depth asked (m,)."""
    scale = np.maximum(np.std(cuts, axis=0), 1e-9)
    apart = np.sum(((asked[:, None] - cuts[None]) / scale) ** 2, axis=2)
    nearest = np.argsort(apart, axis=1)[:, :NEIGHBOURS]
    per_mm = np.log(force_N) - cuts[:, DEPTH]
    return np.asarray(np.exp(np.mean(per_mm[nearest], axis=1) + asked[:, DEPTH]))


def by_trees(cuts: Array, force_N: Array, asked: Array) -> Array:
    """Return what boosted trees of four leaves expect (m,)."""
    per_mm = np.log(force_N) - cuts[:, DEPTH]
    begun = float(np.mean(per_mm))
    now, found = np.full(len(cuts), begun), np.full(len(asked), begun)
    for _ in range(TREES):
        step, asked_step = _tree(cuts, per_mm - now, asked)
        now, found = now + RATE * step, found + RATE * asked_step
    return np.asarray(np.exp(found + asked[:, DEPTH]))


PEERS: dict[str, Way] = {
    "Kienzle's line": by_squares,
    "nearest neighbours": by_neighbours,
    "boosted trees": by_trees,
}


def _tree(rows: Array, left: Array, asked: Array, deep: int = 2) -> tuple[Array, Array]:
    """Return a tree's values at its own rows and at others."""
    best = _split(rows, left) if deep else None
    if best is None:
        mean = float(np.mean(left))
        return np.full(len(rows), mean), np.full(len(asked), mean)
    column, at = best
    value, other = np.empty(len(rows)), np.empty(len(asked))
    for side in (True, False):
        own, theirs = (rows[:, column] <= at) == side, (asked[:, column] <= at) == side
        value[own], other[theirs] = _tree(rows[own], left[own], asked[theirs], deep - 1)
    return value, other


def _split(rows: Array, left: Array) -> tuple[int, float] | None:
    """Return column and value of the split that leaves the least squares; None: too few rows."""
    best, found = np.inf, None
    for column in range(rows.shape[1]):
        for at in np.unique(np.quantile(rows[:, column], np.linspace(0.05, 0.95, SPLITS))):
            below = rows[:, column] <= at
            if min(below.sum(), (~below).sum()) < LEAF:
                continue
            squares = sum(np.sum((left[one] - left[one].mean()) ** 2) for one in (below, ~below))
            if squares < best:
                best, found = float(squares), (column, float(at))
    return found
