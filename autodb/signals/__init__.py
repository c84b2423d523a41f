"""Signals before any model: filters, phase currents to range, quasi-static force, segments."""

from autodb.signals.filters import decimate, derivatives, lowpass
from autodb.signals.folds import Unfolded, touches, unfolded
from autodb.signals.limits import Flat, held_at_top
from autodb.signals.phases import (
    one_phase,
    one_phase_range,
    space_vector,
    three_phase_range,
    three_phases,
)
from autodb.signals.pulses import Pulses, regular_pulses
from autodb.signals.scatter import standard_error
from autodb.signals.segments import MARGIN_S, Levels, Segments, air_and_cut, segments_of, two_levels
from autodb.signals.stops import interrupted, slowing_from
from autodb.signals.stream import STANDING_HZ, PhaseRange, PhaseStream
from autodb.signals.vibration import Line, Turning, chatter
from autodb.signals.wavelets import moving_average, quasi_static, wavelet_range

__all__ = [
    "MARGIN_S",
    "STANDING_HZ",
    "Flat",
    "Levels",
    "Line",
    "PhaseRange",
    "PhaseStream",
    "Pulses",
    "Segments",
    "Turning",
    "Unfolded",
    "air_and_cut",
    "chatter",
    "decimate",
    "derivatives",
    "held_at_top",
    "interrupted",
    "lowpass",
    "moving_average",
    "one_phase",
    "one_phase_range",
    "quasi_static",
    "regular_pulses",
    "segments_of",
    "slowing_from",
    "space_vector",
    "standard_error",
    "three_phase_range",
    "three_phases",
    "touches",
    "two_levels",
    "unfolded",
    "wavelet_range",
]
