"""Low-pass, derivatives and decimation of a recorded channel.

Filters run forwards and backwards (zero phase), so nothing is shifted in time.
"""

import numpy as np
from numpy.typing import NDArray
from scipy import signal

Array = NDArray[np.float64]

BUTTERWORTH_ORDER = 4


def lowpass(values: Array, *, rate_hz: float, cutoff_hz: float) -> Array:
    """Return ``values`` (n,) or (n, k) through a 4th-order zero-phase Butterworth low-pass.

    A cutoff at or above the Nyquist frequency leaves the values as they are.
    """
    if cutoff_hz >= 0.5 * rate_hz:
        return values
    sos = signal.butter(BUTTERWORTH_ORDER, cutoff_hz, fs=rate_hz, output="sos")
    return np.asarray(signal.sosfiltfilt(sos, values, axis=0), dtype=np.float64)


def derivatives(t_s: Array, position: Array, *, cutoff_hz: float) -> tuple[Array, Array, Array]:
    """Return low-passed position, velocity and acceleration by central differences.

    The filter is ``lowpass`` at ``cutoff_hz``; shapes (n,); units per s and s².
    """
    rate_hz = float(1.0 / np.median(np.diff(t_s)))
    smooth = lowpass(position, rate_hz=rate_hz, cutoff_hz=cutoff_hz)
    velocity = np.gradient(smooth, t_s)
    return smooth, velocity, np.gradient(velocity, t_s)


def decimate(values: Array, factor: int) -> Array:
    """Return every ``factor``-th row after a zero-phase anti-alias low-pass (8th-order Chebyshev).

    Effort and regressors decimated alike keep a linear relation between them exactly: the parallel
    filtering of Gautier's inverse-dynamics identification. Cutoff at 0.4 of the new rate.
    """
    if factor == 1:
        return values
    return np.asarray(signal.decimate(values, factor, axis=0), dtype=np.float64)
