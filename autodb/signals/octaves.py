"""A chain of half-band decimations with one short band-pass an octave, in blocks of any size.

Octave j holds the signal at rate / 2^j. Its band-pass reads sinusoids of about 0.1 to 0.3 of that
rate; a slower one is read an octave further down. Every filter is symmetric in time: nothing is
shifted.
"""

from dataclasses import dataclass, field
from functools import cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Samples = NDArray[np.float64] | NDArray[np.complex128]

HALF_BAND = np.array([3.0, 0.0, -25.0, 0.0, 150.0, 256.0, 150.0, 0.0, -25.0, 0.0, 3.0]) / 512.0
"""Half-band low-pass of 11 taps, flat at 0 to the sixth order: Lagrange interpolation of the middle
from six neighbours, beside the middle itself."""
HALF_BAND_REACH = 5
FREQUENCIES = np.linspace(0.0, 0.5, 513)
"""In cycles a sample of an octave, at which gains are tabulated."""
ANALYTIC_REACH = 5
TURNING = np.array([1.0, 0.0, -1.0], dtype=np.complex128)
"""Band-pass of a space vector, which has no negative frequencies of its own: the difference of its
neighbours, 2 sin(2πf), takes off what stands (offsets) and keeps what turns, either way."""
HIGHEST = 0.33
"""Share of the rate up to which a sinusoid is read."""
QUIET_ABOVE = 0.36
QUIET_REACH = 8
QUIET_STEP = 8


def response(taps: Samples, frequency: Array) -> Complex:
    """Return Σ taps[n] e^{−2πi f n} of centred ``taps`` (2m + 1,) at ``frequency`` (n,)."""
    n = np.arange(len(taps)) - len(taps) // 2
    return np.exp(-2j * np.pi * np.multiply.outer(frequency, n)) @ taps.astype(np.complex128)


@cache
def analytic_taps() -> Complex:
    """Return the complex band-pass (11,) that makes one phase current a turning phasor.

    Least squares: 1 on 0.14 to 0.32 of the rate, nothing on its mirror image, and exactly nothing
    at 0, so that no offset comes through. The mirror image is 45 dB down.
    """
    passed, mirrored = np.linspace(0.14, 0.32, 60), np.linspace(-0.48, -0.05, 120)
    design = np.concatenate([_hermitian(passed), 3.0 * _hermitian(mirrored)])
    wanted = np.concatenate([np.ones(passed.size), np.zeros(mirrored.size)])
    found = _fitted(design, wanted, _hermitian(np.zeros(1)))
    right = found[1 : ANALYTIC_REACH + 1] + 1j * found[ANALYTIC_REACH + 1 :]
    return np.concatenate([np.conj(right[::-1]), found[:1], right])


def _fitted(design: Array, wanted: Array, at_zero: Array) -> Array:
    """Return the least-squares taps among those that let nothing through at zero frequency."""
    free = np.linalg.svd(at_zero)[2][1:].T
    return np.asarray(free @ np.linalg.lstsq(design @ free, wanted, rcond=None)[0])


def _hermitian(frequency: Array) -> Array:
    """Return the response of taps h[−n] = h[n]*, linear in the middle, real and imaginary parts."""
    angle = 2.0 * np.pi * np.multiply.outer(frequency, np.arange(1, ANALYTIC_REACH + 1))
    columns = (np.ones((len(frequency), 1)), 2.0 * np.cos(angle), 2.0 * np.sin(angle))
    return np.concatenate(columns, axis=1)


@cache
def quiet_taps() -> Array:
    """Return the high-pass (17,) beyond every drive's sinusoid, where only noise is left."""
    k = np.arange(1, QUIET_REACH + 1)
    low, high = np.linspace(0.0, HIGHEST, 80), np.linspace(QUIET_ABOVE + 0.03, 0.5, 40)
    frequency = np.concatenate([low, high])
    angles = 2.0 * np.pi * np.multiply.outer(frequency, k)
    design = np.concatenate([np.ones((frequency.size, 1)), 2.0 * np.cos(angles)], axis=1)
    weight = np.where(frequency <= HIGHEST, 30.0, 1.0)
    wanted = np.where(frequency <= HIGHEST, 0.0, 1.0)
    at_zero = np.concatenate([np.ones((1, 1)), np.full((1, QUIET_REACH), 2.0)], axis=1)
    found = _fitted(design * weight[:, None], wanted * weight, at_zero)
    return np.concatenate([found[:0:-1], found])


