"""Sensed forces become parameters, parameters become predictions, and the intervals hold."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.stats import binom

from autodb import forward
from autodb.cutting import law, turning
from autodb.fitting import NORMAL_95, Gaussian
from autodb.inverse import Parameters, SensedCuts, Shared, learn
from autodb.jobs import JobCut
from autodb.sensing.forms import LINE

TRUE = np.array([1500.0, 90.0, -30.0])


def _cuts(rng: np.random.Generator, n: int, *, gain: float = 0.0, sd_N: float = 15.0) -> SensedCuts:
    feed, depth = rng.uniform(0.1, 0.4, n), rng.uniform(1.0, 2.5, n)
    force = law.design(feed, depth) @ TRUE
    process = force * rng.normal(0, 0.03, n)
    sensed = (force + process) * (1 + gain) + rng.normal(0, sd_N, n)
    current = sensed / 200.0
    return SensedCuts(
        feed_mm=feed,
        depth_mm=depth,
        force_N=sensed,
        sd_N=np.full(n, sd_N),
        common=np.column_stack([np.ones(n), current]),
        source=np.zeros(n, dtype=np.int_),
        shared=(Shared(LINE, 2, np.diag([1e-6, (200.0 * 0.05) ** 2]), np.zeros(2)),),
    )


def test_known_parameters_are_recovered() -> None:
    learnt = learn(_cuts(np.random.default_rng(1), 400))
    sd = np.sqrt(np.diag(learnt.belief.covariance))
    assert np.all(np.abs(learnt.belief.mean - TRUE) < 4 * sd)
    assert_allclose(learnt.process_share, 0.03, rtol=0.25)
    assert learnt.n_cuts == 400


def test_more_cuts_never_beat_the_calibration() -> None:
    """A gain known to 5 % leaves K_c no surer than 5 %, however many cuts there are."""
    for n in (50, 500, 5000):
        learnt = learn(_cuts(np.random.default_rng(2), n))
        share = np.sqrt(learnt.belief.covariance[0, 0]) / learnt.belief.mean[0]
        assert share > 0.045


def test_a_law_that_misses_a_region_widens_the_interval() -> None:
    cuts = _cuts(np.random.default_rng(3), 200)
    deep = cuts.depth_mm > np.median(cuts.depth_mm)
    thick = cuts.feed_mm > np.median(cuts.feed_mm)
    bent = replace(cuts, force_N=cuts.force_N + np.where(deep == thick, 60.0, -60.0))
    assert learn(cuts).misfit_N < 8.0
    assert learn(bent).misfit_N > 30.0


def test_coverage_of_forces_not_cut_yet() -> None:
    """n = 300 machines, each with its own gain error; 95 % intervals of one unseen cut's force.

    The band is the 99.9 % one of the binomial: correct code fails less than once in a thousand.
    """
    inside, n = 0, 300
    for seed in range(n):
        rng = np.random.default_rng(1000 + seed)
        learnt = learn(_cuts(rng, 30, gain=rng.normal(0, 0.05)))
        feed, depth = rng.uniform(0.1, 0.4, 1), rng.uniform(1.0, 2.5, 1)
        force = float((law.design(feed, depth) @ TRUE)[0]) * (1 + rng.normal(0, 0.03))
        mean, sd = forward.force_N(feed, depth, learnt)
        inside += bool(abs(force - mean[0]) < NORMAL_95 * sd[0])
    assert binom.ppf(0.0005, n, 0.95) <= inside <= binom.ppf(0.9995, n, 0.95)


KNOWN = Parameters(Gaussian(TRUE, np.diag([100.0, 4.0, 25.0])), 0.03, 0.0, 40)
CUT = JobCut(name="a", diameter_mm=50, depth_mm=2.0, feed_mm_rev=0.2, speed_rpm=1000)


def test_torque_and_power_follow_from_the_tangential_force() -> None:
    done = forward.predict(CUT, {"y": KNOWN, "z": KNOWN})
    assert done.force_y_N is not None
    assert done.torque_N_m is not None
    assert done.power_W is not None
    assert_allclose(done.force_y_N.value, 1500 * 0.4 + 90 * 2 - 30)
    assert_allclose(done.torque_N_m.value, done.force_y_N.value * 0.026)
    assert_allclose(done.speed_m_min, np.pi * 50)
    # torque times angular speed at the machined diameter is the cutting power
    omega = 1000 * 2 * np.pi / 60
    assert_allclose(done.power_W.value, done.force_y_N.value * 0.025 * omega, rtol=1e-12)
    assert done.force_x_N is None


def test_either_speed_gives_the_other() -> None:
    by_speed = CUT.model_copy(update={"speed_rpm": None, "speed_m_min": np.pi * 50})
    assert_allclose(forward.predict(by_speed, {"y": KNOWN}).speed_rpm, 1000.0)


def test_scalar_equals_array_and_force_is_linear_in_the_chip() -> None:
    feed, depth = np.array([0.1, 0.2, 0.3]), np.array([1.0, 2.0, 2.5])
    mean, sd = forward.force_N(feed, depth, KNOWN)
    for i in range(3):
        one = forward.force_N(feed[i : i + 1], depth[i : i + 1], KNOWN)
        assert_allclose([mean[i], sd[i]], [one[0][0], one[1][0]])
    twice, _ = forward.force_N(2 * feed, depth, KNOWN)
    assert_allclose(twice - mean, 1500.0 * depth * feed)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_few_cuts_are_no_reason_to_fail(n: int) -> None:
    learnt = learn(_cuts(np.random.default_rng(9), n))
    assert np.isfinite(learnt.belief.mean).all()
    assert np.linalg.eigvalsh(learnt.belief.covariance).min() > 0


def test_units_of_power_and_torque() -> None:
    assert_allclose(turning.power_W(np.array([600.0]), np.array([100.0])), 1000.0)
    assert_allclose(turning.torque_N_m(np.array([1000.0]), np.array([25.0])), 25.0)
    assert_allclose(turning.speed_m_min(np.array([50.0]), np.array([1000.0])), 157.0796327)
