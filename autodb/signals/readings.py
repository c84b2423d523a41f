"""What one octave says of a sinusoid: how strong it is, how fast it turns, if it is one."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.signals.octaves import HIGHEST, Complex, Gains, Samples

Array = NDArray[np.float64]

NOISE_HOPS = 63
"""Hops over which the noise is averaged that is taken off: about 2 s."""
OVER_NOISE = 10.0
"""A sinusoid is read where its octave holds this many times the power of its noise: 5 dB for a
whole recording at the fastest, less below."""
SHARE = 0.6
"""A sinusoid is read where it is at least this share of all that moves in and below its octave:
noise at 5 dB leaves 0.76, a single step of a standing current reaches 0.4."""
TINY = 1e-60  # A², no noise is that small


@dataclass
class Series:
    """Means of hops in their order (k, n), from index ``first``; the oldest may be gone."""

    first: int
    base: int
    means: Complex

    @property
    def stop(self) -> int:
        """Return the index after the last hop."""
        return self.base + int(self.means.shape[1])

    @property
    def begun(self) -> bool:
        """Say whether there was a hop."""
        return self.stop > self.first

    def add(self, means: Samples) -> None:
        """Append hops."""
        self.means = np.concatenate([self.means, means], axis=1)

    def forget(self, before: int) -> None:
        """Drop hops before an index."""
        drop = min(max(0, before - self.base), self.means.shape[1])
        self.means, self.base = self.means[:, drop:], self.base + drop


def empty_reading(first: int, rows: int) -> Series:
    """Return a series that begins at an index."""
    return Series(first, first, np.zeros((rows, 0), dtype=np.complex128))


def average(values: Samples, base: int, width: float, begin: int, stop: int) -> Samples:
    """Return the centred moving average over ``width`` values at the indices begin to stop − 1.

    ``values`` start at index ``base``; near their ends the average is over those that there are.
    """
    weights = _weights(width)
    reach = len(weights) // 2
    low, high = begin - reach - base, stop + reach - base
    inside = values[max(0, low) : max(0, high)]
    before, after = max(0, -low), max(0, high - len(values))
    if not before and not after:
        return np.asarray(np.convolve(inside, weights / weights.sum(), mode="valid"))
    known = np.pad(np.ones(len(inside)), (before, after))
    summed = np.convolve(np.pad(inside, (before, after)), weights, mode="valid")
    return np.asarray(summed / np.convolve(known, weights, mode="valid"))


def _weights(width: float) -> Array:
    """Return the weights of a box of a width that need not be whole."""
    reach = max(0, int(np.ceil(0.5 * (width - 1.0))))
    return np.clip(0.5 * (width + 1.0) - np.abs(np.arange(-reach, reach + 1)), 0.0, 1.0)


@dataclass(frozen=True)
class OctaveReading:
    """One octave at the common hops: squared range, signed frequency, and whether it holds."""

    squared_A2: Array
    frequency_hz: Array
    holds: NDArray[np.bool_]


@dataclass(frozen=True)
class Band:
    """One octave as it is read: its rate, its samples a hop, common hops a hop, gains.

    ``width`` and ``wide``: hops over which a reading is averaged, and over which its share of all
    that moves; ``lowest`` in cycles a sample; ``squared`` and ``moves`` as in `stream.PhaseForm`.
    """

    rate_hz: float
    hop: int
    stride: int
    gains: Gains
    width: float
    wide: float
    lowest: float
    squared: float
    moves: float

    @property
    def reach(self) -> int:
        """Return how many hops on either side an average takes."""
        return len(_weights(self.wide)) // 2

    def wanted(self, begin: int, stop: int) -> tuple[int, int]:
        """Return this octave's hops around common hops begin to stop − 1."""
        return begin // self.stride, -(-(stop - 1) // self.stride) + 1

    def read(self, series: Series, noise: Series, begin: int, stop: int) -> OctaveReading:
        """Return the octave at common hops; at its own ends it keeps a reading for one period."""
        low, high = self.wanted(begin, stop)
        low = min(max(low, series.first), series.stop - 1)
        high = max(min(high, series.stop), low + 1)
        own, asked = np.arange(low, high), np.arange(begin, stop) / self.stride
        place = np.clip(asked, low, high - 1)
        rows = self._own(series, noise, low, high)
        squared, turned, over, share = (np.interp(place, own, row) for row in rows)
        cycles = np.angle(turned) / (2.0 * np.pi)
        in_band = (np.abs(cycles) > self.lowest) & (np.abs(cycles) < HIGHEST)
        beyond = np.abs(asked - place) * self.hop * np.abs(cycles)
        holds = in_band & (over.real > OVER_NOISE) & (share.real > SHARE) & (beyond <= 1.0)
        return OctaveReading(squared.real, cycles * self.rate_hz, holds)

    def _own(self, series: Series, noise: Series, low: int, high: int) -> Complex:
        """Return at hops of this octave: squared range, A²; c[n+1] c*[n]; its power over the
        noise's; its share of all that moves the octave's samples. Shape (4, high − low)."""
        begin = max(low - self.reach, series.base)
        end = min(high + self.reach, series.stop)
        means = series.means[:, begin - series.base : end - series.base]
        level = _level(noise, np.arange(begin, end) * self.stride)
        floor, turned = self.gains.noise * level, means[1] - self.gains.noise_turned * level
        local = np.clip(np.abs(np.angle(turned)) / (2.0 * np.pi), 0.7 * self.lowest, HIGHEST)
        squared = self.squared * (means[0].real - floor) / self.gains.at(local)

        def over(row: Samples, width: float) -> Samples:
            return average(row, begin, width, low, high)

        near = [over(row, self.width) for row in (squared, turned, means[0], floor)]
        wide = [over(row, self.wide) for row in (squared, means[2], means[3])]
        moving = np.maximum(wide[2].real - np.abs(wide[1]) ** 2, TINY)
        clear = near[2].real / np.maximum(near[3].real, TINY)
        return np.array([near[0], near[1], clear, self.moves * wide[0].real / moving])


def _level(noise: Series, at: NDArray[np.int64]) -> Array:
    """Return the noise power averaged over NOISE_HOPS at common hops; at the ends the nearest."""
    at = np.clip(at, noise.first, noise.stop - 1)
    low, high = int(at[0]), int(at[-1]) + 1
    return average(noise.means[0].real, noise.base, NOISE_HOPS, low, high).real[at - low]