@dataclass(frozen=True)
class Gains:
    """What an octave's band-pass makes of a sinusoid, at each frequency, and of white noise.

    ``frequency`` (k,) in cycles a sample of the octave; ``power`` (k,) |response|² of the whole
    chain down to it; ``noise`` and ``noise_turned``: the means of |c|² and of c[n+1] c*[n] that
    white noise of unit power leaves.
    """

    frequency: Array
    power: Array
    noise: float
    noise_turned: complex

    def at(self, frequency: Array) -> Array:
        """Return the power gain at a frequency a sample of the octave."""
        return np.interp(np.abs(frequency), self.frequency, self.power)


def octave_gains(taps: Samples, octaves: int) -> list[Gains]:
    """Return the gains of each octave's band-pass ``taps`` behind its half-band filters."""
    band = np.abs(response(taps, FREQUENCIES)) ** 2
    noise = np.zeros(2 * HALF_BAND_REACH + 1)  # autocovariance of white noise at lags 0, 1, …
    noise[0] = 1.0
    found = []
    for octave in range(octaves):
        left = _left(taps, noise, 0), _left(taps, noise, 1)
        found.append(Gains(FREQUENCIES, band * _let_through(octave), left[0].real, left[1]))
        noise = _decimated(noise)
    return found


@cache
def _let_through(octave: int) -> Array:
    """Return the power gain of the half-band filters down to an octave, at its FREQUENCIES."""
    if octave == 0:
        return np.ones_like(FREQUENCIES)
    last = np.abs(response(HALF_BAND, FREQUENCIES / 2.0**octave)) ** 2
    return np.asarray(_let_through(octave - 1) * last)


def _left(taps: Samples, noise: Array, ahead: int) -> complex:
    """Return the mean of c[n + ahead] c*[n] that noise with an autocovariance leaves."""
    pairs = np.correlate(taps, taps, mode="full")  # Σ h[n + m] h*[n] over m
    lags = np.abs(ahead - np.arange(len(pairs)) + len(taps) - 1)
    kept = lags < len(noise)
    return complex(pairs[kept] @ noise[lags[kept]])


def _decimated(noise: Array) -> Array:
    """Return the autocovariance of noise after the half-band filter and every second sample."""
    both = np.concatenate([noise[:0:-1], noise])
    spread = np.convolve(both, np.convolve(HALF_BAND, HALF_BAND[::-1]))
    middle = len(spread) // 2
    kept = spread[middle::2]
    return np.concatenate([kept, np.zeros(len(noise))])[: len(noise)]


