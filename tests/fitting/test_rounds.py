"""Rounds of an alternation end at their stationary point."""

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb.fitting.rounds import NotSettled, stationary

Array = NDArray[np.float64]


def test_rounds_end_where_they_come_to_rest() -> None:
    """x ← A x + b with eigenvalues up to 0.999: after 12 rounds what a million rounds give."""
    rng = np.random.default_rng(0)
    turned = np.linalg.qr(rng.standard_normal((5, 5)))[0]
    matrix = turned @ np.diag([0.999, 0.9, 0.5, 0.1, -0.3]) @ turned.T
    shift, calls = rng.standard_normal(5), 0

    def moved(x: Array) -> tuple[Array, Array]:
        nonlocal calls
        calls += 1
        return matrix @ x + shift, np.full(5, 1000.0)

    found = stationary(moved, np.zeros(5))
    np.testing.assert_allclose(found, np.linalg.solve(np.eye(5) - matrix, shift), rtol=1e-5)
    assert calls < 15


def test_rounds_that_never_rest_are_said_so() -> None:
    with pytest.raises(NotSettled, match="after 1000 rounds"):
        stationary(lambda x: (-x + 1e3, np.ones(1)), np.array([7.0]), settled=-1.0)
    found = stationary(lambda x: (-x + 1e3, np.ones(1)), np.array([7.0]), settled=-1.0, enough=1e-3)
    np.testing.assert_allclose(found, 500.0, atol=1e-3)


def test_rounds_that_hardly_move_on_their_way_are_followed_to_its_end() -> None:
    """x ← x + (0.001 + x²)(2 − x)/8 passes 0 at a crawl and ends at 2: plain rounds take 420."""
    calls = 0

    def moved(x: Array) -> tuple[Array, Array]:
        nonlocal calls
        calls += 1
        slow = x[0] + (1e-3 + x[0] ** 2) * (2.0 - x[0]) / 8.0
        return np.array([slow, 0.5 * x[1] + x[0]]), np.ones(2)

    np.testing.assert_allclose(stationary(moved, np.array([-0.2, 0.0])), [2.0, 4.0], atol=1e-7)
    assert calls < 210
