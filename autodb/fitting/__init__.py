"""Least squares with honest uncertainty: rank, bounds, priors, covariances, held-out scores."""

from autodb.fitting.covariance import autoregression, given_one, long_run_variance
from autodb.fitting.deviation import Deviating, least_squares_with_deviation
from autodb.fitting.gaussian import NORMAL_95, Gaussian, posterior_after, root_of
from autodb.fitting.groups import Components, components, small_sample
from autodb.fitting.linear import (
    BLOCK_ROWS,
    CoefficientBounds,
    LinearFit,
    Undetermined,
    check_rank,
    least_squares,
    orthonormal_basis,
    robust_least_squares,
    solve,
    spanning,
    spread,
    triangle,
)
from autodb.fitting.projection import (
    Design,
    NotConverged,
    ProjectionProblem,
    Separable,
    best_start,
    separable,
    shape_slopes,
)
from autodb.fitting.rounds import NotSettled, stationary
from autodb.fitting.scores import (
    bootstrap_r_squared,
    leave_group_out,
    leave_one_out,
    r_squared,
    robust_line,
    straight_line,
)

__all__ = [
    "BLOCK_ROWS",
    "NORMAL_95",
    "CoefficientBounds",
    "Components",
    "Design",
    "Deviating",
    "Gaussian",
    "LinearFit",
    "NotConverged",
    "NotSettled",
    "ProjectionProblem",
    "Separable",
    "Undetermined",
    "autoregression",
    "best_start",
    "bootstrap_r_squared",
    "check_rank",
    "components",
    "given_one",
    "least_squares",
    "least_squares_with_deviation",
    "leave_group_out",
    "leave_one_out",
    "long_run_variance",
    "orthonormal_basis",
    "posterior_after",
    "r_squared",
    "robust_least_squares",
    "robust_line",
    "root_of",
    "separable",
    "shape_slopes",
    "small_sample",
    "solve",
    "spanning",
    "spread",
    "stationary",
    "straight_line",
    "triangle",
]
