"""Phase currents as they come: a running demodulator. A whole recording goes through it too."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.signals.octaves import (
    HALF_BAND_REACH,
    QUIET_REACH,
    NoisePower,
    Octave,
    Samples,
    octave_gains,
)
from autodb.signals.readings import NOISE_HOPS, Band, Series, empty_reading

Array = NDArray[np.float64]

STANDING_HZ = 0.05
"""Electrical frequency below which an axis counts as standing. Chosen: half of 0.1 Hz, the slowest
that a range is read at."""
SLOWEST_HZ = 0.1
SLOWEST_SHARE = 0.1
"""The slowest octave's rate is at most SLOWEST_HZ divided by this."""
HOP_S = 0.032
"""Time between readings, between which range and frequency are interpolated; to the nearest power
of two of samples."""
BESIDE = 0.5
"""An octave is read that holds at least this share of the strongest one's power."""


@dataclass(frozen=True)
class PhaseRange:
    """Current range over time, A, and the frequency of the drive's sinusoid, Hz; NaN: not known.

    Of three phases the frequency is signed: positive where v lags u (phase order u, v, w).
    """

    range_A: Array
    frequency_hz: Array


@dataclass(frozen=True)
class PhaseForm:
    """What one phase and three differ in: band-pass, its lowest share of the rate, averages.

    ``squared`` turns power behind a gain of one into the squared range, and ``moves`` that into the
    power that the sinusoid itself has; ``samples`` is the shortest average in samples of an octave,
    and ``smooth_s`` in seconds, of which the longer counts.
    """

    taps: Samples
    lowest: float
    squared: float
    moves: float
    samples: int
    smooth_s: float


