"""How large deviations may be where rows hardly show them, and what follows from a value given."""

import numpy as np
from numpy.testing import assert_allclose

from autodb.fitting.deviation import Deviating, least_squares_with_deviation

ROWS = 600
BLOCKS = np.arange(ROWS) * 12 // ROWS


def _fit(likely: list[float] | None) -> Deviating:
    """Fit a level beside one deviation that nearly follows it, but for a few rows that are off."""
    rng = np.random.default_rng(5)
    level = np.ones((ROWS, 1))
    deviation = np.ones((ROWS, 1))
    deviation[::60] = 0.97
    values = 2.0 + 0.05 * rng.standard_normal(ROWS)
    values[::60] -= 0.5
    return least_squares_with_deviation(
        level, [deviation], values, blocks=BLOCKS, order=0, likely=likely
    )


def test_a_deviation_is_no_larger_than_it_is_likely() -> None:
    """Ten rows 0.5 low are 17 times the level by a column that is there 3 % less."""
    free, likely = _fit(None), _fit([0.2])
    assert free.sds[0] > 5.0
    assert likely.sds[0] < 0.3 * free.sds[0]


def test_values_given_another_do_not_follow_how_blocks_widen_it() -> None:
    """A coefficient that blocks show to differ is wider; what follows from it is as before."""
    rng = np.random.default_rng(11)
    first = rng.standard_normal(ROWS)
    second = 0.9 * first + 0.3 * rng.standard_normal(ROWS)
    differs = rng.standard_normal(12)[BLOCKS]
    values = (1.0 + 0.5 * differs) * first + 1.0 * second + 0.1 * rng.standard_normal(ROWS)
    design = np.column_stack([first, second])
    fit = least_squares_with_deviation(design, [], values, blocks=BLOCKS, order=0)
    assert np.max(fit.inflation) > 1.3
    narrow = fit.narrow_covariance
    given = fit.coefficients[1] - narrow[1, 0] / narrow[0, 0] * fit.coefficients[0]
    alone = np.linalg.lstsq(second[:, None], values, rcond=None)[0][0]
    assert_allclose(given, alone, rtol=1e-6)
