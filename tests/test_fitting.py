"""Least squares, posteriors and scores against closed forms."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb import fitting
from autodb.fitting import Gaussian

RNG = np.random.default_rng(11)
X = RNG.normal(size=(200, 3))
TRUE = np.array([2.0, -1.0, 0.5])
Y = X @ TRUE + RNG.normal(0, 0.1, 200)


def test_least_squares_agrees_with_the_normal_equations() -> None:
    fit = fitting.least_squares(X, Y)
    expected = np.linalg.solve(X.T @ X, X.T @ Y)
    assert_allclose(fit.coefficients, expected, rtol=1e-10)
    variance = np.sum((Y - X @ expected) ** 2) / (200 - 3)
    assert_allclose(fit.covariance, variance * np.linalg.inv(X.T @ X), rtol=1e-8)


@pytest.mark.parametrize("n", [4, 200, fitting.BLOCK_ROWS, 3 * fitting.BLOCK_ROWS + 7])
def test_blocks_agree_with_one_factorisation(n: int) -> None:
    rng = np.random.default_rng(n)
    design, values = rng.normal(size=(n, 3)) * [1.0, 1e5, 1e-5], rng.normal(size=n)
    fit = fitting.least_squares(design, values)
    expected, residual, *_ = np.linalg.lstsq(design / [1.0, 1e5, 1e-5], values, rcond=None)
    assert_allclose(fit.coefficients * [1.0, 1e5, 1e-5], expected, rtol=1e-9)
    assert_allclose(fit.residual @ fit.residual, residual[0], rtol=1e-9)


def test_scaling_a_column_scales_its_coefficient_only() -> None:
    scaled = X * [1.0, 1e6, 1e-6]
    fit, plain = fitting.least_squares(scaled, Y), fitting.least_squares(X, Y)
    assert_allclose(fit.coefficients * [1.0, 1e6, 1e-6], plain.coefficients, rtol=1e-9)


def test_undetermined_columns_are_named() -> None:
    doubled = np.column_stack([X[:, 0], X[:, 1], 2.0 * X[:, 1]])
    with pytest.raises(fitting.Undetermined) as caught:
        fitting.least_squares(doubled, Y)
    assert caught.value.columns == [1, 2]
    with pytest.raises(fitting.Undetermined) as caught:
        fitting.least_squares(np.column_stack([X[:, 0], np.zeros(200)]), Y)
    assert caught.value.columns == [1]


def test_newey_west_is_right_where_residuals_are_correlated() -> None:
    """Mean of an AR(1) series, rho 0.8: variance is (1+rho)/(1-rho) = 9 times the naive one.

    Ratio over 40 series; its own scatter is about 3 %, the tolerance 30 % (Bartlett weights lose
    some). The naive covariance would be off by a factor 9.
    """
    rng = np.random.default_rng(5)
    n, rho, ratios = 4000, 0.8, []
    for _ in range(40):
        noise = rng.normal(size=n + 200)
        series = np.zeros(n + 200)
        for i in range(1, n + 200):
            series[i] = rho * series[i - 1] + noise[i]
        ones = np.ones((n, 1))
        corrected = fitting.least_squares(ones, series[200:], lags=60).covariance[0, 0]
        naive = fitting.least_squares(ones, series[200:]).covariance[0, 0]
        ratios.append(corrected / naive)
    assert_allclose(np.mean(ratios), 9.0, rtol=0.3)


def test_posterior_is_the_same_one_by_one_and_at_once() -> None:
    prior = Gaussian(np.zeros(3), np.diag([10.0, 10.0, 10.0]))
    sd = np.full(200, 0.1)
    whole = fitting.update(prior, X, Y, sd)
    step = prior
    for i in range(200):
        step = fitting.update(step, X[i : i + 1], Y[i : i + 1], sd[i : i + 1])
    assert_allclose(step.mean, whole.mean, rtol=1e-7)
    assert_allclose(step.covariance, whole.covariance, rtol=1e-6)


def test_posterior_without_data_is_the_prior() -> None:
    prior = Gaussian(np.array([1.0, 2.0, 3.0]), np.diag([1.0, 2.0, 3.0]))
    after = fitting.update(prior, np.empty((0, 3)), np.empty(0), np.empty(0))
    assert_allclose(after.mean, prior.mean)
    assert_allclose(after.covariance, prior.covariance, rtol=1e-12)


def test_a_group_is_predicted_without_itself() -> None:
    x = np.array([0.0, 1, 2, 3, 10, 11])
    y = np.array([0.0, 1, 2, 3, 0, 0])
    groups = np.array(["a", "a", "b", "b", "c", "c"])
    errors = fitting.leave_group_out(x, y, groups)
    assert_allclose(errors[4:], [-10.0, -11.0], atol=1e-12)


def test_robust_line_ignores_a_few_wild_rows() -> None:
    x = np.linspace(0, 10, 100)
    y = 1.0 + 2.0 * x + np.random.default_rng(0).normal(0, 0.05, 100)
    y[[3, 50, 90]] += 100.0
    assert_allclose(fitting.robust_line(x, y), [1.0, 2.0], atol=0.05)


def test_bootstrap_resamples_groups_and_is_fixed_by_its_seed() -> None:
    groups = np.repeat(np.arange(10), 20)
    errors, y = RNG.normal(0, 1, 200), RNG.normal(0, 3, 200)
    first = fitting.bootstrap_r_squared(errors, y, groups)
    assert first == fitting.bootstrap_r_squared(errors, y, groups)
    assert first[0] < fitting.r_squared(errors, y) < first[1]


def test_r_squared_of_a_target_that_does_not_vary() -> None:
    assert fitting.r_squared(np.zeros(3), np.ones(3)) == float("-inf")
