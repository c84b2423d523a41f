"""What a prediction of a cut is: its forces, torque and power with their 95 % intervals.

One that is as far from its value on both sides is normal. Any other is a normal's exponential,
shifted, whose 2.5, 50 and 97.5 % are the interval's low end, value and high end:

    F = v + s (e^(k z) - 1)/k,    z ~ N(0, 1),    e^(1.96 k) = (high - v)/(v - low)

What has one sign and is normal in its logarithm has s = v k. Where a variance is not known, z is
Student's t of ν degrees of freedom in place of a normal, as wide at 95 %: that has more in its
middle, and more far off. Both are taken from each other by

    z = c (ν ln(1 + t²/ν))^½,    c = (8 ν + 1)/(8 ν + 3)

(Wallace 1959, Ann. Math. Statist. 30:1121), within 0.2 points of the chances from 4 degrees of
freedom on, and 1 point from 2. So an interval's ends, their widening and chances beyond any limit
are of one distribution.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import copysign, erfc, exp, expm1, inf, isinf, log, log1p, sqrt

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.turning import TURNED, force_role
from autodb.fitting.gaussian import NORMAL_95
from autodb.pairs.engaged import BANDS, DIAMETER, RPM, SPEED, Conditions
from autodb.pairs.forecast import Forecast, one_sign
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
ENDS = np.array([-NORMAL_95, NORMAL_95])[:, None, None]
"""Of an interval, in standard deviations, of cuts and their quantities."""
TINY_SKEW = 1e-9
"""A smaller skew is none: what is left of arithmetic."""
ALIKE = 1e-6
"""Logarithm of the ratio of its sides below which an interval is a normal's: what is left of
arithmetic."""
NORMAL_FROM = 100.0
"""Degrees of freedom from which on Student's t is a normal: chances then differ by 0.1 points."""
ODD = 40.0
"""The largest such logarithm: beyond, one side is none. Chosen."""


@dataclass(frozen=True)
class Interval:
    """A predicted value with its 95 % interval, in the unit that the holder names.

    ``freedom``: degrees of freedom of Student's t that it is shaped as; None: as a normal.
    """

    value: float
    low: float
    high: float
    freedom: float | None = None


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
    logarithm is taken as normal, so that what is hardly known is not said to pull; its standard
    deviation is the share c that is open, 1 + ln c beyond the whole. Other forces are skewed as far
    as the law is where it leads them.
    """
    mean, sd, skew, freedom = expected.mean, expected.sd, expected.skew, expected.freedom
    if operation in TURNED:
        sd = sd.copy()
        sd[:, :3] = np.hypot(sd[:, :3], _open_N(expected, known))
        # What is added is not skewed: the third cumulant stays
        less = np.divide(expected.sd, sd, out=np.ones_like(sd), where=sd > 0.0)
        skew, freedom = skew * less**3, freedom / np.maximum(less, TINY_SKEW) ** 4
    signed = one_sign(expected.along)
    share = np.divide(sd, mean, out=np.zeros_like(sd), where=signed & (mean != 0.0))
    size = np.abs(share)
    share = np.where(size > 1.0, np.sign(share) * (1.0 + np.log(np.maximum(size, 1.0))), share)
    skew, sd = np.where(signed, share, skew), np.where(signed, share * mean, sd)
    low, high = mean + sd * _stretched(skew, ENDS)
    each = zip(mean.tolist(), low.tolist(), high.tolist(), freedom.tolist(), strict=True)
    return [
        [
            Interval(value, least, most, round(shape, 2) if shape < NORMAL_FROM else None)
            for value, least, most, shape in zip(*cut, strict=True)
        ]
        for cut in each
    ]


def _stretched(skew: Array, z: Array) -> Array:
    """Return (e^(k z) - 1)/k of skews k, which is z where there is none."""
    skews = np.abs(skew) > TINY_SKEW
    k = np.where(skews, skew, 1.0)
    return np.where(skews, np.expm1(k * z) / k, z)


def moment(conditions: Conditions, expected: Sequence[Interval]) -> Moment:
    """Return the moment of a cut that has these conditions, and of which this is expected."""
    return Moment(conditions[DIAMETER], conditions[RPM], conditions[SPEED], *expected)


@dataclass(frozen=True)
class _Skewed:
    """What an interval stands for: its value, s and k; k is 0 of a normal, and of Student's t."""

    value: float
    sd: float
    skew: float
    freedom: float | None

    def at(self, z: float) -> float:
        """Return the value that is reached at so many standard deviations."""
        if self.skew == 0.0:
            return self.value + self.sd * z
        return self.value + self.sd * expm1(self.skew * z) / self.skew

    def score(self, reached: float) -> float:
        """Return the normal score of a value: the chance that it is exceeded is a normal's."""
        z = self.z(reached)
        if self.freedom is None or isinf(z):
            return z
        v = self.freedom
        c = (8.0 * v + 1.0) / (8.0 * v + 3.0)
        wide = expm1((NORMAL_95 / c) ** 2 / v)  # t²/v of Student's t at 95 %
        return copysign(c * sqrt(v * log1p(wide * (z / NORMAL_95) ** 2)), z)

    def z(self, reached: float) -> float:
        """Return at how many standard deviations a value is reached; infinite beyond all."""
        if self.sd == 0.0:
            return inf if reached >= self.value else -inf
        off = (reached - self.value) / self.sd
        if self.skew == 0.0:
            return off
        if self.skew * off <= -1.0:
            return -inf if self.skew > 0.0 else inf
        return log1p(self.skew * off) / self.skew


def _of(one: Interval) -> _Skewed:
    rise, fall = one.high - one.value, one.value - one.low
    if rise <= 0.0 or fall <= 0.0:
        return _Skewed(one.value, max(rise, fall, 0.0) / NORMAL_95, 0.0, one.freedom)
    ratio = min(max(log(rise / fall), -ODD), ODD)
    if abs(ratio) < ALIKE:
        return _Skewed(one.value, 0.5 * (rise + fall) / NORMAL_95, 0.0, one.freedom)
    skew = ratio / NORMAL_95
    sd = (rise + fall) * skew / (exp(ratio) - exp(-ratio))
    return _Skewed(one.value, sd, skew, one.freedom)


def wider_interval(one: Interval, factor: float) -> Interval:
    """Return an interval with its standard deviation times a factor."""
    rise, fall = one.high - one.value, one.value - one.low
    if rise <= 0.0 or fall <= 0.0:
        return replace(one, low=one.value - factor * fall, high=one.value + factor * rise)
    its = _of(one)
    return replace(one, low=its.at(-NORMAL_95 * factor), high=its.at(NORMAL_95 * factor))


def chance_above(one: Interval, limit: float) -> float:
    """Return the probability that a predicted value is larger than a limit, with its sign."""
    return 0.5 * erfc(_of(one).score(limit) / sqrt(2.0))


def chance_beyond(one: Interval, limit: float) -> float:
    """Return the probability that a predicted value is larger in size than a limit."""
    return chance_above(one, limit) + 1.0 - chance_above(one, -limit)
