"""Chatter: a narrow band that grows in the cut and is no multiple of what turns.

The tool's and the work's own vibration feeds on the cut at a frequency near a mode of the machine;
forces of runout and of unequal teeth are multiples of the spindle frequency, ripples of a drive's
current are multiples of its electrical frequency. Multiples above half the rate come back folded.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RESOLUTION_S = 2.0
"""Length of the pieces that spectra are averaged over: bins of 0.5 Hz. Chosen."""
LOWEST_HZ = 10.0
"""Below it lie the changes of load themselves. Chosen."""
LINE_BINS, BESIDE_BINS = 2, 20
"""Bins on each side that a line fills (the Hann window's main lobe), and that it is compared to."""
OUT_OF_BESIDE = 10.0
"""A line holds this times the power that its neighbours would put in its place: ringing, which is
random and some per cent of its frequency wide, does not. Chosen."""
BESIDE_TURNING = 0.05
"""and this share at least of what the strongest multiple holds: products of a swing once a
revolution with a drive's own ripple hold less than a thousandth. Chosen."""
GROWS = 10.0
"""and this times the power that it holds in air. Chosen."""


@dataclass(frozen=True)
class NarrowBand:
    """A narrow band: its frequency, Hz, and the rms of what it holds, in the signal's unit."""

    frequency_hz: float
    rms: float


@dataclass(frozen=True)
class Turning:
    """A frequency whose multiples are no chatter: up to ``highest`` of them, each known to a share
    ``spread`` of itself."""

    frequency_hz: float
    highest: int
    spread: float


def chatter(
    cut: Array, air: Array, *, rate_hz: float, turning: Sequence[Turning], least_rms: float
) -> NarrowBand | None:
    """Return the strongest narrow band of a signal in cut (n,) that is chatter, or None.

    ``air`` (m,): the same signal in air. ``least_rms``: below it a line is of no consequence.
    Multiples of ``turning`` are not looked at, nor is anything that their lines reach.
    """
    from scipy.signal import detrend, welch

    size = int(min(RESOLUTION_S * rate_hz, cut.size))
    frequency, density = welch(detrend(cut), rate_hz, nperseg=size)
    step = float(frequency[1])
    free = frequency >= LOWEST_HZ
    for one in turning:
        free &= ~_near_multiples(frequency, one, rate_hz=rate_hz, within=(LINE_BINS + 2) * step)
    here = np.flatnonzero(free)
    if here.size < 2 * BESIDE_BINS:
        return None
    lines = np.convolve(density * step, np.ones(2 * LINE_BINS + 1), mode="same")
    peak = here[int(np.argmax(lines[here]))]
    rms = float(np.sqrt(lines[peak]))
    near = here[(np.abs(here - peak) > LINE_BINS) & (np.abs(here - peak) <= BESIDE_BINS)]
    if rms < least_rms or near.size < LINE_BINS:
        return None
    beside = (2 * LINE_BINS + 1) * step * float(np.median(density[near]))
    others = float(np.max(lines[(frequency >= LOWEST_HZ) & ~free], initial=0.0))
    if lines[peak] < max(OUT_OF_BESIDE * beside, BESIDE_TURNING * others):
        return None
    highest = peak - LINE_BINS + int(np.argmax(density[peak - LINE_BINS : peak + LINE_BINS + 1]))
    line = NarrowBand(float(frequency[highest]), rms)
    within_hz = (LINE_BINS + 1) * step
    if lines[peak] < GROWS * _power_near(air, line.frequency_hz, within_hz, rate_hz=rate_hz):
        return None
    return line


def _near_multiples(
    frequency: Array, one: Turning, *, rate_hz: float, within: float
) -> NDArray[np.bool_]:
    """Return which frequencies are at a multiple, also at one folded at the sampling rate."""
    multiple = one.frequency_hz * np.arange(1, one.highest + 1)
    folded = np.abs(multiple - rate_hz * np.round(multiple / rate_hz))
    apart = np.abs(frequency[:, None] - folded[None, :])
    return np.asarray((apart <= within + one.spread * multiple[None, :]).any(axis=1))


def _power_near(signal: Array, frequency_hz: float, within_hz: float, *, rate_hz: float) -> float:
    """Return the power of a signal within some hertz of a frequency."""
    from scipy.signal import periodogram

    frequency, density = periodogram(signal, rate_hz, window="hann")
    near = np.abs(frequency - frequency_hz) <= within_hz
    return float(np.sum(density[near]) * frequency[1])
