"""Up to which frequency drives hold what forces do, and passing only that on."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

TAPS = 33
"""Taps of the low-pass, an odd number: 64 ms each way at 250 Hz. Chosen."""
SEGMENT = 256
"""Rows of a segment of which a spectrum is made."""
COHERENT = 0.5
"""Share of a force's power that loads must hold. Chosen."""
TOP = 0.45
"""Share of the rate up to which anything is passed on at all."""


def coherent_hz(pairs: Sequence[tuple[Array, Array]], *, rate_hz: float) -> float:
    """Return the highest frequency at which loads and forces are coherent: γ² ≥ COHERENT.

    ``pairs``: load and force (n,) of each recording; γ² = |S_lf|²/(S_ll S_ff) of the spectra of all
    of them, over some neighbouring lines.
    """
    from scipy import signal

    sums = np.zeros((3, SEGMENT // 2 + 1), dtype=np.complex128)
    for load, force in pairs:
        if len(load) < SEGMENT:
            continue
        for k, (one, other) in enumerate(((load, force), (load, load), (force, force))):
            sums[k] += signal.csd(one, other, fs=rate_hz, nperseg=SEGMENT)[1] * len(load)
    coherence = np.abs(sums[0]) ** 2 / np.maximum(np.abs(sums[1] * sums[2]), 1e-300)
    hz = np.fft.rfftfreq(SEGMENT, 1.0 / rate_hz)
    held = np.flatnonzero(_smooth(coherence) >= COHERENT)
    return float(min(hz[held[-1]] if len(held) else hz[1], TOP * rate_hz))


def _smooth(values: Array) -> Array:
    return np.convolve(np.pad(values, 2, mode="edge"), np.full(5, 0.2), mode="valid")


def low_pass(cutoff_hz: Array, *, rate_hz: float) -> "LowPass":
    """Return a low-pass of columns (m,), each with its cutoff, for rows as they come."""
    from scipy import signal

    taps = [
        signal.firwin(TAPS, hz, fs=rate_hz) if hz < TOP * rate_hz else _as_it_is()
        for hz in cutoff_hz
    ]
    return LowPass(np.column_stack(taps))


def _as_it_is() -> Array:
    one = np.zeros(TAPS)
    one[TAPS // 2] = 1.0
    return one


@dataclass
class LowPass:
    """A low-pass ``taps`` (TAPS, m) without a shift in time: what it tells is half of them late.

    Before the first row and after the last it takes these as holding on.
    """

    taps: Array
    _values: Array | None = field(default=None)
    _beside: Array | None = field(default=None)

    def step(self, values: Array, beside: Array) -> tuple[Array, Array]:
        """Return rows (k, m) passed of the next rows (n, m), and ``beside`` at the same rows."""
        if not len(values):
            return values, beside
        half = TAPS // 2
        if self._values is None or self._beside is None:
            self._values = np.repeat(values[:1], half, axis=0)
            self._beside = beside[:0]
        self._values = np.concatenate([self._values, values])
        self._beside = np.concatenate([self._beside, beside])
        count = max(len(self._values) - TAPS + 1, 0)
        passed = np.empty((count, values.shape[1]))
        for k in range(values.shape[1] if count else 0):
            passed[:, k] = np.convolve(self._values[:, k], self.taps[:, k], mode="valid")
        now, self._beside = self._beside[:count], self._beside[count:]
        self._values = self._values[count:]
        return passed, now

    def finish(self) -> tuple[Array, Array]:
        """Return the rest."""
        if self._values is None:
            none = np.zeros((0, self.taps.shape[1]))
            return none, none
        ends = np.repeat(self._values[-1:], TAPS // 2, axis=0)
        return self.step(ends, ends[:0])
