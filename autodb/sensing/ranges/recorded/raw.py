"""One cut recorded over time with raw phase currents becomes one row of a cut table.

Phase currents go through the demodulator, the range is split into air approach and cut, and each
part gives its mean range with its standard error; a dynamometer's forces give their quasi-static
mean over the cut. What disturbs a part of it is left out and said, what spoils it excludes it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb import signals
from autodb.files.channels import DURATION, FORCES, JOB_BLOCK, JOB_CUT
from autodb.files.side import SideFile
from autodb.records.tables import CutTable, Recording
from autodb.sensing.ranges import faults
from autodb.sensing.ranges.recorded import rejections
from autodb.sensing.ranges.recorded.means import AxisInCut, air_and_cut_means
from autodb.sensing.ranges.recorded.phase_loads import (
    AXES,
    PhaseLoad,
    has_phase_currents,
    phase_load_of,
)
from autodb.sensing.ranges.recorded.radius import radius_course
from autodb.sensing.ranges.recorded.segmenting import (
    CutSignals,
    mean_speed_rpm,
    refuse_set_aside,
    segments_of,
)
from autodb.wording import localized, phrase

Array = NDArray[np.float64]

__all__ = ["RawCut", "cut_of_recording", "cut_stretch", "has_phase_currents"]

AVERAGE_S = 0.5
"""What range and force are averaged over: half of it before an event already shows it."""
SLIPS = 0.06
"""Share by which a spindle drive's frequency changes at a constant speed, at most: an induction
motor's slip at its rated torque. Chosen."""
SPEED_SPREAD = 0.003
"""How well a spindle's speed is known which only the side file states; chosen, some slip."""


@dataclass(frozen=True)
class RawCut:
    """A cut as a table of one row, and what was left out of its averages, a sentence each."""

    table: CutTable
    notes: tuple[str, ...]


def cut_of_recording(
    recording: Recording, *, progress: Callable[[str], None] | None = None
) -> RawCut:
    """Return the one cut of a recording, and what was left out of its averages.

    Raises SetAside when no axis shows an air approach followed by a cut, when too little of one is
    left, when the cut stops in the middle, chatters, or runs into a drive's current limit; and
    UnusableInput when X was logged as a diameter.
    """
    found, notes = _recorded(recording, progress)
    parts = segments_of(found, recording)
    faults.refuse(recording.path, faults.x_travels(recording, parts.cut))
    for axis, load in found.loads.items():
        refuse_set_aside(
            recording, rejections.range_at_limit(load, parts, axis=axis, t_s=recording.t_s)
        )
    spindle = _spindle(recording, parts)
    if spindle is None:
        notes.append(phrase("chatter was not searched for: the spindle's speed is not known"))
    else:
        seen = rejections.chatters(
            found.loads, found.forces, parts, rate_hz=found.rate_hz, spindle=spindle
        )
        refuse_set_aside(recording, seen)
    row = _conditions(recording, found, parts) | _during(recording, parts.cut)
    for axis, load in found.loads.items():
        one = AxisInCut(axis, load, parts, found.rate_hz, found.speed_rpm)
        row |= air_and_cut_means(one, notes)
    for name, force in found.quasi_static.items():
        row[name] = float(np.mean(force[parts.cut]) - np.mean(force[parts.air]))
    return RawCut(table_of_cut(recording.path, recording.side, row), tuple(notes))


def cut_stretch(recording: Recording) -> tuple[float, float]:
    """Return from when to when the one cut of a recording lasts, s: the middles of entry and exit.

    Raises SetAside where no cut shows.
    """
    found, _ = _recorded(recording, None)
    return _stretch_s(recording, segments_of(found, recording))


