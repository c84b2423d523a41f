"""Least squares, posteriors and scores against closed forms."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy import signal
from scipy.stats import chi2

from autodb.fitting import deviation, optimum
from autodb.fitting.covariance import bartlett, given_one
from autodb.fitting.deviation import least_squares_with_deviation
from autodb.fitting.gaussian import Gaussian, posterior_after
from autodb.fitting.linear import (
    BLOCK_ROWS,
    CoefficientBounds,
    Undetermined,
    least_squares,
    orthonormal_basis,
    robust_least_squares,
    spanning,
)
from autodb.fitting.projection import ProjectionProblem, separable
from autodb.fitting.scores import (
    bootstrap_r_squared,
    leave_group_out,
    leave_one_out,
    r_squared,
    robust_line,
)
from tests.helpers.campaigns import first

Array = NDArray[np.float64]
RNG = np.random.default_rng(11)
X = RNG.normal(size=(200, 3))
TRUE = np.array([2.0, -1.0, 0.5])
Y = X @ TRUE + RNG.normal(0, 0.1, 200)


def test_least_squares_agrees_with_the_normal_equations() -> None:
    fit = least_squares(X, Y)
    expected = np.linalg.solve(X.T @ X, X.T @ Y)
    assert_allclose(fit.coefficients, expected, rtol=1e-10)
    variance = np.sum((Y - X @ expected) ** 2) / (200 - 3)
    assert_allclose(fit.covariance, variance * np.linalg.inv(X.T @ X), rtol=1e-8)


@pytest.mark.parametrize("n", [4, 200, BLOCK_ROWS, 3 * BLOCK_ROWS + 7])
def test_blocks_agree_with_one_factorisation(n: int) -> None:
    rng = np.random.default_rng(n)
    design, values = rng.normal(size=(n, 3)) * [1.0, 1e5, 1e-5], rng.normal(size=n)
    fit = least_squares(design, values)
    expected, residual, *_ = np.linalg.lstsq(design / [1.0, 1e5, 1e-5], values, rcond=None)
    assert_allclose(fit.coefficients * [1.0, 1e5, 1e-5], expected, rtol=1e-9)
    assert_allclose(fit.residual @ fit.residual, residual[0], rtol=1e-9)


def test_scaling_a_column_scales_its_coefficient_only() -> None:
    scaled = X * [1.0, 1e6, 1e-6]
    fit, plain = least_squares(scaled, Y), least_squares(X, Y)
    assert_allclose(fit.coefficients * [1.0, 1e6, 1e-6], plain.coefficients, rtol=1e-9)


def test_undetermined_columns_are_named() -> None:
    doubled = np.column_stack([X[:, 0], X[:, 1], 2.0 * X[:, 1]])
    with pytest.raises(Undetermined) as caught:
        least_squares(doubled, Y)
    assert caught.value.columns == [1, 2]
    with pytest.raises(Undetermined) as caught:
        least_squares(np.column_stack([X[:, 0], np.zeros(200)]), Y)
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
        corrected = least_squares(ones, series[200:], lags=60).covariance[0, 0]
        naive = least_squares(ones, series[200:]).covariance[0, 0]
        ratios.append(corrected / naive)
    assert_allclose(np.mean(ratios), 9.0, rtol=0.3)


def test_posterior_is_the_same_one_by_one_and_at_once() -> None:
    prior = Gaussian(np.zeros(3), np.diag([10.0, 10.0, 10.0]))
    sd = np.full(200, 0.1)
    whole = posterior_after(prior, X, Y, sd)
    step = prior
    for i in range(200):
        step = posterior_after(step, X[i : i + 1], Y[i : i + 1], sd[i : i + 1])
    assert_allclose(step.mean, whole.mean, rtol=1e-7)
    assert_allclose(step.covariance, whole.covariance, rtol=1e-6)


def test_posterior_without_data_is_the_prior() -> None:
    prior = Gaussian(np.array([1.0, 2.0, 3.0]), np.diag([1.0, 2.0, 3.0]))
    after = posterior_after(prior, np.empty((0, 3)), np.empty(0), np.empty(0))
    assert_allclose(after.mean, prior.mean)
    assert_allclose(after.covariance, prior.covariance, rtol=1e-12)


def test_a_group_is_predicted_without_itself() -> None:
    x = np.array([0.0, 1, 2, 3, 10, 11])
    y = np.array([0.0, 1, 2, 3, 0, 0])
    groups = np.array(["a", "a", "b", "b", "c", "c"])
    errors = leave_group_out(x, y, groups)
    assert_allclose(errors[4:], [-10.0, -11.0], atol=1e-12)


def test_robust_line_ignores_a_few_wild_rows() -> None:
    x = np.linspace(0, 10, 100)
    y = 1.0 + 2.0 * x + np.random.default_rng(0).normal(0, 0.05, 100)
    y[[3, 50, 90]] += 100.0
    assert_allclose(robust_line(x, y), [1.0, 2.0], atol=0.05)


def test_bootstrap_resamples_groups_and_is_fixed_by_its_seed() -> None:
    groups = np.repeat(np.arange(10), 20)
    errors, y = RNG.normal(0, 1, 200), RNG.normal(0, 3, 200)
    first = bootstrap_r_squared(errors, y, groups)
    assert first == bootstrap_r_squared(errors, y, groups)
    assert first[0] < r_squared(errors, y) < first[1]


def test_r_squared_of_a_target_that_does_not_vary() -> None:
    assert r_squared(np.zeros(3), np.ones(3)) == float("-inf")


def test_newey_west_is_the_textbook_sum_at_any_lag() -> None:
    rng = np.random.default_rng(3)
    design, residual = rng.normal(size=(300, 2)), rng.normal(size=300)
    scores = design * residual[:, None]
    for lags in (0, 1, 7, 299, 500):
        total = scores.T @ scores
        for lag in range(1, min(lags, 299) + 1):
            cross = scores[lag:].T @ scores[:-lag]
            total = total + (1.0 - lag / (lags + 1.0)) * (cross + cross.T)
        assert_allclose(bartlett(design, residual, lags), total, rtol=1e-10)


def test_newey_west_does_not_depend_on_how_the_rows_are_cut(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rng = np.random.default_rng(4)
    design, residual = rng.normal(size=(1000, 3)), rng.normal(size=1000)
    whole = bartlett(design, residual, 40)
    monkeypatch.setattr("autodb.fitting.covariance.CHUNK_ROWS", 64)
    assert_allclose(bartlett(design, residual, 40), whole, rtol=1e-10)


def test_weights_are_inverse_variances() -> None:
    weights = np.where(np.arange(200) < 100, 4.0, 1.0)
    fit = least_squares(X, Y, weights=weights)
    twice = np.vstack([np.repeat(X[:100], 4, axis=0), X[100:]])
    repeated = least_squares(twice, np.concatenate([np.repeat(Y[:100], 4), Y[100:]]))
    assert_allclose(fit.coefficients, repeated.coefficients, rtol=1e-10)


def test_a_bound_holds_and_the_others_are_fitted_given_it() -> None:
    bounds = CoefficientBounds(np.array([-np.inf, -0.5, -np.inf]), np.full(3, np.inf))
    fit = least_squares(X, Y, bounds=bounds)
    assert fit.at_bound == (1,)
    assert_allclose(fit.coefficients[1], -0.5)
    rest = least_squares(X[:, [0, 2]], Y + 0.5 * X[:, 1])
    assert_allclose(fit.coefficients[[0, 2]], rest.coefficients, rtol=1e-9)
    assert_allclose(fit.sd[[0, 2]], rest.sd, rtol=1e-9)
    assert fit.sd[1] == 0.0


def test_bounds_that_do_not_bind_change_nothing() -> None:
    bounds = CoefficientBounds(np.full(3, -10.0), np.full(3, 10.0))
    assert_allclose(
        least_squares(X, Y, bounds=bounds).coefficients,
        least_squares(X, Y).coefficients,
        rtol=1e-12,
    )


def test_robust_loss_bears_a_tenth_of_wild_rows() -> None:
    wild = Y.copy()
    wild[::10] += 50.0
    assert np.max(np.abs(least_squares(X, wild).coefficients - TRUE)) > 0.3
    robust = robust_least_squares(X, wild)
    assert_allclose(robust.coefficients, TRUE, atol=0.06)


def test_spanning_columns_leave_out_what_the_others_say() -> None:
    doubled = np.column_stack([X[:, 0], X[:, 1], 2.0 * X[:, 1], X[:, 0] - X[:, 1], X[:, 2]])
    kept = spanning(doubled)
    assert len(kept) == 3
    assert 4 in kept
    assert np.linalg.matrix_rank(doubled[:, kept]) == 3


def test_an_orthonormal_basis_spans_columns_of_any_size_and_leaves_out_what_is_no_direction() -> (
    None
):
    rng = np.random.default_rng(4)
    free = rng.normal(size=(50, 3)) * np.array([1e-7, 1.0, 1e8])
    columns = np.column_stack([free, free[:, 1] + free[:, 2] / 1e8, np.zeros(50)])
    basis = orthonormal_basis(columns, least=1e-9)
    assert basis.shape == (50, 3)
    assert_allclose(basis.T @ basis, np.eye(3), atol=1e-12)
    assert_allclose(basis @ (basis.T @ columns), columns, rtol=1e-7, atol=1e-14)
    assert orthonormal_basis(np.empty((50, 0)), least=1e-9).shape == (50, 0)


def test_held_out_errors_come_from_fits_without_the_block_and_its_gap() -> None:
    blocks = np.arange(200) // 20
    values = Y.copy()
    values[25] += 1000.0  # fold 1 is left out with its own outlier; the gap keeps row 40 free of it
    errors = leave_one_out(X, values, blocks, gap=5)
    near = np.zeros(200, dtype=bool)
    for row in np.flatnonzero(blocks % 5 == 1):
        near[max(0, row - 5) : row + 6] = True
    expected = np.linalg.lstsq(X[~near], values[~near], rcond=None)[0]
    test = blocks % 5 == 1
    assert_allclose(errors[test], values[test] - X[test] @ expected, rtol=1e-9)


def test_a_gap_as_long_as_the_rows_leaves_none_to_fit_on() -> None:
    """Few rows with gaps between them: noise is correlated over all of them."""
    errors = leave_one_out(X[:50], Y[:50], np.arange(50) // 10, gap=31)
    assert_allclose(errors[20:30], Y[20:30])


def _deviating(seed: int, *, rho: float, law: float) -> tuple[float, float]:
    """Return (error in sd, sd) of a slope beside a curve that the law y = a + b·z does not know."""
    rng = np.random.default_rng(seed)
    n = 1500
    z, x = rng.uniform(0, 1, n), rng.normal(size=n)
    order = 6
    bumps = np.column_stack([np.cos(np.pi * k * z) for k in range(1, order)])
    noise = signal.lfilter([1.0], [1.0, -rho], rng.normal(0, 0.1, n))
    values = 1.0 + 0.5 * x + law * np.sqrt(z + 0.01) + noise
    fit = least_squares_with_deviation(
        np.column_stack([np.ones(n), x]), [bumps], values, blocks=np.arange(n) // 100, order=2
    )
    sd = float(np.sqrt(fit.covariance[1, 1]))
    return (float(fit.coefficients[1]) - 0.5) / sd, sd


@pytest.mark.parametrize(("rho", "law"), first(1, [(0.9, 2.0), (0.0, 2.0), (0.0, 0.0)]))
def test_intervals_hold_where_the_law_deviates_and_noise_is_coloured(
    rho: float, law: float
) -> None:
    """Of 100 intervals of 95 % at least 87 hold: fewer come by chance once in a thousand."""
    z = np.array([_deviating(seed, rho=rho, law=law)[0] for seed in range(100)])
    assert np.sum(np.abs(z) <= 1.96) >= 87
    assert 0.7 < np.std(z) < 1.4


def test_a_law_without_deviation_costs_nothing() -> None:
    """With a true law the sd is that of ordinary least squares within 10 %."""
    plain = 0.1 / np.sqrt(1500)
    sd = np.median([_deviating(seed, rho=0.0, law=0.0)[1] for seed in range(9)])
    assert_allclose(sd, plain, rtol=0.1)


def test_blocks_that_differ_widen_the_covariance() -> None:
    """A slope that changes from block to block is known as well as its mean over blocks is."""
    rng = np.random.default_rng(8)
    n, blocks = 2000, np.arange(2000) // 100
    x = rng.normal(size=n)
    slopes = 1.0 + rng.normal(0, 0.5, 20)
    values = slopes[blocks] * x + rng.normal(0, 0.1, n)
    fit = least_squares_with_deviation(x[:, None], [], values, blocks=blocks, order=2)
    assert_allclose(np.sqrt(fit.covariance[0, 0]), 0.5 / np.sqrt(20), rtol=0.5)


def test_variable_projection_keeps_bounds_and_priors() -> None:
    x = np.linspace(0.0, 5.0, 200)
    values = 3.0 * np.exp(-x / 1.5) + np.random.default_rng(2).normal(0, 0.05, 200)

    def design(shape: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(np.exp(-x / shape[0])[:, None], dtype=np.float64)

    def problem(low: float, high: float, prior: Gaussian | None = None) -> ProjectionProblem:
        limits = CoefficientBounds(np.array([low]), np.array([high]))
        return ProjectionProblem(
            design, values, np.array([1e-3]), limits, prior=prior, noise=0.05**2
        )

    start = np.array([3.0])
    assert_allclose(separable(problem(0.1, 10.0), start).shape, 1.5, rtol=0.05)
    bounded = separable(problem(2.0, 10.0), start)
    assert_allclose(bounded.shape, 2.0)
    assert bounded.held == (1,)
    sure = Gaussian(np.array([0.0, 2.5]), np.diag([1e6, 1e-8]))
    assert_allclose(separable(problem(0.1, 10.0, sure), start).shape, 2.5, rtol=0.01)


def test_covariance_given_one_parameter_is_that_of_the_others_information() -> None:
    root = np.random.default_rng(4).standard_normal((4, 4))
    covariance = root @ root.T + np.eye(4)
    given = given_one(covariance, 1)
    others = [0, 2, 3]
    information = np.linalg.inv(covariance)[np.ix_(others, others)]
    assert_allclose(given[np.ix_(others, others)], np.linalg.inv(information), rtol=1e-10)
    assert_allclose(given[1], 0.0)


def test_what_the_law_follows_nearly_does_not_tell_how_large_deviations_are() -> None:
    """A slope of each run adds up to the law's, but for 0.01 % in rows in which something stands.

    It was taken for a deviation of 12 700 times the slope, between - 22 000 and - 3500 for one of
    2.
    """
    runs = np.repeat(np.arange(12), 250)
    speed = np.tile(np.sin(np.linspace(0.0, np.pi, 250)), 12)
    stands = np.arange(len(runs)) % 125 == 0
    own = speed[:, None] * (runs[:, None] == np.arange(12)) + 1e-4 / 12 * stands[:, None]
    noise = 0.05 * np.random.default_rng(1).standard_normal(len(runs))
    values = 2.0 * speed + 3.0 * stands + noise
    fit = least_squares_with_deviation(speed[:, None], [own], values, blocks=runs, order=2)
    assert_allclose(fit.coefficients, 2.0, atol=0.05)
    assert fit.covariance[0, 0] < 0.05**2


def test_standard_deviations_widen_without_a_step() -> None:
    freedom = 20
    limit = chi2.ppf(deviation.SURE, freedom) / freedom
    ratio = np.concatenate([[0.01, 1.0], np.linspace(1.0, 20.0, 20_001), [limit]])
    widened = deviation._widened(ratio, freedom)
    assert_allclose(widened[:2], 1.0)
    assert np.all(np.diff(widened[1:-1]) >= 0.0)
    assert np.max(np.diff(widened[1:-1])) < 0.002
    assert_allclose(widened[-1] ** 2, 0.5 * (1.0 + limit))
    assert_allclose(widened[-2] ** 2, 20.0, rtol=1e-6)


def test_a_climb_ends_where_rounding_hides_the_rest_of_it() -> None:
    """A height that came out too low by 2e-8 is nothing to stay at, 1e-4 standard errors off."""
    curvature, wanted = np.array([[90.0, 5.0], [5.0, 16.0]]), np.array([1.0, 0.3])
    near = wanted + np.array([1e-5, 2e-5])

    def misfit(at: Array) -> tuple[float, Array]:
        slope = curvature @ (at - wanted)
        return float(0.5 * (at - wanted) @ slope) - 2e-8 * np.array_equal(at, near), slope

    assert_allclose(optimum._ended(misfit, near), wanted, rtol=0.0, atol=1e-12)
