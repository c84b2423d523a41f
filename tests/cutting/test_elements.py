"""Edge elements: turned into machine axes, summed over inserts, end mills and drills."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.cutting import drill, endmill, insert, shear
from autodb.cutting.elements import Elements, cut_forces, force_gradient, force_parts
from autodb.cutting.endmill import EndMill, Milled
from autodb.cutting.insert import Insert, TurnedCuts
from autodb.cutting.shear import Edge
from autodb.cutting.tools import FOLLOWS_DEG, insert_of
from autodb.errors import UnusableInput
from tests.helpers.plain_law import theta

Array = NDArray[np.float64]

STEEL = theta(shear_stress=500.0, friction_angle=28.0, chip_ratio=0.4, chip_ratio_thickness=0.0)
"""Constant coefficients."""


def array(*values: float) -> Array:
    return np.array(values, dtype=np.float64)


def turned(
    *, feed: float = 0.2, depth: float = 2.0, inward_deg: float = 0.0, speed: float = 100.0
) -> TurnedCuts:
    """Return one cut."""
    angle = array(np.radians(inward_deg))
    return TurnedCuts(array(feed), array(depth), array(speed), array(30.0), angle)


def milled(band: tuple[Array, Array], **changed: float) -> Milled:
    """Return one cut of a mill."""
    cut = {"feed": 0.05, "depth": 4.0, "rpm": 3000.0, "direction": 0.0, "ramp": 0.0} | changed
    feed, depth, rpm, direction, ramp = (array(value) for value in cut.values())
    return Milled(feed, depth, rpm, band[0], band[1], direction, ramp)


def a_slot(diameter_mm: float = 10.0) -> tuple[Array, Array]:
    return endmill.up(diameter_mm, array(diameter_mm))


def test_a_straight_edge_pushes_as_the_contract_says() -> None:
    """κ 90: no radial force, tangential +y, axial against the feed; κ 45: radial as axial."""
    square = cut_forces(STEEL, insert.insert_elements(Insert(0.0, 90.0), turned())).force_N[0]
    tangential, thrust, _ = (one[0] * 2.0 for one in shear.per_width(STEEL, _orthogonal(0.2)))
    assert_allclose(square, [0.0, tangential, thrust], rtol=1e-12, atol=1e-9)
    lean = cut_forces(STEEL, insert.insert_elements(Insert(0.0, 45.0), turned())).force_N[0]
    assert_allclose(lean[0], lean[2], rtol=1e-12)


@pytest.mark.parametrize("lambda_s_deg", [-12.0, -6.0, 0.0, 8.0])
def test_an_inclined_edge_pushes_as_its_rake_face_does(lambda_s_deg: float) -> None:
    """In machine axes: feed along -z at κ 90, the work moves along +y, ISO 3002's λ_s.

    A positive one has the tip in front: from it the edge falls back along the work's way. The face
    takes a pressure upright to it, and friction along a chip that flows at λ_s (Stabler).
    """
    lam, rub = np.radians(lambda_s_deg), np.tan(np.radians(28.0))
    edge = np.array([np.cos(lam), np.sin(lam), 0.0])
    into_face = np.array([-np.sin(lam), np.cos(lam), 0.0])
    chip = np.cos(lam) * np.array([0.0, 0.0, 1.0]) + np.sin(lam) * edge
    real = into_face + rub * chip

    sharp = theta(friction_angle=28.0, chip_ratio=0.4, K_te=1e-9, K_re=1e-9)
    tool = Insert(0.0, 90.0, inclination_deg=lambda_s_deg)
    found = cut_forces(sharp, insert.insert_elements(tool, turned())).force_N[0]
    assert_allclose(found / found[1], real / real[1], rtol=1e-9, atol=1e-9)
    assert np.sign(np.round(found[0], 6)) == -np.sign(lam), "a negative one pushes off the work"


def _orthogonal(thickness_mm: float) -> Edge:
    none = array(0.0)
    return Edge(array(thickness_mm), array(100.0), none, none)


def test_facing_is_turning_with_the_axes_exchanged() -> None:
    tool = Insert(0.8, 95.0)
    along = cut_forces(STEEL, insert.insert_elements(tool, turned())).force_N[0]
    across = cut_forces(STEEL, insert.insert_elements(tool, turned(inward_deg=90.0))).force_N[0]
    assert_allclose(across, along[[2, 1, 0]], rtol=1e-12)
    assert Insert(0.8, 95.0, included_deg=80.0).facing_deg == 95.0
    pointed = Insert(0.8, 93.0, included_deg=55.0)
    assert_allclose(pointed.facing_deg, 122.0)


@pytest.mark.parametrize("depth", [0.1, 0.5, 2.0])
@pytest.mark.parametrize("inward_deg", [-15.0, 0.0, 20.0, 90.0])
def test_the_chip_has_the_area_of_feed_and_depth(depth: float, inward_deg: float) -> None:
    made = insert.insert_elements(Insert(0.8, 75.0), turned(depth=depth, inward_deg=inward_deg))
    assert_allclose((made.width_mm * made.edge.thickness_mm).sum(), 0.2 * depth, rtol=1e-12)


def test_twenty_elements_are_enough_on_a_nose() -> None:
    """Against 400: 0.1 % of the tangential force in every component."""
    for depth in (0.1, 0.3, 2.0):
        known = theta(chip_flow=0.5)
        few, many = (
            cut_forces(
                known, insert.insert_elements(Insert(0.8, 93.0), turned(depth=depth), on_nose=n)
            )
            for n in (insert.ON_NOSE, 400)
        )
        assert_allclose(few.force_N, many.force_N, atol=1e-3 * float(many.force_N[0, 1]))


def test_forces_scale_with_width_and_power_is_force_times_speed() -> None:
    """Deeper by what lies behind the nose: the straight edge's force, twice for twice the depth."""
    tool = Insert(0.8, 90.0)
    one, two, three = (
        cut_forces(STEEL, insert.insert_elements(tool, turned(depth=d))).force_N[0]
        for d in (1.0, 2.0, 3.0)
    )
    assert_allclose(three - two, two - one, rtol=1e-10, atol=1e-9)
    whole = cut_forces(STEEL, insert.insert_elements(tool, turned(speed=180.0)))
    assert_allclose(whole.power_W, whole.force_N[:, 1] * 180.0 / 60.0, rtol=1e-12)
    assert_allclose(whole.torque_N_m, whole.force_N[:, 1] * 0.030, rtol=1e-12)


