"""The passive force from a turned part: beams, known forces, and where nothing is determined."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.sensing.ranges.inspection import (
    MeasuredPart,
    RoundBar,
    between_centres,
    held_in_a_chuck,
    passive_force,
)

Array = NDArray[np.float64]

STEEL = RoundBar(diameter_mm=25.0, length_mm=150.0, modulus_MPa=210_000.0)
PLACES = np.linspace(20.0, 145.0, 8)
NOISE_MM, SHARE = 0.004, 0.05


def _bent_mm(bar: RoundBar, at_mm: float, moment_N_mm: Array, x: Array, *, centres: bool) -> float:
    """Integrate M/(E I) twice along the bar; 0 at both centres, or with its slope at the jaws."""
    slope = np.concatenate([[0.0], np.cumsum(0.5 * (moment_N_mm[1:] + moment_N_mm[:-1]))])
    slope *= (x[1] - x[0]) / bar.bending_N_mm2
    way = np.concatenate([[0.0], np.cumsum(0.5 * (slope[1:] + slope[:-1]))]) * (x[1] - x[0])
    if centres:
        way -= way[-1] * x / x[-1]
    return float(np.interp(at_mm, x, way))


@pytest.mark.parametrize("at_mm", [30.0, 80.0, 140.0])
def test_compliances_are_those_of_bent_beams(at_mm: float) -> None:
    x = np.linspace(0.0, STEEL.length_mm, 4001)
    lever = np.maximum(at_mm - x, 0.0)
    chuck = _bent_mm(STEEL, at_mm, lever, x, centres=False)
    assert_allclose(held_in_a_chuck(STEEL, np.array([at_mm])), chuck, rtol=1e-4)
    share = at_mm / STEEL.length_mm
    moment = -np.where(x < at_mm, (1.0 - share) * x, share * (STEEL.length_mm - x))
    centres = _bent_mm(STEEL, at_mm, moment, x, centres=True)
    assert_allclose(between_centres(STEEL, np.array([at_mm])), centres, rtol=1e-4)


def _measured(seed: int, force_N: float) -> MeasuredPart:
    """Draw a part: what the force left, a setting that is off, noise, a modulus that is off."""
    rng = np.random.default_rng([seed, 40])
    nominal = held_in_a_chuck(STEEL, PLACES) + 2e-5
    true = nominal * (1.0 + SHARE * rng.standard_normal())
    off_mm = 0.02 * rng.standard_normal()
    error = 2.0 * (force_N * true + off_mm) + NOISE_MM * rng.standard_normal(len(PLACES))
    return MeasuredPart(error, nominal, SHARE, NOISE_MM)


def test_known_forces_come_back_within_their_intervals() -> None:
    """Of 1000 parts 925 to 973 hold: all but 1 in 1000 of what 95 % intervals do (binomial)."""
    rng = np.random.default_rng(41)
    held = 0
    for seed in range(1000):
        force_N = float(rng.uniform(100.0, 400.0))
        found = passive_force(_measured(seed, force_N), range_N=600.0)
        held += abs(found.force_N - force_N) <= 1.96 * found.sd_N
    assert 925 <= held <= 973


def test_force_without_noise_is_exact_whatever_the_setting() -> None:
    compliance = between_centres(STEEL, PLACES)
    error = 2.0 * (250.0 * compliance - 0.03)
    found = passive_force(MeasuredPart(error, compliance, 0.0, 1e-6), range_N=500.0)
    assert_allclose((found.force_N, found.off_mm), (250.0, -0.03), rtol=1e-6)
    twice = passive_force(MeasuredPart(2.0 * error, compliance, 0.0, 1e-6), range_N=900.0)
    assert_allclose(twice.force_N, 2.0 * found.force_N, rtol=1e-9)


def test_a_known_setting_tells_more() -> None:
    loose, tight = (
        passive_force(replace(_measured(3, 200.0), share=0.0, setting_mm=mm), range_N=600.0)
        for mm in (np.inf, 0.001)
    )
    assert tight.sd_N < 0.98 * loose.sd_N


def test_where_nothing_is_determined_it_is_not_sensed_and_says_why() -> None:
    stiff = RoundBar(diameter_mm=80.0, length_mm=150.0, modulus_MPa=210_000.0)
    hardly = MeasuredPart(np.zeros(8), held_in_a_chuck(stiff, PLACES), SHARE, NOISE_MM)
    found = passive_force(hardly, range_N=400.0)
    assert np.isnan(found.force_N)
    assert "interval is" in str(found.why_not)
    alike = MeasuredPart(np.zeros(8), np.full(8, 1e-4), SHARE, NOISE_MM)
    assert "the setting is unknown" in str(passive_force(alike, range_N=400.0).why_not)


def test_what_cannot_be_used_is_refused() -> None:
    with pytest.raises(UnusableInput, match="2 measured diameters are too few; measure 3 places"):
        passive_force(MeasuredPart(np.zeros(2), np.ones(2), 0.0, 0.01), range_N=1.0)
    with pytest.raises(UnusableInput, match="no finite number"):
        passive_force(
            MeasuredPart(np.array([0.0, np.nan, 0.0]), np.ones(3), 0.0, 0.01), range_N=1.0
        )
