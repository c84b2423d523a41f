"""Signals before any model: filters, phase currents to range, quasi-static force, segments.

Names load when they are used: who filters loads no wavelets.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from autodb.signals.filters import (
        by_piece,
        decimate,
        derivatives,
        lowpass,
        lowpass_pieces,
        slope,
        standard_error,
    )
    from autodb.signals.folds import Flat, Unfolded, held_at_top, touches, unfolded
    from autodb.signals.phases import (
        one_phase,
        one_phase_range,
        space_vector,
        three_phase_range,
        three_phases,
    )
    from autodb.signals.pulses import Pulses, regular_pulses
    from autodb.signals.segments import (
        MARGIN_S,
        CutSegments,
        LoadLevels,
        air_and_cut,
        cut_segments,
        flagged_runs,
        interrupted,
        slowing_from,
        stepped_levels,
        two_levels,
    )
    from autodb.signals.steady import SteadySinusoid, steady_sinusoid, strongest_hz
    from autodb.signals.stream import STANDING_HZ, PhaseRange, PhaseStream
    from autodb.signals.vibration import NarrowBand, Turning, chatter
    from autodb.signals.wavelets import moving_average, quasi_static, wavelet_range

__all__ = [
    "MARGIN_S",
    "STANDING_HZ",
    "CutSegments",
    "Flat",
    "LoadLevels",
    "NarrowBand",
    "PhaseRange",
    "PhaseStream",
    "Pulses",
    "SteadySinusoid",
    "Turning",
    "Unfolded",
    "air_and_cut",
    "by_piece",
    "chatter",
    "cut_segments",
    "decimate",
    "derivatives",
    "flagged_runs",
    "held_at_top",
    "interrupted",
    "lowpass",
    "lowpass_pieces",
    "moving_average",
    "one_phase",
    "one_phase_range",
    "quasi_static",
    "regular_pulses",
    "slope",
    "slowing_from",
    "space_vector",
    "standard_error",
    "steady_sinusoid",
    "stepped_levels",
    "strongest_hz",
    "three_phase_range",
    "three_phases",
    "touches",
    "two_levels",
    "unfolded",
    "wavelet_range",
]

_PLACES = {
    "filters": (
        "by_piece",
        "decimate",
        "derivatives",
        "lowpass",
        "lowpass_pieces",
        "slope",
        "standard_error",
    ),
    "folds": ("Flat", "Unfolded", "held_at_top", "touches", "unfolded"),
    "phases": ("one_phase", "one_phase_range", "space_vector", "three_phase_range", "three_phases"),
    "pulses": ("Pulses", "regular_pulses"),
    "segments": (
        "MARGIN_S",
        "CutSegments",
        "LoadLevels",
        "air_and_cut",
        "cut_segments",
        "flagged_runs",
        "interrupted",
        "slowing_from",
        "stepped_levels",
        "two_levels",
    ),
    "steady": ("SteadySinusoid", "steady_sinusoid", "strongest_hz"),
    "stream": ("STANDING_HZ", "PhaseRange", "PhaseStream"),
    "vibration": ("NarrowBand", "Turning", "chatter"),
    "wavelets": ("moving_average", "quasi_static", "wavelet_range"),
}
"""Modules, and the names that are taken from each."""


def __getattr__(name: str) -> Any:
    for module, names in _PLACES.items():
        if name in names:
            return getattr(import_module(f"{__name__}.{module}"), name)
    raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
