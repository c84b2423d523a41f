"""The distribution that a predicted value with its 95 % interval stands for.

One that is as far from its value on both sides is normal. Any other is a normal's exponential,
shifted, whose 2.5, 50 and 97.5 % are the interval's low end, value and high end:

    F = v + s (e^(k z) - 1)/k,    z ~ N(0, 1),    e^(1.96 k) = (high - v)/(v - low)

What has one sign and is normal in its logarithm has s = v k. So an interval's ends, their widening
and chances beyond any limit are of one distribution.
"""

from dataclasses import dataclass
from math import erfc, exp, expm1, inf, log, log1p, sqrt

from autodb.fitting import NORMAL_95
from autodb.forward.prediction import Interval

ALIKE = 1e-6
"""Logarithm of the ratio of its sides below which an interval is a normal's: what is left of
arithmetic."""
ODD = 40.0
"""The largest such logarithm: beyond, one side is none. Chosen."""


@dataclass(frozen=True)
class _Skewed:
    """What an interval stands for: its value, s and k; k is 0 of a normal."""

    value: float
    sd: float
    skew: float

    def at(self, z: float) -> float:
        """Return the value that is reached at so many standard deviations."""
        if self.skew == 0.0:
            return self.value + self.sd * z
        return self.value + self.sd * expm1(self.skew * z) / self.skew

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
        return _Skewed(one.value, max(rise, fall, 0.0) / NORMAL_95, 0.0)
    ratio = min(max(log(rise / fall), -ODD), ODD)
    if abs(ratio) < ALIKE:
        return _Skewed(one.value, 0.5 * (rise + fall) / NORMAL_95, 0.0)
    skew = ratio / NORMAL_95
    return _Skewed(one.value, (rise + fall) * skew / (exp(ratio) - exp(-ratio)), skew)


def wider_interval(one: Interval, factor: float) -> Interval:
    """Return an interval with its standard deviation times a factor."""
    rise, fall = one.high - one.value, one.value - one.low
    if rise <= 0.0 or fall <= 0.0:
        return Interval(one.value, one.value - factor * fall, one.value + factor * rise)
    its = _of(one)
    return Interval(one.value, its.at(-NORMAL_95 * factor), its.at(NORMAL_95 * factor))


def chance_above(one: Interval, limit: float) -> float:
    """Return the probability that a predicted value is larger than a limit, with its sign."""
    return 0.5 * erfc(_of(one).z(limit) / sqrt(2.0))


def chance_beyond(one: Interval, limit: float) -> float:
    """Return the probability that a predicted value is larger in size than a limit."""
    return chance_above(one, limit) + 1.0 - chance_above(one, -limit)
