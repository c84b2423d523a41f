"""A Sugeno system as a form of calibration: it recovers, comes back from its JSON, and widens."""

import json
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.fitting import anfis
from autodb.fitting.linear import Undetermined
from autodb.sensing.ranges.choosing import best, try_forms
from autodb.sensing.ranges.forms import (
    FEED_FORMS,
    OF_CURRENT,
    OF_CURRENT_FEED,
    CurrentForm,
    FittedForm,
    MeasuredCuts,
    stored_form,
)

Array = NDArray[np.float64]
N = 160
NOISE_N = 8.0


def _sensed(seed: int, n: int = N) -> MeasuredCuts:
    rng = np.random.default_rng([seed, 0])
    rpm, feed_mm = rng.uniform(800.0, 2400.0, n), rng.uniform(0.1, 0.4, n)
    current, depth_mm = rng.uniform(0.5, 6.0, n), rng.uniform(0.5, 2.5, n)
    return MeasuredCuts(current, feed_mm * rpm / 60.0, rpm, feed_mm, depth_mm, np.full(n, np.nan))


def _force_N(sensed: MeasuredCuts) -> Array:
    """A screw that grips: the slope doubles around 3 A, which no line follows."""
    bent = 100.0 * np.log1p(np.exp(2.0 * (sensed.current - 3.0)))
    return np.asarray(100.0 * sensed.current + bent)


def _fitted(seed: int, form: CurrentForm = OF_CURRENT) -> tuple[MeasuredCuts, FittedForm]:
    sensed = _sensed(seed)
    noise_N = NOISE_N * np.random.default_rng([seed, 1]).standard_normal(N)
    return sensed, form.fit(sensed, _force_N(sensed) + noise_N)


def test_a_bend_is_followed_within_the_noise_on_other_cuts() -> None:
    _, law = _fitted(1)
    other = _sensed(2, 400)
    error = law.form.value(law.coefficients, other) - _force_N(other)
    assert float(np.sqrt(np.mean(error**2))) < 0.5 * NOISE_N


def test_its_covariance_says_how_far_off_it_is() -> None:
    """n = 60 fits; the rms of (estimate − truth)/sd over them, each at 50 cuts."""
    other = _sensed(3, 50)
    z = []
    for seed in range(60):
        _, law = _fitted(100 + seed)
        slopes = law.form.slopes(law.coefficients, other)
        sd = np.sqrt(np.einsum("ij,jk,ik->i", slopes, law.covariance, slopes))
        z.append((law.form.value(law.coefficients, other) - _force_N(other)) / sd)
    assert 0.7 < float(np.sqrt(np.mean(np.square(z)))) < 1.5


@pytest.mark.parametrize("form", [OF_CURRENT, OF_CURRENT_FEED], ids=lambda form: form.label)
def test_it_comes_back_from_what_is_kept(form: CurrentForm) -> None:
    sensed, law = _fitted(4, form)
    back = stored_form("anfis", json.loads(json.dumps(law.form.parameters())))
    assert_allclose(
        back.value(law.coefficients, sensed), law.form.value(law.coefficients, sensed), rtol=1e-12
    )
    assert back.label == form.label


def test_slopes_and_scaling_are_those_of_the_value() -> None:
    sensed, law = _fitted(5, OF_CURRENT_FEED)
    value = law.form.value(law.coefficients, sensed)
    step = 1e-3 * np.random.default_rng(6).standard_normal(len(law.coefficients))
    moved = law.form.value(law.coefficients + step, sensed)
    assert_allclose(
        moved - value, law.form.slopes(law.coefficients, sensed) @ step, rtol=1e-8, atol=1e-8
    )
    scaled = law.coefficients + 0.04 * law.form.scaling(law.coefficients)
    assert_allclose(law.form.value(scaled, sensed), 1.04 * value, rtol=1e-10)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_more_load_is_never_less_force(sign: float) -> None:
    """Cuts that seem to fall beyond 4 A, in both directions; without the rule the output does."""
    sensed, rng = _sensed(12), np.random.default_rng(13)
    seeming = 100.0 * sensed.current - 150.0 * np.maximum(sensed.current - 4.0, 0.0)
    target = sign * (seeming + NOISE_N * rng.standard_normal(N))
    law = OF_CURRENT.fit(sensed, target)
    ordered = sensed.at(np.argsort(sensed.current))
    assert np.all(sign * np.diff(law.form.value(law.coefficients, ordered)) >= -1e-6)
    free = anfis.fit_anfis(sensed.current[:, None], target, [anfis.premise_grid((2,))])
    falls = sign * np.diff(anfis.evaluate(free, ordered.current[:, None]))
    assert np.min(falls) < -0.1


def test_outside_the_box_it_widens_and_inside_it_does_not() -> None:
    sensed, law = _fitted(7)
    assert not law.form.beyond(sensed).any()
    far = replace(sensed, current=sensed.current + 8.0)
    assert np.all(law.form.beyond(far) > np.std(_force_N(sensed)))


def test_few_cuts_or_unknown_feed_are_no_ground_for_rules() -> None:
    assert not OF_CURRENT.fits(_sensed(8, 29))
    assert OF_CURRENT.fits(_sensed(8, 30))
    assert not OF_CURRENT_FEED.fits(_sensed(8, 71))
    assert OF_CURRENT_FEED.fits(_sensed(8, 72))
    assert not OF_CURRENT_FEED.fits(replace(_sensed(8), feed_mm_s=np.full(N, np.nan)))


def test_nothing_is_sensed_before_it_has_learned() -> None:
    with pytest.raises(Undetermined):
        OF_CURRENT.value(np.zeros(4), _sensed(9))


def test_rules_win_where_the_current_bends_and_lose_where_it_does_not() -> None:
    sensed, groups = _sensed(10), np.repeat(np.arange(20), 8)
    noise_N = NOISE_N * np.random.default_rng(11).standard_normal(N)
    for force_N, wanted in (
        (_force_N(sensed), OF_CURRENT),
        (100.0 * sensed.current, FEED_FORMS[0]),
    ):
        trials = try_forms(FEED_FORMS, sensed, force_N + noise_N, groups, folds=10)
        assert {trial.form.label for trial in trials} == {
            form.label for form in FEED_FORMS if form.fits(sensed)
        }
        assert best(trials, groups).form is wanted
