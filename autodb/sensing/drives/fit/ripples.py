"""Ripples along the travel: found in what a model leaves, and told apart by direction."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.covariance import autoregression
from autodb.terms.drive import COGGING, FRICTION_RIPPLE
from autodb.terms.term import Term

Array = NDArray[np.float64]

MARGIN = 10.0
"""ΔlnL after its price above which a ripple is believed: e^10 against chance. Chosen."""
FEWEST_WAVES = 3.0
OVERSAMPLED = 4
MOST_PARTS = 6
"""The strongest ripple of a pole may be up to this harmonic. Chosen."""
SHARE_OF_ALL = 0.95
"""Of what the best period explains, that is enough for a shorter one. Chosen."""
SETTLED = 3
"""Orders of the filter for which the axis has moved before a row counts."""
STEP_CLASSES = 60
"""Classes of speed over which the filter's gain is averaged."""


@dataclass(frozen=True)
class Ripple:
    """A periodic load: its period [mm or the position's unit], size, and which law it follows.

    ``term``: cogging (keeps its sign in both directions) or periodic position friction (flips);
    ``evidence``: ln of how much better than no ripple, after the price of the search;
    ``over_other``: the same against the other law; ``pole``: the way after which all that is
    periodic repeats, of which the strongest ripple may be a part.
    """

    term: Term
    period: float
    amplitude: float
    evidence: float
    over_other: float
    pole: float


