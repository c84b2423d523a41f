"""Forward: a posterior about a pair becomes forces, torque and power of a job's cuts.

A cut whose conditions change, such as a line of a program, is taken in steps over its time: of each
quantity are found the mean, the ends and the largest value. One that goes from one diameter to
another has steps of equal time: at one feed a revolution and one spindle speed its radius changes
evenly.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from autodb.cutting import endmill, tools
from autodb.cutting.elements import Elements, removal_mm3_min
from autodb.files.job_cut import JobCut
from autodb.forward.prediction import (
    Interval,
    Moment,
    Peaks,
    PredictedCut,
    ToolOf,
    intervals,
    moment,
    not_read,
    passive_known,
)
from autodb.pairs.engaged import (
    BANDS,
    BY_NAME,
    CUTTING_TIME,
    FEED,
    RPM,
    SPEED,
    Conditions,
    CutOperation,
    Stated,
    stated_milling,
)
from autodb.pairs.forecast import Shares, expected_means, forecast
from autodb.pairs.observed import PairCuts, Variant
from autodb.pairs.posterior import PairPosterior

Array = NDArray[np.float64]

_QUANTITIES = 5
"""Force x, y, z, torque and power: the columns of a forecast."""
TURN_STEPS = 360
"""Moments of a turn among which a milling cut's peaks are searched for."""
SLICE_MM = 0.2
"""Height of a mill's slices then. Chosen: a peak is off by less than 0.5 % of what 0.05 mm give."""
STEPS_AT_ONCE = 50
"""Steps of cuts from which on no more are worked out together. Chosen: a mill's take some 15 MB."""
COURSE_STEPS = 8
"""Steps of a cut whose diameter changes. Chosen: means are off by less than 0.1 % of what 512 give
(a test)."""


def predict(
    posterior: PairPosterior, tool: ToolOf, cuts: Sequence[JobCut]
) -> tuple[PredictedCut, ...]:
    """Predict a job's cuts. Raises UnusableInput where the tool cannot make one."""
    found: dict[int, PredictedCut] = {}
    for name in dict.fromkeys(cut.operation for cut in cuts):
        some = {k: cut for k, cut in enumerate(cuts) if cut.operation == name}
        changing = {k: cut for k, cut in some.items() if cut.changes_diameter}
        steady = {k: cut for k, cut in some.items() if k not in changing}
        for which, predicted in ((steady, _steady), (changing, _changing)):
            if which:
                made = predicted(posterior, tool, BY_NAME[name], list(which.values()))
                found |= dict(zip(which, made, strict=True))
    return tuple(found[k] for k in range(len(cuts)))


def _steady(
    posterior: PairPosterior, tool: ToolOf, operation: CutOperation, cuts: Sequence[JobCut]
) -> Iterator[PredictedCut]:
    """Yield what cuts of one operation take that stay the same over their time."""
    rows = [cut.conditions(tool.diameter_mm) for cut in cuts]
    engaged = operation.cuts(tool.numbers, rows, called=tool.name)
    expected = forecast(posterior, engaged)
    known = passive_known(posterior, operation.name)
    means = intervals(expected, operation=operation.name, known=known)
    removal = removal_mm3_min(engaged.elements).tolist()
    for cut, row, mean, taken in zip(cuts, rows, means, removal, strict=True):
        mills = cut.operation in BANDS
        peaks = turn_peaks(posterior, tool, cut.operation, row) if mills else None
        whole = _predicted(posterior, tool, cut, row, mean)
        yield replace(whole, peaks=peaks, removal_mm3_min=taken)


def _predicted(
    posterior: PairPosterior,
    tool: ToolOf,
    cut: JobCut,
    conditions: Conditions,
    mean: Sequence[Interval],
) -> PredictedCut:
    feed_mm_rev = conditions[FEED] * teeth_of(cut.operation, tool.numbers)
    feed_mm_min, path_mm = feed_mm_rev * conditions[RPM], cut.path_mm
    return PredictedCut(
        name=cut.name,
        operation=cut.operation,
        speed_rpm=conditions[RPM],
        speed_m_min=conditions[SPEED],
        force_x_N=mean[0],
        force_y_N=mean[1],
        force_z_N=mean[2],
        torque_N_m=mean[3],
        power_W=mean[4],
        passive=not_read(posterior, cut.operation),
        feed_mm_min=feed_mm_min,
        time_s=None if path_mm is None else 60.0 * path_mm / feed_mm_min,
    )


def teeth_of(operation: str, numbers: Mapping[str, float]) -> int:
    """Return how many times a tool's feed its path goes on in a turn: a mill's is of a tooth."""
    return int(numbers["teeth"]) if operation in BANDS else 1


@dataclass(frozen=True)
class _Steps:
    """A cut whose diameter changes, in steps of equal time."""

    time_s: Array
    steps: Sequence[Conditions]
    ends: tuple[Conditions, Conditions]

    @property
    def extremes(self) -> Sequence[Conditions]:
        """Moments among which the largest values are."""
        return (*self.ends, *self.steps)


def _changing(
    posterior: PairPosterior, tool: ToolOf, operation: CutOperation, cuts: Sequence[JobCut]
) -> Iterator[PredictedCut]:
    """Yield what cuts of one operation take whose diameter changes over their time."""
    middles = (np.arange(COURSE_STEPS) + 0.5) / COURSE_STEPS
    some = [
        _Steps(
            np.ones(COURSE_STEPS),
            [cut.conditions_at(share, tool.diameter_mm) for share in middles.tolist()],
            (cut.conditions_at(0.0, tool.diameter_mm), cut.conditions_at(1.0, tool.diameter_mm)),
        )
        for cut in cuts
    ]

    def engaged(rows: Sequence[Conditions]) -> PairCuts:
        return operation.cuts(tool.numbers, rows, called=tool.name)

    for cut, its in zip(cuts, over_time(posterior, some, engaged), strict=True):
        row = cut.conditions(tool.diameter_mm)
        whole = _predicted(posterior, tool, cut, row, its.mean)
        taken = its.removal_mm3_min
        yield replace(whole, peaks=its.peaks, start=its.start, end=its.end, removal_mm3_min=taken)


