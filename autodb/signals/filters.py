"""Low-pass, derivatives and decimation of a recorded channel.

Filters run forwards and backwards (zero phase), so nothing is shifted in time.

How well a mean over time is known when neighbouring samples are alike.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from autodb.timing import Timing

Array = NDArray[np.float64]

BUTTERWORTH_ORDER = 4


def by_piece(function: Callable[[Array], Array], values: Array, pieces: Sequence[slice]) -> Array:
    """Return ``function`` of each piece of the values (n,) or (n, k), one after the other.

    What filters and differences do to one piece of even rows has nothing to do with the next.
    """
    if len(pieces) == 1:
        return function(values)
    return np.concatenate([function(values[piece]) for piece in pieces])


def slope(values: Array, timing: Timing, t_s: Array) -> Array:
    """Return the slope of values (n,) by central differences, piece by piece, per s.

    Of rows that were laid out the step is known better than single times, which late in a day have
    few digits.
    """
    if timing.layout is None:
        return np.gradient(values, t_s)
    return by_piece(lambda own: np.gradient(own, timing.step_s), values, timing.pieces)


def lowpass(values: Array, *, rate_hz: float, cutoff_hz: float) -> Array:
    """Return ``values`` (n,) or (n, k) through a 4th-order zero-phase Butterworth low-pass.

    A cutoff at or above the Nyquist frequency leaves the values as they are.
    """
    if cutoff_hz >= 0.5 * rate_hz:
        return values
    from scipy import signal

    sos = signal.butter(BUTTERWORTH_ORDER, cutoff_hz, fs=rate_hz, output="sos")
    return np.asarray(signal.sosfiltfilt(sos, values, axis=0), dtype=np.float64)


def derivatives(
    t_s: Array, position: Array, *, cutoff_hz: float, timing: Timing
) -> tuple[Array, Array, Array]:
    """Return low-passed position, velocity and acceleration by central differences.

    The filter is ``lowpass`` at ``cutoff_hz``, piece by piece; shapes (n,); units per s and s².
    """
    smooth = lowpass_pieces(position, timing, cutoff_hz=cutoff_hz)
    velocity = slope(smooth, timing, t_s)
    return smooth, velocity, slope(velocity, timing, t_s)


def lowpass_pieces(values: Array, timing: Timing, *, cutoff_hz: float) -> Array:
    """Return ``values`` (n,) or (n, k) low-passed piece by piece."""
    return by_piece(
        lambda own: lowpass(own, rate_hz=timing.rate_hz, cutoff_hz=cutoff_hz),
        values,
        timing.pieces,
    )


def decimate(values: Array, factor: int) -> Array:
    """Return every ``factor``-th row after a zero-phase anti-alias low-pass (8th-order Chebyshev).

    Effort and regressors decimated alike keep a linear relation between them exactly: the parallel
    filtering of Gautier's inverse-dynamics identification. Cutoff at 0.4 of the new rate.
    """
    if factor == 1:
        return values
    from scipy import signal

    return np.asarray(signal.decimate(values, factor, axis=0), dtype=np.float64)


FEWEST = 4
"""Waves that a spectrum is read off, at least: chosen, from four its level scatters by 70 %."""
MOST = 16
"""and at most: chosen, the fastest then has 0.8 to 2 Hz in cuts of 10 to 4 s."""


def standard_error(values: Array, *, rate_hz: float, averaged_s: float) -> float | None:
    """Return the standard error of the mean of a series (n,), a moving average over ``averaged_s``.

    var(mean) = S(0)/n, S(0) being the sum of all autocovariances, that is the spectrum's level at
    frequency 0. The squares of the series' coefficients on orthonormal cosines of low frequency
    f = k/2T scatter around S(f) (U. K. Müller, A theory of robust long-run variance estimation, J.
    Econometrics 141 (2007) 1331); to them S(f) = S(0)/(1 + (f/f0)²), noise that forgets
    exponentially, is weighed by P. Whittle's likelihood (Ark. Mat. 2 (1953) 423): the mean of S(0)
    over all f0, the logarithm of which is taken to be anything. The moving average lets through
    sinc²(f · averaged_s) of it, which is divided out. The cosines are orthogonal to a
    straight line: a steady rise (a shrinking diameter) is no scatter.

    NaN is left out. None where fewer than 4 waves have f up to half of 1/averaged_s: the series is
    too short.
    """
    rows = np.flatnonzero(np.isfinite(values))
    if rows.size < 4 * FEWEST:
        return None
    duration_s = (rows[-1] - rows[0] + 1) / rate_hz
    waves = min(MOST, int(duration_s / averaged_s) - 1)
    if waves < FEWEST:
        return None
    number = np.arange(2, waves + 2)  # the first half wave is mostly the straight line
    frequency_hz = 0.5 * number / duration_s
    place = (rows - rows[0] + 0.5) / (rows[-1] - rows[0] + 1)
    strength = _strength(values[rows], place, number) / np.sinc(frequency_hz * averaged_s) ** 2
    return float(np.sqrt(_level_at_zero(strength, frequency_hz) / rows.size))


def _strength(values: Array, place: Array, number: NDArray[np.int64]) -> Array:
    """Return the squared coefficients (k,) on cosines orthogonal to each other and to a line."""
    line = np.stack([np.ones_like(place), place], axis=1)
    waves = np.cos(np.pi * np.outer(place, number))
    basis, _ = np.linalg.qr(np.hstack([line, waves]))
    return np.asarray((basis[:, 2:].T @ values) ** 2)


def _level_at_zero(strength: Array, frequency_hz: Array) -> float:
    """Return the mean S(0) of S(0)/(1 + (f/f0)²); for each f0 the likeliest has a closed form."""
    bends_hz = np.geomspace(frequency_hz[0], 20.0 * frequency_hz[-1], 60)
    shape = 1.0 / (1.0 + (frequency_hz[None, :] / bends_hz[:, None]) ** 2)
    level = np.mean(strength[None, :] / shape, axis=1)
    if not level.all():
        return 0.0
    unlikely = 0.5 * strength.size * (np.log(level) + np.mean(np.log(shape), axis=1))
    return float(np.average(level, weights=np.exp(np.min(unlikely) - unlikely)))
