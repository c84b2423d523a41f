"""Where a mismatch sits: the stretch of a load, and the range of a signal that holds most of it."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from autodb.explain.answer import Regime

Array = NDArray[np.float64]

DENSER = 1.5
"""A regime holds this many times the squared error of as many rows taken anywhere. Spread evenly it
is 1; what acts in one of two directions alone comes to 2, and a load that grows along the travel to
1.75 in its upper half. Chosen."""
SHARE = 0.5
"""A regime holds this share of the squared error at least: most of it."""
FEWEST = 5
"""Rows of a regime: one or two that stand out are no range. Chosen."""
TINY = 1e-300


def strongest_interval(residual: Array, *, bins: int = 400) -> tuple[int, int, int]:
    """Return (start, end, tries): the rows in which a constant added to the residual explains most.

    Sums over all pairs of ``bins`` edges by cumulative sums, Σ²/length maximal; then each edge is
    refined row by row between its neighbours. At most 80 % of the rows.
    """
    n = len(residual)
    edges = np.unique(np.linspace(0, n, min(bins, n) + 1).astype(np.intp))
    total = np.concatenate([[0.0], np.cumsum(residual - residual.mean())])
    length = edges[None, :] - edges[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        gain = (total[edges][None, :] - total[edges][:, None]) ** 2 / length
    gain[(length <= 0) | (length > 0.8 * n)] = -np.inf
    i, j = np.unravel_index(int(np.argmax(gain)), gain.shape)
    start, end = int(edges[i]), int(edges[j])
    reach = int(np.ceil(n / len(edges))) + 1
    for _ in range(2):
        start = _refine(
            total, np.arange(max(0, start - reach), min(end - 1, start + reach) + 1), end
        )
        end = _refine(total, np.arange(max(start + 1, end - reach), min(n, end + reach) + 1), start)
    return start, end, int(len(edges) * (len(edges) - 1) / 2)


def _refine(total: Array, moved: NDArray[np.intp], fixed: int) -> int:
    gain = (total[moved] - total[fixed]) ** 2 / np.maximum(np.abs(moved - fixed), 1)
    return int(moved[np.argmax(gain)])


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
