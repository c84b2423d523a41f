"""Why the cut of a recording is excluded: each function returns what was seen and the remedy.

None where there is nothing against the cut. ``t_s`` (n,) is the recording's clock.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from autodb import signals
from autodb.sensing.ranges.recorded.phase_loads import PhaseLoad
from autodb.wording import localized, phrase, significant

Array = NDArray[np.float64]

FEWEST_S = 0.3
FEWEST_REVOLUTIONS = 10
"""Of the work (of the tool in milling) in the part that is averaged: chosen, a part of one at the
end then weighs a tenth, and a swing once a revolution leaves 1/60 of its amplitude in the mean."""
CHATTERS_N, CHATTERS_A, LEAST_A = 0.05, 0.02, 0.01
"""Shares that a narrow band's rms is least: of the resultant force, of the range's rise in cut, and
of the range itself. Chosen: the virtual lathe's ringing, 5 % over 18 Hz, stays below."""
FAST_S = 0.2
"""A range averaged over more is too smooth to distinguish a limit from a lull. Chosen."""
HARMONICS, ELECTRICAL_SPREAD = 12, 0.003
"""Multiples of a drive's frequency that its own ripples reach, and how well that is known."""


def too_short(
    parts: signals.CutSegments, *, t_s: Array, rate_hz: float, speed_rpm: float | None
) -> str | None:
    """Say where too little of a cut, or of its air approach, is left between the transitions."""
    margin_s = signals.MARGIN_S
    air_s = (parts.air.stop - parts.air.start) / rate_hz
    if air_s < FEWEST_S:
        return phrase(
            "its air approach is too short: {air} s beside transitions of {margin} s; "
            "start the recording 1.5 s before the tool enters",
            air=localized(f"{air_s:.2g}"),
            margin=localized(f"{margin_s:g}"),
        )
    cut_s = (parts.cut.stop - parts.cut.start) / rate_hz
    revolutions = None if speed_rpm is None else cut_s * speed_rpm / 60.0
    if cut_s >= FEWEST_S and (revolutions is None or revolutions >= FEWEST_REVOLUTIONS):
        return None
    needs_s = FEWEST_S
    if speed_rpm is not None:
        needs_s = max(needs_s, FEWEST_REVOLUTIONS * 60.0 / speed_rpm)
    seen = (
        ""
        if revolutions is None
        else phrase(" and {revolutions} revolutions", revolutions=localized(f"{revolutions:.2g}"))
    )
    at_s, works_s = t_s[parts.entry.start] + margin_s, needs_s + 2.0 * margin_s
    return phrase(
        "its cut at {at} s is too short: {cut} s{seen} between transitions of {margin} "
        "s; make a cut of {works} s or longer",
        at=localized(f"{at_s:.2f}"),
        cut=localized(f"{cut_s:.2g}"),
        seen=seen,
        margin=localized(f"{margin_s:g}"),
        works=localized(f"{works_s:.2g}"),
    )


def starts_in_cut(levels: signals.LoadLevels) -> str | None:
    """Say where a spindle's range begins high and falls: its cut is not what comes second."""
    if levels.cut > levels.air:
        return None
    return phrase(
        "spindle.current.range is high first and falls, as when the recording starts "
        "in the cut; start the recording 1 s before the tool enters"
    )


def stops(
    load: Array, levels: signals.LoadLevels, *, named: str, t_s: Array, rate_hz: float
) -> str | None:
    """Say where a load (n,) falls back to air in the middle of the cut and comes again."""
    gap = signals.interrupted(load, levels, rate_hz=rate_hz)
    if gap is None:
        return None
    return phrase(
        "the cut is interrupted from {t} to {t_2} s: {named} falls back to air and "
        "comes again, as when feed or spindle stop; make the cut without a stop",
        t=localized(f"{t_s[gap.start]:.2f}"),
        t_2=localized(f"{t_s[gap.stop]:.2f}"),
        named=named,
    )


def chatters(
    loads: Mapping[str, PhaseLoad],
    forces: Mapping[str, Array],
    parts: signals.CutSegments,
    *,
    rate_hz: float,
    spindle: signals.Turning,
) -> str | None:
    """Say which narrow band, no multiple of the spindle's frequency, grows in the cut.

    Looks at forces (n,), N, then at the envelopes of the axes of which three phases were recorded.
    """
    rises = [float(np.mean(f[parts.cut]) - np.mean(f[parts.air])) for f in forces.values()]
    least_N = CHATTERS_N * float(np.linalg.norm(rises))
    for name, force in forces.items():
        line = signals.chatter(
            force[parts.cut], force[parts.air],
            rate_hz=rate_hz, turning=(spindle,), least_rms=least_N,
        )  # fmt: skip
        if line is not None:
            return _chatter(line, name, "N", spindle)
    for axis, load in loads.items():
        line = _envelope_line(load, parts, rate_hz=rate_hz, spindle=spindle)
        if line is not None:
            return _chatter(line, f"{axis}.current", "A", spindle)
    return None


def _envelope_line(
    load: PhaseLoad, parts: signals.CutSegments, *, rate_hz: float, spindle: signals.Turning
) -> signals.NarrowBand | None:
    electrical_hz = load.turning_hz(parts.cut)
    if load.envelope_A is None or not electrical_hz:
        return None
    cut, air = load.envelope_A[parts.cut], load.envelope_A[parts.air]
    rise_A = abs(float(np.mean(cut) - np.mean(air)))
    own = signals.Turning(electrical_hz, HARMONICS, ELECTRICAL_SPREAD)
    least_A = max(CHATTERS_A * rise_A, LEAST_A * float(np.mean(cut)))
    return signals.chatter(cut, air, rate_hz=rate_hz, turning=(spindle, own), least_rms=least_A)


def _chatter(line: signals.NarrowBand, name: str, unit: str, spindle: signals.Turning) -> str:
    return phrase(
        "chatter in the cut: {name} swings by {rms} {unit} rms at {frequency} Hz, no "
        "multiple of the spindle's {frequency_2} Hz; use another speed or less depth",
        name=name,
        rms=significant(line.rms),
        unit=unit,
        frequency=localized(f"{line.frequency_hz:.1f}"),
        frequency_2=localized(f"{spindle.frequency_hz:.2f}"),
    )


def range_at_limit(
    load: PhaseLoad, parts: signals.CutSegments, *, axis: str, t_s: Array
) -> str | None:
    """Say where an axis' range is held at its maximum: the force is at least what it says.

    Looks at drives that turn fast enough to be read in ``FAST_S``: a spindle, seldom a feed.
    """
    air = load.quick_A[parts.air]
    air = air[np.isfinite(air)]
    if air.size == 0 or load.averaged_s(parts.cut) > FAST_S:
        return None
    noise_A = 1.4826 * float(np.median(np.abs(air - np.median(air))))
    found = signals.held_at_top(load.quick_A[parts.cut], noise_A=noise_A)
    if found is None:
        return None
    begin, end = t_s[parts.cut.start], t_s[parts.cut.stop - 1]
    return phrase(
        "{axis}.current is at its limit in the cut from {begin} to {end} s; for "
        "{share} % of it the range stays at {level} A, its maximum, so the force is at "
        "least the sensed value; use less depth or feed",
        axis=axis,
        begin=localized(f"{begin:.2f}"),
        end=localized(f"{end:.2f}"),
        share=localized(f"{100.0 * found.share:.0f}"),
        level=localized(f"{found.level:.4g}"),
    )
