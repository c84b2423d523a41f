"""The first resonance of a table dynamometer, from taps, and a force corrected for it.

A sensor with work on it is a mass on a spring, and what it reads Y of a force F that changes is

    Y(f) = F(f) / (1 − r² + 2 i ζ r),  r = f / f_1,

f_1 the natural frequency of that component, ζ its damping; at rest Y = F, so that the force of the
hammer need not be known. After a tap each component swings freely, as e^{−ζωt} cos(ω √(1 − ζ²) t +
φ): f_1 and ζ by nonlinear least squares over the taps, and their scatter by leaving each tap out.
The force is Y (1 − r² + 2 i ζ r), up to BAND times f_1: beyond, other modes are read, too.
"""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from autodb import signals
from autodb.records.tables import Recording
from autodb.timing import Timing

Array = NDArray[np.float64]

BAND = 1.5
"""Times its natural frequency up to which a component is told. Chosen: a second mode at twice the
first, with a tenth of the whole, makes a third of what the first alone would read there."""
SECOND = 0.1
"""Share of a correction that further modes may hold, as a standard deviation. Chosen."""
LEAST_HZ = 1000.0
"""Rate from which on taps are looked for. Chosen: dynamometers ring at some hundred hertz."""
QUICK_HZ = 100.0
"""Frequency above which a tap is looked for. Chosen: tables move more slowly."""
LOUD, QUIET = 30.0, 0.1
"""Times the usual size of a reading that a tap reaches, and the share of its peak that was there in
the BEFORE_S before. Chosen."""
BEFORE_S, APART_S = 0.05, 0.2
"""Time before a tap that is quiet, and that one lasts at least."""
CONTACT_S, RINGS_S = 0.003, 0.15
"""Time after a tap's peak in which the hammer may still touch, and that it rings. Chosen."""
ALONG = 0.5
"""Share of the loudest component that another one reaches for a tap to count for it. Chosen."""
FEWEST = 3
"""Taps of a component at least."""
EXPLAINED, SURE = 0.8, 0.02
"""Share of a tap's swinging that frequency and damping of the others explain, in all, and relative
standard deviation of the frequency, for a resonance to be determined. Chosen."""


@dataclass(frozen=True)
class Mode:
    """A component's natural frequency, Hz, and damping, with their standard deviations."""

    hz: float
    damping: float
    hz_sd: float
    damping_sd: float

    def corrected(self, read_N: Array, rate_hz: float, *, cutoff_hz: float) -> tuple[Array, Array]:
        """Return the force (n,) of an evenly sampled reading (n,), and the sd of its correction up
        to ``cutoff_hz``.
        """
        count = len(read_N)
        more = min(count - 1, round(RINGS_S * rate_hz))
        # Turned about both ends, so that it goes on smoothly there
        ahead, behind = read_N[more:0:-1], read_N[-2 : -more - 2 : -1]
        longer = np.concatenate([2.0 * read_N[0] - ahead, read_N, 2.0 * read_N[-1] - behind])
        line = np.linspace(longer[0], longer[-1], len(longer))
        spectrum = np.fft.rfft(longer - line)
        ratio = np.fft.rfftfreq(len(longer), 1.0 / rate_hz) / self.hz

        def of(factor: NDArray[np.complexfloating]) -> Array:
            return np.asarray(np.fft.irfft(spectrum * factor, len(longer))[more : more + count])

        stiff, damped = of(-(ratio**2) + 0j), of(2j * self.damping * ratio)
        slow = [
            signals.lowpass(one, rate_hz=rate_hz, cutoff_hz=cutoff_hz) for one in (stiff, damped)
        ]
        squares = (2.0 * slow[0] * self.hz_sd / self.hz) ** 2 + (SECOND * (slow[0] + slow[1])) ** 2
        squares += (slow[1] * self.damping_sd / self.damping) ** 2
        return read_N + stiff + damped, np.sqrt(squares)


def without_ringing(
    modes: "Modes", sensed_N: Array, timing: Timing, *, cutoff_hz: float
) -> tuple[Array, Array]:
    """Return forces and sds of their correction (3, n), N, of what a sensor sensed (3, n).

    Up to ``cutoff_hz``, a component with a mode up to BAND times its frequency at most.
    """
    force_N, sd_N = sensed_N.copy(), np.zeros_like(sensed_N)
    for k, mode in enumerate(modes):
        hz = cutoff_hz if mode is None else min(cutoff_hz, BAND * mode.hz)
        if mode is not None:
            for piece in timing.pieces:
                force_N[k, piece], sd_N[k, piece] = mode.corrected(
                    sensed_N[k, piece], timing.rate_hz, cutoff_hz=hz
                )
        force_N[k] = signals.lowpass_pieces(force_N[k], timing, cutoff_hz=hz)
    return force_N, sd_N


Modes = tuple[Mode | None, Mode | None, Mode | None]
NONE: Modes = (None, None, None)


def modes_to_json(modes: Modes) -> list[dict[str, float] | None]:
    """Return modes as JSON keeps them."""
    return [None if one is None else asdict(one) for one in modes]