def _stretch_s(recording: Recording, parts: signals.CutSegments) -> tuple[float, float]:
    middles = [(one.start + one.stop) // 2 for one in (parts.entry, parts.exit)]
    last = len(recording) - 1
    return float(recording.t_s[middles[0]]), float(recording.t_s[min(middles[1], last)])


def _recorded(
    recording: Recording, progress: Callable[[str], None] | None
) -> tuple[CutSignals, list[str]]:
    """Return the signals before the spindle slows down for good, and a note where it does."""
    loads = {}
    for axis in AXES:
        if progress:
            progress(f"demodulating {axis}")
        load = phase_load_of(recording, axis)
        if load is not None:
            loads[axis] = load
    rate = recording.timing.rate_hz
    begins = _slows(recording, loads)
    end, notes = len(recording), []
    if begins is not None:
        end = max(0, begins - round(0.5 * AVERAGE_S * rate))
        notes.append(_slowing(float(recording.t_s[begins]), loads, begins))
        loads = {axis: load.until(end) for axis, load in loads.items()}
    forces = {name: recording[name][:end] for name in FORCES if name in recording}
    pieces = [slice(p.start, min(p.stop, end)) for p in recording.pieces if p.start < end]
    slow = partial(signals.quasi_static, rate_hz=rate)
    quasi = {name: signals.by_piece(slow, f, pieces) for name, f in forces.items()}
    speed_rpm = _speed_over_time_rpm(recording, loads)
    radius = radius_course(recording, speed_rpm)
    if speed_rpm is not None:
        speed_rpm = speed_rpm[:end]
    known = None if radius is None else radius.until(end)
    return CutSignals(rate, loads, forces, quasi, speed_rpm, known), notes


def _speed_over_time_rpm(recording: Recording, loads: dict[str, PhaseLoad]) -> Array | None:
    """Return the spindle's speed (n,), rpm, as recorded; None where it is not known.

    Else what the side file states of the beginning, followed by the drive's frequency where that
    changes by more than a motor slips under load.
    """
    speed = recording.get("spindle.speed")
    stated_rpm = recording.side.cut.speed_rpm
    if speed is not None or stated_rpm is None:
        return None if speed is None else np.abs(speed)
    turns = np.abs(loads["spindle"].frequency_hz) if "spindle" in loads else np.zeros(0)
    known = np.flatnonzero(np.isfinite(turns))
    if not known.size:
        return np.full(len(recording), stated_rpm)
    whole = np.interp(np.arange(len(recording)), known, turns[known])
    first = whole[known[0] : known[0] + round(signals.MARGIN_S * recording.timing.rate_hz)]
    share = whole / np.median(first)
    changes = float(np.quantile(share, 0.95) - np.quantile(share, 0.05)) > SLIPS
    return np.asarray(stated_rpm * share if changes else np.full_like(share, stated_rpm))


def _slows(recording: Recording, loads: dict[str, PhaseLoad]) -> int | None:
    """Return from where the spindle slows down, by its speed or its drive's frequency."""
    speed = recording.get("spindle.speed")
    if speed is None and "spindle" in loads:
        speed = loads["spindle"].frequency_hz
    return None if speed is None else signals.slowing_from(speed, rate_hz=recording.timing.rate_hz)


def _slowing(from_s: float, loads: dict[str, PhaseLoad], begins: int) -> str:
    after = loads["spindle"].range_A[begins:] if "spindle" in loads else np.zeros(0)
    known = after[np.isfinite(after)]
    high = (
        phrase(", its range up to {max} A,", max=localized(f"{np.max(known):.4g}"))
        if known.size
        else ""
    )
    return phrase(
        "from {from_} s on the spindle slows down{high} and all of it is excluded",
        from_=localized(f"{from_s:.2f}"),
        high=high,
    )


def _spindle(recording: Recording, parts: signals.CutSegments) -> signals.Turning | None:
    """Return the frequency whose multiples are no chatter, up to the rate; None: not known."""
    speed_rpm = mean_speed_rpm(recording, parts.cut)
    if not speed_rpm:
        return None
    speed, spread = recording.get("spindle.speed"), SPEED_SPREAD
    if speed is not None:
        smooth = signals.moving_average(
            speed[parts.cut], rate_hz=recording.timing.rate_hz, window_s=AVERAGE_S
        )
        spread = float(np.std(smooth)) / speed_rpm
    turning_hz = abs(speed_rpm) / 60.0
    return signals.Turning(turning_hz, int(recording.timing.rate_hz / turning_hz), spread)


def _conditions(
    recording: Recording, found: CutSignals, parts: signals.CutSegments
) -> dict[str, float]:
    """Return what was cut with: as stated, and speed and diameter as they were on average."""
    row = {"cut": 1.0, "t": float(recording.t_s[parts.cut.start])} | stated_by(recording.side)
    if parts.exit.stop < len(recording):
        begin_s, end_s = _stretch_s(recording, parts)
        row[DURATION] = end_s - begin_s
    if found.speed_rpm is not None:
        row["spindle.speed"] = float(np.mean(found.speed_rpm[parts.cut]))
    if found.radius is not None:
        begin = (parts.entry.start + parts.entry.stop) // 2
        row["work.diameter"] = 2.0 * float(np.mean(found.radius.of_cut(begin)[parts.cut]))
    return row


def stated_by(side_file: SideFile) -> dict[str, float]:
    """Return what a side file states of the one cut of its recording, by channel."""
    side = side_file.cut
    known = {
        "cutting.feed": side.feed_mm_rev or side.feed_mm_tooth,
        "cutting.depth": side.depth_mm,
        "cutting.width": side.width_mm,
        "cutting.direction": side.feed_direction_deg,
        "spindle.speed": side.speed_rpm,
        "work.diameter": side.work_diameter_mm,
    }
    return {name: value for name, value in known.items() if value is not None}


def _during(recording: Recording, cut: slice) -> dict[str, float]:
    """Return means over the cut of what decides which calibration holds: velocity, temperature.

    The velocity of an axis that records its position only is what it travelled over the time.
    """
    found = {}
    took_s = float(recording.t_s[cut.stop - 1] - recording.t_s[cut.start])
    for axis in AXES:
        velocity, position = (recording.get(f"{axis}.{of}") for of in ("velocity", "position"))
        if velocity is not None:
            found[f"{axis}.velocity"] = float(np.mean(velocity[cut]))
        elif position is not None and took_s > 0:
            travelled_mm = float(position[cut.stop - 1] - position[cut.start])
            found[f"{axis}.velocity"] = travelled_mm / took_s
    temperature = recording.get("spindle.temperature")
    if temperature is not None:
        found["spindle.temperature"] = float(np.mean(temperature[cut]))
    return found


def table_of_cut(path: Path, side: SideFile, row: Mapping[str, float]) -> CutTable:
    """Return the one cut of a recording over time as a table, with what its side file says."""
    texts: dict[str, list[str]] = {
        "operation": [side.cut.operation or ""],
        "work.material": [side.recording.work or ""],
        "tool": [side.tool.name or ""],
        JOB_CUT: [side.cut.name or ""],
    }
    channels = {name: np.array([value]) for name, value in row.items()}
    if side.cut.block is not None:
        channels[JOB_BLOCK] = np.array([float(side.cut.block)])
    return CutTable(path=path, channels=channels, texts=texts, side=side)
