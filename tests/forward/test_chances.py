"""Chances beyond a limit are those of the interval's own distribution, on both sides of it."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy.stats import binom, lognorm, norm

from autodb.fitting import NORMAL_95
from autodb.forward.distribution import chance_above, chance_beyond, wider_interval
from autodb.forward.prediction import Interval

Array = NDArray[np.float64]
DRAWS = 2000
CHANCES = (0.03, 0.2, 0.5, 0.8, 0.97)
FALSE_ALARM = 1e-4
"""Of one count: with five of each of two distributions, 1 in 1000 for all."""


def _normal(value: float, sd: float) -> Interval:
    return Interval(value, value - NORMAL_95 * sd, value + NORMAL_95 * sd)


def _in_logarithm(value: float, sd: float) -> Interval:
    factor = np.exp(NORMAL_95 * sd)
    ends = sorted((value / factor, value * factor))
    return Interval(value, *ends)


@pytest.mark.parametrize("limit", [15.0, 40.0, 99.0, 101.0, 250.0, 900.0])
def test_a_wide_torque_has_the_chances_of_its_logarithm_on_either_side(limit: float) -> None:
    """At 40 N·m of 100 (17 to 590) it is 84 % (58 % where a side is a normal's)."""
    expected = lognorm.sf(limit, 0.9, scale=100.0)
    assert_allclose(chance_beyond(_in_logarithm(100.0, 0.9), limit), expected, rtol=1e-9)
    assert_allclose(chance_beyond(_in_logarithm(-100.0, 0.9), limit), expected, rtol=1e-9)


@pytest.mark.parametrize("limit", [5.0, 60.0, 140.0])
def test_a_force_of_either_sign_has_both_tails(limit: float) -> None:
    expected = norm.sf(limit, -30.0, 50.0) + norm.cdf(-limit, -30.0, 50.0)
    assert_allclose(chance_beyond(_normal(-30.0, 50.0), limit), expected, rtol=1e-6)


@pytest.mark.parametrize("one", [_normal(-300.0, 90.0), _in_logarithm(80.0, 0.4)])
def test_a_chance_at_an_end_is_that_of_the_interval(one: Interval) -> None:
    assert_allclose(chance_above(one, one.high), 0.025, atol=1e-7)
    assert_allclose(chance_above(one, one.low), 0.975, atol=1e-7)
    assert_allclose(chance_above(one, one.value), 0.5, atol=1e-12)


def test_a_wider_interval_is_of_the_same_distribution() -> None:
    """As far off by twice as many standard deviations, as probably."""
    one = _in_logarithm(80.0, 0.2)
    wide = wider_interval(one, 2.0)
    assert_allclose(chance_above(wide, 80.0 * np.exp(0.5)), chance_above(one, 80.0 * np.exp(0.25)))


@pytest.mark.parametrize("seed", [40, 41])
def test_limits_are_exceeded_as_often_as_said(seed: int) -> None:
    """Of truths drawn around predictions of all widths, as many are beyond a limit as was said.

    2000 draws at each of five chances, of a normal and of a logarithm: counts within the binomial
    band that right chances leave once in 10 000, so that all ten do once in 1000.
    """
    rng = np.random.default_rng(seed)
    sd = rng.uniform(0.05, 1.0, DRAWS)
    value = rng.uniform(20.0, 2000.0, DRAWS)
    z = rng.standard_normal(DRAWS)
    for chance in CHANCES:
        at = norm.isf(chance)
        logs = [_in_logarithm(v, s) for v, s in zip(value, sd, strict=True)]
        limits = value * np.exp(at * sd)
        assert_allclose(_chances(logs, limits), chance, rtol=1e-6)
        _count(value * np.exp(z * sd) > limits, chance)
        plain = [_normal(v, v * s) for v, s in zip(value, sd, strict=True)]
        limits = value * (1.0 + at * sd)
        above = [chance_above(o, x) for o, x in zip(plain, limits, strict=True)]
        assert_allclose(above, chance, rtol=1e-6)
        _count(value * (1.0 + z * sd) > limits, chance)


def _chances(some: list[Interval], limits: Array) -> list[float]:
    return [chance_beyond(one, limit) for one, limit in zip(some, limits.tolist(), strict=True)]


def _count(beyond: NDArray[np.bool_], chance: float) -> None:
    low, high = binom.interval(1.0 - FALSE_ALARM, DRAWS, chance)
    assert low <= int(beyond.sum()) <= high
