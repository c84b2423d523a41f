"""What machines know together: sums that are the joint inference, and nothing counts twice."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy.stats import chi2

from autodb.fitting.gaussian import Gaussian, posterior_after
from autodb.pairs.hierarchy import (
    ACTIVE,
    ANY,
    MACHINES,
    METALS,
    OF_MACHINES,
    OF_TOOLS,
    STEPS,
    InformationOfCuts,
    KnownMaterial,
    information_of_cuts,
)
from autodb.pairs.posterior import OWN
from autodb.pairs.prior import RELATIVE

Array = NDArray[np.float64]
SIZE = len(ACTIVE)
MIDDLE = (len(STEPS) // 2,) * 2


def readings(rng: np.random.Generator, theta: Array, *, count: int, sd: float) -> InformationOfCuts:
    """Return the information of linear readings of active coordinates."""
    design = rng.standard_normal((count, SIZE)) / np.sqrt(METALS)
    values = design @ theta + sd * rng.standard_normal(count)
    return InformationOfCuts(design.T @ design / sd**2, design.T @ values / sd**2)


def fleet(
    rng: np.random.Generator, *, tools: int, machines: int, a: float, b: float, sd: float = 0.05
) -> tuple[KnownMaterial, Array]:
    """Draw a material, and learn it; return what is known and the truth of each tool (t, a)."""
    material = ANY.mean[ACTIVE] + np.sqrt(METALS) * rng.standard_normal(SIZE)
    of_tools = np.where(OF_TOOLS[0] == OF_TOOLS[1], OF_TOOLS[0], a**2 * METALS)
    truths = material + np.sqrt(of_tools) * rng.standard_normal((tools, SIZE))
    known = KnownMaterial(ANY)
    for machine in range(machines):
        tool = machine % tools
        own = truths[tool] + b * np.sqrt(METALS) * rng.standard_normal(SIZE)
        known = known.changed(f"tool {tool}", more=readings(rng, own, count=30, sd=sd))
    return known, truths


def test_sums_are_the_joint_inference() -> None:
    """Against all of μ, τ and ε in one linear system, with the shares of the grid's middle."""
    rng = np.random.default_rng(1)
    pairs = [("a", 0), ("a", 1), ("b", 0), ("b", 2), ("b", 3)]
    given = [readings(rng, ANY.mean[ACTIVE], count=8, sd=0.3) for _ in pairs]
    known = KnownMaterial(ANY, held=MIDDLE)
    for (tool, _), one in zip(pairs, given, strict=True):
        known = known.changed(tool, more=one)

    # μ, then τ of a and b, then ε of each pair, and of a new one with tool b
    blocks = 1 + 2 + len(pairs) + 1
    prior = np.zeros((blocks * SIZE, blocks * SIZE))
    variances = [METALS, *[OF_TOOLS[MIDDLE[0]]] * 2, *[OF_MACHINES[MIDDLE[1]]] * (len(pairs) + 1)]
    prior[np.diag_indices(blocks * SIZE)] = np.concatenate(variances)
    prior[:SIZE, :SIZE] = ANY.covariance[np.ix_(ACTIVE, ACTIVE)]
    mean = np.concatenate([ANY.mean[ACTIVE], np.zeros((blocks - 1) * SIZE)])
    precision, weighted = np.linalg.inv(prior), np.linalg.solve(prior, mean)
    for k, ((tool, _), one) in enumerate(zip(pairs, given, strict=True)):
        into = _places(blocks, 0, 1 + "ab".index(tool), 3 + k)
        precision += into.T @ one.precision @ into
        weighted += into.T @ one.weighted
    covariance = np.linalg.inv(precision)
    new = _places(blocks, 0, 2, blocks - 1)
    found = known.pair("b")
    assert_allclose(found.mean[ACTIVE], new @ covariance @ weighted, rtol=1e-7, atol=1e-9)
    assert_allclose(
        found.covariance[np.ix_(ACTIVE, ACTIVE)], new @ covariance @ new.T, rtol=1e-6, atol=1e-10
    )
    unknown = known.pair("c")
    assert np.all(np.diag(unknown.covariance)[ACTIVE] > np.diag(found.covariance)[ACTIVE])


def _places(blocks: int, *of: int) -> Array:
    into = np.zeros((SIZE, blocks * SIZE))
    for block in of:
        into[:, block * SIZE : (block + 1) * SIZE] = np.eye(SIZE)
    return into


