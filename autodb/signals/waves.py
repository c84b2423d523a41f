"""Sines over a place or a time whose values are not evenly spaced."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MOST_WAVES = 1024
ROWS_A_WAVE = 2.2
"""Rows that a sine takes at least: a little more than two, which tell none from its alias."""
BINS, FINER = 65536, 4
"""Parts of the range that products are summed over, and how many a row at most: with fewer than
rows, what is fast in white residuals folds into slow waves."""


def strongest_wave(
    place: Array, weight: Array, length: Callable[[Array], Array], *, fewest: float
) -> tuple[float, int] | None:
    """Return (waves over the range, number of waves tried) of the strongest sine in ``weight``.

    ``place``, ``weight``: (n,); ``length`` gives the squared length of a sine by its number of
    waves; ``fewest``: waves over the range at least. None where nothing moves.
    """
    span = float(np.ptp(place))
    if span <= 0:
        return None
    bins = int(min(BINS, FINER * len(place)))
    total = _summed((place - place.min()) / span * (bins - 1), weight, bins)
    most = min(MOST_WAVES, int(len(place) / ROWS_A_WAVE))
    waves = np.arange(4 * most + 1) / 4.0 * (bins - 1) / bins
    spectrum = np.abs(np.fft.rfft(total, n=4 * bins)[: len(waves)]) ** 2
    open_ones = waves >= fewest
    if not open_ones.any():
        return None
    strength = np.where(open_ones, spectrum / np.maximum(length(waves), 1e-300), 0.0)
    best = waves[int(np.argmax(strength))]
    finer = best + np.linspace(-0.25, 0.25, 41)
    phase = 2j * np.pi * (place - place.min()) / span
    turned, step = np.exp(phase * finer[0]), np.exp(phase * (finer[1] - finer[0]))
    exact = np.empty(len(finer))
    for number in range(len(finer)):
        exact[number] = abs(turned @ weight) ** 2
        turned *= step
    return float(finer[int(np.argmax(exact))]), int(open_ones.sum()) // 4


def _summed(at: Array, weight: Array, bins: int) -> Array:
    """Return the sums of weights (n,) at places 0 to bins − 1, each shared by its neighbours."""
    low = np.minimum(at.astype(np.intp), bins - 2)
    share = at - low
    return np.asarray(
        np.bincount(low, weights=weight * (1.0 - share), minlength=bins)
        + np.bincount(low + 1, weights=weight * share, minlength=bins)
    )
