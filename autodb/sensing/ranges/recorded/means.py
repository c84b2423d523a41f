"""Means of an axis' range in air and in cut with their standard errors, without what disturbs them.

A slide's range in air is that of a sinusoid fitted to its currents; an average of a slow drive's
range would reach into the cut.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb import signals
from autodb.sensing.ranges.recorded.phase_loads import PhaseLoad
from autodb.sensing.ranges.recorded.rejections import FEWEST_S
from autodb.wording import localized, phrase

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

SPINDLE = "spindle"


@dataclass(frozen=True)
class AxisInCut:
    """The load of an axis over the parts of a cut; ``speed_rpm`` (n,) of the spindle, if known."""

    axis: str
    load: PhaseLoad
    parts: signals.CutSegments
    rate_hz: float
    speed_rpm: Array | None

    @property
    def slides(self) -> bool:
        """Whether it is a feed axis."""
        return self.axis != SPINDLE

    def too_short_air(self) -> str | None:
        """Say where an approach is too short for its range to be averaged."""
        has_s = self.parts.air.stop / self.rate_hz + signals.MARGIN_S
        needs_s = self.load.air_needs_s(self.parts.air)
        if has_s >= needs_s or not self.load.turning_hz(self.parts.cut):
            return None
        return phrase(
            "{axis}: its range in air is excluded, because the approach takes {has} s and "
            "is not steady; approach for {needs} s, for a drive that turns at {turning} Hz",
            axis=self.axis,
            has=localized(f"{has_s:.2g}"),
            needs=localized(f"{needs_s:.2g}"),
            turning=localized(f"{self.load.turning_hz(self.parts.air):.2g}"),
        )

    def steady_air(self) -> dict[str, float] | None:
        """Return the range in air and its standard error, A; None where it is not steady."""
        beside = round(0.5 * signals.MARGIN_S * self.rate_hz)  # an entry takes no more than that
        air = slice(self.parts.air.start, self.parts.air.stop + beside)
        found = self.load.steady_in_air(
            air, self.parts.cut, rate_hz=self.rate_hz, speed_rpm=self.speed_rpm
        )
        if found is None:
            return None
        return {
            f"{self.axis}.current.air": found.range_A,
            f"{self.axis}.current.air.sd": found.sd_A,
        }

    def steady_cut(self) -> dict[str, float]:
        """Return the same in cut, of a drive that turns too seldom to be demodulated."""
        found = self.load.steady(self.parts.cut, rate_hz=self.rate_hz)
        if found is None:
            return {}
        name = f"{self.axis}.current.range"
        return {name: found.range_A, f"{name}.sd": found.sd_A}

    def pulses(self, segments: Mapping[str, slice]) -> signals.Pulses | None:
        """Return short rises of the range at regular intervals over some parts."""
        parts = [(part.start, self.load.quick_A[part]) for part in segments.values()]
        averaged_s = self.load.averaged_s(self.parts.cut)
        return signals.regular_pulses(parts, rate_hz=self.rate_hz, averaged_s=averaged_s)

    def outside(self, pulses: signals.Pulses) -> Flags:
        """Return which samples no pulse reaches, through the average either."""
        kept = np.ones(self.load.quick_A.size, dtype=np.bool_)
        beside = round(0.5 * self.load.averaged_s(self.parts.cut) * self.rate_hz)
        for run in (*pulses.seen, *pulses.expected):
            kept[max(0, run.start - beside) : run.stop + beside] = False
        return kept


def air_and_cut_means(one: AxisInCut, notes: list[str]) -> dict[str, float]:
    """Return an axis' means and standard errors, A, in air and in cut; note what is left out."""
    load, segments = one.load, _usable(one, notes)
    values, kept = load.range_A, np.ones(load.range_A.size, dtype=np.bool_)
    short = one.too_short_air()
    long = {name: part for name, part in segments.items() if name != "air" or short is None}
    pulses = one.pulses(long) if one.slides else None
    if pulses is not None:
        values, kept = load.quick_A, one.outside(pulses)
        notes.append(
            phrase(
                "{axis}: {n} short rises of the range every {every} s, as of way lubrication, "
                "are excluded",
                axis=one.axis,
                n=len(pulses.seen),
                every=localized(f"{pulses.every_s:.2f}"),
            )
        )
    fitted = pulses is None and (one.slides or short is not None)
    row = one.steady_air() if fitted else None
    if row is not None or short is not None:
        del segments["air"]
    if row is None and short is not None:
        notes.append(short)
    row = row or {}
    for name, part in segments.items():
        row |= _mean(one, name, part, np.where(kept, values, np.nan), kept)
    if one.slides and "range" in segments and not np.isfinite(load.range_A[one.parts.cut]).any():
        row |= one.steady_cut()
    return row


def _usable(one: AxisInCut, notes: list[str]) -> dict[str, slice]:
    """Return the parts in which an axis' range is known, by the name of its channel."""
    air, cut = one.parts.air, one.parts.cut
    segments = {"air": air, "range": cut}
    if one.slides and signals.touches(one.load.range_A[air.start : cut.stop]):
        notes.append(
            phrase(
                "{axis}: the range folds between air and cut; its force is not sensed",
                axis=one.axis,
            )
        )
        del segments["range"]
    return segments


def _mean(one: AxisInCut, name: str, part: slice, values: Array, kept: Flags) -> dict[str, float]:
    """Return the mean of a range (n,) over what is kept of a part, with its standard error."""
    known = values[part][np.isfinite(values[part])]
    if known.size <= max(0.5 * kept[part].sum(), FEWEST_S * one.rate_hz):
        return {}
    found = {f"{one.axis}.current.{name}": float(np.mean(known))}
    quick = np.where(kept, one.load.quick_A, np.nan)[part]
    averaged_s = one.load.averaged_s(part)
    error = signals.standard_error(quick, rate_hz=one.rate_hz, averaged_s=averaged_s)
    return found if error is None else found | {f"{one.axis}.current.{name}.sd": error}
