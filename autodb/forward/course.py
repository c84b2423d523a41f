"""Forward over the time of a cut whose conditions change: mean, ends and largest values."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.elements import removal_mm3_min
from autodb.forward.prediction import Interval, Moment, Peaks, intervals, moment, passive_known
from autodb.pairs.engaged import Conditions
from autodb.pairs.forecast import Shares, expected_means, forecast
from autodb.pairs.observed import PairCuts
from autodb.pairs.posterior import PairPosterior

Array = NDArray[np.float64]

QUANTITIES = 5
"""Force x, y, z, torque and power: the columns of a forecast."""


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
    its moment. Raises UnusableInput as ``engaged`` does.
    """
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
        for quantity in range(QUANTITIES)
    ]


def _of_cut(
    one: Stepped,
    k: int,
    mean: tuple[Sequence[Interval], float],
    at_ends: Sequence[Sequence[Interval]],
    largest: Sequence[Sequence[Interval]],
) -> OverTime:
    own = largest[QUANTITIES * k : QUANTITIES * (k + 1)]
    x, y, z, torque, power = (each[quantity] for quantity, each in enumerate(own))
    peaks = Peaks(x, y, z, torque, power)
    start, end = map(moment, one.ends, at_ends[2 * k : 2 * k + 2])
    return OverTime(tuple(mean[0]), peaks, start, end, mean[1])