def turn_peaks(
    posterior: PairPosterior, tool: ToolOf, operation: str, conditions: Conditions
) -> Peaks:
    """Return a mill's peaks: each component at the moment where it is largest."""
    assumed = tools.end_mill_of(tool.numbers)
    cut = stated_milling(assumed.tool, Stated([conditions]), BANDS[operation])
    theta = posterior.law.mean
    turn = endmill.turn(theta, assumed.tool, cut, steps=TURN_STEPS, slice_mm=SLICE_MM)
    moments = turn.angle_rad[np.argmax(np.abs(turn.forces.all), axis=0)]

    def there(mill: endmill.EndMill) -> Elements:
        return endmill.at_angles(mill, cut, moments, slice_mm=SLICE_MM)

    variants = tuple(
        Variant(f"{tool.name}: {usual.key}", there(other)) for usual, other in assumed.variants
    )
    worn_s = conditions.get(CUTTING_TIME, 0.0)
    worn = np.full(len(moments), worn_s) if worn_s else None
    expected = forecast(posterior, PairCuts(operation, there(assumed.tool), variants, worn))
    x, y, z, torque, power = (one[k] for k, one in enumerate(intervals(expected)))
    return Peaks(x, y, z, torque, power)


class Stepped(Protocol):
    """A cut in steps."""

    @property
    def time_s(self) -> Array:
        """How long each step takes (n,), in any unit of time."""

    @property
    def steps(self) -> Sequence[Conditions]:
        """Conditions of each step (n), means over it in time."""

    @property
    def extremes(self) -> Sequence[Conditions]:
        """Conditions of the moments among which the largest values are."""

    @property
    def ends(self) -> tuple[Conditions, Conditions]:
        """Conditions at the start and at the end."""


@dataclass(frozen=True)
class OverTime:
    """Of one cut: the mean of each quantity in time, the largest ones, and the two ends.

    ``removal_mm3_min``: what it takes off, in the mean.
    """

    mean: tuple[Interval, ...]
    peaks: Peaks
    start: Moment
    end: Moment
    removal_mm3_min: float


Engaged = Callable[[Sequence[Conditions]], PairCuts]
"""What turns conditions of one operation into cuts of a tool; raises where it cannot make them."""


def over_time(
    posterior: PairPosterior, some: Sequence[Stepped], engaged: Engaged
) -> list[OverTime]:
    """Return what cuts of one operation take over their time.

    The steps of a cut share all errors, what is its own too; a largest value has the interval of
    its moment. Cuts are worked out some at a time, so that a long program takes no more memory than
    a short one. Raises UnusableInput as ``engaged`` does.
    """
    found: list[OverTime] = []
    begin = steps = 0
    for end, one in enumerate(some, start=1):
        steps += len(one.steps)
        if steps >= STEPS_AT_ONCE or end == len(some):
            found += _over_time(posterior, some[begin:end], engaged)
            begin, steps = end, 0
    return found


def _over_time(
    posterior: PairPosterior, some: Sequence[Stepped], engaged: Engaged
) -> list[OverTime]:
    """Return ``over_time`` of cuts, worked out together."""
    share = np.concatenate([one.time_s / one.time_s.sum() for one in some])
    begins = np.cumsum([0, *(len(one.steps) for one in some)])
    steps = engaged([row for one in some for row in one.steps])
    ends = engaged([row for one in some for row in one.ends])
    largest = engaged(_largest(posterior, some, engaged))
    known = passive_known(posterior, steps.operation)
    means, at_ends, peaks = (
        intervals(expected, operation=steps.operation, known=known)
        for expected in (
            forecast(posterior, steps, Shares(begins[:-1], share)),
            forecast(posterior, ends),
            forecast(posterior, largest),
        )
    )
    removal = Shares(begins[:-1], share).means(removal_mm3_min(steps.elements)).tolist()
    return [_of_cut(one, k, (means[k], removal[k]), at_ends, peaks) for k, one in enumerate(some)]


def _largest(
    posterior: PairPosterior, some: Sequence[Stepped], engaged: Engaged
) -> list[Conditions]:
    """Return the conditions at which each quantity of each cut is largest by size."""
    rows = [row for one in some for row in one.extremes]
    size = np.abs(expected_means(posterior, engaged(rows)))
    bounds = np.cumsum([0, *(len(one.extremes) for one in some)]).tolist()
    return [
        rows[begin + int(np.argmax(size[begin:end, quantity]))]
        for begin, end in pairwise(bounds)
        for quantity in range(_QUANTITIES)
    ]


def _of_cut(
    one: Stepped,
    k: int,
    mean: tuple[Sequence[Interval], float],
    at_ends: Sequence[Sequence[Interval]],
    largest: Sequence[Sequence[Interval]],
) -> OverTime:
    own = largest[_QUANTITIES * k : _QUANTITIES * (k + 1)]
    x, y, z, torque, power = (each[quantity] for quantity, each in enumerate(own))
    peaks = Peaks(x, y, z, torque, power)
    start, end = map(moment, one.ends, at_ends[2 * k : 2 * k + 2])
    return OverTime(tuple(mean[0]), peaks, start, end, mean[1])