def strongest_ripple(
    position: Array, direction: Array, residual: Array, *, order: int = 10
) -> Ripple | None:
    """Return the strongest ripple of a residual (n,) over position (n,), or None.

    Rows evenly in time. Noise is an autoregression of ``order``; both laws are tried with a filter
    matched to it, over periods from a third of the travel to four bins of position, and the period
    is refined with white rows. Rows near a standstill or reversal do not count.
    """
    travel = float(np.ptp(position))
    bins = int(min(1 << 14, len(position) // 4))
    if bins < 64 or travel <= 0:
        return None
    a, _ = autoregression(residual, order)
    noise = _Noise(a, residual - residual.mean(), _far_from_reversals(direction, SETTLED * order))
    if noise.kept.sum() < 64:
        return None
    found = []
    for term, sense in ((COGGING, np.ones_like(position)), (FRICTION_RIPPLE, direction)):
        period, tries = _search(noise, position, sense, bins)
        period = _refined(noise, position, sense, period)
        amplitude, gain = noise.fitted(_ripple(position, sense, period))
        evidence = gain - 1.5 * float(np.log(len(position))) - float(np.log(2.0 * tries))
        found.append(Ripple(term, period, amplitude, evidence, 0.0, period))
    best, other = found if found[0].evidence >= found[1].evidence else found[::-1]
    if best.evidence < MARGIN:
        return None
    pole = period_of_all(noise, position, best) if best.term is COGGING else best.period
    return replace(best, over_other=best.evidence - other.evidence, pole=pole)


def period_of_all(noise: "_Noise", position: Array, strongest: Ripple) -> float:
    """Return the period of a pole: the strongest ripple's, or the multiple that explains more.

    With m times the period come 2m harmonics, up to the strongest one's second. The smallest m of
    up to MOST_PARTS counts that explains SHARE_OF_ALL of what the best one does.
    """
    fewest = FEWEST_WAVES * strongest.period / float(np.ptp(position))
    gains = {
        m: noise.explained(_harmonics(position, m * strongest.period, 2 * m))
        for m in range(1, MOST_PARTS + 1)
        if m * fewest <= 1.0
    }
    enough = SHARE_OF_ALL * max(gains.values())
    return strongest.period * min(m for m, gain in gains.items() if gain >= enough)


def _harmonics(position: Array, period: float, count: int) -> Array:
    waves = [COGGING.function(position, period_mm=period / k) for k in range(1, count + 1)]
    return np.column_stack(waves)


@dataclass(frozen=True)
class _Noise:
    """Coloured noise of a residual (n,): the autoregression ``a`` that makes it white.

    ``kept`` (n,): white rows that count.
    """

    a: Array
    residual: Array
    kept: NDArray[np.bool_]

    @property
    def taps(self) -> Array:
        """1 and −a: the whitening filter."""
        return np.concatenate([[1.0], -self.a])

    def white(self, columns: Array) -> Array:
        """Return columns (n, k) through the filter, at the rows that count."""
        from scipy import signal

        return np.asarray(signal.lfilter(self.taps, [1.0], columns, axis=0)[self.kept])

    def matched(self) -> Array:
        """Return the residual filtered forwards and backwards, (n,): its product with a column is
        that of the white ones."""
        from scipy import signal

        once = signal.lfilter(self.taps, [1.0], self.residual) * self.kept
        return np.asarray(signal.lfilter(self.taps, [1.0], once[::-1])[::-1])

    def fitted(self, columns: Array) -> tuple[float, float]:
        """Return (amplitude, ΔlnL) of two columns (n, 2) and a constant in the white residual."""
        white = self.white(np.column_stack([np.ones_like(self.residual), columns, self.residual]))
        weights = np.linalg.lstsq(white[:, :3], white[:, 3], rcond=None)[0]
        mean = float(white[:, 0] @ white[:, 3]) / float(white[:, 0] @ white[:, 0])
        before = float(np.sum((white[:, 3] - mean * white[:, 0]) ** 2))
        after = float(np.sum((white[:, 3] - white[:, :3] @ weights) ** 2))
        gain = 0.5 * len(white) * float(np.log(before / max(after, 1e-300)))
        return float(np.hypot(weights[1], weights[2])), gain

    def explained(self, columns: Array) -> float:
        """Return by what share columns (n, k) and a constant lower the white residual's squares,
        less what that many columns are worth (Schwarz's criterion).
        """
        white = self.white(np.column_stack([np.ones_like(self.residual), columns, self.residual]))
        gram = white.T @ white
        inner, right, total = gram[:-1, :-1], gram[:-1, -1], float(gram[-1, -1])
        share = float(right @ np.linalg.lstsq(inner, right, rcond=1e-10)[0]) / total
        price = float(columns.shape[1] * np.log(len(white)) / len(white))
        return share - (1.0 - share) * price


def _far_from_reversals(direction: Array, rows: int) -> NDArray[np.bool_]:
    """Say which rows (n,) lie in motion that has gone on for so many rows.

    A reversal's own shape is no ripple, but so sharp that a whitening filter sees little else.
    """
    sense = np.where(np.abs(direction) >= 1.0, np.sign(direction), 0.0)
    breaks = (sense == 0) | (np.diff(sense, prepend=sense[0]) != 0)
    since = np.concatenate([[0], np.cumsum(breaks)])
    at = np.arange(len(sense))
    begun = np.maximum(at + 1 - rows, 0)
    return np.asarray((since[at + 1] == since[begun]) & (at + 1 >= rows), dtype=np.bool_)


def _ripple(position: Array, sense: Array, period: float) -> Array:
    return sense[:, None] * COGGING.function(position, period_mm=period)


def _search(noise: _Noise, position: Array, sense: Array, bins: int) -> tuple[float, int]:
    """Return (period, places looked at) of the ripple that a matched filter sees best.

    Σ u·e^(−iφ), u the matched residual times the sense, summed over bins of position and Fourier
    transformed; what it would be of noise alone follows from the filter's gain at the frequency at
    which each row passes the ripple.
    """
    low, travel = float(position.min()), float(np.ptp(position))
    place = np.minimum((position - low) / travel * bins, bins - 1).astype(np.intp)
    total = np.bincount(place, weights=noise.matched() * sense, minlength=bins)
    seen = np.abs(np.fft.rfft(total, n=OVERSAMPLED * bins)) ** 2
    waves = np.arange(len(seen)) / OVERSAMPLED
    searched = (waves >= FEWEST_WAVES) & (waves <= bins / 4)
    step, weight = _steps(position, sense * noise.kept)
    omega = 2.0 * np.pi * np.multiply.outer(waves[searched], step / travel)
    power = np.abs(_response(noise.taps, omega)) ** 2 @ weight
    best = int(np.argmax(seen[searched] / power))
    return travel / float(waves[searched][best]), int(searched.sum())


def _steps(position: Array, sense: Array) -> tuple[Array, Array]:
    """Return the way from row to row in classes, and the rows in each, by their sense squared."""
    step = np.abs(np.gradient(position))
    edges = np.linspace(0.0, float(step.max()) * (1.0 + 1e-12), STEP_CLASSES + 1)
    count, _ = np.histogram(step, edges, weights=sense**2)
    return 0.5 * (edges[1:] + edges[:-1]), count.astype(np.float64)


def _response(taps: Array, omega: Array) -> NDArray[np.complex128]:
    """Return the filter's response at angular frequencies per row."""
    turn = np.exp(-1j * omega)
    return np.asarray(np.polynomial.polynomial.polyval(turn, taps), dtype=np.complex128)


def _refined(noise: _Noise, position: Array, sense: Array, period: float) -> float:
    """Return the period that explains most, within two lines of the spectrum around ``period``."""
    half = 2.0 * period**2 / float(np.ptp(position)) / OVERSAMPLED
    low, high = period - half, period + half
    for _ in range(4):
        grid = np.linspace(low, high, 9)
        gains = [noise.fitted(_ripple(position, sense, float(p)))[1] for p in grid]
        at = int(np.argmax(gains))
        low, high = grid[max(at - 1, 0)], grid[min(at + 1, 8)]
    return float(0.5 * (low + high))


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
