"""What a posterior makes of a law that is off, of assumed geometry, and of errors of days."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.cutting.elements import cut_forces, engaged_mm, force_parts
from autodb.errors import UnusableInput
from autodb.pairs import averaging, updating
from autodb.pairs.averaging import learn_averaging, log_evidence
from autodb.pairs.engaged import BY_NAME
from autodb.pairs.forecast import forecast
from autodb.pairs.observed import PairCuts, X
from autodb.pairs.posterior import DAY, FAR, OWN, PairPosterior, Shared
from autodb.pairs.updating import posterior_of_readings
from tests.helpers.law_off import PRIOR, Array, cuts_of, sensed

NUMBERS = {
    "nose_radius_mm": 0.8, "kappa_deg": 95.0, "rake_deg": -6.0, "inclination_deg": -6.0,
    "included_deg": 80.0,
}  # fmt: skip
KAPPA = "tool: entering angle of any holder"


def _true(seed: int) -> Array:
    law = PRIOR.law
    drawn = np.random.default_rng(seed).multivariate_normal(law.mean, 0.25 * law.covariance)
    return np.asarray(drawn)


def _scattered(force_N: Array, seed: int) -> Array:
    rng = np.random.default_rng(seed)
    return force_N * (1.0 + 0.02 * rng.standard_normal(force_N.shape))


def _turned(some: PairCuts, by_rad: float) -> Array:
    """Return forces (n, 3) of a thrust that turns by so much a factor e of the engaged edge."""
    theta = _true(2)
    whole, parts = cut_forces(theta, some.elements).force_N, force_parts(theta, some.elements)
    return np.asarray(whole + by_rad * np.log(engaged_mm(some.elements))[:, None] * parts[:, :3, 2])


def test_a_law_that_holds_is_taken_to_hold() -> None:
    cuts = cuts_of(24, 1)
    found = learn_averaging(
        PRIOR, sensed(cuts, _scattered(cut_forces(_true(2), cuts.elements).force_N, 3))
    )
    assert found.off_law.direction_rad < 1e-6 * FAR.direction_rad


def test_a_thrust_that_turns_with_the_depth_speaks_for_a_law_far_off() -> None:
    """By 0.5 rad a factor e of the engaged edge: the far law is taken, and holds what comes."""
    cuts, ahead = cuts_of(24, 1), cuts_of(40, 9)
    observed = sensed(cuts, _scattered(_turned(cuts, 0.5), 3))
    found = learn_averaging(PRIOR, observed)
    assert found.off_law.direction_rad == pytest.approx(FAR.direction_rad, rel=1e-3)
    assert log_evidence(replace(PRIOR, off_law=FAR), found, observed) > log_evidence(
        PRIOR, posterior_of_readings(PRIOR, observed), observed
    )
    near, far = (forecast(one, ahead) for one in (posterior_of_readings(PRIOR, observed), found))
    real = _turned(ahead, 0.5)[:, X]
    assert np.mean(np.abs(far.mean[:, X] - real) < 1.96 * far.sd[:, X]) > 0.85
    assert np.mean(np.abs(far.mean[:, X] - real)) < 0.5 * np.mean(np.abs(near.mean[:, X] - real))


def test_laws_that_need_many_steps_are_averaged_all_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Few steps are there to save time: the answer is that of as many as it takes."""
    cuts = cuts_of(24, 1)
    observed = sensed(cuts, _scattered(cut_forces(_true(2), cuts.elements).force_N, 3))
    found = learn_averaging(PRIOR, observed)
    monkeypatch.setattr(averaging, "STEPS", 1)
    slowly = learn_averaging(PRIOR, observed)
    assert_allclose(slowly.state.mean, found.state.mean, rtol=1e-6, atol=1e-9)
    assert slowly.off_law == found.off_law


