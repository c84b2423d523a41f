"""Where a recorded cut begins and ends: by the load that shows it, and by how its arm changes."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb import signals
from autodb.errors import SetAside, behind_name
from autodb.records.tables import Recording
from autodb.sensing.ranges.recorded import rejections
from autodb.sensing.ranges.recorded.phase_loads import QUICK_S, PhaseLoad
from autodb.sensing.ranges.recorded.radius import RadiusCourse
from autodb.wording import phrase

Array = NDArray[np.float64]

SPINDLE = "spindle.current.range"
FASTER, LONG_S = 1.15, 0.5
"""Ratio of a speed to that in air up to which its idle range is taken to be the same, and what is
left of a cut that speeds up sooner. Chosen."""


@dataclass(frozen=True)
class CutSignals:
    """What was recorded, up to where the spindle slows down: loads by axis, forces by channel.

    ``forces`` as recorded, ``quasi_static`` averaged as the ranges are; both in N, each (n,).
    ``speed_rpm`` (n,) of the spindle, and the edge's ``radius``; None: not known.
    """

    rate_hz: float
    loads: dict[str, PhaseLoad]
    forces: dict[str, Array]
    quasi_static: dict[str, Array]
    speed_rpm: Array | None
    radius: RadiusCourse | None


def refuse_set_aside(recording: Recording, seen: str | None) -> None:
    """Raise SetAside where something speaks against a cut."""
    if seen is not None:
        raise SetAside(behind_name(recording.path, seen))


def segments_of(found: CutSignals, recording: Recording) -> signals.CutSegments:
    """Return the parts by the first load that shows them; the spindle sees every cut: it leads.

    Forces of a dynamometer come last, the largest first. Raises SetAside.
    """
    seen = None
    for name, load, quick in _leading(found):
        levels = _levels(found, name, load)
        if levels is None:
            continue
        rate = found.rate_hz
        if name == SPINDLE:
            refuse_set_aside(recording, rejections.starts_in_cut(levels))
        stop = rejections.stops(quick, levels, named=name, t_s=recording.t_s, rate_hz=rate)
        refuse_set_aside(recording, stop)
        parts = _far_enough(signals.cut_segments(levels.cutting, rate_hz=rate), found)
        speed_rpm = mean_speed_rpm(recording, slice(parts.entry.start, parts.exit.stop))
        short = rejections.too_short(parts, t_s=recording.t_s, rate_hz=rate, speed_rpm=speed_rpm)
        if short is None:
            return parts
        seen = seen or short
    refuse_set_aside(recording, seen)
    raise SetAside(
        phrase(
            "{file}: no air approach followed by a cut in the {found}; start the recording "
            "1 s before the tool enters",
            file=recording.path,
            found=_sensed(found),
        )
    )


def _levels(found: CutSignals, name: str, load: Array) -> signals.LoadLevels | None:
    """Return a load's levels in air and in cut; a spindle's changes with the radius."""
    radius = found.radius
    if name != SPINDLE or radius is None or not radius.changes:
        return signals.two_levels(load)
    return signals.stepped_levels(load, rate_hz=found.rate_hz)


def _far_enough(parts: signals.CutSegments, found: CutSignals) -> signals.CutSegments:
    """Return the parts without what of the cut is near the axis, or turns faster than the air did.

    What the idle spindle takes is known at the speed of the air alone: at constant cutting speed it
    is another one towards the axis. At least ``LONG_S`` is left of it.
    """
    if found.radius is None or not found.radius.changes:
        return parts
    begin = (parts.entry.start + parts.entry.stop) // 2
    cut = found.radius.high(begin, parts.cut)
    if found.speed_rpm is not None:
        fast = np.flatnonzero(found.speed_rpm[cut] > FASTER * found.speed_rpm[begin])
        if fast.size:
            least = round(LONG_S * found.rate_hz)
            cut = slice(cut.start, min(cut.stop, cut.start + max(int(fast[0]), least)))
    return replace(parts, cut=cut)


def _leading(found: CutSignals) -> list[tuple[str, Array, Array]]:
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


def _sensed(found: CutSignals) -> str:
    if found.loads and found.forces:
        return "currents and forces"
    return "forces" if found.forces else "currents"


def mean_speed_rpm(recording: Recording, part: slice) -> float | None:
    """Return the spindle's mean speed in a part, else the one that the side file states, rpm."""
    speed = recording.get("spindle.speed")
    if speed is None or speed[part].size == 0:
        return recording.side.cut.speed_rpm
    return float(np.mean(speed[part]))
