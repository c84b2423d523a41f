"""A law that is off by more where chips are thicker, or faster cut; and hills that are averaged."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.agent.rows.posteriors import posterior_columns, posterior_of
from autodb.cutting.elements import cut_forces, force_parts
from autodb.cutting.insert import TurnedCuts, insert_elements
from autodb.cutting.shear import NAMES
from autodb.fitting.gaussian import root_of
from autodb.pairs import averaging
from autodb.pairs.averaging import learn_averaging
from autodb.pairs.forecast import forecast
from autodb.pairs.observed import PairCuts, growth, off_law
from autodb.pairs.posterior import (
    FARTHER,
    NEAR,
    OF_GROWTH,
    OF_OPERATION,
    PairPosterior,
    averaged_law,
)
from autodb.pairs.prior import any_metal
from autodb.pairs.updating import met, posterior_of_readings
from tests.helpers.law_off import PRIOR, TOOL, sensed

Array = NDArray[np.float64]
LAW = PRIOR.law.mean


def _cuts(count: int, seed: int) -> PairCuts:
    rng = np.random.default_rng(seed)
    feed, speed = np.exp(rng.uniform(np.log(0.08), np.log(0.4), count)), rng.uniform(60, 300, count)
    depth, one = rng.uniform(1.0, 3.0, count), np.ones(count)
    return PairCuts(
        "turn", insert_elements(TOOL, TurnedCuts(feed, depth, speed, 20.0 * one, 0.0 * one))
    )


def _turned(cuts: PairCuts, by: int, rad: float) -> Array:
    """Return forces (n, 3) of a thrust that turns with a column of what errors grow with."""
    turns = rad * growth(cuts.elements)[:, by, None]
    parts = force_parts(LAW, cuts.elements)[:, :3, 2]
    return np.asarray(cut_forces(LAW, cuts.elements).force_N + turns * parts)


@pytest.mark.parametrize("by", [1, 2], ids=["thickness", "speed"])
def test_a_thrust_that_turns_with_the_chip_speaks_for_a_law_far_off(by: int) -> None:
    """By 0.4 rad a factor e: the far law is taken, foresees what comes, and holds it."""
    cuts, ahead = _cuts(24, 1), _cuts(60, 9)
    force = _turned(cuts, by, 0.4)
    scatter = np.random.default_rng(3).standard_normal(force.shape)
    observed = sensed(cuts, force * (1.0 + 0.02 * scatter))
    found = learn_averaging(PRIOR, observed)
    assert_allclose(found.off_law.grow_in_chip, FARTHER.grow_in_chip, rtol=1e-3)
    expected, real = forecast(found, ahead), _turned(ahead, by, 0.4)[:, (0, 2)]
    off = np.abs(expected.mean[:, (0, 2)] - real)
    assert np.mean(off) < 0.05 * np.mean(np.abs(real))
    assert np.mean(off < 1.96 * expected.sd[:, (0, 2)]) > 0.85


def test_errors_grow_with_the_chip_and_the_speed_from_where_the_law_is_stated() -> None:
    cuts = _cuts(5, 2).elements
    changed, by = off_law(LAW, cuts), growth(cuts)
    for k in (1, 2):
        columns = OF_GROWTH.start + 3 * (k - 1) + np.arange(3)
        expected = changed[..., OF_OPERATION][..., :3] * by[:, k, None, None]
        assert_allclose(changed[..., columns], expected, rtol=1e-12)
    assert_allclose(np.exp(by[:, 2]) * 100.0, np.mean(cuts.edge.speed_m_min, axis=1), rtol=0.01)


def test_a_flatter_shear_plane_goes_with_more_friction() -> None:
    """Of metals drawn beforehand the resultant keeps its angle to the shear plane within 10°."""
    known = any_metal().law
    root = root_of(known.covariance)
    draws = np.random.default_rng(5).standard_normal((20_000, root.shape[1]))
    drawn = known.mean + draws @ root.T
    ratio = np.exp(drawn[:, NAMES.index("chip_ratio")])
    friction = np.arctan(np.exp(drawn[:, NAMES.index("friction_angle")]))
    angle = np.degrees(np.arctan(ratio) + friction)
    assert np.mean(angle) == pytest.approx(52.0, abs=1.0)
    assert np.std(angle) == pytest.approx(10.0, abs=1.0)


def test_a_version_keeps_how_its_law_grows_with_the_chip() -> None:
    """One of before 0.3.0 knew no such law."""
    half = averaged_law([NEAR, FARTHER], [0.75, 0.25])
    assert_allclose(half.grow_in_chip, 0.5 * np.array(FARTHER.grow_in_chip))
    kept = posterior_columns(PairPosterior(PRIOR.state, (), PRIOR.scatter, 3, half))
    columns = [kept[name] for name in ("mean", "covariance", "shared", "scatter", "terms")]
    assert half.near == 0.75
    assert posterior_of(*columns, cuts=3).off_law == half
    del kept["scatter"]["off_law"]["near"]  # of before 0.3.0, too: it counts as near
    assert posterior_of(*columns, cuts=3).off_law.near == 1.0
    del kept["scatter"]["off_law"]["grow_in_chip"]
    assert posterior_of(*columns, cuts=3).off_law.grow_in_chip == NEAR.grow_in_chip


def test_a_lower_hill_is_carried_along_the_bend_of_the_forces() -> None:
    """To numbers that expect the readings which it expects: one straight step misses them."""
    cuts = _cuts(12, 4)
    observed = sensed(cuts, cut_forces(LAW, cuts.elements).force_N)
    one, mean = posterior_of_readings(PRIOR, observed), any_metal().law.mean.copy()
    mean[NAMES.index("friction_angle")] += 0.8
    other = posterior_of_readings(
        any_metal(), sensed(cuts, cut_forces(mean, cuts.elements).force_N)
    )
    known, model = met(any_metal(), observed)
    at_one, at_other = (met(each, observed)[0].state.mean for each in (one, other))
    assert len(at_one) == len(at_other) == len(known.state.mean)
    there, here = model.seen(at_one), model.seen(at_other)
    noise = model.noise(here, other.scatter)
    assert np.max(np.abs(there.expected - here.expected) / noise) > 3.0
    carried = averaging.carried(one, other, any_metal(), observed)
    left = (model.seen(carried.mean).expected - there.expected) / noise
    assert np.max(np.abs(left)) < 0.5
