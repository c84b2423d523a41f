"""Sines over a place or a time whose values are not evenly spaced."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

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
    return _peak(finer, exact), int(open_ones.sum()) // 4


def _peak(at: Array, height: Array) -> float:
    """Return where a curve (n,) over even places is highest, between them by a parabola."""
    best = int(np.argmax(height))
    if not 0 < best < len(at) - 1:
        return float(at[best])
    before, top, after = height[best - 1 : best + 2]
    bend = before - 2.0 * top + after
    return float(
        at[best] + (0.5 * (before - after) / bend if bend < 0.0 else 0.0) * (at[1] - at[0])
    )


@dataclass(frozen=True)
class WhiteSines:
    """How noise of a colour is seen: ``white`` makes rows (n,) or columns (n, p) white, ``adjoint``
    rows white forwards and backwards, and ``length`` gives the squared length of a white sine by
    its number of waves.
    """

    white: Callable[[Array], Array]
    adjoint: Callable[[Array], Array]
    length: Callable[[Array], Array]


def waves_beside(
    place: Array,
    rows: Array,
    first: float,
    seen: WhiteSines,
    *,
    asked: float,
    fewest: float,
    most: int,
) -> tuple[float, ...]:
    """Return the sines over a place (n,) that stand out in rows (n,), each by its waves over the
    range: a first one, and others, each searched for in what those before leave.

    Another needs that N ln of the mean square of white rows falls by ``asked``; ``fewest``: waves
    that it has at least; ``most`` of them, the first counted.
    """
    found = [first]
    left = _left_beside(place, rows, found, seen)
    while len(found) < most:
        more = strongest_wave(place, seen.adjoint(left), seen.length, fewest=fewest)
        if more is None:
            break
        after = _left_beside(place, rows, [*found, more[0]], seen)
        fall = np.log(np.mean(seen.white(left) ** 2) / np.mean(seen.white(after) ** 2))
        if len(rows) * fall < asked:
            break
        found.append(more[0])
        left = after
    return tuple(found)


def _left_beside(place: Array, rows: Array, waves: Sequence[float], seen: WhiteSines) -> Array:
    """Return what sines fitted to white rows leave of the rows, (n,)."""
    angle = 2 * np.pi * (place - place.min()) / np.ptp(place)
    columns = np.column_stack([f(one * angle) for one in waves for f in (np.cos, np.sin)])
    sizes = np.linalg.lstsq(seen.white(columns), seen.white(rows), rcond=None)[0]
    return np.asarray(rows - columns @ sizes)


def _summed(at: Array, weight: Array, bins: int) -> Array:
    """Return the sums of weights (n,) at places 0 to bins − 1, each shared by its neighbours."""
    low = np.minimum(at.astype(np.intp), bins - 2)
    share = at - low
    return np.asarray(
        np.bincount(low, weights=weight * (1.0 - share), minlength=bins)
        + np.bincount(low + 1, weights=weight * share, minlength=bins)
    )