def test_pairs_are_added_and_taken_out_in_any_order() -> None:
    rng = np.random.default_rng(2)
    some = [readings(rng, ANY.mean[ACTIVE], count=20, sd=0.1) for _ in range(4)]
    forth, back = KnownMaterial(ANY), KnownMaterial(ANY)
    for one in some:
        forth = forth.changed("a", more=one)
    for one in some[::-1]:
        back = back.changed("a", more=one)
    more = forth.changed("a", more=some[0]).changed("b", more=some[1])
    less = more.changed("a", less=some[0]).changed("b", less=some[1])
    for other in (back, less):
        assert_allclose(other.shares, forth.shares, rtol=1e-9)
        assert set(other.tools) == {"a"}
        assert other.pairs == 4
        assert_allclose(other.pair("a").mean, forth.pair("a").mean, rtol=1e-8, atol=1e-9)
        assert_allclose(other.pair("a").covariance, forth.pair("a").covariance, rtol=1e-6)


def test_nothing_known_is_the_start_and_how_far_pairs_are_apart() -> None:
    nothing = KnownMaterial(ANY).pair("a")
    a, b = MIDDLE
    assert_allclose(nothing.mean, ANY.mean)
    assert_allclose(np.diag(nothing.covariance)[ACTIVE], METALS + OF_TOOLS[a] + OF_MACHINES[b])
    assert_allclose(KnownMaterial(ANY).shares, (RELATIVE, MACHINES))


def test_information_of_cuts_is_the_same_from_any_start() -> None:
    """So that a pair that began from the others tells them only what its own cuts did."""
    rng = np.random.default_rng(3)
    design, values = np.zeros((12, OWN)), rng.standard_normal(12)
    design[:, ACTIVE] = rng.standard_normal((12, SIZE)) / np.sqrt(METALS)
    elsewhere = Gaussian(ANY.mean + 0.3, 0.25 * ANY.covariance)
    first, second = (
        information_of_cuts(posterior_after(start, design, values, np.full(12, 0.3)), start)
        for start in (ANY, elsewhere)
    )
    whitened = np.sqrt(np.outer(METALS, METALS))
    assert_allclose(first.precision * whitened, second.precision * whitened, rtol=1e-6, atol=1e-6)
    unit = np.sqrt(METALS)
    assert_allclose(first.weighted * unit, second.weighted * unit, rtol=1e-6, atol=1e-5)
    assert_allclose(
        first.precision, design[:, ACTIVE].T @ design[:, ACTIVE] / 0.09, rtol=1e-6, atol=1e-6
    )
    nothing = information_of_cuts(ANY, ANY)
    assert not nothing.precision.any()
    assert not nothing.weighted.any()


@pytest.mark.parametrize("b", [0.03, 0.15])
def test_how_far_machines_are_apart_is_estimated_from_them(b: float) -> None:
    """Of 24 machines with 16 coordinates each: to a step and a half of the grid, 0.37 in ln b."""
    found = fleet(np.random.default_rng(4), tools=2, machines=24, a=0.2, b=b, sd=0.01)[0]
    assert abs(np.log(found.shares[1] / b)) < 0.375


def test_posteriors_hold_the_next_machine() -> None:
    """Of 60 fleets the misfit of a next machine's pair, χ² with 16 degrees each, is within the
    interval that correct posteriors leave once in a thousand, widened by a fifth for shares that
    six machines gave.
    """
    rng = np.random.default_rng(5)
    misfit = 0.0
    fleets = 60
    for _ in range(fleets):
        a, b = 0.2 * np.exp(0.3 * rng.standard_normal()), 0.07 * np.exp(0.3 * rng.standard_normal())
        known, truths = fleet(rng, tools=2, machines=6, a=float(a), b=float(b))
        truth = truths[0] + b * np.sqrt(METALS) * rng.standard_normal(SIZE)
        expected = known.pair("tool 0")
        off = truth - expected.mean[ACTIVE]
        misfit += off @ np.linalg.solve(expected.covariance[np.ix_(ACTIVE, ACTIVE)], off)
    low, high = chi2.interval(0.999, fleets * SIZE)
    assert low / 1.2 < misfit < high * 1.2


def test_from_many_pairs_on_one_does_not_move_the_spreads() -> None:
    rng = np.random.default_rng(6)
    one = readings(rng, ANY.mean[ACTIVE], count=20, sd=0.1)
    known = fleet(rng, tools=1, machines=61, a=0.2, b=0.07)[0]
    assert known.without("tool 0", one).shares == known.shares
    few = fleet(rng, tools=1, machines=3, a=0.2, b=0.07)[0]
    assert few.without("tool 0", one).held is None
