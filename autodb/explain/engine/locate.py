"""Where a mismatch sits: the stretch of a load, and the range of a signal that holds its energy."""

import numpy as np
from numpy.typing import NDArray

from autodb.explain.answer.answer import Regime

Array = NDArray[np.float64]

SHARE = 0.7
"""A regime holds this share of the energy …"""
NARROW = 0.6
"""… in at most this part of the signal's range; otherwise the mismatch is not confined by it."""


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


def regimes(contribution: Array, signals: dict[str, Array], *, bins: int = 24) -> list[Regime]:
    """Return the signals in whose narrow range most of a contribution's energy sits.

    Energy per row is compared over equal bins of the signal, so that a place where the axis dwells
    counts no more than one it passes.
    """
    found: list[Regime] = []
    for name, signal in signals.items():
        low, high = float(signal.min()), float(signal.max())
        if high <= low:
            continue
        place = np.minimum((signal - low) / (high - low) * bins, bins - 1).astype(np.intp)
        count = np.bincount(place, minlength=bins)
        energy = np.bincount(place, weights=contribution**2, minlength=bins) / np.maximum(count, 1)
        start, end, share = _narrowest(energy)
        if end - start <= NARROW * bins:
            width = (high - low) / bins
            found.append(
                Regime(signal=name, low=low + start * width, high=low + end * width, share=share)
            )
    return found


def _narrowest(energy: Array) -> tuple[int, int, float]:
    """Return the shortest run of bins that holds SHARE of the energy, and what it holds."""
    total = np.concatenate([[0.0], np.cumsum(energy)]) / max(float(energy.sum()), 1e-300)
    n = len(energy)
    for width in range(1, n + 1):
        held = total[width:] - total[:-width]
        start = int(np.argmax(held))
        if held[start] >= SHARE:
            return start, start + width, float(held[start])
    return 0, n, 1.0
