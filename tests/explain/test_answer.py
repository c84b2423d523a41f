"""How much of the squared error each cause takes away: of known contributions, and in any order."""

from itertools import permutations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.explain.answer import Cause, IntervalValue, largest_first, shares_taken

Array = NDArray[np.float64]
RNG = np.random.default_rng(3)
N = 4000
TIME = np.linspace(0.0, 30.0, N)
SPEED = 80.0 * np.sin(TIME) * np.sin(0.37 * TIME)


def _fall(difference: Array, parts: list[Array]) -> float:
    """Return the share of the squares that corrections take away."""
    left = sum((-part for part in parts), start=difference)
    return 1.0 - float(left @ left) / float(difference @ difference)


def _over_all_orders(difference: Array, parts: list[Array]) -> Array:
    """Return the mean of what each takes away when it is added, over all orders."""
    found = np.zeros(len(parts))
    orders = list(permutations(range(len(parts))))
    for order in orders:
        for at, number in enumerate(order):
            before = [parts[k] for k in order[:at]]
            found[number] += _fall(difference, [*before, parts[number]]) - _fall(difference, before)
    return found / len(orders)


def test_contributions_that_do_not_overlap_take_their_own_squares() -> None:
    parts = [np.sin(TIME * 2.0 * np.pi / 30.0 * k) * size for k, size in ((3, 2.0), (5, 1.0))]
    shares = shares_taken(parts[0] + parts[1], parts[0] + parts[1], parts)
    assert_allclose(shares, [0.8, 0.2], atol=1e-3)


@pytest.mark.parametrize("seed", range(4))
def test_shares_are_the_means_over_all_orders(seed: int) -> None:
    rng = np.random.default_rng(seed)
    sizes = rng.uniform(0.3, 1.5, 3)
    laws = [np.sign(SPEED), SPEED / 40.0, np.ones(N) + 0.3 * np.sign(SPEED)]
    parts = [size * law for size, law in zip(sizes, laws, strict=True)]
    correction = np.sum(parts, axis=0)
    difference = correction + 0.3 * rng.standard_normal(N)
    shares = shares_taken(difference, correction, parts)
    assert np.all(shares > 0.0)
    assert_allclose(shares.sum(), _fall(difference, parts))
    assert_allclose(shares, _over_all_orders(difference, parts))


def test_what_undoes_another_takes_nothing_and_the_sum_stays() -> None:
    drag = np.sign(SPEED)
    parts = [drag, np.where(np.abs(SPEED) < 20.0, -drag, 0.0)]
    difference = parts[0] + parts[1]
    assert _over_all_orders(difference, parts)[1] < 0.0
    assert_allclose(shares_taken(difference, difference, parts), [1.0, 0.0])
    assert_allclose(shares_taken(0.0 * drag, drag, [drag]), [0.0])
    assert_allclose(shares_taken(drag, -drag, [-drag]), [0.0])  # worse than none: takes nothing


def _cause(term: str) -> Cause:
    size = IntervalValue(value=1.0, low=0.9, high=1.1, unit="A")
    return Cause(term=term, kind="missing", confidence=0.9, statement="", parameters={"size": size})


def test_the_largest_comes_first_whatever_its_peak() -> None:
    spike = np.where(np.arange(N) == 7, 9.0, 0.0)
    drag = np.sign(SPEED)
    causes, shares = largest_first(
        [_cause("saturation"), _cause("coulomb")],
        [spike, drag],
        correction=spike + drag,
        difference=spike + drag + 0.1 * RNG.standard_normal(N),
    )
    assert [cause.term for cause in causes] == ["coulomb", "saturation"]
    assert shares[0] > 0.9
    assert 0.0 < shares[1] < 0.1
    assert_allclose(sum(shares), 1.0, atol=0.03)


def test_what_a_refitted_simulation_has_swallowed_goes_to_the_cause() -> None:
    """Viscosity stands in for dry friction; the correction takes that back along with it."""
    drag = np.sign(SPEED)
    swallowed = SPEED * float(SPEED @ drag) / float(SPEED @ SPEED)
    difference = drag - swallowed
    ((cause,), (share,)) = largest_first(
        [_cause("coulomb")], [drag], correction=difference, difference=difference
    )
    assert cause.term == "coulomb"
    assert_allclose(share, 1.0)


def test_what_is_said_against_a_lower_own_term_takes_the_error_that_both_leave() -> None:
    """Thin chips take more, all chips less: neither looks like the error, both together are it."""
    thickness = np.linspace(0.1, 0.4, 12)
    depth = np.linspace(1.0, 0.3, 12)
    law = depth * thickness * ((thickness / 0.2) ** -0.3 - 1.0)
    error = 0.05 * depth
    columns = np.column_stack([law, depth * thickness])
    sizes = np.linalg.lstsq(columns, error, rcond=None)[0]
    part, correction = columns[:, 0] * sizes[0], columns @ sizes
    assert float(part @ (2.0 * error - correction)) < 0.0
    (share,) = shares_taken(error, correction, [part])
    assert_allclose(share, _fall(error, [correction]))
    assert share > 0.9
