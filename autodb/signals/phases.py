"""Phase currents to current range and frequency: a demodulator that follows the drive's sinusoid.

Each octave of `octaves` says how strong a sinusoid it holds and how fast it turns (`readings`). The
fastest octave in whose band that frequency lies is read, and its amplitude divided by the gain at
that frequency.
"""

import numpy as np
from numpy.typing import NDArray

from autodb.signals.octaves import TURNING, Complex, analytic_taps
from autodb.signals.stream import PhaseForm, PhaseRange, PhaseStream

Array = NDArray[np.float64]

PART = 1 << 16
"""Samples at a time that a whole recording is taken in: they stay in a processor's own memory."""


def one_phase(smooth_s: float) -> PhaseForm:
    """Return how one phase is read: half its amplitude turns either way."""
    return PhaseForm(analytic_taps(), 0.15, 16.0, 0.125, 7, smooth_s)


def three_phases(smooth_s: float) -> PhaseForm:
    """Return how three phases are read: the space vector's length is the amplitude."""
    return PhaseForm(TURNING, 0.09, 4.0, 0.25, 5, smooth_s)


def space_vector(u_A: Array, v_A: Array, w_A: Array) -> Complex:
    """Return (2/3)(u + v e^{2πi/3} + w e^{4πi/3}) of three phase currents (Clarke)."""
    out = np.empty(len(u_A), dtype=np.complex128)
    out.real = (2.0 * u_A - v_A - w_A) / 3.0
    out.imag = (v_A - w_A) / np.sqrt(3.0)
    return out


def three_phase_range(
    u_A: Array, v_A: Array, w_A: Array, *, rate_hz: float, smooth_s: float = 0.5
) -> PhaseRange:
    """Return the current range of three phase currents: twice the length of their space vector.

    Averaged over the longer of ``smooth_s`` and five samples of the octave: half a period to one.
    """
    stream = PhaseStream.start(three_phases(smooth_s), rate_hz=rate_hz)
    for part in _parts(len(u_A)):
        stream.take(space_vector(u_A[part], v_A[part], w_A[part]))
    return stream.finish()


def one_phase_range(current_A: Array, *, rate_hz: float, smooth_s: float = 1.0) -> PhaseRange:
    """Return the current range of one phase: twice the amplitude of its sinusoid.

    Averaged over the longer of ``smooth_s`` and seven samples of the octave: one to two periods.
    """
    stream = PhaseStream.start(one_phase(smooth_s), rate_hz=rate_hz)
    for part in _parts(len(current_A)):
        stream.take(current_A[part])
    return stream.finish()


def _parts(size: int) -> list[slice]:
    return [slice(begin, begin + PART) for begin in range(0, size, PART)]
