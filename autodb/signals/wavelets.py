"""Daubechies-5 sub-bands, as P1 (sections 7 and 8) de-noises currents and forces.

Sub-band A_level of a wavelet decomposition ends at rate / 2^(level + 1), and each detail kept with
it doubles that. The edge is not sharp: a drive's sinusoid near it reads low. So a recording's range
comes from the demodulator (`phases`); this is kept for comparison, and for a dynamometer's force.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

WAVELET = "db5"
CLEAR = 0.02
"""Share of a sinusoid that may be missing before a note says so: chosen, twice what the
demodulator may err by."""
_PROBE_PERIODS = 40


def ends_hz(*, rate_hz: float, level: int, details: int = 0) -> float:
    """Return where the band of A_level and its ``details`` coarsest details ends."""
    return float(rate_hz / 2 ** (level + 1 - details))


def denoised(values: Array, *, level: int, details: int = 0) -> Array:
    """Return ``values`` (n,) without the sub-bands above A_level and its coarsest details.

    At the ends the signal goes on mirrored, which is right to about 5·2^level samples from them.
    A signal too short for ``level`` is taken to the level that it holds.
    """
    import pywt

    level = min(level, pywt.dwt_max_level(len(values), WAVELET))
    parts = pywt.wavedec(np.array(values), WAVELET, mode="symmetric", level=level)
    kept = [p if i <= details else np.zeros_like(p) for i, p in enumerate(parts)]
    lowest = pywt.waverec(kept, WAVELET, mode="symmetric")[: len(values)]
    return np.asarray(lowest, dtype=np.float64)


def passed(frequency_hz: float, *, rate_hz: float, level: int, details: int = 0) -> float:
    """Return the share of a sinusoid's rms that the band keeps, read off a sinusoid."""
    length = round(_PROBE_PERIODS * rate_hz * max(1.0 / frequency_hz, 2.0**level / rate_hz))
    wave = np.sin(2.0 * np.pi * frequency_hz * np.arange(length) / rate_hz)
    middle = slice(length // 4, -length // 4)
    out = denoised(wave, level=level, details=details)
    return float(np.std(out[middle]) / np.std(wave[middle]))


@dataclass(frozen=True)
class WaveletRange:
    """The range of a de-noised phase current, A, and what its band edge does to it, or None."""

    range_A: Array
    note: str | None


def wavelet_range(
    current_A: Array,
    *,
    rate_hz: float,
    frequency_hz: float,
    window_s: float,
    level: int = 6,
    details: int = 0,
) -> WaveletRange:
    """Return largest less smallest over ``window_s`` of one de-noised phase current (n,).

    ``frequency_hz``: of the drive's sinusoid. The note says how much of it is missing where it is
    near the band's edge.
    """
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    smooth = denoised(current_A, level=level, details=details)
    window = max(2, round(rate_hz * window_s))
    found = maximum_filter1d(smooth, window) - minimum_filter1d(smooth, window)
    kept = passed(frequency_hz, rate_hz=rate_hz, level=level, details=details)
    note = None
    if abs(1.0 - kept) > CLEAR:
        end = ends_hz(rate_hz=rate_hz, level=level, details=details)
        note = (
            f"{WAVELET} keeps {100.0 * kept:.0f} % of a sinusoid of {frequency_hz:g} Hz in a band "
            f"that ends at {end:.3g} Hz: the range reads low; the demodulator reads it"
        )
    return WaveletRange(np.asarray(found, dtype=np.float64), note)


def quasi_static(force_N: Array, *, rate_hz: float, band_hz: float = 8.0) -> Array:
    """Return the quasi-static force: the db5 sub-band that ends nearest ``band_hz``, over 0.5 s.

    As in P1 section 7 (there level 6 at 1000 Hz, which ends at 7.8 Hz). At the ends the average
    goes on with the last value: there a slope of s N/s is off by up to s/16 N.
    """
    level = max(1, round(np.log2(0.5 * rate_hz / band_hz)))
    return moving_average(denoised(force_N, level=level), rate_hz=rate_hz, window_s=0.5)


def moving_average(values: Array, *, rate_hz: float, window_s: float) -> Array:
    """Return the centred moving average of ``values`` (n,), which go on level at the ends."""
    from scipy.ndimage import uniform_filter1d

    samples = max(1, round(window_s * rate_hz))
    return np.asarray(uniform_filter1d(values, samples, mode="nearest"), dtype=np.float64)
