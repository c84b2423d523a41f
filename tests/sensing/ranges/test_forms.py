"""Forms of current to force: known truth comes back, and the plainest that does it is chosen."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.fitting.linear import Undetermined
from autodb.sensing.ranges.choosing import (
    FOLDS,
    TriedForm,
    assessed,
    best,
    close,
    groups_left_out,
    try_forms,
)
from autodb.sensing.ranges.forms import (
    FEED_FORMS,
    LAWS,
    LINE,
    LINE_OF_SPEED,
    MAGNETISED,
    MAGNETISED_OF_SPEED,
    OF_CURRENT_SPEED,
    POWER,
    POWER_OF_SPEED,
    SPINDLE_FORMS,
    WARMED_LINE,
    WARMED_POWER,
    CurrentForm,
    MeasuredCuts,
)
from autodb.store.models.sensing import CALIBRATION_KINDS

Array = NDArray[np.float64]
N = 120
TRUTH = {
    "line": [30.0, 210.0],
    "line-of-speed": [5.0, 180.0, 22.0],
    "power": [0.4, 0.92, np.log(1570.0)],
    "power-of-speed": [0.4, 0.9, np.log(1400.0), 0.08, 0.9],
    "line-warmed": [15.0, 210.0, 0.002],
    "power-warmed": [0.4, 0.92, np.log(1570.0), 0.002],
    "power-of-speed-warmed": [0.4, 0.9, np.log(1400.0), 0.08, 0.9, 0.002],
    "magnetised": [0.2, 2.0],
    "magnetised-of-speed": [0.2, 1.5, 1.2, np.log(1500.0)],
}


def _sensed(seed: int = 1) -> MeasuredCuts:
    rng = np.random.default_rng(seed)
    rpm = rng.uniform(800.0, 2400.0, N)
    current, feed_mm = rng.uniform(1.0, 20.0, N), rng.uniform(0.1, 0.4, N)
    depth_mm, temperature_C = rng.uniform(0.5, 2.5, N), rng.uniform(22.0, 48.0, N)
    air = 14.0 * np.minimum(1.0, 1500.0 / rpm) + 0.5 * rpm / 1000.0
    feed_mm_s = feed_mm * rpm / 60.0
    return MeasuredCuts(current, feed_mm_s, rpm, feed_mm, depth_mm, temperature_C, air=air)


@pytest.mark.parametrize("form", LAWS, ids=lambda form: form.kind)
def test_known_coefficients_come_back(form: CurrentForm) -> None:
    sensed, truth = _sensed(), np.array(TRUTH[form.kind])
    target = form.value(truth, sensed)
    exact = form.fit(sensed, target).coefficients
    assert_allclose(exact, truth, rtol=1e-4, atol=1e-6)
    noise = 0.02 * float(np.std(target)) * np.random.default_rng(2).standard_normal(N)
    law = form.fit(sensed, target + noise)
    sd = np.sqrt(np.diag(law.covariance))
    assert np.all(np.abs(law.coefficients - truth) < 4.5 * sd)


@pytest.mark.parametrize("form", LAWS, ids=lambda form: form.kind)
def test_slopes_are_derivatives(form: CurrentForm) -> None:
    sensed, truth = _sensed(), np.array(TRUTH[form.kind])
    steps = 1e-6 * np.eye(len(truth))
    numeric = np.array(
        [(form.value(truth + h, sensed) - form.value(truth - h, sensed)) / 2e-6 for h in steps]
    ).T
    assert_allclose(form.slopes(truth, sensed), numeric, rtol=1e-4, atol=1e-5)
    scaled = truth + 1e-6 * form.scaling(truth)
    assert_allclose(
        form.value(scaled, sensed), (1.0 + 1e-6) * form.value(truth, sensed), rtol=1e-10
    )


def test_every_form_can_be_kept() -> None:
    assert {form.kind for form in (*LAWS, OF_CURRENT_SPEED)} == set(CALIBRATION_KINDS)


def test_a_current_that_does_not_rise_tells_no_torque() -> None:
    still = np.ones(4)
    sensed = MeasuredCuts(
        np.array([-1.0, 0.0, 5.0, np.nan]), still, 1000.0 * still, still, still, still
    )
    torque = POWER.value(np.array(TRUTH["power"]), sensed)
    assert torque[:2].tolist() == [0.0, 0.0]
    assert_allclose(torque[2], np.exp(0.4) * 5.0**0.92)
    assert np.isnan(torque[3])
    without = MAGNETISED.value(np.array(TRUTH["magnetised"]), sensed)
    assert np.isnan(without).all()  # no range in air
    beside = MAGNETISED.value(np.array(TRUTH["magnetised"]), replace(sensed, air=10.0 * still))
    assert beside[:2].tolist() == [0.0, 0.0]
    assert np.isnan(beside[3])


def test_what_is_not_known_or_does_not_vary_takes_the_line() -> None:
    sensed = _sensed()
    nothing, same = np.full(N, np.nan), np.full(N, 1000.0)
    for theta in (nothing, np.full(N, 30.0)):
        assert not WARMED_LINE.fits(replace(sensed, temperature_C=theta))
    for rpm in (nothing, same):
        assert not POWER.fits(replace(sensed, speed_rpm=rpm))
        assert not LINE_OF_SPEED.fits(replace(sensed, feed_mm_s=rpm))
        assert LINE.fits(replace(sensed, feed_mm_s=rpm, speed_rpm=rpm))


@pytest.mark.parametrize("stated", [False, True])
def test_a_motors_field_beside_its_load_is_told_from_both_ranges(stated: bool) -> None:
    """118 cuts of an induction motor, 2 % scatter of torque, 0.3 A of each range.

    Truth: range² = a² + ((T + T_air)/k)², a and k below 1500 rpm constant, above as 1500/n. Of
    cuts left out it has 0.85 N·m, a power of the rise 1.31 N·m.
    """
    rng, count = np.random.default_rng(38), 118
    rpm, torque = rng.uniform(400.0, 2400.0, count), rng.uniform(2.0, 60.0, count)
    weak = np.minimum(1.0, 1500.0 / rpm)
    idle = 1.5 + 1.2 * rpm / 1000.0
    cut, air = (
        np.hypot(14.0 * weak, (load + idle) / (1.2 * weak)) + 0.3 * rng.standard_normal(count)
        for load in (torque, np.zeros(count))
    )
    nothing, feed = np.full(count, np.nan), rng.uniform(0.1, 0.4, count)
    sd = np.full(count, 0.3 * np.sqrt(2.0)) if stated else None
    sensed = MeasuredCuts(
        cut - air, feed * rpm / 60.0, rpm, feed, feed, nothing, stated_sd=sd, air=air
    )
    target = torque * (1.0 + 0.02 * rng.standard_normal(count))
    groups = np.arange(count) // 8
    trials = try_forms(SPINDLE_FORMS, sensed, target, groups, folds=FOLDS)
    assert best(trials, groups).form is MAGNETISED_OF_SPEED
    rmse = {one.form.kind: one.rmse for one in trials}
    assert rmse["magnetised-of-speed"] < 0.7 * min(rmse["power"], rmse["power-of-speed"])
    law = MAGNETISED_OF_SPEED.fit(sensed, target)
    off = law.coefficients - [np.log(1.2), 1.5, 1.2, np.log(1500.0)]
    assert np.all(np.abs(off) < 4.0 * np.sqrt(np.diag(law.covariance)))


def test_five_torques_hold_no_power_law() -> None:
    sensed = _sensed()
    torque = np.where(np.arange(N) < 5, 1.5 * sensed.current**0.9, -1.0)
    with pytest.raises(Undetermined):
        POWER.fit(sensed, torque)


@pytest.mark.parametrize(
    ("truth", "forms"),
    [
        (LINE, FEED_FORMS),
        (LINE_OF_SPEED, FEED_FORMS),
        (POWER_OF_SPEED, SPINDLE_FORMS),
        (WARMED_POWER, SPINDLE_FORMS),
    ],
    ids=["line", "line of speed", "power of speed", "warmed power"],
)
def test_the_true_form_is_chosen_and_errors_left_out_are_those_of_the_noise(
    truth: CurrentForm, forms: tuple[CurrentForm, ...]
) -> None:
    sensed = _sensed(3)
    target = truth.value(np.array(TRUTH[truth.kind]), sensed)
    noise = 0.02 * float(np.std(target))
    groups = np.repeat(np.arange(20), 6)
    target = target + noise * np.random.default_rng(4).standard_normal(N)
    trials = try_forms(forms, sensed, target, groups, folds=FOLDS)
    assert best(trials, groups).form is truth
    errors = assessed(trials, groups)
    assert 0.8 * noise < float(np.sqrt(np.mean(errors**2))) < 1.3 * noise
    if truth is not LINE:
        worse = groups_left_out(LINE, sensed, target, groups, folds=20)
        assert np.mean(worse**2) > 2.0 * np.mean(errors**2)


@pytest.mark.parametrize(
    ("better", "said"), [(0.7, [LINE_OF_SPEED]), (1.3, [LINE]), (3.0, []), (0.0, [])]
)
def test_a_choice_near_its_margin_is_said(better: float, said: list[CurrentForm]) -> None:
    """A richer form has to be better by one standard error over groups."""
    groups = np.arange(100)
    gain = np.random.default_rng(5).standard_normal(100)
    gain = (gain - gain.mean()) / gain.std(ddof=1) + 0.1 * better  # of the mean: so many errors
    plain = TriedForm(LINE, np.full(100, 10.0))
    richer = TriedForm(LINE_OF_SPEED, np.sqrt(100.0 - gain))
    assert best([plain, richer], groups).form is (LINE_OF_SPEED if better > 1.0 else LINE)
    assert close([plain, richer], groups) == said
