"""Where a mismatch sits: the stretch of a load, and the range of a signal that holds most of it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from autodb.explain.answer import Regime
from autodb.explain.engine.normal import HELD, columns_side_by_side

Array = NDArray[np.float64]

DENSER = 1.5
"""A regime holds this many times the squared error of as many rows taken anywhere. Spread evenly it
is 1; what acts in one of two directions alone comes to 2, and a load that grows along the travel to
1.75 in its upper half. Chosen."""
SHARE = 0.5
"""A regime holds this share of the squared error at least: most of it."""
FEWEST = 5
"""Rows of a regime: one or two that stand out are no range. Chosen."""
LONGEST = 0.8
"""Share of the rows that a stretch covers at most: what is longer is its own opposite. Chosen."""
SHOWN = 0.05
"""Share of a stretch's squares that columns beside it must leave for it to be told. Chosen."""
TINY = 1e-300


def strongest_interval(
    residual: Array, beside: Array | None = None, *, inside: float = 0.0, bins: int = 400
) -> tuple[int, int, int]:
    """Return (start, end, tries): the rows in which a constant explains most of a residual (n,)
    beside a constant everywhere and columns (n, k) that are fitted with it.

    Of all pairs of ``bins`` edges, ``inside`` times n rows from the ends at least, the one with
    which the squares fall most; then each edge is refined row by row between its neighbours. It is
    ``LONGEST`` of the rows at most, and not given by the columns but for ``SHOWN``; an empty one,
    start = end, where there is none.
    """
    n = len(residual)
    first = int(np.ceil(inside * n))
    edges = np.unique(np.linspace(first, n - first, min(bins, n) + 1).astype(np.intp))
    falls = _Falls.beside(residual, beside)
    gain = np.array([falls.of(start, edges) for start in edges])
    gain[edges[None, :] - edges[:, None] <= 0] = -np.inf
    i, j = np.unravel_index(int(np.argmax(gain)), gain.shape)
    start, end = int(edges[i]), int(edges[j])
    if not np.isfinite(gain[i, j]):
        return first, first, 1
    reach = int(np.ceil(n / len(edges))) + 1
    for _ in range(2):
        near = np.arange(max(first, start - reach), min(end - 1, start + reach) + 1)
        start = int(near[np.argmax(falls.of(end, near))])
        near = np.arange(max(start + 1, end - reach), min(n - first, end + reach) + 1)
        end = int(near[np.argmax(falls.of(start, near))])
    return start, end, int(len(edges) * (len(edges) - 1) / 2)


@dataclass(frozen=True)
class _Falls:
    """By how much the squares of a residual fall with a constant between two rows: its sums up to
    each row, (n + 1,), and those of the columns of length 1 beside it, (n + 1, k).
    """

    total: Array
    held: Array

    @classmethod
    def beside(cls, residual: Array, columns: Array | None) -> Self:
        """Return the falls beside a constant and columns (n, k)."""
        n = len(residual)
        given = columns_side_by_side(np.ones(n), np.empty((n, 0)) if columns is None else columns)
        lengths = np.linalg.norm(given, axis=0)
        base, sizes, _ = np.linalg.svd(given[:, lengths > 0] / lengths[lengths > 0], False)
        base = base[:, sizes > HELD * sizes[0]]
        left = residual - base @ (base.T @ residual)
        sums = np.cumsum(np.column_stack([left, base]), axis=0)
        sums = np.vstack([np.zeros((1, sums.shape[1])), sums])
        return cls(sums[:, 0], sums[:, 1:])

    def of(self, fixed: int, moved: NDArray[np.intp]) -> Array:
        """Return the falls with a constant between one row and each of others."""
        length = np.abs(moved - fixed)
        own = length - np.sum((self.held[moved] - self.held[fixed]) ** 2, axis=1)
        able = (own > SHOWN * length) & (length <= LONGEST * (len(self.total) - 1)) & (length > 0)
        falls = (self.total[moved] - self.total[fixed]) ** 2 / np.where(able, own, 1.0)
        return np.where(able, falls, -np.inf)


def regimes(
    difference: Array, correction: Array, signals: Mapping[str, Array]
) -> tuple[Regime, ...]:
    """Return the ranges of signals in which the squared error is concentrated.

    ``difference`` (n,): recording − simulation; ``correction`` (n,): what was found of it, which
    must be concentrated there too, since noise may be; ``signals`` (n,) by name.
    """
    error, found = (
        values**2 / max(float(values @ values), TINY) for values in (difference, correction)
    )
    made = (_regime(name, values, error, found) for name, values in signals.items())
    return tuple(regime for regime in made if regime is not None)


def _regime(name: str, signal: Array, error: Array, found: Array) -> Regime | None:
    """Return the range of a signal with the most of ``error`` (n,) beyond DENSER of the mean row.

    It is the interval of the largest excess mass (Müller, Sawitzki 1991) at that density; rows of
    one value go together. None where it is not concentrated.
    """
    order = np.argsort(signal, kind="stable")
    values, begins = np.unique(signal[order], return_index=True)
    excess = np.add.reduceat(error[order] - DENSER / len(signal), begins)
    total = np.concatenate([[0.0], np.cumsum(excess)])
    lowest = np.minimum.accumulate(total[:-1])
    end = int(np.argmax(total[1:] - lowest))
    start = int(np.argmin(total[: end + 1]))
    low, high = float(values[start]), float(values[end])
    inside = (signal >= low) & (signal <= high)
    count, share = int(np.count_nonzero(inside)), float(np.sum(error[inside]))
    rows = count / len(signal)
    concentrated = min(share, float(np.sum(found[inside]))) >= max(SHARE, DENSER * rows)
    if count < FEWEST or not concentrated:
        return None
    return Regime(signal=name, low=low, high=high, share=min(share, 1.0), rows=rows)