def _bands(form: PhaseForm, count: int, *, rate_hz: float, common: int) -> list[Band]:
    """Return how each octave is read; the slowest down to between standing and SLOWEST_HZ."""
    bands = []
    for number, gain in enumerate(octave_gains(form.taps, count)):
        rate, hop = rate_hz / 2**number, max(1, common >> number)
        width = max(form.smooth_s * rate, form.samples) / hop
        band = Band(
            rate_hz=rate,
            hop=hop,
            stride=max(1, 2**number // common),
            gains=gain,
            width=width,
            wide=width + (len(form.taps) - 1) / hop,
            lowest=form.lowest,
            squared=form.squared,
            moves=form.moves,
        )
        bands.append(band)
    slowest_hz = float(np.sqrt(STANDING_HZ * SLOWEST_HZ))
    bands[-1] = replace(bands[-1], lowest=slowest_hz / bands[-1].rate_hz)
    return bands


@dataclass
class PhaseStream:
    """A demodulator that takes samples as they come; after `finish` it has given what
    `one_phase_range` or `three_phase_range` gives of the whole.

    ``bands`` and ``octaves`` are the chain, the fastest first. A sample's range is given at most
    ``latency_samples`` later.
    """

    hop: int
    bands: list[Band]
    octaves: list[Octave]
    quiet: NoisePower
    series: list[Series]
    noise: Series
    taken: int = 0
    given: int = 0
    next_hop: int = 0
    last: tuple[Array, Array] = (np.zeros(0), np.zeros(0))

    @classmethod
    def start(cls, form: PhaseForm, *, rate_hz: float) -> "PhaseStream":
        """Return a demodulator at the first sample of a recording."""
        half_hop = 2 ** max(2, round(np.log2(HOP_S * rate_hz)) - 1)
        octaves: list[Octave] = []
        for number in range(
            max(1, 1 + int(np.ceil(np.log2(SLOWEST_SHARE * rate_hz / SLOWEST_HZ))))
        ):
            first = octaves[-1].next_half if octaves else 0
            octaves.append(Octave.start(form.taps, half_hop=half_hop >> number, first=first))
        quiet = NoisePower.start(half_hop)
        return cls(
            hop=2 * half_hop,
            bands=_bands(form, len(octaves), rate_hz=rate_hz, common=2 * half_hop),
            octaves=octaves,
            quiet=quiet,
            series=[empty_reading(octave.next_hop, 4) for octave in octaves],
            noise=empty_reading(quiet.next_hop, 1),
        )

    @property
    def latency_samples(self) -> int:
        """Return how many samples after a sample its range is given at the latest."""
        slowest, octave = self.bands[-1], 2 ** (len(self.bands) - 1)
        first = self.series[-1].first + 1  # before it, the first reading is kept
        reach = len(self.octaves[-1].taps) // 2 + HALF_BAND_REACH + 1
        noise = self.hop * (NOISE_HOPS // 2 + 2) + QUIET_REACH
        hops = max(octave, self.hop) * (slowest.reach + 1 + first)
        return int(hops + octave * reach + noise + self.hop)

    def push(self, samples: Samples) -> PhaseRange:
        """Take further samples, one phase's currents or the space vector; return what is ready."""
        self.take(samples)
        return self._give(self._ready())

    def take(self, samples: Samples) -> None:
        """Take further samples, and read them later."""
        self.taken += len(samples)
        self.noise.add(self.quiet.push(samples)[None, :])
        for octave, series in zip(self.octaves, self.series, strict=True):
            samples, means = octave.push(samples)
            series.add(means)

    def finish(self) -> PhaseRange:
        """Return what is left; beyond its filters' reach an octave keeps its reading one period."""
        pairs = list(zip(self.bands, self.series, strict=True)) if self.noise.begun else []
        known = [(band, series) for band, series in pairs if series.begun]
        self.bands, self.series = [band for band, _ in known], [series for _, series in known]
        return self._give((self.taken - 1) // self.hop + 2, last=True)

    def _ready(self) -> int:
        """Return the common hop before which every octave has all that an average takes."""
        stops = []
        for band, series in zip(self.bands, self.series, strict=True):
            noisy = (self.noise.stop - 1 - NOISE_HOPS // 2) // band.stride + 1
            high = min(series.stop, noisy) - band.reach
            stops.append((high - 1) * band.stride + 1 if high > series.first else 0)
        return min(stops)

    def _give(self, stop: int, *, last: bool = False) -> PhaseRange:
        """Return the samples up to common hop ``stop`` − 1, interpolated between hops."""
        begin = self.next_hop
        if stop > begin:
            fresh = self._choose(begin, stop)
            self.last = (
                np.concatenate([self.last[0], fresh[0]]),
                np.concatenate([self.last[1], fresh[1]]),
            )
            self.next_hop = stop
            self._forget()
        base = self.next_hop - len(self.last[0])
        end = self.taken if last else max(self.given, (self.next_hop - 1) * self.hop + 1)
        place = np.arange(self.given, end) / self.hop - base
        own = np.arange(len(self.last[0]))
        out = [np.interp(place, own, values) if place.size else np.zeros(0) for values in self.last]
        self.given = end
        self.last = (self.last[0][-1:], self.last[1][-1:])
        return PhaseRange(out[0], out[1])

    def _choose(self, begin: int, stop: int) -> tuple[Array, Array]:
        """Return range and frequency at common hops: the fastest octave that holds a sinusoid."""
        pairs = zip(self.bands, self.series, strict=True)
        read = [band.read(series, self.noise, begin, stop) for band, series in pairs]
        found, frequency = np.full((2, stop - begin), np.nan)
        strongest = np.zeros(stop - begin)
        for one in read:
            strongest = np.where(one.holds, np.maximum(strongest, one.squared_A2), strongest)
        for one in read[::-1]:
            taken = one.holds & (one.squared_A2 >= BESIDE * strongest) & (one.squared_A2 > 0.0)
            found = np.where(taken, np.sqrt(np.where(taken, one.squared_A2, 0.0)), found)
            frequency = np.where(taken, one.frequency_hz, frequency)
        return found, frequency

    def _forget(self) -> None:
        """Drop what no later reading takes."""
        oldest = self.noise.stop
        for band, series in zip(self.bands, self.series, strict=True):
            keep = min(self.next_hop // band.stride, series.stop - 1) - band.reach
            series.forget(keep)
            oldest = min(oldest, keep * band.stride)
        self.noise.forget(oldest - NOISE_HOPS)
