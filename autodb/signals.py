"""Signals before any model: derivatives, filters, current range, quasi-static force, segments.

Filters run forwards and backwards (zero phase), so nothing is shifted in time.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal

Array = NDArray[np.float64]

BUTTERWORTH_ORDER = 4
STANDING_HZ = 0.05
"""Electrical frequency below which an axis counts as standing. Chosen: half of 0.1 Hz, the slowest
that a range is read at."""


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


@dataclass(frozen=True)
class PhaseRange:
    """Current range over time and the frequency of the drive's sinusoid."""

    range_A: Array
    frequency_hz: Array


def three_phase_range(
    u_A: Array, v_A: Array, w_A: Array, *, rate_hz: float, smooth_s: float = 0.5
) -> PhaseRange:
    """Return the current range 2·|i| of the space vector of three phase currents.

    i = (2/3)(u + v e^{2πi/3} + w e^{4πi/3}) (Clarke); each phase's Hall offset is taken off as the
    mean over the turning part. Where the phasor stands (STANDING_HZ) the range is NaN: a standing
    axis shows no load. Range and frequency are averaged over ``smooth_s``.
    """
    phases = np.stack([u_A, v_A, w_A])
    vector = _space_vector(phases)
    frequency = _frequency_hz(vector, rate_hz, smooth_s)
    turning = np.abs(frequency) > STANDING_HZ
    if turning.any():
        vector = _space_vector(phases - np.mean(phases[:, turning], axis=1, keepdims=True))
        frequency = np.where(turning, _frequency_hz(vector, rate_hz, smooth_s), frequency)
    amplitude = np.sqrt(_moving_average(np.abs(vector) ** 2, rate_hz, smooth_s))
    return PhaseRange(np.where(turning, 2.0 * amplitude, np.nan), np.abs(frequency))


def _space_vector(phases_A: Array) -> NDArray[np.complex128]:
    turn = np.exp(2j * np.pi / 3)
    vector = (2.0 / 3.0) * (phases_A[0] + phases_A[1] * turn + phases_A[2] * turn**2)
    return np.asarray(vector, dtype=np.complex128)


def _frequency_hz(vector: NDArray[np.complex128], rate_hz: float, smooth_s: float) -> Array:
    step = np.angle(vector[1:] * np.conj(vector[:-1])) * rate_hz / (2 * np.pi)
    return _moving_average(np.append(step, step[-1]), rate_hz, smooth_s)


def _moving_average(values: Array, rate_hz: float, window_s: float) -> Array:
    n = max(1, round(window_s * rate_hz))
    padded = np.pad(values, (n // 2, n - 1 - n // 2), mode="edge")
    return np.asarray(np.convolve(padded, np.full(n, 1.0 / n), mode="valid"), dtype=np.float64)


def quasi_static(force_N: Array, *, rate_hz: float, band_hz: float = 8.0) -> Array:
    """Return the quasi-static force: the db5 sub-band below ``band_hz``, averaged over 0.5 s.

    As in P1 section 7 (there level 6 at 1000 Hz, which ends at 7.8 Hz).
    """
    import pywt

    level = max(1, int(np.log2(0.5 * rate_hz / band_hz)))
    level = min(level, pywt.dwt_max_level(len(force_N), "db5"))
    details = pywt.wavedec(np.array(force_N), "db5", mode="symmetric", level=level)
    kept = [details[0], *[np.zeros_like(d) for d in details[1:]]]
    lowest = pywt.waverec(kept, "db5", mode="symmetric")[: len(force_N)]
    return _moving_average(np.asarray(lowest, dtype=np.float64), rate_hz, 0.5)


@dataclass(frozen=True)
class Segments:
    """Where the tool approached in air and where it cut, as slices of the samples."""

    air: slice
    cut: slice


def air_and_cut(load: Array, *, rate_hz: float, margin_s: float = 0.5) -> Segments | None:
    """Split one recorded cut into its air approach and the cut by fuzzy c-means on the load signal.

    ``load`` (n,): a range that rises or falls in the cut (NaN where the axis stands). The cut is
    the longest run in the cluster that the recording does not start in; the air part is the run
    before it. Both lose ``margin_s`` at each end. None when the clusters are not apart by 6 times
    their spread, or a part is shorter than 0.3 s.
    """
    import skfuzzy

    known = np.isfinite(load)
    if known.sum() < 10:
        return None
    filled = np.interp(np.arange(len(load)), np.flatnonzero(known), load[known])
    centres, member, *_ = skfuzzy.cluster.cmeans(
        filled[None, :], c=2, m=2.0, error=1e-4, maxiter=200, seed=0
    )
    label = np.argmax(member, axis=0)
    spread = np.median(np.abs(filled - centres[label, 0]))
    if abs(centres[0, 0] - centres[1, 0]) < 6.0 * spread:
        return None
    cutting = label != label[np.flatnonzero(known)[0]]
    edges = np.flatnonzero(np.diff(np.concatenate(([0], cutting.astype(int), [0]))))
    if not edges.size:
        return None
    starts, ends = edges[::2], edges[1::2]
    longest = int(np.argmax(ends - starts))
    margin = round(margin_s * rate_hz)
    air = slice(margin, int(starts[longest]) - margin)
    cut = slice(int(starts[longest]) + margin, int(ends[longest]) - margin)
    short = 0.3 * rate_hz
    if air.stop - air.start < short or cut.stop - cut.start < short:
        return None
    return Segments(air, cut)