def modes_of_json(kept: Sequence[dict[str, float] | None] | None) -> Modes:
    """Return what ``modes_to_json`` made; None: none are determined."""
    x, y, z = (None if one is None else Mode(**one) for one in kept or (None, None, None))
    return x, y, z


def taps(read_N: Array, timing: Timing) -> list[int]:
    """Return the rows of the peaks of taps in a reading (3, n)."""
    rate_hz = timing.rate_hz
    if rate_hz < LEAST_HZ:
        return []
    slow = [signals.lowpass_pieces(one, timing, cutoff_hz=QUICK_HZ) for one in read_N]
    size = np.sqrt(np.sum((read_N - np.array(slow)) ** 2, axis=0))
    loud = size > LOUD * max(float(np.median(size)), 1e-300)
    before, apart = round(BEFORE_S * rate_hz), round(APART_S * rate_hz)
    found: list[int] = []
    for piece in timing.pieces:
        row = piece.start
        while loud[row : piece.stop].any():
            row += int(np.argmax(loud[row : piece.stop]))
            peak = row + int(np.argmax(size[row : row + round(CONTACT_S * rate_hz)]))
            quiet = size[max(piece.start, row - before) : row]
            # The low-pass sees a tap a little before it comes
            if len(quiet) and np.median(quiet) < QUIET * size[peak] and peak + apart < piece.stop:
                found.append(peak)
            row += apart
    return found


def modes_of(recordings: Sequence[tuple[Recording, Array]]) -> Modes:
    """Return the modes that taps determine, of recordings and their sensed forces (3, n), N."""
    x, y, z = (_mode_of(list(_swings(recordings, k))) for k in range(3))
    return x, y, z


def _swings(
    recordings: Sequence[tuple[Recording, Array]], component: int
) -> Iterator[tuple[Array, Array]]:
    """Give times (n,), s, and a component's free swinging (n,), N, after each tap along it."""
    for recording, sensed_N in recordings:
        rate_hz = recording.timing.rate_hz
        begin, length = round(CONTACT_S * rate_hz), round(RINGS_S * rate_hz)
        for peak in taps(sensed_N, recording.timing):
            swing = sensed_N[:, peak + begin : peak + begin + length]
            sizes = swing.std(axis=1)
            if sizes[component] >= ALONG * sizes.max():
                yield np.arange(swing.shape[1]) / rate_hz, swing[component]


def _mode_of(swings: Sequence[tuple[Array, Array]]) -> Mode | None:
    """Return the mode of taps along a component; None: they do not determine it."""
    if len(swings) < FEWEST:
        return None
    whole = _fitted(swings, _loudest_hz(swings), 0.03)
    without = []
    left = total = 0.0
    for k, own in enumerate(swings):
        others = _fitted([*swings[:k], *swings[k + 1 :]], *whole)
        without.append(others)
        left += float(np.sum(_left(own, *others) ** 2))
        total += float(np.sum((own[1] - own[1].mean()) ** 2))
    # Jackknife (B. Efron, The Jackknife, the Bootstrap and Other Resampling Plans, 1982, chapter 3)
    sd = np.sqrt((len(swings) - 1.0) * np.var(without, axis=0))
    if left > (1.0 - EXPLAINED) * total or sd[0] > SURE * whole[0] or not 0.0 < whole[1] < 0.5:
        return None
    return Mode(float(whole[0]), float(whole[1]), float(sd[0]), float(sd[1]))


def _loudest_hz(swings: Sequence[tuple[Array, Array]]) -> float:
    """Return the frequency at which taps swing most."""
    t_s = swings[0][0]
    count = 8 * len(t_s)
    power = sum(np.abs(np.fft.rfft(one - one.mean(), count)) ** 2 for _, one in swings)
    return float(np.fft.rfftfreq(count, t_s[1])[int(np.argmax(power))])


def _left(swing: tuple[Array, Array], hz: float, damping: float) -> Array:
    """Return what a decaying oscillation (and a constant) leaves of a tap's swinging (n,)."""
    t_s, read_N = swing
    omega = 2.0 * np.pi * hz
    decay, turn = np.exp(-damping * omega * t_s), omega * np.sqrt(1.0 - damping**2) * t_s
    columns = np.column_stack([decay * np.cos(turn), decay * np.sin(turn), np.ones(len(t_s))])
    return np.asarray(read_N - columns @ np.linalg.lstsq(columns, read_N, rcond=None)[0])


def _fitted(
    swings: Sequence[tuple[Array, Array]], hz: float, damping: float
) -> tuple[float, float]:
    """Return frequency and damping that leave the least of all taps, from a first guess."""
    from scipy.optimize import least_squares

    def left(logs: Array) -> Array:
        return np.concatenate([_left(one, *np.exp(logs)) for one in swings])

    bounds = np.log([[0.5 * hz, 1e-4], [2.0 * hz, 0.5]])
    start = np.clip(np.log([hz, damping]), bounds[0] + 1e-9, bounds[1] - 1e-9)
    hz, damping = np.exp(least_squares(left, start, bounds=(bounds[0], bounds[1])).x)
    return float(hz), float(damping)
