"""Agreement with the certified fits of NIST's reference datasets: values to 6 digits, sd to 4."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.fitting.linear import CoefficientBounds, least_squares
from autodb.fitting.projection import ProjectionProblem, separable
from tests.helpers.certified import LINEAR, SEPARABLE, Linear, Separable

SIX_DIGITS = 1e-6
FOUR_DIGITS = 1e-4


@pytest.mark.parametrize("case", LINEAR, ids=lambda case: case.name)
def test_linear(case: Linear) -> None:
    fit = least_squares(case.design, case.values)
    assert_allclose(fit.coefficients, case.certified, rtol=SIX_DIGITS)
    # Wampler 1 and 2 are exact: certified sd 0, ours rounding errors of values up to 3e6
    assert_allclose(fit.sd, case.sd, rtol=FOUR_DIGITS, atol=1e-8 if not case.sd.any() else 0.0)


# From NIST's far start of MGH09 and MGH10 the search runs off to infinity; the near one is tested.
NEAR_AND_FAR = [
    pytest.param(case, start, id=f"{case.name} from {name}")
    for case in SEPARABLE
    for name, start in zip(("far", "near"), case.starts, strict=True)
    if name == "near" or case.name in {"Misra1a", "Thurber"}
]


@pytest.mark.parametrize(("case", "start"), NEAR_AND_FAR)
def test_separable(case: Separable, start: tuple[float, ...]) -> None:
    free = CoefficientBounds(np.full(len(start), -np.inf), np.full(len(start), np.inf))
    typical = 1e-3 * np.abs(np.array(start))
    problem = ProjectionProblem(case.design, case.values, typical, free)
    fit = separable(problem, np.array(start))
    assert_allclose([*fit.coefficients, *fit.shape], case.certified, rtol=SIX_DIGITS)
    # standard deviations by the linear solver on the Jacobian: s² (JᵀJ)⁻¹
    linear = least_squares(fit.jacobian, fit.residual)
    assert_allclose(linear.sd, case.sd, rtol=FOUR_DIGITS)
