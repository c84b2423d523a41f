"""Signals before any model: filters, phase currents to range, quasi-static force, segments."""

from autodb.signals.filters import decimate, derivatives, lowpass
from autodb.signals.folds import Unfolded, touches, unfolded
from autodb.signals.phases import (
    one_phase,
    one_phase_range,
    space_vector,
    three_phase_range,
    three_phases,
)
from autodb.signals.segments import Segments, air_and_cut
from autodb.signals.stream import STANDING_HZ, PhaseRange, PhaseStream
from autodb.signals.wavelets import quasi_static, wavelet_range

__all__ = [
    "STANDING_HZ",
    "PhaseRange",
    "PhaseStream",
    "Segments",
    "Unfolded",
    "air_and_cut",
    "decimate",
    "derivatives",
    "lowpass",
    "one_phase",
    "one_phase_range",
    "quasi_static",
    "space_vector",
    "three_phase_range",
    "three_phases",
    "touches",
    "unfolded",
    "wavelet_range",
]