def test_a_chip_that_flows_as_one_keeps_its_size_across_a_straight_edge() -> None:
    """With no nose there is one direction only, so that the share does not matter."""
    cut = turned()
    straight = [
        cut_forces(theta(chip_flow=share), insert.insert_elements(Insert(0.0, 75.0), cut)).force_N
        for share in (0.0, 1.0)
    ]
    assert_allclose(straight[0], straight[1], rtol=1e-12)
    rubs = theta(chip_flow=1.0, K_re=1e-9)
    made = insert.insert_elements(Insert(0.8, 93.0), turned(depth=0.5))
    thrust = np.hypot(*cut_forces(rubs, made).force_N[0, [0, 2]])
    alone = np.sum(shear.per_width(rubs, made.edge)[1] * made.width_mm)
    assert_allclose(thrust, alone, rtol=1e-9)


def test_a_holder_that_nobody_stated_follows_the_path() -> None:
    """Up a shoulder, which an edge at 77° cannot follow: a shop takes one that can."""
    up = turned(inward_deg=-88.0)
    made = insert.insert_elements(insert_of({"nose_radius_mm": 0.0}).tool, up)
    assert_allclose(np.degrees(np.arcsin(made.kappa[0][0, -1])), FOLLOWS_DEG)
    with pytest.raises(UnusableInput, match=r"an edge at 77° cannot follow"):
        insert.insert_elements(insert_of({"kappa_deg": 77.0}).tool, up)


def test_an_edge_that_cannot_follow_is_refused() -> None:
    with pytest.raises(UnusableInput, match=r"another kappa_deg"):
        insert.insert_elements(Insert(0.8, 20.0), turned(inward_deg=-30.0))


def test_mean_slot_forces_are_the_closed_form() -> None:
    """Means of a slot with constant coefficients, in closed form, within 0.1 %."""
    known = theta(shear_stress=500.0, chip_ratio=0.4, chip_ratio_thickness=0.0, K_ae=2.0)
    at = Edge(array(0.03), array(94.0), array(0.0), array(np.radians(30.0)))
    shear_t, shear_r, shear_a = (one[0] for one in shear.chip_coefficients(known, at))
    teeth, depth, feed = 4, 4.0, 0.05
    expected = [
        -teeth * depth / 4 * shear_r * feed - teeth * depth / np.pi * 43.0,
        teeth * depth / 4 * shear_t * feed + teeth * depth / np.pi * 24.0,
        teeth * depth / np.pi * shear_a * feed + teeth * depth / 2 * 2.0,
    ]
    mill = EndMill(10.0, teeth, 30.0)
    mean = cut_forces(known, endmill.averaged(mill, milled(a_slot()))).force_N[0]
    assert_allclose(mean, expected, rtol=1e-6)
    angles = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
    wave = endmill.waveform(known, mill, milled(a_slot()), angles)
    assert_allclose(wave.force_N.mean(axis=0), expected, rtol=1e-3)


