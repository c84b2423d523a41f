"""Laws and closed forms of the terms of cutting forces and of a rotating table."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.terms.chip import (
    REFERENCE_SPEED_M_MIN,
    REFERENCE_THICKNESS_MM,
    built_up_edge,
    hard_spot,
    size_effect,
    speed_softening,
)
from autodb.terms.engagement import deflection, depth_error
from autodb.terms.nose import nose_axial, nose_length, nose_radial, nose_thinning
from autodb.terms.process import tool_wear
from autodb.terms.table import (
    G_M_S2,
    crosstalk,
    table_gravity_x,
    table_gravity_y,
    table_gravity_z,
    table_inertia,
    thermal_drift,
)
from tests.helpers.truths import Array

RNG = np.random.default_rng(1)
DEPTH_MM = np.array([0.05, 0.3, 0.8, 1.0, 4.0])


def test_size_effect_and_softening_are_one_at_their_reference_and_fall() -> None:
    assert size_effect(np.array([REFERENCE_THICKNESS_MM]), exponent=0.3) == 1.0
    assert speed_softening(np.array([REFERENCE_SPEED_M_MIN]), exponent=0.3) == 1.0
    grid = np.geomspace(0.01, 500.0, 40)
    assert (np.diff(size_effect(grid, exponent=0.3)) < 0).all()
    assert (np.diff(speed_softening(grid[10:], exponent=0.2)) < 0).all()
    ratio = size_effect(np.array([0.1]), exponent=0.3) / size_effect(np.array([0.2]), exponent=0.3)
    assert_allclose(ratio, 2.0**0.3)


def test_a_built_up_edge_vanishes_on_both_sides_of_its_band() -> None:
    factor = built_up_edge(
        np.array([1.0, 15.0, 40.0, 110.0, 500.0]), change=-0.3, centre_m_min=40.0, width=0.2
    )
    assert_allclose(factor[[0, 1, 3, 4]], 1.0, atol=0.004)
    assert_allclose(factor[2], 0.7)


def test_a_hard_spot_is_its_run_of_cuts() -> None:
    factor = hard_spot(np.arange(40.0), factor=1.5, first=10.0, last=20.0)
    assert_allclose(factor[[8, 22]], 1.0, atol=2e-3)
    assert_allclose(factor[12:19], 1.5, atol=2e-3)
    assert_allclose(factor[[10, 20]], 1.0 + 0.5 * 0.8808, atol=1e-4)


def test_depth_error_is_one_over_depth_and_never_turns_the_force() -> None:
    relative = depth_error(DEPTH_MM, error_mm=0.02) - 1.0
    assert_allclose(relative * DEPTH_MM, 0.02)
    assert depth_error(np.array([0.1]), error_mm=-0.3) == 0.0


def test_deflection_leaves_the_depth_that_its_own_force_allows() -> None:
    normal_N, compliance = np.array([50.0, 400.0, -400.0]), 2e-4
    depth = np.array([0.5, 1.0, 2.0])
    factor = deflection(normal_N, depth, compliance_mm_N=compliance)
    real_mm = depth - compliance * np.abs(normal_N) * factor
    assert_allclose(factor, real_mm / depth)
    assert_allclose(deflection(normal_N, depth, compliance_mm_N=0.0), 1.0)


def test_a_nose_shallower_than_the_cut_takes_a_constant_off() -> None:
    r, depth = 0.8, np.array([0.8, 1.0, 4.0])
    assert_allclose(nose_axial(depth, radius_mm=r), 1.0 - (1.0 - np.pi / 4) * r / depth)
    radial = nose_radial(100.0 * depth, depth, radius_mm=r)
    assert_allclose(radial, np.column_stack([np.full(3, 50.0 * r), np.full(3, r)]))
    assert_allclose(nose_length(depth, radius_mm=r), 1.0 + (np.pi / 2 - 1.0) * r / depth)


@pytest.mark.parametrize("depth_mm", DEPTH_MM)
def test_nose_is_the_sum_of_its_elements(depth_mm: float) -> None:
    r, pieces = 0.8, 20_000
    top = np.arccos(1.0 - min(depth_mm / r, 1.0))
    angle = (np.arange(pieces) + 0.5) / pieces * top
    width, straight = r * top / pieces, max(depth_mm - r, 0.0)
    load = np.sin(angle) * width
    depth = np.array([depth_mm])
    assert_allclose(load.sum() + straight, depth_mm, rtol=1e-6)
    axial = (np.sum(load * np.sin(angle)) + straight) / depth_mm
    assert_allclose(nose_axial(depth, radius_mm=r), axial, rtol=1e-6)
    radial = [np.sum(load * np.cos(angle)) / depth_mm, np.sum(np.cos(angle)) * width]
    assert_allclose(nose_radial(np.ones(1), depth, radius_mm=r), [radial], rtol=1e-6)
    thin = nose_thinning(np.array([0.2]), depth, radius_mm=r)
    assert_allclose(thin, 0.2 * depth_mm / (pieces * width + straight), rtol=1e-6)


def test_no_nose_changes_nothing() -> None:
    assert_allclose(nose_axial(DEPTH_MM, radius_mm=1e-9), 1.0)
    assert_allclose(nose_length(DEPTH_MM, radius_mm=1e-9), 1.0)
    assert_allclose(nose_radial(np.ones(5), DEPTH_MM, radius_mm=1e-9), 0.0, atol=1e-7)


def test_wear_goes_with_depth_and_the_edge_s_own_time() -> None:
    assert_allclose(tool_wear(np.full(3, 2.0), np.array([0.0, 0.0, 5.0])), [0.0, 0.0, 10.0])


# --- the rotating table, against the matrices of P4


def turn(angle_x: float, angle_z: float) -> Array:
    """Return T = T_z T_x, (3, 3)."""
    cx, sx, cz, sz = np.cos(angle_x), np.sin(angle_x), np.cos(angle_z), np.sin(angle_z)
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, cx, -sx], [0.0, sx, cx]])
    about_z = np.array([[cz, -sz, 0.0], [sz, cz, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(about_z @ about_x)


def gravity(angle_x: Array, angle_z: Array, *, mass_kg: float, tared_kg: float) -> Array:
    """Return the weight of the terms, (n, 3)."""
    along_z = table_gravity_z(angle_x) @ [mass_kg, mass_kg - tared_kg]
    along_x, along_y = table_gravity_x(angle_x, angle_z), table_gravity_y(angle_x, angle_z)
    return np.column_stack([mass_kg * along_x, mass_kg * along_y, along_z])


def inertia(omega: Array, alpha: Array, moment: Array) -> Array:
    """Return the pull of the terms, (n, 3), for ω and ω̇ (n, 3) and m·r (3,)."""
    turns = ((0, 1, 2), (1, 2, 0), (2, 0, 1))
    return np.column_stack(
        [
            table_inertia(omega[:, i], omega[:, j], omega[:, k], alpha[:, j], alpha[:, k])
            @ moment[[i, j, k]]
            for i, j, k in turns
        ]
    )


def test_weight_on_a_tilted_table_is_the_turned_weight_less_the_tared() -> None:
    x, z = RNG.uniform(-2.0, 2.0, (2, 20))
    up = np.array([0.0, 0.0, 21.0 * G_M_S2])
    expected = [turn(a, c) @ up - [0.0, 0.0, 20.0 * G_M_S2] for a, c in zip(x, z, strict=True)]
    assert_allclose(gravity(x, z, mass_kg=21.0, tared_kg=20.0), expected, atol=1e-9)


def test_weight_is_tared_away_upright_and_keeps_its_size() -> None:
    x, z = RNG.uniform(-2.0, 2.0, (2, 20))
    assert_allclose(gravity(0.0 * x, z, mass_kg=20.0, tared_kg=20.0), 0.0, atol=1e-12)
    untared = gravity(x, z, mass_kg=20.0, tared_kg=0.0)
    assert_allclose(np.linalg.norm(untared, axis=1), 20.0 * G_M_S2)
    tilted = gravity(np.array([np.pi]), np.zeros(1), mass_kg=20.0, tared_kg=20.0)
    assert_allclose(tilted, [[0.0, 0.0, -40.0 * G_M_S2]], atol=1e-9)


def test_inertia_is_the_cross_products() -> None:
    omega, alpha = RNG.normal(size=(2, 20, 3))
    r, mass = np.array([0.02, 0.065, 0.035]), 30.0
    expected = mass * (np.cross(omega, np.cross(omega, r)) + np.cross(alpha, r))
    assert_allclose(inertia(omega, alpha, mass * r), expected, atol=1e-12)


def test_centrifugal_force_grows_with_the_square_of_speed_and_euler_with_acceleration() -> None:
    omega, alpha = RNG.normal(size=(2, 20, 3))
    moment, still = np.array([0.6, 2.0, 1.0]), np.zeros((20, 3))
    assert_allclose(inertia(3.0 * omega, still, moment), 9.0 * inertia(omega, still, moment))
    assert_allclose(inertia(still, 3.0 * alpha, moment), 3.0 * inertia(still, alpha, moment))
    along = omega / np.linalg.norm(omega, axis=1)[:, None]
    across = np.sum(inertia(omega, still, moment) * along, axis=1)
    assert_allclose(across, 0.0, atol=1e-12)


def test_heat_rises_while_cutting_and_relaxes_after() -> None:
    t = np.arange(0.0, 400.0, 0.5)
    heat = thermal_drift((t < 200.0).astype(float), t, time_constant_s=50.0)
    assert_allclose(heat[t == 100.0], 1.0 - np.exp(-2.0), rtol=1e-9)
    assert_allclose(heat[t == 300.0], heat[t == 200.0] * np.exp(-2.0), rtol=1e-9)


def test_heat_goes_on_over_rows_that_are_missing() -> None:
    t = np.arange(0.0, 400.0, 0.5)
    whole = thermal_drift((t < 200.0).astype(float), t, time_constant_s=50.0)
    there = ~((t > 90.0) & (t < 150.0)) & ~((t > 300.0) & (t < 340.0))
    seen = t[there]
    heat = thermal_drift((seen < 200.0).astype(float), seen, time_constant_s=50.0)
    assert_allclose(heat, whole[there], rtol=1e-9)


def test_crosstalk_is_the_other_component() -> None:
    assert_allclose(crosstalk(np.array([1.0, -2.0])), [1.0, -2.0])
