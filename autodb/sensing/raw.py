"""One cut recorded over time with raw phase currents becomes one row of a cut table.

Phase currents go through the demodulator, the range is split into air approach and cut, and each
part gives its mean range; a dynamometer's forces give their quasi-static mean over the cut.
"""

from collections.abc import Callable, Collection

import numpy as np
from numpy.typing import NDArray

from autodb import signals
from autodb.channels import FORCES
from autodb.errors import UnusableInput
from autodb.records import CutTable, Recording
from autodb.sensing import faults

Array = NDArray[np.float64]

AXES = ("x", "z", "spindle")


def has_phase_currents(channels: Collection[str]) -> bool:
    """Say whether a phase current of some axis is among ``channels``; one is enough."""
    return any(f"{axis}.current.{phase}" in channels for axis in AXES for phase in "uvw")


def cut_of(recording: Recording, *, progress: Callable[[str], None] | None = None) -> CutTable:
    """Return the one cut of a recording as a table of one row.

    Raises UnusableInput when no axis shows an air approach followed by a cut, or X was logged as a
    diameter.
    """
    rate = recording.rate_hz
    ranges = _ranges(recording, progress)
    forces = {
        name: signals.quasi_static(recording[name], rate_hz=rate)
        for name in FORCES
        if name in recording
    }
    segments = _segments(ranges, forces, rate, recording)
    faults.refuse(recording.path, faults.x_travels(recording, segments.cut))
    row = _conditions(recording, segments.cut)
    for axis, values in ranges.items():
        parts = {"air": segments.air, "range": segments.cut}
        if axis != "spindle" and _folds(values, segments):
            if progress:
                progress(f"{axis}: the range folds between air and cut; its force is not sensed")
            del parts["range"]
        for name, part in parts.items():
            known = values[part][np.isfinite(values[part])]
            if known.size > 0.5 * (part.stop - part.start):
                row[f"{axis}.current.{name}"] = float(np.mean(known))
    for name, quasi in forces.items():
        row[name] = float(np.mean(quasi[segments.cut]) - np.mean(quasi[segments.air]))
    side = recording.side
    texts: dict[str, list[str]] = {
        "operation": [side.cut.operation or ""],
        "work.material": [side.recording.work or ""],
        "tool": [side.tool.name or ""],
    }
    channels = {name: np.array([value]) for name, value in row.items()}
    return CutTable(path=recording.path, channels=channels, texts=texts, side=side)


def _ranges(recording: Recording, progress: Callable[[str], None] | None) -> dict[str, Array]:
    """Return the range (n,) of every axis of which a phase current was recorded."""
    ranges = {}
    for axis in AXES:
        phases = [recording.get(f"{axis}.current.{phase}") for phase in "uvw"]
        recorded = [phase for phase in phases if phase is not None]
        if recorded:
            if progress:
                progress(f"demodulating {axis}")
            ranges[axis] = _range_A(recorded, recording.rate_hz)
    return ranges


def _range_A(phases: list[Array], rate_hz: float) -> Array:
    """Return the range of all three phases, or of the first where one or two were recorded."""
    if len(phases) < 3:
        return signals.one_phase_range(phases[0], rate_hz=rate_hz).range_A
    u, v, w = phases
    return signals.three_phase_range(u, v, w, rate_hz=rate_hz).range_A


def _folds(range_A: Array, segments: signals.Segments) -> bool:
    """Say whether the load may have changed its sign between the air approach and the cut."""
    return bool(signals.touches(range_A[segments.air.start : segments.cut.stop]))


def _segments(
    ranges: dict[str, Array], forces: dict[str, Array], rate: float, recording: Recording
) -> signals.Segments:
    """Return the split of the first load that shows one; the spindle sees every cut: it leads.

    Forces of a dynamometer come last, the largest first.
    """
    currents = [ranges[axis] for axis in ("spindle", "z", "x") if axis in ranges]
    for load in (*currents, *sorted(forces.values(), key=np.ptp, reverse=True)):
        found = signals.air_and_cut(load, rate_hz=rate)
        if found is not None:
            return found
    raise UnusableInput(
        f"{recording.path}: no air approach followed by a cut in the {_felt(ranges, forces)}; "
        "a recording that starts 1 s before the tool enters would work"
    )


def _felt(ranges: dict[str, Array], forces: dict[str, Array]) -> str:
    return "currents and forces" if ranges and forces else "forces" if forces else "currents"


def _conditions(recording: Recording, cut: slice) -> dict[str, float]:
    side = recording.side.cut
    known = {
        "cut": 1.0,
        "t": float(recording.t_s[cut.start]),
        "cutting.feed": side.feed_mm_rev or side.feed_mm_tooth,
        "cutting.depth": side.depth_mm,
        "spindle.speed": side.speed_rpm,
        "work.diameter": side.work_diameter_mm,
    }
    return {name: value for name, value in known.items() if value is not None}
