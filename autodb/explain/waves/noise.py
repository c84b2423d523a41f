"""Noise of a force whose waveform is full of lines: read off a running median of its periodogram.

An autoregression fitted to what is left would take a strong line, chatter say, for colour and
filter it away. The median over neighbouring frequencies does not see a line. Of exponentially
distributed powers the median is ln 2 of the mean.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz
from scipy.ndimage import median_filter

from autodb.explain.engine.noise import ORDER, Whitener

Array = NDArray[np.float64]

WIDE = 0.02
"""Width of the running median, a share of all frequencies. Chosen: lines of 1 to 5 Hz and their
side bands are far narrower."""
FEWEST = 15
FLOOR = 1e-12


def whitener_of(left: Array) -> Whitener:
    """Return the filter that makes the noise in what is left (n,) white, of variance 1.

    It is an autoregression with the spectrum's running median, divided by its sd.
    """
    n = len(left)
    power = np.abs(np.fft.rfft(left - left.mean())) ** 2 / n
    width = max(FEWEST, 2 * int(WIDE * len(power) / 2) + 1)
    smooth = median_filter(power, size=width, mode="nearest") / np.log(2.0)
    smooth = np.maximum(smooth, FLOOR * float(np.max(power)) + 1e-300)
    covariance = np.fft.irfft(smooth, n)[: ORDER + 1]
    covariance[0] *= 1.0 + 1e-9
    taps = solve_toeplitz(covariance[:ORDER], covariance[1:])
    return Whitener(np.asarray(taps, dtype=np.float64))


def variance_of(whitener: Whitener, left: Array) -> float:
    """Return the variance of a white row, lines aside."""
    white = whitener(left)
    power = np.abs(np.fft.rfft(white)) ** 2 / len(white)
    return float(np.median(power)) / float(np.log(2.0))
