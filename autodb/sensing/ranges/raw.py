"""One cut recorded over time with raw phase currents becomes one row of a cut table.

Phase currents go through the demodulator, the range is split into air approach and cut, and each
part gives its mean range with its standard error; a dynamometer's forces give their quasi-static
mean over the cut. What disturbs a part of it is left out and said, what spoils it excludes it.

Means of a range in air and in cut with their standard errors, without what disturbs them.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb import signals
from autodb.errors import SetAside
from autodb.files.channels import FORCES, JOB_BLOCK, JOB_CUT
from autodb.files.side import SideFile
from autodb.records import CutTable, Recording
from autodb.sensing.ranges import faults, rejections
from autodb.sensing.ranges.phase_loads import (
    AXES,
    QUICK_S,
    PhaseLoad,
    has_phase_currents,
    phase_load_of,
)
from autodb.sensing.ranges.rejections import FEWEST_S

Array = NDArray[np.float64]


Flags = NDArray[np.bool_]


def air_and_cut_means(
    axis: str, load: PhaseLoad, parts: signals.CutSegments, rate_hz: float, notes: list[str]
) -> dict[str, float]:
    """Return an axis' means and standard errors, A, in air and in cut; note what is left out."""
    segments = _usable(axis, load, parts, rate_hz, notes)
    values, kept = load.range_A, np.ones(load.range_A.size, dtype=np.bool_)
    if axis != "spindle":
        steady = [(part.start, load.quick_A[part]) for part in segments.values()]
        averaged_s = load.averaged_s(parts.cut)
        pulses = signals.regular_pulses(steady, rate_hz=rate_hz, averaged_s=averaged_s)
        if pulses is not None:
            values, kept = load.quick_A, _outside(pulses, load, parts.cut, rate_hz)
            notes.append(
                f"{axis}: {len(pulses.seen)} short rises of the range every "
                f"{pulses.every_s:.2f} s, as of way lubrication, are excluded"
            )
    row = {}
    for name, part in segments.items():
        used = np.where(kept, values, np.nan)[part]
        known = used[np.isfinite(used)]
        if known.size <= max(0.5 * kept[part].sum(), FEWEST_S * rate_hz):
            continue
        row[f"{axis}.current.{name}"] = float(np.mean(known))
        quick = np.where(kept, load.quick_A, np.nan)[part]
        error = signals.standard_error(quick, rate_hz=rate_hz, averaged_s=load.averaged_s(part))
        if error is not None:
            row[f"{axis}.current.{name}.sd"] = error
    return row


def _usable(
    axis: str, load: PhaseLoad, parts: signals.CutSegments, rate_hz: float, notes: list[str]
) -> dict[str, slice]:
    """Return the parts in which an axis' range is known, by the name of its channel."""
    segments = {"air": parts.air, "range": parts.cut}
    if axis != "spindle" and signals.touches(load.range_A[parts.air.start : parts.cut.stop]):
        notes.append(f"{axis}: the range folds between air and cut; its force is not sensed")
        del segments["range"]
    has_s = parts.air.stop / rate_hz + signals.MARGIN_S
    needs_s = load.air_needs_s(parts.air)
    if has_s < needs_s:
        notes.append(
            f"{axis}: its range in air is excluded, because the approach takes {has_s:.2g} s; "
            f"approach for {needs_s:.2g} s, for a drive that turns at "
            f"{load.turning_hz(parts.air):.2g} Hz"
        )
        del segments["air"]
    return segments


def _outside(pulses: signals.Pulses, load: PhaseLoad, cut: slice, rate_hz: float) -> Flags:
    """Return which samples no pulse reaches, through the average either."""
    kept = np.ones(load.quick_A.size, dtype=np.bool_)
    beside = round(0.5 * load.averaged_s(cut) * rate_hz)
    for run in (*pulses.seen, *pulses.expected):
        kept[max(0, run.start - beside) : run.stop + beside] = False
    return kept


__all__ = ["RawCut", "cut_of_recording", "has_phase_currents"]


AVERAGE_S = 0.5
"""What range and force are averaged over: half of it before an event already shows it."""
SPINDLE = "spindle.current.range"
SPEED_SPREAD = 0.003
"""How well a spindle's speed is known which only the side file states; chosen, some slip."""


@dataclass(frozen=True)
class RawCut:
    """A cut as a table of one row, and what was left out of its averages, a sentence each."""

    table: CutTable
    notes: tuple[str, ...]


@dataclass(frozen=True)
class _Signals:
    """What was recorded, up to where the spindle slows down: loads by axis, forces by channel.

    ``forces`` as recorded, ``quasi_static`` averaged as the ranges are; both in N, each (n,).
    """

    rate_hz: float
    loads: dict[str, PhaseLoad]
    forces: dict[str, Array]
    quasi_static: dict[str, Array]


