"""Forward: a posterior about a pair becomes forces, torque and power of cuts not yet made."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.cutting import endmill, tools
from autodb.cutting.elements import Elements
from autodb.cutting.turning import PASSIVE_AXIS
from autodb.files.job import JobCut
from autodb.fitting import NORMAL_95
from autodb.pairs.engaged import BANDS, BY_NAME, CUTTING_TIME, Conditions, Stated, stated_milling
from autodb.pairs.forecast import Forecast, forecast
from autodb.pairs.observed import PairCuts, Variant
from autodb.pairs.posterior import PairPosterior, PassiveKnown

Array = NDArray[np.float64]

COLUMNS = {"x": 0, "y": 1, "z": 2}
"""Columns of a forecast that are forces, by component."""
STEPS = 360
"""Moments of a turn among which a milling cut's peaks are searched for."""
PASSIVE_RAD = 0.2
"""Standard deviation of the thrust's direction, which no sensed force determines where one of its
components is passive. Chosen: laws of chip flow over a nose are off by 5 to 10° (Young, Mathew and
Oxley 1987), and breakers and inclinations of inserts turn the chip further."""
ALL = 0.999
"""Share of a force from which on it is taken to be all along the cutting speed."""
SLICE_MM = 0.2
"""Height of a mill's slices then. Chosen: a peak is off by less than 0.5 % of what 0.05 mm give."""


@dataclass(frozen=True)
class Interval:
    """A predicted value with its 95 % interval, in the unit that the holder names."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Peaks:
    """The largest forces and torque, by size, within a turn of a mill or along a program's line.

    ``speed_rpm``: the fastest along a line; None of a mill, which turns at one speed.
    """

    force_x_N: Interval
    force_y_N: Interval
    force_z_N: Interval
    torque_N_m: Interval
    speed_rpm: float | None = None


@dataclass(frozen=True)
class PredictedCut:
    """What one cut will take; of a mill, the mean over a turn, and ``peaks``.

    Of turning, speeds, torque and power are those at the largest diameter. Of a program's line,
    forces, torque and power are means in time along it, speeds those at its largest diameter, and
    ``peaks`` the largest. ``passive``: the component that no drive senses and nobody measured,
    known from the law alone. ``state``: the process state that it is predicted in; None: the
    pair's usual one.
    """

    name: str
    operation: str
    speed_rpm: float
    speed_m_min: float
    force_x_N: Interval
    force_y_N: Interval
    force_z_N: Interval
    torque_N_m: Interval
    power_W: Interval
    peaks: Peaks | None = None
    passive: str | None = None
    state: str | None = None

    @property
    def of_what(self) -> str:
        """Of what its peaks are the largest."""
        return "in a turn" if self.operation in BANDS else "along the line"


@dataclass(frozen=True)
class ToolOf:
    """A pair's tool: what it is called, and what is known of its geometry, by name."""

    name: str
    numbers: Mapping[str, float]

    @property
    def diameter_mm(self) -> float | None:
        """Diameter of a tool that turns."""
        return self.numbers.get("diameter_mm")


def predict(
    posterior: PairPosterior, tool: ToolOf, cuts: Sequence[JobCut]
) -> tuple[PredictedCut, ...]:
    """Predict a job's cuts. Raises UnusableInput where the tool cannot make one."""
    found: dict[int, PredictedCut] = {}
    for name in dict.fromkeys(cut.operation for cut in cuts):
        some = {k: cut for k, cut in enumerate(cuts) if cut.operation == name}
        rows = [cut.conditions(tool.diameter_mm) for cut in some.values()]
        expected = forecast(posterior, BY_NAME[name].cuts(tool.numbers, rows, called=tool.name))
        passive = COLUMNS.get(PASSIVE_AXIS.get(name, ""))
        means = intervals(expected, passive=passive, known=posterior.passive.get(name))
        for at, (k, cut) in enumerate(some.items()):
            found[k] = _predicted(posterior, tool, cut, rows[at], means[at])
    return tuple(found[k] for k in range(len(cuts)))


