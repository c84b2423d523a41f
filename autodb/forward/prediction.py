"""What a prediction of a cut is: its forces, torque and power with their 95 % intervals.

One that is as far from its value on both sides is normal; any other is normal in its logarithm, as
what has one sign is. On either side of the value, its median, half of the interval is 1.96 standard
deviations, so that the interval's ends, their widening and chances beyond any limit are of one
distribution.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import erfc, inf, isclose, log, sqrt

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.turning import TURNED, force_role
from autodb.fitting.gaussian import NORMAL_95
from autodb.pairs.engaged import BANDS, DIAMETER, RPM, SPEED, Conditions
from autodb.pairs.forecast import Forecast
from autodb.pairs.posterior import PairPosterior, PassiveKnown
from autodb.wording import msgid

Array = NDArray[np.float64]

COLUMNS = {"x": 0, "y": 1, "z": 2}
"""Columns of a forecast that are forces, by component."""
OBLIQUE = ("taper", "contour")
"""Turned along a path that is oblique to the axis, so that both slides feel the passive force."""
PASSIVE_RAD = 0.2
"""Standard deviation of the thrust's direction, which no sensed force determines where one of its
components is passive. Chosen: laws of chip flow over a nose are off by 5 to 10° (Young, Mathew and
Oxley 1987), and breakers and inclinations of inserts turn the chip further."""
SAME_MM = 1e-6
"""Difference of diameters below which they are one: what is left of a path's arithmetic."""
ALL = 0.999
"""Share of a force from which on it is taken to be all along the cutting speed."""
ALIKE = 1e-6
"""Share by which the sides of a normal's interval may differ: what is left of arithmetic."""


@dataclass(frozen=True)
class Interval:
    """A predicted value with its 95 % interval, in the unit that the holder names."""

    value: float
    low: float
    high: float


class _Quantities:
    """Forces, torque and power of a cut, of whatever statistic."""

    force_x_N: Interval
    force_y_N: Interval
    force_z_N: Interval
    torque_N_m: Interval
    power_W: Interval

    @property
    def quantities(self) -> tuple[Interval, ...]:
        """Force x, y, z, torque and power."""
        return self.force_x_N, self.force_y_N, self.force_z_N, self.torque_N_m, self.power_W


@dataclass(frozen=True)
class Peaks(_Quantities):
    """The largest forces, torque and power, by size, within a mill's turn or along a cut.

    ``speed_rpm``: the fastest along a program's line; None where the spindle turns at one speed.
    """

    force_x_N: Interval
    force_y_N: Interval
    force_z_N: Interval
    torque_N_m: Interval
    power_W: Interval
    speed_rpm: float | None = None


@dataclass(frozen=True)
class Moment(_Quantities):
    """What a cut takes at one moment, and the diameter and speeds that it has then."""

    diameter_mm: float
    speed_rpm: float
    speed_m_min: float
    force_x_N: Interval
    force_y_N: Interval
    force_z_N: Interval
    torque_N_m: Interval
    power_W: Interval


@dataclass(frozen=True)
class PredictedCut:
    """What one cut will take, in the mean.

    Of a mill that is the mean over a turn, and ``peaks`` are the largest. Of a cut that goes from
    one diameter to another, and of a program's line, forces, torque and power are means in time
    along it, speeds those at its largest diameter, ``peaks`` the largest, and ``start`` and ``end``
    what it begins and ends with. ``passive``: the component that no drive of the machine senses and
    nobody measured, known from the law alone. ``state``: the process state that it is predicted in;
    None: the pair's usual one. ``feed_mm_min``: its fastest along the
    path; ``removal_mm3_min``: what it takes off, in the mean; ``time_s``: how long it cuts, None
    where nobody says how far.
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
    start: Moment | None = None
    end: Moment | None = None
    feed_mm_min: float | None = None
    removal_mm3_min: float | None = None
    time_s: float | None = None

    @property
    def of_what(self) -> str:
        """Of what its peaks are the largest."""
        return msgid("in a turn") if self.operation in BANDS else msgid("along the cut")

    @property
    def changes(self) -> bool:
        """Whether it ends at another diameter than it starts at."""
        if self.start is None or self.end is None:
            return False
        return abs(self.end.diameter_mm - self.start.diameter_mm) > SAME_MM

    @property
    def statistics(self) -> "tuple[tuple[str, Moment | Peaks], ...]":
        """What is known of it beside its mean, by name: start, end and peak."""
        named: list[tuple[str, Moment | Peaks | None]] = [(self._peak, self.peaks)]
        if self.changes:
            named = [(msgid("start"), self.start), (msgid("end"), self.end), *named]
        return tuple((name, one) for name, one in named if one is not None)

    @property
    def _peak(self) -> str:
        """What its peaks are called."""
        along = msgid("peak along the cut")
        return msgid("peak in a turn") if self.operation in BANDS else along


@dataclass(frozen=True)
class ToolOf:
    """A pair's tool: what it is called, and what is known of its geometry, by name."""

    name: str
    numbers: Mapping[str, float]

    @property
    def diameter_mm(self) -> float | None:
        """Diameter of a tool that turns."""
        return self.numbers.get("diameter_mm")