def test_half_up_and_half_down_are_a_slot() -> None:
    known, mill, half = theta(edge_mm=0.02), EndMill(10.0, 3, 38.0, rake_deg=6.0), array(5.0)
    whole, up, down = (
        cut_forces(known, endmill.averaged(mill, milled(band))).all
        for band in (a_slot(), endmill.up(10.0, half), endmill.down(10.0, half))
    )
    assert_allclose(up + down, whole, rtol=5e-4)


def test_the_contracts_example_of_one_tooth() -> None:
    """D 10, 4 teeth, helix 0, slot, h 0.05, K_tc 2000, K_rc 600, a_p 1: F_x -30, F_y +100 N."""
    made = endmill.at_angles(
        EndMill(10.0, 4), milled(a_slot(), depth=1.0), array(0.5 * np.pi), slice_mm=1.0
    )
    tooth = (made.phi[0] > 0.999) & (made.width_mm > 0)
    radial, tangential = 600.0 * 0.05, 2000.0 * 0.05
    assert_allclose(made.edge.thickness_mm[tooth], 0.05, rtol=1e-12)
    sin, cos = made.phi[0][tooth], made.phi[1][tooth]
    force = [-tangential * cos - radial * sin, tangential * sin - radial * cos]
    assert_allclose(np.ravel(force), [-30.0, 100.0], rtol=1e-9, atol=1e-9)
    one_law = theta(chip_ratio_thickness=0.0)
    single = cut_forces(one_law, _only(made, tooth))
    t, r, _ = (one[0] for one in shear.per_width(one_law, _orthogonal(0.05)))
    assert_allclose(single.force_N[0, :2], [-r, t], rtol=1e-9, atol=1e-6)


def _only(made: Elements, keep: NDArray[np.bool_]) -> Elements:
    from dataclasses import replace

    return replace(made, width_mm=np.where(keep, made.width_mm, 0.0))


TOOLS = (
    EndMill(10.0, 4, 30.0, corner_radius_mm=1.0),
    EndMill(10.0, 2, 30.0, corner_radius_mm=5.0, rake_deg=5.0),
    EndMill(10.0, 4, (30.0, 35.0, 30.0, 35.0), (85.0, 95.0, 85.0, 95.0)),
    EndMill(10.0, 4, 30.0, runout_mm=0.01, runout_deg=40.0),
)
BANDS = (
    a_slot(),
    endmill.up(10.0, array(3.0)),
    endmill.down(10.0, array(3.0)),
    endmill.pocket(10.0, hole_mm=array(8.0), path_mm=array(6.0)),
)


@pytest.mark.parametrize("tool", TOOLS, ids=["bull", "ball", "variable", "run-out"])
@pytest.mark.parametrize("band", BANDS, ids=["slot", "up", "down", "pocket"])
def test_means_are_those_of_the_waveform(tool: EndMill, band: tuple[Array, Array]) -> None:
    """Within 0.5 % of the largest component, slices of 0.02 mm against quadrature."""
    known = theta(K_ae=1.0)
    cut = milled(band, depth=3.0, ramp=0.05, direction=0.3)
    mean = cut_forces(known, endmill.averaged(tool, cut)).force_N[0]
    angles = np.linspace(0.0, 2.0 * np.pi, 360, endpoint=False)
    wave = endmill.waveform(known, tool, cut, angles, slice_mm=0.02).force_N.mean(axis=0)
    assert_allclose(wave, mean, atol=5e-3 * np.abs(mean).max())


def test_runout_moves_chips_from_tooth_to_tooth_and_keeps_their_sum() -> None:
    """Where every tooth still cuts: per turn the same is fed at every angle."""
    angles = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
    chips = []
    for runout in (0.0, 0.01):
        mill = EndMill(10.0, 4, 0.0, runout_mm=runout)
        made = endmill.at_angles(mill, milled(a_slot(), depth=0.1), angles)
        assert made.of is not None
        chips.append(np.sum(made.edge.thickness_mm * (made.phi[0] > 0.51)))
    assert_allclose(chips[1], chips[0], rtol=1e-9)


def test_harmonics_of_a_turn_are_the_teeths_and_run_out_adds_the_spindles() -> None:
    """Four even teeth: multiples of four only; run-out: the spindle's own line too."""
    plain, uneven = (
        endmill.turn(theta(), EndMill(10.0, 4, 30.0, runout_mm=out), milled(a_slot(), depth=1.0))
        for out in (0.0, 0.02)
    )
    others = np.arange(1, 40) % 4 != 0
    assert np.all(plain.amplitude[1:40][others] < 1e-6 * plain.amplitude[4].max())
    assert uneven.amplitude[1, 0] > 0.05 * uneven.amplitude[4, 0]
    assert_allclose(plain.amplitude[0], np.abs(plain.mean), rtol=1e-9, atol=1e-9)
    assert_allclose(np.abs(plain.peak), np.abs(plain.forces.all).max(axis=0), rtol=1e-12)