def test_a_climb_is_left_where_another_law_is_far_likelier(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """By exp(30), once its scatter is about found; one that is as likely is climbed to its end."""
    monkeypatch.setattr(updating, "PATIENCE", 8)
    cuts = cuts_of(24, 1)
    observed = sensed(cuts, _scattered(cut_forces(_true(2), cuts.elements).force_N, 3))
    found = posterior_of_readings(PRIOR, observed)
    evidence = log_evidence(PRIOR, found, observed)
    climbed = posterior_of_readings(PRIOR, observed, beaten=evidence)
    assert np.array_equal(climbed.state.mean, found.state.mean)
    with pytest.raises(UnusableInput, match="far below another law"):
        posterior_of_readings(PRIOR, observed, beaten=evidence + 31.0)


def test_geometry_that_is_assumed_is_learnt_with_the_pair() -> None:
    """An entering angle one sd over the assumed one: the posterior of cuts has it, and forces."""
    theta = _true(4)
    rows = [
        {"cutting.feed": f, "cutting.depth": d, "cutting.speed": 100.0, "work.diameter": 40.0}
        for f in (0.1, 0.2, 0.4)
        for d in (0.5, 1.0, 2.0, 4.0)
    ]
    true = BY_NAME["turn"].cuts({**NUMBERS, "kappa_deg": 99.0}, rows, called="tool")
    assert not true.variants
    bare = {name: value for name, value in NUMBERS.items() if name != "kappa_deg"}
    assumed = BY_NAME["turn"].cuts(bare, rows, called="tool")
    assert [one.key for one in assumed.variants] == [KAPPA]
    value = _scattered(cut_forces(theta, true.elements).force_N, 5)
    found = posterior_of_readings(PRIOR, sensed(assumed, value))
    place = found.columns(KAPPA).start
    sd = np.sqrt(found.state.covariance[place, place])
    assert sd < 0.8
    assert abs(found.state.mean[place] - 1.0) < 3.0 * sd, "99° is one sd over 77°"
    expected = forecast(found, assumed)
    held = (
        np.abs(expected.mean[:, :3] - cut_forces(theta, true.elements).force_N)
        < 1.96 * expected.sd[:, :3]
    )
    assert held.mean() > 0.85


def test_what_a_day_adds_is_forgotten_and_leaves_the_rest_as_it_was() -> None:
    cuts = cuts_of(6, 1)
    value = 1.1 * cut_forces(_true(2), cuts.elements).force_N
    day = Shared(f"{DAY} 1", np.array([[0.05**2]]))
    gain = Shared("calibration 1", np.array([[0.03**2]]))
    observed = replace(sensed(cuts, value), common=np.ones((18, 2)), shared=(day, gain))
    after = posterior_of_readings(PRIOR, observed)
    past = after.past()
    assert {one.key for one in after.shared} - {one.key for one in past.shared} == {day.key}
    assert_allclose(past.law.mean, after.law.mean)
    assert_allclose(past.law.covariance, after.law.covariance)
    kept, was = past.columns(gain.key), after.columns(gain.key)
    assert_allclose(past.state.covariance[:OWN, kept], after.state.covariance[:OWN, was])
    assert isinstance(past, PairPosterior)
    assert past.past() is past


def test_an_offset_moves_a_reading_by_itself() -> None:
    """Readings all 40 N too high: an offset's error is found, and no force is."""
    cuts = cuts_of(30, 1)
    true = cut_forces(_true(2), cuts.elements).force_N
    offset = Shared("calibration 1", np.array([[50.0**2]]))
    observed = replace(
        sensed(cuts, true + 40.0),
        common=np.zeros((90, 1)),
        shared=(offset,),
        shift=np.ones((90, 1)),
    )
    found = posterior_of_readings(PRIOR, observed)
    place = found.columns(offset.key).start
    sd = np.sqrt(found.state.covariance[place, place])
    assert sd < 25.0
    assert abs(found.state.mean[place] - 40.0) < 3.0 * sd
