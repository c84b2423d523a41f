"""A prediction as a table: one row a cut, each quantity with its 95 % interval and its limit.

Columns: docs/formats.md, "Predictions". Numbers are written with six digits; what a cut or the
machine has not is empty.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain

from autodb.files import csvtext
from autodb.files.machine import AxisLimits
from autodb.forward.limits import SPINDLE, probability_beyond
from autodb.forward.prediction import Interval, Moment, Peaks, PredictedCut


@dataclass(frozen=True)
class PredictedQuantity:
    """A predicted quantity: its channel, field and unit, and the axis and key of its limit."""

    channel: str
    field: str
    unit: str
    axis: str | None = None
    key: str = ""

    def of(self, some: PredictedCut | Peaks | Moment | None) -> Interval | None:
        """Return the interval of a cut, its peaks or a moment; None where there are none."""
        found: Interval | None = getattr(some, self.field, None)
        return found

    def limit(self, limits: Mapping[str, AxisLimits]) -> float | None:
        """Return the limit of the machine; None where it states none."""
        stated = limits.get(self.axis or "")
        found: float | None = getattr(stated, self.key, None)
        return found


QUANTITIES = (
    *(PredictedQuantity(f"force.{a}", f"force_{a}_N", "N", a, "force_N") for a in ("x", "y", "z")),
    PredictedQuantity("torque.spindle", "torque_N_m", "N·m", SPINDLE, "torque_N_m"),
    PredictedQuantity("spindle.power", "power_W", "W"),
)
ENDS = ("", ".low", ".high")
STATISTICS = ("", ".start", ".end", ".peak")
"""What is known of a quantity over the time of a cut; first its mean."""


def prediction_as_csv(cuts: Sequence[PredictedCut], limits: Mapping[str, AxisLimits]) -> str:
    """Return predicted cuts as CSV; ``limits``: of the machine's axes by name."""
    columns = [
        *("cut", "name", "operation", "spindle.speed", "spindle.speed.limit", "cutting.speed"),
        *chain.from_iterable(_columns(one) for one in QUANTITIES),
    ]
    rows = (_row(number, cut, limits) for number, cut in enumerate(cuts, start=1))
    return csvtext.rows_as_csv([columns, *rows])


def _columns(one: PredictedQuantity) -> list[str]:
    limit = [f"{one.channel}.limit", f"{one.channel}.chance"] if one.axis else []
    return [*(f"{one.channel}{of}{end}" for of in STATISTICS for end in ENDS), *limit]


def _row(number: int, cut: PredictedCut, limits: Mapping[str, AxisLimits]) -> list[str]:
    fastest = limits[SPINDLE].speed_rpm if SPINDLE in limits else None
    speeds = [_number(cut.speed_rpm), _number(fastest), _number(cut.speed_m_min)]
    cells = [_cells(one, cut, limits) for one in QUANTITIES]
    return [f"{number}", cut.name, cut.operation, *speeds, *chain.from_iterable(cells)]


def _cells(
    one: PredictedQuantity, cut: PredictedCut, limits: Mapping[str, AxisLimits]
) -> list[str]:
    """Return mean, ends, peak, limit, and the probability that the peak, or mean, exceeds it."""
    mean, *ends, peak = (one.of(some) for some in (cut, cut.start, cut.end, cut.peaks))
    known = [*chain.from_iterable(_ends(each) for each in (mean, *ends, peak))]
    if one.axis is None:
        return known
    worst, limit = peak or mean, one.limit(limits)
    chance = None if worst is None or limit is None else probability_beyond(worst, limit)
    return [*known, _number(limit), _number(chance)]


def _ends(interval: Interval | None) -> list[str]:
    if interval is None:
        return ["", "", ""]
    return [_number(value) for value in (interval.value, interval.low, interval.high)]


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.6g}"
