"""The chain rule of the law: against steps along the imaginary axis, and central differences."""

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.cutting import shear, steepness
from autodb.cutting.elements import cut_forces, force_gradient, joined_elements, linearised_forces
from autodb.cutting.shear import Edge, Values
from autodb.pairs.engaged import BY_NAME, DRILL, END_MILL, INSERT
from autodb.pairs.prior import any_metal
from tests.helpers.plain_law import theta

Array = NDArray[np.float64]

TOOLS = {
    INSERT: {"nose_radius_mm": 0.8, "kappa_deg": 95.0, "rake_deg": -6.0, "inclination_deg": -6.0},
    END_MILL: {
        "diameter_mm": 10.0, "teeth": 3.0, "helix_deg": 30.0, "corner_radius_mm": 1.0,
        "rake_deg": 8.0,
    },
    DRILL: {"diameter_mm": 8.0, "point_angle_deg": 130.0, "helix_deg": 30.0},
}  # fmt: skip
STATED = {
    "cutting.feed": (0.05, 0.3), "cutting.depth": (0.3, 3.0), "cutting.width": (1.0, 6.0),
    "cutting.speed": (60.0, 300.0), "spindle.speed": (800.0, 3000.0), "work.diameter": (20.0, 80.0),
    "cutting.direction": (0.0, 30.0), "cutting.ramp": (1.0, 5.0), "pocket.diameter": (30.0, 60.0),
    "cutting.band_low": (-4.0, -1.0), "cutting.band_high": (1.0, 4.0),
}  # fmt: skip
COUNT = 7


def drawn(rng: np.random.Generator) -> Array:
    """Return coordinates of the law, each off by a part of what any metal may be off."""
    known = any_metal().law
    sd = np.sqrt(np.diag(known.covariance))
    return theta() + 0.3 * np.minimum(sd, 0.5) * rng.standard_normal(len(sd))


def edges(rng: np.random.Generator) -> Edge:
    """Return elements of an edge."""
    return Edge(
        rng.uniform(0.02, 0.4, COUNT), rng.uniform(60.0, 300.0, COUNT),
        rng.uniform(-0.2, 0.2, COUNT), rng.uniform(-0.2, 0.2, COUNT),
    )  # fmt: skip


def stepped(law: Callable[[Values], tuple[Values, ...]], size: Array, known: Array) -> Array:
    """Return derivatives (3, p, m) of what a law gives of elements of some size."""
    return shear.gradient(lambda t: np.array(law(t)) * size, known, axes=1)


@pytest.mark.parametrize("seed", range(20))
def test_what_shears_and_rubs_changes_as_a_step_says(seed: int) -> None:
    rng = np.random.default_rng(seed)
    known, at, width = drawn(rng), edges(rng), rng.uniform(0.1, 2.0, COUNT)
    area = at.thickness_mm * width
    parts = (
        (steepness.sheared(known, at, area), lambda t: shear.chip_coefficients(t, at), area),
        (steepness.rubbed(known, at, width), lambda t: shear.edge_coefficients(t, at), width),
    )
    begin = 0
    for part, law, size in parts:
        exact = stepped(law, size, known)
        made = np.concatenate(
            [np.stack([one[d.which] * d.factor for one in part.by]) for d in part.drives], axis=1
        )
        order = list(steepness.ORDER[begin : begin + made.shape[1]])
        begin += made.shape[1]
        assert_allclose(made, exact[:, order], rtol=1e-9, atol=1e-9 * np.abs(exact).max())
        others = [k for k in range(len(known)) if k not in order]
        assert not exact[:, others].any()
    assert begin == len(steepness.ORDER)


def test_where_a_force_would_be_infinite_it_ends_and_changes_as_a_step_says() -> None:
    """Friction at which φ + β - α passes 90°, of orthogonal edges and of slightly oblique ones."""
    known = theta()
    at = Edge(np.array([0.1]), np.array([100.0]), np.array([-0.05]), np.zeros(1))
    ratio = float(shear.chip_ratio(known, at)[0])
    phi = np.arctan2(ratio * np.cos(-0.05), 1.0 - ratio * np.sin(-0.05))
    beta = np.radians(90.0) - phi - 0.05 + np.radians(np.linspace(-8.0, 8.0, 41))
    offset = known[shear.BETA_RAKE] * -0.05
    for lean in (0.0, 0.02):
        for one in beta:
            known[shear.BETA] = np.log(np.tan(one)) - offset
            edge = Edge(np.array([0.1]), np.array([100.0]), np.array([-0.05]), np.array([lean]))
            zone = shear.zone(known, edge)
            most = 2.0 / (np.sin(phi) * np.cos(one) * shear.LEAST_D)
            assert zone.strength[0] <= 1.0001 * most * np.exp(known[shear.TAU])
            area = np.ones(1)
            part = steepness.sheared(known, edge, area)
            made = np.concatenate([np.stack([x[d.which] * d.factor for x in part.by])
                                   for d in part.drives], axis=1)  # fmt: skip
            exact = stepped(partial(_coefficients, edge), area, known)
            order = list(steepness.ORDER[: made.shape[1]])
            assert_allclose(made, exact[:, order], rtol=1e-9, atol=1e-9 * np.abs(exact).max())


def _coefficients(edge: Edge, known: Values) -> tuple[Values, ...]:
    return shear.chip_coefficients(known, edge)


@pytest.mark.parametrize("name", BY_NAME)
def test_forces_of_every_operation_change_as_differences_say(name: str) -> None:
    rng = np.random.default_rng(len(name))
    known = drawn(rng)
    rows = [{k: float(rng.uniform(*ends)) for k, ends in STATED.items()} for _ in range(COUNT)]
    cuts = BY_NAME[name].cuts(TOOLS[BY_NAME[name].kind], rows, called="tool")
    whole, parts, slopes = linearised_forces(known, cuts.elements)
    assert_allclose(whole, cut_forces(known, cuts.elements).all, rtol=1e-12, atol=1e-9)
    assert_allclose(slopes, force_gradient(known, cuts.elements), rtol=1e-12)
    assert_allclose(parts[..., :2].sum(axis=-1), whole, rtol=1e-10, atol=1e-9)
    for k in range(len(known)):
        step = 1e-5 * (np.arange(len(known)) == k)
        high, low = (cut_forces(known + sign * step, cuts.elements).all for sign in (1.0, -1.0))
        size = np.abs(slopes[..., k]).max() + 1e-3
        assert_allclose(slopes[..., k], (high - low) / 2e-5, rtol=1e-5, atol=1e-6 * size)


@pytest.mark.parametrize("name", BY_NAME)
def test_cuts_behind_each_other_are_the_cuts_by_themselves(name: str) -> None:
    rng = np.random.default_rng(3)
    known = drawn(rng)
    tool = TOOLS[BY_NAME[name].kind]
    several = []
    for count in (1, 4):
        rows = [{k: float(rng.uniform(*ends)) for k, ends in STATED.items()} for _ in range(count)]
        several.append(BY_NAME[name].cuts(tool, rows, called="tool").elements)
    together = linearised_forces(known, joined_elements(several))
    alone = [linearised_forces(known, one) for one in several]
    for whole, *parts in zip(together, *alone, strict=True):
        assert_allclose(whole, np.concatenate(parts), rtol=1e-12, atol=1e-9)
