"""Ripples along the travel: found in what a model leaves, and told apart by direction."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.terms import COGGING, FRICTION_RIPPLE, Term

Array = NDArray[np.float64]

MARGIN = 10.0
"""ΔlnL after its price above which a ripple is believed: e^10 against chance. Chosen."""
FEWEST_WAVES = 3.0
OVERSAMPLED = 4


@dataclass(frozen=True)
class Ripple:
    """A periodic load: its period [mm or the position's unit], size, and which law it follows.

    ``term``: cogging (keeps its sign in both directions) or periodic position friction (flips);
    ``evidence``: ln of how much better than no ripple, after the price of the search;
    ``over_other``: the same against the other law.
    """

    term: Term
    period: float
    amplitude: float
    evidence: float
    over_other: float


def strongest_ripple(
    position: Array, direction: Array, residual: Array, *, correlation_rows: float = 1.0
) -> Ripple | None:
    """Return the strongest ripple of a residual (n,) over position (n,), or None.

    Both laws are tried: residual and residual · sgn(v), binned over position, spectrum from
    FEWEST_WAVES waves over the travel to a quarter of the bins; the period is then refined on all
    rows. ``correlation_rows``: rows that count as one, because noise is correlated.
    """
    moving = np.abs(direction) >= 1.0
    if moving.sum() < 64 or np.ptp(position) <= 0:
        return None
    place, sense, left = position[moving], direction[moving], residual[moving]
    left = left - left.mean()
    rows = len(left) / correlation_rows
    best: dict[str, tuple[float, float, float, float]] = {}
    for term, signal in ((COGGING, left), (FRICTION_RIPPLE, left * sense)):
        found = _search(place, signal)
        if found is None:
            return None
        period, tries = found
        amplitude, gain = _fitted(place, signal, period)
        best[term.form] = (_evidence(gain, rows, tries), period, amplitude, gain)
    (form, (evidence, period, amplitude, _)), other = (
        max(best.items(), key=lambda item: item[1][0]),
        min(value[0] for value in best.values()),
    )
    if evidence < MARGIN:
        return None
    term = COGGING if form == COGGING.form else FRICTION_RIPPLE
    return Ripple(term, period, amplitude, evidence, evidence - other)


def _evidence(gain: float, rows: float, tries: int) -> float:
    """Return ΔlnL − 3/2 ln n − ln(tries): cosine, sine, period, and the places looked at."""
    return -0.5 * rows * float(np.log1p(-gain)) - 1.5 * float(np.log(rows)) - float(np.log(tries))


def _search(place: Array, signal: Array) -> tuple[float, int] | None:
    """Return (period, places looked at) of the largest line in the spectrum over position."""
    travel = float(np.ptp(place))
    bins = int(min(1 << 14, len(place) // 4))
    if bins < 64:
        return None
    at = np.minimum((place - place.min()) / travel * bins, bins - 1).astype(np.intp)
    total = np.bincount(at, weights=signal, minlength=bins)
    count = np.bincount(at, minlength=bins)
    mean = total / np.sqrt(np.maximum(count, 1))
    spectrum = np.abs(np.fft.rfft(mean, n=OVERSAMPLED * bins))
    waves = np.arange(len(spectrum)) / OVERSAMPLED
    searched = (waves >= FEWEST_WAVES) & (waves <= bins / 4)
    if not searched.any():
        return None
    first = float(waves[searched][np.argmax(spectrum[searched])])
    return _refined(place, signal, travel / first, travel), int(searched.sum())


def _refined(place: Array, signal: Array, period: float, travel: float) -> float:
    """Return the period that explains most, within one line of the spectrum around ``period``."""
    half = period**2 / travel / OVERSAMPLED
    low, high = period - half, period + half
    for _ in range(4):
        grid = np.linspace(low, high, 9)
        gains = [_fitted(place, signal, float(p))[1] for p in grid]
        at = int(np.argmax(gains))
        low, high = grid[max(at - 1, 0)], grid[min(at + 1, 8)]
    return float(0.5 * (low + high))


def _fitted(place: Array, signal: Array, period: float) -> tuple[float, float]:
    """Return (amplitude, share of the signal's energy) of cosine and sine of a period."""
    columns = COGGING.function(place, period_mm=period)
    weights, rss, *_ = np.linalg.lstsq(columns, signal, rcond=None)
    total = float(signal @ signal)
    left = float(rss[0]) if rss.size else total
    return float(np.hypot(*weights)), 1.0 - left / total if total > 0 else 0.0


@dataclass(frozen=True)
class Orders:
    """Harmonics of one revolution: order, cosine, sine, (k,) each, by size."""

    order: NDArray[np.intp]
    cosine: Array
    sine: Array

    def at(self, angle_rad: Array) -> Array:
        """Return the ripple (n,) at angles (n,)."""
        phase = np.multiply.outer(angle_rad, self.order)
        return np.asarray(np.cos(phase) @ self.cosine + np.sin(phase) @ self.sine)


def find_orders(angle_rad: Array, values: Array, *, highest: int | None = None) -> Orders:
    """Return the orders of a revolution that measured values (n,) at angles (n,) hold for sure.

    One after the other the order that explains most of what is left is taken, while it is worth its
    parameters (n·ln of the RSS ratio > 2 ln n + 2 ln of the orders tried, Schwarz's criterion with
    the price of the search); the taken ones are re-fitted together, with a constant. ``highest``:
    the highest order tried, a third of the rows if not given.
    """
    n = len(values)
    highest = highest or n // 3
    tried = np.arange(1, highest + 1)
    phase = np.multiply.outer(angle_rad, tried)
    cosines, sines = np.cos(phase), np.sin(phase)
    taken: list[int] = []
    design = np.ones((n, 1))
    left = values - values.mean()
    weights = np.array([values.mean()])
    while len(taken) < highest:
        gain = (cosines.T @ left) ** 2 + (sines.T @ left) ** 2
        gain[[k - 1 for k in taken]] = 0.0
        order = int(tried[np.argmax(gain)])
        wider = np.column_stack([design, cosines[:, order - 1], sines[:, order - 1]])
        new = np.linalg.lstsq(wider, values, rcond=None)[0]
        rest = values - wider @ new
        worth = n * np.log((left @ left) / max(float(rest @ rest), 1e-300))
        if worth < 2.0 * np.log(n) + 2.0 * np.log(highest):
            break
        taken.append(order)
        design, left, weights = wider, rest, new
    return Orders(np.array(taken, dtype=np.intp), weights[1::2], weights[2::2])