def cut_of_recording(
    recording: Recording, *, progress: Callable[[str], None] | None = None
) -> RawCut:
    """Return the one cut of a recording, and what was left out of its averages.

    Raises SetAside when no axis shows an air approach followed by a cut, when too little of one is
    left, when the cut stops in the middle, chatters, or runs into a drive's current limit; and
    UnusableInput when X was logged as a diameter.
    """
    found, notes = _recorded(recording, progress)
    parts = _segments(found, recording)
    faults.refuse(recording.path, faults.x_travels(recording, parts.cut))
    for axis, load in found.loads.items():
        _set_aside(recording, rejections.range_at_limit(load, parts, axis=axis, t_s=recording.t_s))
    spindle = _spindle(recording, parts)
    if spindle is None:
        notes.append("chatter was not searched for: the spindle's speed is not known")
    else:
        seen = rejections.chatters(
            found.loads, found.forces, parts, rate_hz=found.rate_hz, spindle=spindle
        )
        _set_aside(recording, seen)
    row = _conditions(recording, parts.cut) | _during(recording, parts.cut)
    for axis, load in found.loads.items():
        row |= air_and_cut_means(axis, load, parts, found.rate_hz, notes)
    for name, force in found.quasi_static.items():
        row[name] = float(np.mean(force[parts.cut]) - np.mean(force[parts.air]))
    return RawCut(table_of_cut(recording.path, recording.side, row), tuple(notes))


def _set_aside(recording: Recording, seen: str | None) -> None:
    if seen is not None:
        raise SetAside(f"{recording.path}: {seen}")


def _recorded(
    recording: Recording, progress: Callable[[str], None] | None
) -> tuple[_Signals, list[str]]:
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
    return _Signals(rate, loads, forces, quasi), notes


def _slows(recording: Recording, loads: dict[str, PhaseLoad]) -> int | None:
    """Return from where the spindle slows down, by its speed or its drive's frequency."""
    speed = recording.get("spindle.speed")
    if speed is None and "spindle" in loads:
        speed = loads["spindle"].frequency_hz
    return None if speed is None else signals.slowing_from(speed, rate_hz=recording.timing.rate_hz)


def _slowing(from_s: float, loads: dict[str, PhaseLoad], begins: int) -> str:
    after = loads["spindle"].range_A[begins:] if "spindle" in loads else np.zeros(0)
    known = after[np.isfinite(after)]
    high = f", its range up to {np.max(known):.4g} A," if known.size else ""
    return f"from {from_s:.2f} s on the spindle slows down{high} and all of it is excluded"


def _segments(found: _Signals, recording: Recording) -> signals.CutSegments:
    """Return the parts by the first load that shows them; the spindle sees every cut: it leads.

    Forces of a dynamometer come last, the largest first. Raises SetAside.
    """
    seen = None
    for name, load, quick in _leading(found):
        levels = signals.two_levels(load)
        if levels is None:
            continue
        rate = found.rate_hz
        if name == SPINDLE:
            _set_aside(recording, rejections.starts_in_cut(levels))
        stop = rejections.stops(quick, levels, named=name, t_s=recording.t_s, rate_hz=rate)
        _set_aside(recording, stop)
        parts = signals.cut_segments(levels.cutting, rate_hz=rate)
        speed_rpm = _speed_rpm(recording, slice(parts.entry.start, parts.exit.stop))
        short = rejections.too_short(parts, t_s=recording.t_s, rate_hz=rate, speed_rpm=speed_rpm)
        if short is None:
            return parts
        seen = seen or short
    _set_aside(recording, seen)
    raise SetAside(
        f"{recording.path}: no air approach followed by a cut in the {_sensed(found)}; start the "
        "recording 1 s before the tool enters"
    )


def _leading(found: _Signals) -> list[tuple[str, Array, Array]]:
    """Return name, averaged and quickly averaged values (n,) of each load, in order."""
    axes = [axis for axis in ("spindle", "z", "x") if axis in found.loads]
    currents = [
        (f"{a}.current.range", found.loads[a].range_A, found.loads[a].quick_A) for a in axes
    ]
    by_size = sorted(found.quasi_static, key=lambda n: np.ptp(found.quasi_static[n]), reverse=True)
    return currents + [
        (name, found.quasi_static[name], _quick(found.forces[name], found.rate_hz))
        for name in by_size
    ]


def _quick(force_N: Array, rate_hz: float) -> Array:
    return signals.moving_average(force_N, rate_hz=rate_hz, window_s=QUICK_S)


def _sensed(found: _Signals) -> str:
    if found.loads and found.forces:
        return "currents and forces"
    return "forces" if found.forces else "currents"


def _speed_rpm(recording: Recording, part: slice) -> float | None:
    """Return the spindle's mean speed in a part, else the one that the side file states, rpm."""
    speed = recording.get("spindle.speed")
    if speed is None or speed[part].size == 0:
        return recording.side.cut.speed_rpm
    return float(np.mean(speed[part]))


def _spindle(recording: Recording, parts: signals.CutSegments) -> signals.Turning | None:
    """Return the frequency whose multiples are no chatter, up to the rate; None: not known."""
    speed_rpm = _speed_rpm(recording, parts.cut)
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


def _conditions(recording: Recording, cut: slice) -> dict[str, float]:
    return {"cut": 1.0, "t": float(recording.t_s[cut.start])} | stated_by(recording.side)


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
