"""The score of intervals against closed forms."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.proofs.machines.axis.axes import axis_columns, draw_run
from autodb.proofs.machines.axis.quantities import quantities
from autodb.proofs.runs import score
from autodb.proofs.runs.oracle import oracle
from autodb.proofs.runs.score import Judged, Z, scored_quantities


def _normal(runs: int, *, factor: float, bias: float = 0.0, seed: int = 5) -> list[Judged]:
    """Intervals of a standard normal estimate of 0: ``factor`` x as wide as right, shifted."""
    values = np.random.default_rng(seed).standard_normal(runs)
    return [
        Judged("a", "N", 0.0, v + bias, v + bias - factor * Z, v + bias + factor * Z, v - Z, v + Z)
        for v in values.tolist()
    ]


def test_exact_interval_of_a_share() -> None:
    # Clopper, Pearson: closed form where none or all were held
    assert_allclose(score.exact_interval(0, 20), (0.0, 1.0 - 0.025 ** (1 / 20)))
    assert_allclose(score.exact_interval(20, 20), (0.025 ** (1 / 20), 1.0))
    # 8 of 10: tabulated as 0.4439 to 0.9748
    assert_allclose(score.exact_interval(8, 10), (0.4439, 0.9748), atol=5e-5)


def test_binomial_band_holds_what_it_says() -> None:
    low, high = score.binomial_band(40)
    held = np.random.default_rng(2).binomial(40, 0.95, 200_000) / 40
    assert np.mean((held < low) | (held > high)) < 0.001
    assert low == 32 / 40
    assert high == 1.0
    assert score.coverage_limits(1999) == score.binomial_band(1999)
    assert score.coverage_limits(2000) == (0.93, 0.97)


def test_interval_score_of_known_cases() -> None:
    low, high = np.array([1.0, 1.0, 1.0]), np.array([3.0, 3.0, 3.0])
    found = score.interval_score(low, high, np.array([2.0, 0.5, 3.1]))
    assert_allclose(found, [2.0, 2.0 + 40.0 * 0.5, 2.0 + 40.0 * 0.1])


def test_interval_score_of_a_normal_estimate() -> None:
    # E = 2 z sd + (2/alpha) 2 sd (phi(z) - z (1 - Phi(z))), with 1 - Phi(z) = 0.025
    values = np.random.default_rng(3).standard_normal(200_000)
    found = np.mean(score.interval_score(values - Z, values + Z, np.zeros_like(values)))
    density = np.exp(-0.5 * Z**2) / np.sqrt(2.0 * np.pi)
    assert_allclose(found, 2.0 * Z + 80.0 * (density - Z * 0.025), rtol=0.005)


def test_right_intervals_pass() -> None:
    for runs in (40, 4000):
        row, pooled = scored_quantities(_normal(runs, factor=1.0), runs=runs)
        assert row.passed
        assert pooled.passed
        assert row.share == row.oracle_share
        for found, expected in (
            (row.score_ratio, 1.0),
            (row.width_ratio, 1.0),
            (row.width, 2.0 * Z),
        ):
            assert found is not None
            assert_allclose(found, expected)
        assert row.share_low < 0.95 < row.share_high


@pytest.mark.parametrize(("factor", "bias"), [(0.5, 0.0), (1.6, 0.0), (1.0, 1.0)])
def test_narrow_wide_and_shifted_intervals_fail(factor: float, bias: float) -> None:
    row, pooled = scored_quantities(_normal(4000, factor=factor, bias=bias), runs=4000)
    assert not row.passed
    assert not pooled.passed
    if factor == 0.5:
        assert_allclose(row.share, 0.673, atol=0.03)  # Phi(0.98) - Phi(-0.98)


def test_an_interval_that_is_not_given_does_not_hold() -> None:
    right = _normal(4000, factor=1.0)
    half = [
        Judged(o.name, o.unit, o.truth, None, None, None, o.oracle_low, o.oracle_high)
        if i % 2
        else o
        for i, o in enumerate(right)
    ]
    row, _ = scored_quantities(half, runs=4000)
    assert row.given == 0.5
    assert 0.45 < row.share < 0.5
    assert not row.passed
    never, _ = scored_quantities(half[1::2], runs=2000)
    assert never.score_ratio is None
    assert not never.passed


def test_quantities_of_one_run_count_once() -> None:
    same = _normal(100, factor=1.0)
    other = [Judged("b", "N", *(vars(o)[k] for k in list(vars(o))[2:])) for o in same]
    *_, pooled = scored_quantities([*same, *other], runs=100)
    assert pooled.limits == score.binomial_band(100)
    one, _ = scored_quantities(same, runs=100)
    assert (pooled.share, pooled.share_low) == (one.share, one.share_low)


def test_the_oracle_knows_its_own_uncertainty() -> None:
    held, asked = 0, 0
    for seed in range(201, 221):
        run = draw_run(seed)
        motion = run.motion
        own = axis_columns(run.axis, x_mm=motion.x, v_mm_s=motion.v, a_mm_s2=motion.a)
        truth = np.array([column.coefficient for column in own])
        found = oracle(run)
        z = (found.coefficients - truth) / np.sqrt(np.diag(found.covariance))
        assert np.max(np.abs(z)) < 5.0
        for quantity in quantities(run.axis, motion):
            low, high = found.interval(quantity)
            held, asked = held + (low <= quantity.truth <= high), asked + 1
    assert 0.88 < held / asked < 0.99  # 20 runs of some 13 dependent quantities each
