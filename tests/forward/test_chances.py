"""Chances beyond a limit are those of the interval's own distribution, on both sides of it."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy.stats import lognorm, norm
from scipy.stats import t as student

from autodb.fitting.gaussian import NORMAL_95, Gaussian
from autodb.forward.prediction import (
    Interval,
    chance_above,
    chance_beyond,
    intervals,
    wider_interval,
)
from autodb.pairs.engaged import BY_NAME
from autodb.pairs.forecast import expected_means, forecast
from autodb.pairs.observed import TORQUE, PairCuts, X, Y, Z
from autodb.pairs.posterior import (
    FAR,
    NEAR,
    OWN,
    LawDiscrepancy,
    PairPosterior,
    Scatter,
    averaged_law,
)
from tests.helpers.campaigns import first
from tests.helpers.known_pairs import INSERT, known

Array = NDArray[np.float64]
CUT = {
    "cutting.feed": 0.25, "cutting.depth": 2.0, "cutting.speed": 220.0, "work.diameter": 50.0,
    "spindle.speed": 1400.0,
}  # fmt: skip


def _normal(value: float, sd: float) -> Interval:
    return Interval(value, value - NORMAL_95 * sd, value + NORMAL_95 * sd)


def _in_logarithm(value: float, sd: float) -> Interval:
    factor = np.exp(NORMAL_95 * sd)
    ends = sorted((value / factor, value * factor))
    return Interval(value, *ends)


@pytest.mark.parametrize("limit", [15.0, 40.0, 99.0, 101.0, 250.0, 900.0])
def test_a_wide_torque_has_the_chances_of_its_logarithm_on_either_side(limit: float) -> None:
    """At 40 N·m of 100 (17 to 590) it is 85 % (60 % where a side is a normal's)."""
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


def test_what_is_skewed_has_the_chances_of_its_three_quantiles() -> None:
    """A shifted exponential of a normal, on either side and of either sign, and widened."""
    for sign in (1.0, -1.0):
        ends = sorted(sign * (40.0 + 30.0 * np.exp(0.6 * z)) for z in (-NORMAL_95, NORMAL_95))
        one = Interval(sign * 70.0, *ends)
        for z in (-3.0, -1.0, 0.5, 2.5):
            reached = sign * (40.0 + 30.0 * np.exp(0.6 * z))
            assert_allclose(chance_above(one, reached), norm.sf(sign * z), rtol=1e-9)
            assert_allclose(chance_above(wider_interval(one, 0.5), reached), norm.sf(2 * sign * z))
        assert chance_above(one, sign * 39.0) == (1.0 if sign > 0.0 else 0.0)


@pytest.mark.parametrize("freedom", [4.0, 6.0, 20.0, 99.0])
def test_what_is_not_known_how_wide_has_the_chances_of_students_t(freedom: float) -> None:
    """As wide at 95 %, of Wallace's approximation within 0.2 points; a normal's are 4 off."""
    one = replace(_normal(100.0, 10.0), freedom=freedom)
    spread = 10.0 * NORMAL_95 / student.ppf(0.975, freedom)
    for limit in (60.0, 85.0, 95.0, 100.0, 103.0, 112.0, 150.0):
        expected = student.sf((limit - 100.0) / spread, freedom)
        assert_allclose(chance_above(one, limit), expected, atol=0.002)
        wide, middle = wider_interval(one, 2.0), chance_above(one, 0.5 * (limit + 100.0))
        assert_allclose(chance_above(wide, limit), middle, rtol=1e-12)
    assert_allclose(chance_above(one, one.high), 0.025, atol=1e-7)


def test_a_scatter_that_few_cuts_tell_shapes_what_it_makes_most_of() -> None:
    posterior, cuts = _known(0.15)
    shapes = [
        forecast(replace(posterior, scatter=Scatter(np.full(2, share), np.full(2, 6.0))), cuts)
        for share in (0.01, 0.1, 10.0)
    ]
    little, more, all_of_it = (one.freedom[0] for one in shapes)
    assert np.all(little > more)
    assert np.all(more > all_of_it)
    assert_allclose(all_of_it[TORQUE], 6.0, rtol=0.01)
    assert np.all((all_of_it[:3] >= 6.0) & (all_of_it[:3] < 12.0))  # of two parts, each its own


@pytest.mark.parametrize("far", [0.03, 0.1, 0.3])
def test_a_law_that_may_be_far_off_has_the_chances_of_both(far: float) -> None:
    """Of a law that is near or far, and of nothing else, within 4 points; a normal is 8 off."""
    posterior, cuts = _known(0.02)
    of_laws = [forecast(_off_by(posterior, law), cuts) for law in (NEAR, FAR)]
    law = averaged_law([NEAR, FAR], [1.0 - far, far])
    mean = forecast(_off_by(posterior, law), cuts)
    worst = 0.0
    for quantity in (X, Z):
        (one,) = (cut[quantity] for cut in intervals(mean))
        assert one.freedom is not None
        for z in (-1.0, -0.6, -0.3, 0.0, 0.3, 0.6, 1.0):
            limit = one.value + z * mean.sd[0, quantity]
            each = [norm.sf(limit, o.mean[0, quantity], o.sd[0, quantity]) for o in of_laws]
            expected = (1.0 - far) * each[0] + far * each[1]
            assert abs(chance_above(one, limit) - expected) < 0.04
            worst = max(worst, abs(chance_above(replace(one, freedom=None), limit) - expected))
    assert worst > 0.08


def _off_by(posterior: PairPosterior, law: LawDiscrepancy) -> PairPosterior:
    """Return a posterior whose law is off by this, and is not known otherwise."""
    own = Gaussian(posterior.state.mean[:OWN], posterior.state.covariance[:OWN, :OWN])
    return replace(posterior, state=own, shared=(), off_law=law)


TRUTHS = 12_000
WITHIN = 0.027


@pytest.mark.parametrize(
    ("share", "quantity"), first(2, [(0.15, Z), (0.15, TORQUE), (0.15, X), (0.15, Y)])
)
def test_chances_are_those_of_pairs_drawn_from_what_is_known(share: float, quantity: int) -> None:
    """Pairs drawn from a posterior, law errors and scatter with it, and cut by the whole law.

    Of 12 000, shares beyond five limits are within 2.7 points of the chance. What is linear in the
    prediction and not in the law makes 1.9 of it, in a tenth of the forces along x, as a mean over
    eight draws; those scatter by 0.2, and are beyond the rest once in thousands.
    """
    expected = forecast(*_known(share))
    one, means = intervals(expected)[0][quantity], _means(share)[:, quantity]
    rng = np.random.default_rng(4041)
    scatter = np.sqrt(expected.own[0, quantity]) / abs(expected.mean[0, quantity])
    size = np.abs(means * (1.0 + scatter * rng.standard_normal(TRUTHS)))
    for beyond in (0.9, 0.7, 0.5, 0.3, 0.1):
        said = chance_beyond(one, float(np.quantile(size, 1.0 - beyond)))
        assert abs(said - beyond) < WITHIN


@pytest.mark.parametrize("quantity", [X, Y, TORQUE])
def test_of_a_metal_of_which_nothing_is_known_the_value_is_the_median(quantity: int) -> None:
    """The law at the middle of its numbers is below 56 % of the torques (0.46 points a draw)."""
    expected = forecast(*_known(1.0))
    share = float(np.mean(_means(1.0)[:, quantity] / expected.mean[0, quantity] > 1.0))
    assert abs(share - 0.5) < WITHIN


def _known(share: float) -> tuple[PairPosterior, PairCuts]:
    """Return what is known of a pair, and a cut of it."""
    posterior = known(share)
    cuts = BY_NAME["turn"].cuts(INSERT.numbers, [CUT], called="insert")
    return posterior.also((*posterior.law_errors("turn"), *cuts.assumed)), cuts


@cache
def _means(share: float) -> Array:
    """Return forces, torque and power of the cut (TRUTHS, 5) by laws drawn from what is known."""
    posterior, cuts = _known(share)
    rng, state = np.random.default_rng(4040), posterior.state
    drawn = (
        replace(posterior, state=Gaussian(one, state.covariance))
        for one in rng.multivariate_normal(state.mean, state.covariance, TRUTHS)
    )
    return np.array([expected_means(one, cuts)[0] for one in drawn])


@pytest.mark.parametrize("share", [0.4, 1.0, 1.5, 20.0, 400.0])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_what_is_hardly_known_has_one_sign_and_ends_that_can_be_worked_with(
    share: float, sign: float
) -> None:
    """Beyond the whole of a value the ends go farther apart with what is open, and stay finite."""
    own = forecast(*_known(0.15))
    sd = share * np.abs(own.mean)
    (one, *_) = intervals(replace(own, mean=sign * np.abs(own.mean), sd=sd))
    torque = one[TORQUE]
    ends = sorted((abs(torque.low), abs(torque.high)))
    assert torque.low * sign > 0.0
    assert_allclose(np.prod(ends), torque.value**2, rtol=1e-9)
    spread = share if share <= 1.0 else 1.0 + np.log(share)
    assert_allclose(np.log(ends[1] / ends[0]), 2.0 * NORMAL_95 * spread, rtol=1e-9)
    assert 0.0 < chance_beyond(wider_interval(torque, 1.3), 2.0 * abs(torque.value)) < 0.5