def _predicted(
    posterior: PairPosterior,
    tool: ToolOf,
    cut: JobCut,
    conditions: Conditions,
    means: Sequence[Interval],
) -> PredictedCut:
    mills = cut.operation in BANDS
    return PredictedCut(
        name=cut.name,
        operation=cut.operation,
        speed_rpm=conditions["spindle.speed"],
        speed_m_min=conditions["cutting.speed"],
        force_x_N=means[0],
        force_y_N=means[1],
        force_z_N=means[2],
        torque_N_m=means[3],
        power_W=means[4],
        peaks=_peaks(posterior, tool, cut.operation, conditions) if mills else None,
        passive=not_read(posterior, cut.operation),
    )


def _peaks(posterior: PairPosterior, tool: ToolOf, operation: str, conditions: Conditions) -> Peaks:
    """Return a mill's peaks: each component at the moment where it is largest."""
    assumed = tools.end_mill_of(tool.numbers)
    cut = stated_milling(assumed.tool, Stated([conditions]), BANDS[operation])
    theta = posterior.law.mean
    turn = endmill.turn(theta, assumed.tool, cut, steps=STEPS, slice_mm=SLICE_MM)
    moments = turn.angle_rad[np.argmax(np.abs(turn.forces.all[:, :4]), axis=0)]

    def there(mill: endmill.EndMill) -> Elements:
        return endmill.at_angles(mill, cut, moments, slice_mm=SLICE_MM)

    variants = tuple(
        Variant(f"{tool.name}: {usual.name}", there(other)) for usual, other in assumed.variants()
    )
    worn_s = conditions.get(CUTTING_TIME, 0.0)
    worn = np.full(len(moments), worn_s) if worn_s else None
    expected = forecast(posterior, PairCuts(operation, there(assumed.tool), variants, worn))
    x, y, z, torque = (one[k] for k, one in enumerate(intervals(expected)[:4]))
    return Peaks(x, y, z, torque)


def not_read(posterior: PairPosterior, operation: str) -> str | None:
    """Return the passive component of an operation, where it is known from the law alone."""
    return None if operation in posterior.passive else PASSIVE_AXIS.get(operation)


def _open_rad(expected: Forecast, passive: int, known: PassiveKnown | None) -> Array:
    """Return by how much the thrust's direction is open (n,), rad: less after forces were read.

    Each reading determines it by its variance and that of its cut.
    """
    if known is None:
        return np.full(len(expected.mean), PASSIVE_RAD)
    each = known.variance_N2 + expected.own[:, passive]
    information = known.count * expected.turned[:, passive] ** 2 / each
    return np.asarray(1.0 / np.sqrt(1.0 / PASSIVE_RAD**2 + information))


def intervals(
    expected: Forecast, *, passive: int | None = None, known: PassiveKnown | None = None
) -> list[list[Interval]]:
    """Return force x, y, z, torque and power of each cut with their 95 % intervals.

    ``passive``: the force that no drive senses, wider by what is not known of the thrust's
    direction; ``known``: what was read of it.
    Torque and power, and a force that is all along the cutting speed, have one sign: their
    logarithm is taken as normal, so that what is hardly known is not said to pull.
    """
    mean, sd = expected.mean, expected.sd
    if passive is not None:
        sd = sd.copy()
        open_rad = _open_rad(expected, passive, known)
        sd[:, passive] = np.hypot(sd[:, passive], open_rad * expected.turned[:, passive])
    half = NORMAL_95 * sd
    one_sign = np.ones(mean.shape, dtype=np.bool_)
    one_sign[:, :3] = expected.along >= ALL
    size = np.abs(mean)
    share = np.divide(half, size, out=np.zeros_like(half), where=one_sign & (size > 0.0))
    factor = np.exp(share)
    ends = mean / factor, mean * factor
    low = np.where(one_sign, np.minimum(*ends), mean - half)
    high = np.where(one_sign, np.maximum(*ends), mean + half)
    each = zip(mean.tolist(), low.tolist(), high.tolist(), strict=True)
    return [[Interval(*three) for three in zip(*cut, strict=True)] for cut in each]
