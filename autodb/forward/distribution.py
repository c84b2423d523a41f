"""The distribution that a predicted value with its 95 % interval stands for.

One that is as far from its value on both sides is normal; any other is normal in its logarithm, as
what has one sign is. On either side of the value, its median, half of the interval is 1.96 standard
deviations, so that the interval's ends, their widening and chances beyond any limit are of one
distribution.
"""

from math import erfc, inf, isclose, log, sqrt

from autodb.fitting.gaussian import NORMAL_95
from autodb.forward.prediction import Interval

ALIKE = 1e-6
"""Share by which the sides of a normal's interval may differ: what is left of arithmetic."""


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
