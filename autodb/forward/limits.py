"""How likely a predicted cut goes beyond what a machine's axes and spindle give.

A prediction is a normal force, of a mill its peak within a turn, of a program's line the largest
along it; its probability beyond a limit in either direction follows. A spindle speed is asked for,
not predicted: above its limit it is sure.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import erfc, sqrt

from autodb.files.machine import AxisLimits
from autodb.fitting import NORMAL_95
from autodb.forward.prediction import Interval, Peaks, PredictedCut

WORTH_SAYING = 0.001
"""Probability from which a limit is spoken of. Chosen."""
SPINDLE = "spindle"


@dataclass(frozen=True)
class Exceeding:
    """A limit that a cut (number from 1) may exceed: whose, which, in what unit, how probably."""

    cut: int
    axis: str
    limit: float
    unit: str
    probability: float

    @property
    def statement(self) -> str:
        """The line for the planner, without the cut."""
        limit = f"{self.axis}'s {self.limit:g} {self.unit}"
        if self.unit == "rpm":
            return f"faster than {limit}"
        return f"{probability_words(self.probability)} chance to exceed {limit}"


def exceeding(
    cuts: Sequence[PredictedCut], limits: Mapping[str, AxisLimits]
) -> tuple[Exceeding, ...]:
    """Return the limits, by axis, that cuts may exceed, in the order of the cuts."""
    found = []
    for number, cut in enumerate(cuts, start=1):
        for axis, most in limits.items():
            worst = cut if cut.peaks is None else cut.peaks
            torque = worst.torque_N_m if axis == SPINDLE else None
            for predicted, limit, unit in (
                (_force(worst, axis), most.force_N, "N"),
                (torque, most.torque_N_m, "N·m"),
            ):
                if predicted is not None and limit is not None:
                    chance = probability_beyond(predicted, limit)
                    if chance >= WORTH_SAYING:
                        found.append(Exceeding(number, axis, limit, unit, chance))
            fastest = most.speed_rpm if axis == SPINDLE else None
            if fastest is not None and _fastest_rpm(cut) > fastest:
                found.append(Exceeding(number, axis, fastest, "rpm", 1.0))
    return tuple(found)


def probability_beyond(predicted: Interval, limit: float) -> float:
    """Return the probability that a predicted value is larger in size than a limit.

    Each side of the value is a normal's with that side's half of the interval.
    """
    above = _beyond(limit - predicted.value, predicted.high - predicted.value)
    return above + _beyond(limit + predicted.value, predicted.value - predicted.low)


def _beyond(off: float, half: float) -> float:
    """Return the probability to be off by more, with half a 95 % interval that wide."""
    if half == 0.0:
        return float(off < 0.0)
    return 0.5 * erfc(NORMAL_95 * off / (sqrt(2.0) * half))


def _force(cut: PredictedCut | Peaks, axis: str) -> Interval | None:
    return {"x": cut.force_x_N, "y": cut.force_y_N, "z": cut.force_z_N}.get(axis)


def _fastest_rpm(cut: PredictedCut) -> float:
    along = None if cut.peaks is None else cut.peaks.speed_rpm
    return cut.speed_rpm if along is None else along


def probability_words(probability: float) -> str:
    """Return a probability in words."""
    if probability > 0.999:
        return "over 99.9 %"
    return f"{100.0 * probability:.2g} %" if probability < 0.995 else f"{100 * probability:.1f} %"