def test_a_turned_feed_turns_the_force() -> None:
    mill = EndMill(10.0, 4, 30.0)
    plain = cut_forces(STEEL, endmill.averaged(mill, milled(a_slot()))).force_N[0]
    quarter = cut_forces(STEEL, endmill.averaged(mill, milled(a_slot(), direction=0.5 * np.pi)))
    assert_allclose(quarter.force_N[0], [-plain[1], plain[0], plain[2]], rtol=1e-12)


def test_a_pocket_of_a_large_radius_is_a_straight_wall() -> None:
    straight = endmill.down(10.0, array(3.0))
    curved = endmill.pocket(10.0, hole_mm=array(1e6 + 2.0), path_mm=array(1e6))
    assert_allclose(curved, straight, atol=1e-4)
    tight = endmill.pocket(10.0, hole_mm=array(8.0), path_mm=array(6.0))
    assert tight[1] > straight[1], "a small pocket engages more of the tool"


def test_a_drill_pushes_back_and_twists() -> None:
    """Torque grows with the square of the diameter, thrust is made by lips and chisel edge."""
    cut = drill.DrilledCuts(array(0.1, 0.2), array(1000.0, 1000.0))
    small, large = (
        cut_forces(STEEL, drill.drill_elements(drill.Drill(d), cut)) for d in (5.0, 10.0)
    )
    assert_allclose(small.force_N[:, :2], 0.0, atol=1e-9)
    assert np.all(small.force_N[:, 2] > 0)
    assert_allclose(large.torque_N_m / small.torque_N_m, 4.0, rtol=0.02)
    assert_allclose(large.force_N[:, 2] / small.force_N[:, 2], 2.0, rtol=0.02)


def test_many_cuts_are_the_same_cuts_alone() -> None:
    """More than are summed together: each as if it were alone."""
    rng, count = np.random.default_rng(1), 2300
    cuts = TurnedCuts(
        rng.uniform(0.1, 0.4, count), rng.uniform(0.2, 3.0, count),
        rng.uniform(50.0, 300.0, count), rng.uniform(5.0, 50.0, count),
        rng.choice([0.0, 0.5 * np.pi], count),
    )  # fmt: skip
    known = theta(chip_flow=0.5)
    together = cut_forces(known, insert.insert_elements(Insert(0.8, 93.0), cuts)).all
    for k in (0, 999, 1000, 2299):
        one = TurnedCuts(*(getattr(cuts, name)[k : k + 1] for name in TurnedCuts.__annotations__))
        alone = cut_forces(known, insert.insert_elements(Insert(0.8, 93.0), one)).all
        assert_allclose(together[k], alone[0], rtol=1e-12)


def test_gradients_and_parts_of_sums() -> None:
    known = theta(chip_flow=0.4, edge_mm=0.01)
    made = (
        insert.insert_elements(Insert(0.8, 95.0, 6.0, -5.0), turned(inward_deg=20.0)),
        endmill.averaged(EndMill(10.0, 3, 30.0), milled(a_slot())),
        endmill.at_angles(EndMill(10.0, 3, 30.0), milled(a_slot()), array(0.3, 1.4)),
    )
    for elements in made:
        slopes = force_gradient(known, elements)
        for k in range(len(known)):
            step = 1e-5 * (np.arange(len(known)) == k)
            two = [cut_forces(known + sign * step, elements).all for sign in (1.0, -1.0)]
            assert_allclose(slopes[..., k], (two[0] - two[1]) / 2e-5, rtol=1e-5, atol=1e-4)
        whole = cut_forces(known, elements).all
        parts = force_parts(known, elements)
        assert_allclose(parts[..., :2].sum(axis=-1), whole, rtol=1e-10, atol=1e-9)


def test_a_face_cut_outward_is_one_cut_inward_in_a_mirror() -> None:
    """Across the axis: pushed against its feed, off the same finished surface."""
    tool = Insert(0.8, 95.0, included_deg=80.0)
    inward, outward = (
        cut_forces(STEEL, insert.insert_elements(tool, turned(inward_deg=angle))).force_N[0]
        for angle in (90.0, -90.0)
    )
    assert_allclose(outward, inward * [-1.0, 1.0, 1.0], rtol=1e-9)
