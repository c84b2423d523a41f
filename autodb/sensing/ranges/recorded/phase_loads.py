"""What an axis' phase currents say over time: its range twice averaged, its frequency, envelope."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb import signals
from autodb.records.tables import Recording

Array = NDArray[np.float64]

AXES = ("x", "z", "spindle")
QUICK_S = 0.1
"""Average of the range in which short events show."""
PERIODS = (2.0, 1.0)
"""Periods of the drive's sinusoid that a range is at least averaged over: of one phase, of three
(`signals.one_phase_range`, `three_phase_range`)."""

LEAD_S = 1.0
"""What an air approach takes at least,"""
LEAD_PERIODS = (1.7, 1.5)
"""these periods more, of one phase and of three,"""
SLOW_HZ, SLOW_PERIODS = (1.4, 1.0), 3.0
"""and three where the axis turns slower: measured at rates of 700 to 1900 Hz, where shorter
approaches were read up to 40 % too high, the average reaching into the cut."""
STEADY_S, STEADY_PERIODS = 1.0, 1.5
"""Of the cut's beginning, what tells a short approach its frequency and its sensors' offsets."""


@dataclass(frozen=True)
class PhaseLoad:
    """One axis over the samples of a recording, each (n,); NaN where it stands.

    ``range_A`` as it is averaged in a cut table, ``quick_A`` over ``QUICK_S`` where the axis turns
    fast enough; ``frequency_hz`` of the drive's sinusoid; ``envelope_A`` is the range of each
    sample by itself, with noise and ripple, None with fewer than three phases. ``phases_A``: the
    currents themselves.
    """

    range_A: Array
    quick_A: Array
    frequency_hz: Array
    envelope_A: Array | None
    phases_A: tuple[Array, ...] = ()

    @property
    def three(self) -> bool:
        """Whether all three phases were recorded."""
        return self.envelope_A is not None

    def turning_hz(self, part: slice) -> float:
        """Return the frequency of the drive's sinusoid in a part, without sign; 0 at standstill."""
        found = np.abs(self.frequency_hz[part])
        known = found[np.isfinite(found)]
        return float(np.median(known)) if known.size else 0.0

    def averaged_s(self, part: slice) -> float:
        """Return what ``quick_A`` is averaged over in a part, s."""
        turning_hz = self.turning_hz(part)
        return max(QUICK_S, PERIODS[self.three] / turning_hz) if turning_hz else np.inf

    def air_needs_s(self, air: slice) -> float:
        """Return how long an air approach must be for its range to be known, s."""
        turning_hz = self.turning_hz(air)
        if not turning_hz:
            return LEAD_S
        slow = turning_hz < SLOW_HZ[self.three]
        return LEAD_S + (SLOW_PERIODS if slow else LEAD_PERIODS[self.three]) / turning_hz

    def until(self, end: int) -> "PhaseLoad":
        """Return the load up to a sample."""
        envelope = None if self.envelope_A is None else self.envelope_A[:end]
        phases = tuple(phase[:end] for phase in self.phases_A)
        return PhaseLoad(
            self.range_A[:end], self.quick_A[:end], self.frequency_hz[:end], envelope, phases
        )

    def feeding_hz(self, part: slice, *, rate_hz: float) -> float:
        """Return the signed frequency in a part, Hz; 0 where it is not known.

        One phase is demodulated from some six periods on; of fewer the strongest swing counts.
        """
        found = self.frequency_hz[part]
        known = found[np.isfinite(found)]
        if known.size:
            return float(np.median(known))
        return signals.strongest_hz(self.phases_A[0][part], rate_hz=rate_hz)

    def steady(
        self, part: slice, *, rate_hz: float, turned: Array | None = None
    ) -> signals.SteadySinusoid | None:
        """Return the sinusoid of a part, steady in the clock ``turned`` (n,), s."""
        t_s = np.arange(self.range_A.size) / rate_hz if turned is None else turned
        return signals.steady_sinusoid(
            [phase[part] for phase in self.phases_A],
            t_s=t_s[part],
            frequency_hz=self.feeding_hz(part, rate_hz=rate_hz),
        )

    def steady_in_air(
        self, air: slice, cut: slice, *, rate_hz: float, speed_rpm: Array | None
    ) -> signals.SteadySinusoid | None:
        """Return the sinusoid in air of a drive that feeds there as it does where the cut begins.

        A feed per revolution follows ``speed_rpm`` (n,). None where either part is not steady.
        """
        turning_hz = abs(self.feeding_hz(cut, rate_hz=rate_hz))
        if not turning_hz:
            return None
        lasts = round(max(STEADY_S, STEADY_PERIODS / turning_hz) * rate_hz)
        begins = slice(cut.start, min(cut.start + lasts, cut.stop))
        t_s = np.arange(self.range_A.size) / rate_hz
        if speed_rpm is not None:
            t_s = np.cumsum(speed_rpm) / float(np.median(speed_rpm[begins])) / rate_hz
        in_cut = self.steady(begins, rate_hz=rate_hz, turned=t_s)
        if in_cut is None:
            return None
        return signals.steady_sinusoid(
            [phase[air] for phase in self.phases_A],
            t_s=t_s[air],
            frequency_hz=in_cut.frequency_hz,
            beside=in_cut,
        )


def has_phase_currents(channels: Collection[str]) -> bool:
    """Say whether a phase current of some axis is among ``channels``; one is enough."""
    return any(f"{axis}.current.{phase}" in channels for axis in AXES for phase in "uvw")


def phase_load_of(recording: Recording, axis: str) -> PhaseLoad | None:
    """Return the load of an axis from its three phases, or the first of fewer; None without any."""
    phases = [recording.get(f"{axis}.current.{phase}") for phase in "uvw"]
    recorded = [phase for phase in phases if phase is not None]
    if not recorded:
        return None
    rate_hz = recording.timing.rate_hz
    loads = [
        _load_of([phase[piece] for phase in recorded], rate_hz=rate_hz)
        for piece in recording.pieces
    ]
    whole = loads[0] if len(loads) == 1 else _joined(loads)
    return replace(whole, phases_A=tuple(recorded if whole.three else recorded[:1]))


def _load_of(phases: Sequence[Array], *, rate_hz: float) -> PhaseLoad:
    """Return the load of one piece of even rows."""
    if len(phases) < 3:
        mean = signals.one_phase_range(phases[0], rate_hz=rate_hz)
        quick = signals.one_phase_range(phases[0], rate_hz=rate_hz, smooth_s=QUICK_S)
        return PhaseLoad(mean.range_A, quick.range_A, quick.frequency_hz, None)
    u, v, w = phases
    mean = signals.three_phase_range(u, v, w, rate_hz=rate_hz)
    quick = signals.three_phase_range(u, v, w, rate_hz=rate_hz, smooth_s=QUICK_S)
    envelope = 2.0 * np.abs(signals.space_vector(u, v, w))
    return PhaseLoad(mean.range_A, quick.range_A, quick.frequency_hz, envelope)


def _joined(loads: Sequence[PhaseLoad]) -> PhaseLoad:
    """Return the loads of pieces one after the other."""
    envelopes = [load.envelope_A for load in loads if load.envelope_A is not None]
    return PhaseLoad(
        np.concatenate([load.range_A for load in loads]),
        np.concatenate([load.quick_A for load in loads]),
        np.concatenate([load.frequency_hz for load in loads]),
        np.concatenate(envelopes) if envelopes else None,
    )
