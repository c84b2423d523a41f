"""Means of a range in air and in cut with their standard errors, without what disturbs them."""

import numpy as np
from numpy.typing import NDArray

from autodb import signals
from autodb.sensing.ranges.loads import PhaseLoad
from autodb.sensing.ranges.rejections import FEWEST_S

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
                f"{pulses.every_s:.2f} s, as of way lubrication, are left out"
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
            f"{axis}: its range in air is left out: the approach takes {has_s:.2g} s, and "
            f"{needs_s:.2g} s would work for a drive that turns at "
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