def not_read(posterior: PairPosterior, operation: str) -> str | None:
    """Return the passive component of an operation, where it is known from the law alone."""
    if operation in posterior.passive:
        return None
    return next((one for one in COLUMNS if force_role(one, [operation]) == "Fp"), None)


def passive_known(posterior: PairPosterior, operation: str) -> PassiveKnown | None:
    """Return what was read of passive forces in an operation; None: nothing.

    A path that is oblique to the axis has the direction that turning along the axis told.
    """
    known = posterior.passive.get(operation)
    return posterior.passive.get("turn") if known is None and operation in OBLIQUE else known


def _open_N(expected: Forecast, known: PassiveKnown | None) -> Array:
    """Return the sd of forces x, y, z (n, 3) by the thrust's direction, less after readings.

    It moves what is off the surface: what is against the feed is known as far as it is sensed. Each
    reading of the passive force determines it by its variance and that of its cut.
    """
    off = np.vecdot(expected.turned, expected.normal)
    information = np.zeros_like(off)
    if known is not None:
        own = np.vecdot(expected.own[:, :3], expected.normal**2)
        information = known.count * off**2 / (known.variance_N2 + own)
    open_rad = 1.0 / np.sqrt(1.0 / PASSIVE_RAD**2 + information)
    return np.asarray((open_rad * off)[:, None] * expected.normal)


def intervals(
    expected: Forecast, *, operation: str | None = None, known: PassiveKnown | None = None
) -> list[list[Interval]]:
    """Return force x, y, z, torque and power of each cut with their 95 % intervals.

    What is off a surface that the ``operation`` turns is wider by what is not known of the thrust's
    direction; None: nothing is. ``known``: what was read of that force.
    Torque and power, and a force that is all along the cutting speed, have one sign: their
    logarithm is taken as normal, so that what is hardly known is not said to pull.
    """
    mean, sd = expected.mean, expected.sd
    if operation in TURNED:
        sd = sd.copy()
        sd[:, :3] = np.hypot(sd[:, :3], _open_N(expected, known))
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


def moment(conditions: Conditions, expected: Sequence[Interval]) -> Moment:
    """Return the moment of a cut that has these conditions, and of which this is expected."""
    return Moment(conditions[DIAMETER], conditions[RPM], conditions[SPEED], *expected)


def in_logarithm(one: Interval) -> bool:
    """Return whether a value is normal in its logarithm."""
    rise, fall = one.high - one.value, one.value - one.low
    return not (isclose(rise, fall, rel_tol=ALIKE) or one.low * one.high <= 0.0)


def wider_interval(one: Interval, factor: float) -> Interval:
    """Return an interval with its standard deviation times a factor."""
    if not in_logarithm(one):
        rise, fall = one.high - one.value, one.value - one.low
        return Interval(one.value, one.value - factor * fall, one.value + factor * rise)
    low, high = ((end / one.value) ** factor for end in (one.low, one.high))
    return Interval(one.value, one.value * low, one.value * high)


def chance_above(one: Interval, limit: float) -> float:
    """Return the probability that a predicted value is larger than a limit, with its sign."""
    if not in_logarithm(one):
        half = one.high - one.value if limit > one.value else one.value - one.low
        return _beyond(limit - one.value, half)
    sign = 1.0 if one.value > 0.0 else -1.0
    if limit * sign <= 0.0:
        return 1.0 if sign > 0.0 else 0.0
    end = one.high if limit > one.value else one.low
    return _beyond(sign * log(limit / one.value), abs(log(end / one.value)))


def chance_beyond(one: Interval, limit: float) -> float:
    """Return the probability that a predicted value is larger in size than a limit."""
    below = 1.0 - chance_above(one, -limit) if one.low < 0.0 or not in_logarithm(one) else 0.0
    return chance_above(one, limit) + below


def _beyond(off: float, half: float) -> float:
    """Return the probability to be off by more, with half a 95 % interval that wide."""
    score = NORMAL_95 * off / half if half > 0.0 else (inf if off >= 0.0 else -inf)
    return 0.5 * erfc(score / sqrt(2.0))
