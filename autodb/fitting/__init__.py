"""Least squares with honest uncertainty: rank, bounds, priors, covariances, held-out scores."""

from autodb.fitting.covariance import autoregression, given_one, long_run_variance
from autodb.fitting.deviation import Deviating, least_squares_with_deviation
from autodb.fitting.gaussian import NORMAL_95, Gaussian, root_of, update
from autodb.fitting.groups import Components, components, small_sample
from autodb.fitting.linear import (
    BLOCK_ROWS,
    Bounds,
    Fit,
    Undetermined,
    check_rank,
    least_squares,
    robust_least_squares,
    solve,
    spanning,
    spread,
    triangle,
)
from autodb.fitting.projection import (
    Design,
    NotConverged,
    Problem,
    Separable,
    best_start,
    separable,
    slopes,
)
from autodb.fitting.rounds import NotSettled, stationary
from autodb.fitting.scores import (
    bootstrap_r_squared,
    held_out,
    leave_group_out,
    line,
    r_squared,
    robust_line,
)

__all__ = [
    "BLOCK_ROWS",
    "NORMAL_95",
    "Bounds",
    "Components",
    "Design",
    "Deviating",
    "Fit",
    "Gaussian",
    "NotConverged",
    "NotSettled",
    "Problem",
    "Separable",
    "Undetermined",
    "autoregression",
    "best_start",
    "bootstrap_r_squared",
    "check_rank",
    "components",
    "given_one",
    "held_out",
    "least_squares",
    "least_squares_with_deviation",
    "leave_group_out",
    "line",
    "long_run_variance",
    "r_squared",
    "robust_least_squares",
    "robust_line",
    "root_of",
    "separable",
    "slopes",
    "small_sample",
    "solve",
    "spanning",
    "spread",
    "stationary",
    "triangle",
    "update",
]
