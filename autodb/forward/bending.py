"""How far work and tool give way under a predicted cut, and what that leaves on the part.

Both are round bars: in a chuck or a holder bent most at the free end, between centres in the
middle, which is where it is taken. A turned diameter is larger by twice what both give way under
the force off the surface; a bore's smaller. A mill is bent by the largest forces across its axis,
taken together, and the wall of side milling is off by that at most. What a cut is off by beyond,
slides and spindle, is not in it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import hypot

import numpy as np

from autodb.files.job import Job
from autodb.files.part import BarSection
from autodb.fitting.gaussian import NORMAL_95
from autodb.forward.prediction import Interval, PredictedCut
from autodb.pairs.engaged import BANDS
from autodb.wording import listed, localized, msgid, phrase, shop_amount

RADIAL = ("turn", "taper", "contour", "bore", "thread")
"""Turning in which force x is off the surface."""
WALLS = ("side-up", "side-down")


@dataclass(frozen=True)
class CutBending:
    """Of one cut, mm: how far work and tool give way, and by what the part is off for it.

    None where the bar or the shank is not stated, or does not bend that way. ``error_mm``: of the
    diameter in turning, of the wall in side milling.
    """

    work_mm: Interval | None
    tool_mm: Interval | None
    error_mm: Interval | None


def bending_of_job(job: Job, cuts: tuple[PredictedCut, ...]) -> tuple[CutBending, ...]:
    """Return how far each cut of a job bends work and tool; none where neither is stated."""
    if job.bar is None and job.shank is None:
        return ()
    return tuple(_of_cut(job, cut) for cut in cuts)


def _of_cut(job: Job, cut: PredictedCut) -> CutBending:
    worst = cut.peaks or cut
    if cut.operation in RADIAL:
        inside = cut.operation == "bore"
        work = None if inside else _bent(job.bar, worst.force_x_N)
        tool = _bent(job.shank, worst.force_x_N)
        return CutBending(work, tool, _twice(work, tool))
    if cut.operation in BANDS:
        tool = _bent(job.shank, _together(worst.force_x_N, worst.force_y_N))
        return CutBending(None, tool, tool if cut.operation in WALLS else None)
    return CutBending(None, None, None)


def _bent(bar: BarSection | None, force: Interval) -> Interval | None:
    """Return how far a bar gives way under a force of either sign where that is most."""
    if bar is None:
        return None
    from autodb.sensing.ranges.inspection import RoundBar, between_centres, held_in_a_chuck

    of = RoundBar(bar.diameter_mm, bar.length_mm, bar.modulus_MPa)
    centres = bar.held == "centres"
    place = np.array([0.5 * bar.length_mm if centres else bar.length_mm])
    mm_N = float((between_centres if centres else held_in_a_chuck)(of, place)[0])
    size = _size(force)
    own = NORMAL_95 * bar.share * size.value
    low = max(0.0, size.value - hypot(size.value - size.low, own))
    high = size.value + hypot(size.high - size.value, own)
    return Interval(mm_N * size.value, mm_N * low, mm_N * high)


def _size(force: Interval) -> Interval:
    """Return the size of a force: from nothing on where its sign is open."""
    ends = sorted((abs(force.low), abs(force.high)))
    return Interval(abs(force.value), 0.0 if force.low * force.high < 0.0 else ends[0], ends[1])


def _together(one: Interval, other: Interval) -> Interval:
    a, b = _size(one), _size(other)
    return Interval(hypot(a.value, b.value), hypot(a.low, b.low), hypot(a.high, b.high))


def _twice(*some: Interval | None) -> Interval | None:
    """Return twice the sum of what is known: both give way to the same force."""
    known = [one for one in some if one is not None]
    if not known:
        return None
    ends = (2.0 * sum(getattr(one, end) for one in known) for end in ("value", "low", "high"))
    return Interval(*ends)


def bending_in_words(cuts: Sequence[PredictedCut], bending: Sequence[CutBending]) -> Iterator[str]:
    """Say of each cut how far work and tool give way, in micrometres."""
    for number, (cut, one) in enumerate(zip(cuts, bending, strict=False), start=1):
        parts = (
            (msgid("work {amount}"), one.work_mm),
            (msgid("tool {amount}"), one.tool_mm),
            (msgid("error of the part {amount}"), one.error_mm),
        )
        said = [phrase(what, amount=_micrometres(its)) for what, its in parts if its is not None]
        if said:
            yield phrase(
                "cut {number} '{name}' bends: {parts}",
                number=number,
                name=cut.name,
                parts=listed(said),
            )


def _micrometres(one: Interval) -> str:
    ends = (shop_amount(1000.0 * end, "µm")[0] for end in (one.value, one.low, one.high))
    value, low, high = (localized(f"{end:.3g}") for end in ends)
    unit = shop_amount(1.0, "µm")[1]
    return phrase("{value} {unit} ({low} to {high})", value=value, unit=unit, low=low, high=high)