@dataclass
class Octave:
    """One octave of a running chain: its filters and the samples that they still need.

    ``half_hop`` samples on either side make a hop, over which products are summed; 0 where one
    sample is a hop. ``at`` is the index of the first sample held.
    """

    taps: Samples
    half_hop: int
    held: Samples
    at: int
    next_half: int
    next_hop: int

    @classmethod
    def start(cls, taps: Samples, *, half_hop: int, first: int) -> "Octave":
        """Return an octave whose first sample has the index ``first``."""
        reach = len(taps) // 2
        hop = max(1, 2 * half_hop)
        return cls(
            taps=taps,
            half_hop=half_hop,
            held=np.zeros(0),
            at=first,
            next_half=-(-(first + HALF_BAND_REACH) // 2),
            next_hop=-(-(first + reach + max(1, half_hop)) // hop),
        )

    def push(self, samples: Samples) -> tuple[Samples, Complex]:
        """Take further samples; return those of the next octave, and each new hop's means (4, n).

        Of the band-pass c: |c|² and c[n+1] c*[n]; of the samples before it: x and |x|².
        """
        self.held = np.concatenate([self.held, samples]) if self.held.size else samples
        end = self.at + len(self.held)
        half = self._halved((end - 1 - HALF_BAND_REACH) // 2 + 1)
        means = self._hops(end)
        reach, hop = len(self.taps) // 2, max(1, 2 * self.half_hop)
        needed = min(
            2 * self.next_half - HALF_BAND_REACH,
            self.next_hop * hop - max(1, self.half_hop) - reach,
        )
        drop = max(0, needed - self.at)
        self.held, self.at = self.held[drop:].copy(), self.at + min(drop, len(self.held))
        return half, means

    def _halved(self, stop: int) -> Samples:
        """Return every second sample of the half-band low-pass, up to index ``stop`` of those."""
        count = max(0, stop - self.next_half)
        x, first = self.held, 2 * self.next_half - self.at
        if not count:
            return x[:0]

        def at(shift: int) -> Samples:
            begin = first + shift
            return x[begin : begin + 2 * count - 1 : 2]

        out = at(0) * HALF_BAND[HALF_BAND_REACH]
        for k in range(1, HALF_BAND_REACH + 1, 2):
            out += (at(k) + at(-k)) * HALF_BAND[HALF_BAND_REACH + k]
        self.next_half += count
        return np.asarray(out)

    def _hops(self, end: int) -> Complex:
        """Return the means of each hop that is complete; those at its two ends count half."""
        reach, side, hop = len(self.taps) // 2, max(1, self.half_hop), max(1, 2 * self.half_hop)
        count = max(0, (end - 1 - reach - side) // hop - self.next_hop + 1)
        if not count:
            return np.zeros((4, 0), dtype=np.complex128)
        begin = self.next_hop * hop - side - self.at
        size = (count - 1) * hop + 2 * side + 1
        x = self.held[begin : begin + size]
        c = _filtered(self.held[begin - reach : begin + size + reach], self.taps)
        self.next_hop += count
        out = np.empty((4, count), dtype=np.complex128)
        for row, values in ((0, _squared(c)), (2, x), (3, _squared(x))):
            out[row] = self._mean(values, count)
        turned = c[1:] * np.conj(c[:-1])
        if self.half_hop:
            out[1] = turned.reshape(count, hop).mean(axis=1)
        else:
            out[1] = 0.5 * (turned[1:] + turned[:-1])
        return out

    def _mean(self, values: Samples, count: int) -> Samples:
        if not self.half_hop:
            return values[1:-1]
        hop = 2 * self.half_hop
        ends = values[::hop]
        inside = values[:-1].reshape(count, hop).sum(axis=1)
        return np.asarray((inside + 0.5 * (ends[1:] - ends[:-1])) / hop)


def _squared(values: Samples) -> Array:
    return np.asarray(values.real**2 + values.imag**2 if np.iscomplexobj(values) else values**2)


def _filtered(samples: Samples, taps: Samples) -> Complex:
    """Return Σ taps[k] samples[n − k] wherever all of them are there."""
    if taps is TURNING:
        return np.asarray(samples[2:] - samples[:-2], dtype=np.complex128)
    out = np.empty(len(samples) - len(taps) + 1, dtype=np.complex128)
    out.real = np.convolve(samples, taps.real, mode="valid")
    out.imag = np.convolve(samples, taps.imag, mode="valid")
    return out


@dataclass
class NoisePower:
    """The running power of what lies above every sinusoid, as the white noise that would make it.

    ``half_hop``: samples on either side of a hop's middle.
    """

    half_hop: int
    next_hop: int
    held: Samples = field(default_factory=lambda: np.zeros(0))
    at: int = 0

    @classmethod
    def start(cls, half_hop: int) -> "NoisePower":
        """Return one that begins with the first sample."""
        return cls(half_hop, -(-(QUIET_REACH + half_hop) // (2 * half_hop)))

    def push(self, samples: Samples) -> Array:
        """Take further samples; return the noise power of each new hop."""
        self.held = np.concatenate([self.held, samples]) if self.held.size else samples
        hop, end = 2 * self.half_hop, self.at + len(self.held)
        count = max(0, (end - 1 - QUIET_REACH - self.half_hop) // hop - self.next_hop + 1)
        if not count:
            return np.zeros(0)
        step = min(QUIET_STEP, hop)
        begin = self.next_hop * hop - self.half_hop - self.at
        taps = quiet_taps()
        size = count * hop // step
        out = np.zeros(size, dtype=self.held.dtype)
        for k, tap in enumerate(taps):
            first = begin + k - QUIET_REACH
            out += tap * self.held[first : first + (size - 1) * step + 1 : step]
        self.next_hop += count
        drop = self.next_hop * hop - self.half_hop - QUIET_REACH - self.at
        self.held, self.at = self.held[drop:].copy(), self.at + drop
        power = (out.real**2 + out.imag**2).reshape(count, hop // step).mean(axis=1)
        return np.asarray(power / float(taps @ taps))
