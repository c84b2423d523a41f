"""Engagement along a contour: depths by geometry, volumes conserved, rapids out of the stock."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.cutting.contour import engagement
from autodb.cutting.engaged_steps import ContourEngagement
from autodb.cutting.stock import Stock, bar, profile
from autodb.errors import UnusableInput
from autodb.nc.reading import turning_program
from autodb.standard import run_order
from tests.helpers.nc_cases import case_of
from tests.helpers.remedies import has_remedy

HEAD = "G95 G97 S1000 M3\n"
VOLUME = 0.002
"""Relative tolerance of volumes: steps of 0.05 mm across edges of the stock."""


def _cut(
    body: str, stock: Stock, *, head: str = HEAD, edge_mm: float = np.inf, step_mm: float = 0.05
) -> tuple[ContourEngagement, Stock]:
    """Return the engagement of a program that counts X as a radius, and the stock it leaves."""
    program = turning_program(head + body, source="p.nc", diameter=False)
    return engagement(program.moves, stock, source="p.nc", step_mm=step_mm, edge_mm=edge_mm)


def _removed(before: Stock, after: Stock, *, from_mm: float) -> float:
    return before.volume_mm3(from_mm=from_mm) - after.volume_mm3(from_mm=from_mm)


def _line(done: ContourEngagement, line: int) -> NDArray[np.bool_]:
    return np.asarray(done.line == line)


def test_a_longitudinal_pass_is_as_deep_as_it_takes_off_the_radius() -> None:
    done, left = _cut("G0 X18 Z2\nG1 Z-30 F.2\n", bar(20))
    cutting = done.z_mm < 0
    assert_allclose(done.depth_mm, np.where(cutting, 2.0, 0.0), atol=1e-12)
    assert_allclose((done.along_x[0], done.along_z[0]), (0, -1), atol=1e-12)
    assert_allclose(done.outer_mm, np.where(cutting, 20.0, 18.0), atol=1e-12)
    assert_allclose(done.speed_m_min[cutting], 2 * np.pi * 20, rtol=1e-12)
    assert_allclose(done.feed_mm_rev, 0.2)
    assert_allclose(done.path_mm[-1], 32 - 0.025, rtol=1e-12)
    assert_allclose(done.time_s, done.path_mm * 60 / 200, rtol=1e-12)
    assert_allclose(done.removed_mm3().sum(), np.pi * (20**2 - 18**2) * 30, rtol=1e-12)
    assert_allclose(left.radius_mm(np.array([-40.0, -15.0, 1.0])), [20, 18, 0])


def test_facing_is_as_deep_as_the_face_stands_out() -> None:
    done, left = _cut("G0 X22 Z-1.5\nG1 X0 F.2\n", bar(20, face_mm=0.5))
    assert_allclose(done.depth_mm, np.where(done.x_mm < 20, 2.0, 0.0), atol=1e-12)
    assert_allclose(done.outer_mm, done.x_mm)
    assert_allclose(left.radius_mm(np.array([-2.0, -1.0])), [20, 0])
    assert_allclose(done.removed_mm3().sum(), np.pi * 20**2 * 2, rtol=1e-12)


def test_facing_beyond_the_axis_cuts_nothing_there() -> None:
    done, _ = _cut("G0 X22 Z-1\nG1 X-0.8 F.2\n", bar(20))
    assert_allclose(done.depth_mm[done.x_mm < 0], 0.0, atol=0)
    assert_allclose(done.removed_mm3().sum(), np.pi * 20**2, rtol=VOLUME)


ANGLES_DEG = (5.0, 30.0, 45.0, 70.0)


@pytest.mark.parametrize("deg", ANGLES_DEG)
def test_a_cone_is_cut_at_the_distance_across(deg: float) -> None:
    """(X − x) cos θ in a cylinder: rising towards the chuck, or falling away from it."""
    angle = np.radians(deg)
    x1, z1 = 15.0 + 4 * np.sin(angle), -2.0 - 4 * np.cos(angle)
    rising, _ = _cut(f"G0 X15 Z2\nG1 Z-2 F.2\nX{x1:.9f} Z{z1:.9f}\n", bar(20))
    neck = profile(np.array([-50.0, z1, z1, 0.0]), np.array([x1, x1, 20.0, 20.0]))
    fed = f"G0 X{x1:.9f} Z-20\nG1 Z{z1:.9f} F.2\nX15 Z-2\n"
    falling, _ = _cut(fed, neck)
    for done in (rising, falling):
        cone = _line(done, 4)
        assert_allclose(done.depth_mm[cone], (20 - done.x_mm[cone]) * np.cos(angle), atol=1e-8)
        assert_allclose(done.outer_mm[cone], 20.0)


@pytest.mark.parametrize("deg", ANGLES_DEG)
def test_a_cone_with_an_even_allowance_is_cut_at_the_allowance(deg: float) -> None:
    slope, across = np.tan(np.radians(deg)), np.cos(np.radians(deg))
    z = np.array([-10.0, 0.0])
    stock = profile(z, 10 - slope * z + 0.5 / across)
    done, left = _cut(f"G0 X10 Z0\nG1 X{10 + 10 * slope:.9f} Z-10 F.2\n", stock)
    assert_allclose(done.depth_mm, 0.5, atol=1e-8)
    inner = np.linspace(-9.9, -0.1, 7)
    assert_allclose(left.radius_mm(inner), 10 - slope * inner, atol=1e-6)


def test_a_face_that_falls_outwards_is_cut_at_the_distance_across() -> None:
    """Inwards and away from the chuck, from outside: a cone of 80° under an even allowance."""
    slope = np.tan(np.radians(10.0))
    done, left = _cut(f"G0 X21 Z-5\nG1 X1 Z{-5 + 20 * slope:.9f} F.2\n", bar(20, face_mm=0.0))
    met = done.x_mm < 19.5  # the cell in which the path enters is straight between its ends
    assert_allclose(done.depth_mm[met], -done.z_mm[met] * np.cos(np.radians(10.0)), atol=1e-8)
    assert_allclose(left.radius_mm(done.z_mm[met]), done.x_mm[met], atol=1e-6)
    assert_allclose(left.radius_mm(np.array([-1.0])), 1.0)


def test_the_tool_leaves_in_air() -> None:
    """Off the shoulder and out, off the hub and out: all that it passes is turned already."""
    for body in (
        "G0 X18 Z2\nG1 Z-30 F.2\nX20 Z-28\nX30\n",
        "G0 X18 Z2\nG1 Z-30 F.2\nX22\n",
        "G0 X22 Z-2\nG1 X5 F.2\nX7 Z0\nZ2\n",
    ):
        done, _ = _cut(body, bar(20))
        assert_allclose(done.depth_mm[done.line > 3], 0.0, atol=1e-12)
        assert done.depth_mm.max() > 1.9


def test_the_allowance_of_a_shoulder_is_met_in_the_run_towards_it() -> None:
    stock = profile(np.array([-40.0, -29.7, -29.7, 0.0]), np.array([20.0, 20, 12.5, 12.5]))
    done, left = _cut("G0 X12 Z1\nG1 Z-30 F.1\nX21\n", stock)
    expected = np.where(done.z_mm > -29.7, 0.5, 8.0) * (done.z_mm < 0) * (done.line == 3)
    assert_allclose(done.depth_mm, expected, atol=1e-9)
    assert_allclose(left.radius_mm(np.array([-29.9, -30.1])), [12.0, 20.0])


def test_a_ball_under_an_even_allowance_is_cut_less_deep_where_it_is_steep() -> None:
    """√((ρ + a)² − ρ² sin²φ) − ρ cos φ, times cos φ: 4 %, 11 %, 45 % less at 45°, 60°, 80°."""
    angle = np.linspace(0.0, np.pi, 20_001)[::-1]
    stock = profile(5.5 * np.cos(angle), 5.5 * np.sin(angle))
    x, z = 5 * np.sin(np.radians(5)), 5 * np.cos(np.radians(5))
    done, _ = _cut(f"G0 X{x:.9f} Z9\nG1 F.1 Z{z:.9f}\nG3 X5 Z0 R5\n", stock, step_mm=0.01)
    ball = _line(done, 4)
    slope = np.arctan2(done.along_x, -done.along_z)[ball]
    less = 1 - np.interp(np.radians([45, 60, 80]), slope[::-1], done.depth_mm[ball][::-1]) / 0.5
    assert_allclose(less, [0.042, 0.109, 0.450], atol=0.002)


ROUGH_AND_FINISH = """G0 X22 Z-0.5
G1 X0 F.2
G0 X18 Z1
G1 Z-40
X19 Z-39
G0 Z1
G0 X16
G1 Z-25
X17 Z-24
G0 Z1
G0 X5
G1 Z-0.5 F.1
G3 X10 Z-5.5 R5
G1 Z-15
X14 Z-22
G2 X17 Z-25 R3
G1 X22
"""


def test_the_volume_of_several_passes_is_what_the_stock_has_lost() -> None:
    stock = bar(20)
    done, left = _cut(ROUGH_AND_FINISH, stock)
    lost = _removed(stock, left, from_mm=-45.0)
    assert_allclose(done.removed_mm3().sum(), lost, rtol=VOLUME)
    finished = (
        _volume([10.0, 10.0], [9.5])
        + _volume([10.0, 14.0], [7.0])
        + _round_volume(centre=5.0, radius=5.0, sign=1)
        + _round_volume(centre=17.0, radius=3.0, sign=-1)
        + _volume([18.0, 18.0], [15.0])
        + _volume([20.0, 20.0], [5.0])
    )
    assert_allclose(left.volume_mm3(from_mm=-45.0), finished, rtol=VOLUME)
    at = np.array([-0.6, -10.0, -18.5, -24.0, -30.0, -44.0])
    ball, fillet = 5 + np.sqrt(25 - 4.9**2), 17 - np.sqrt(9 - 2.0**2)
    assert_allclose(left.radius_mm(at), [ball, 10, 12, fillet, 18, 20], atol=2e-3)


def _volume(radii: Sequence[float], lengths: Sequence[float]) -> float:
    a, b = radii
    return float(np.pi / 3 * sum(lengths) * (a * a + a * b + b * b))


def _round_volume(*, centre: float, radius: float, sign: int) -> float:
    """Return the volume inside a quarter circle turned about the axis, by Gauss-Legendre."""
    nodes, weights = np.polynomial.legendre.leggauss(60)
    angle = np.pi / 4 * (nodes + 1)
    x = centre + sign * radius * np.sin(angle)
    return float(np.sum(weights * np.pi / 4 * np.pi * x**2 * radius * np.sin(angle)))


DRAWN = 12
"""Contours that are drawn; what they must keep is geometry, so that no draw may fail."""


def test_drawn_contours_take_off_what_the_stock_loses() -> None:
    """Cones up and down (less than 45° down) to drawn depths, in passes, with square shoulders."""
    draw = np.random.default_rng(20)
    for _ in range(DRAWN):
        stock, face = bar(20.0), -draw.uniform(0.2, 1.5)
        z = np.concatenate([[0.0], -np.cumsum(draw.uniform(3.0, 8.0, 6))])
        x = np.clip(12 + np.cumsum(draw.uniform(-2.5, 2.5, 7)), 6, 17)
        body = f"G0 X22 Z{face:.3f}\nG1 X0 F.2\nG0 Z2\n"
        for offset in (2.4, 0.6, 0.0):
            body += f"G0 X{x[0] + offset:.3f} Z2\nG1 F.2\n"
            body += "".join(f"X{a + offset:.3f} Z{b:.3f}\n" for a, b in zip(x, z, strict=True))
            body += "X23\nG0 X23 Z2\n"
        done, left = _cut(body, stock)
        lost = _removed(stock, left, from_mm=-60.0)
        assert_allclose(done.removed_mm3().sum(), lost, rtol=VOLUME)
        assert_allclose(left.radius_mm(z[1:-1]), x[1:-1], atol=0.001)


def test_many_short_moves_are_met_like_one() -> None:
    """A cone and an arc in 40 chords each: the same depth at the same place."""
    angle = np.radians(np.linspace(90.0, 0.0, 41))
    cone = "".join(f"X{12 + 3 * s:.9f} Z{-5 - 9 * s:.9f}\n" for s in np.linspace(0, 1, 41))
    chords = "".join(f"X{18 - 3 * np.sin(a):.9f} Z{-14 - 3 * np.cos(a):.9f}\n" for a in angle[1:])
    many, _ = _cut(f"G0 X12 Z2\nG1 F.2 {cone}{chords}", bar(20))
    one, _ = _cut("G0 X12 Z2\nG1 Z-5 F.2\nX15 Z-14\nG2 X18 Z-17 R3\n", bar(20))
    at = np.linspace(-1.0, -16.9, 50)
    depths = [np.interp(-at, -done.z_mm, done.depth_mm) for done in (many, one)]
    assert_allclose(depths[0], depths[1], atol=0.1)  # the chords' directions are steps of 2.25°
    assert_allclose(many.removed_mm3().sum(), one.removed_mm3().sum(), rtol=VOLUME)


def test_constant_cutting_speed_holds_at_the_tip_up_to_its_limit() -> None:
    done, _ = _cut("G0 X22 Z-1\nG1 X0 F.2\n", bar(20), head="G95 G50 S2000\nG96 S180 M3\n")
    expected = np.minimum(180_000 / (2 * np.pi * done.x_mm), 2000)
    assert_allclose(done.speed_rpm, expected, rtol=1e-12)
    assert_allclose(done.speed_m_min[done.speed_rpm < 2000], 180, rtol=1e-12)
    per_minute, _ = _cut("G0 X18 Z1\nG1 Z-5 F150\n", bar(20), head="G94 G97 S1000 M3\n")
    assert_allclose(per_minute.feed_mm_rev, 0.15)
    assert_allclose(per_minute.time_s[-1] + per_minute.time_s[0], 6 / 150 * 60)


REFUSED = {
    "rapid": ("G0 X18 Z2\nG0 Z-5\nG1 Z-6 F.1", "line 3: this rapid goes through the"),
    "slanting rapid": (
        "G0 X30 Z2\nG1 X25 F.1\nG0 X12 Z-4", "line 4: this rapid goes through the stock, at",
    ),
    "edge": ("G0 X14 Z2\nG1 Z-5 F.1", "line 3: 6.000 mm deep, more than the edge's 5 mm"),
    "bore": ("G0 X0 Z2\nG1 Z-5 F.1", "line 3: 20.000 mm deep, more than the edge's 5 mm"),
    "plunge": ("G0 X22 Z-10\nG1 X17 Z-11 F.1", "line 3: this move enters the stock"),
    "far off": ("G0 X50 Z-1\nG0 Z999000\nG1 X40 F.1", "line 3: the path is 999 m long"),
    "endless": ("G96 S100\nG0 X22 Z-1\nG1 X0 F.1", "line 4: G96 reaches the axis without a"),
}  # fmt: skip


@pytest.mark.parametrize(("body", "says"), REFUSED.values(), ids=REFUSED)
def test_what_the_tool_cannot_do_is_refused_with_its_line(body: str, says: str) -> None:
    with pytest.raises(UnusableInput) as caught:
        _cut(body, bar(20), edge_mm=5.0)
    assert str(caught.value).startswith(f"p.nc: {says}")
    assert has_remedy(str(caught.value))


def test_no_move_at_a_feed_is_refused() -> None:
    with pytest.raises(UnusableInput, match=r"p\.nc: no move at a feed; use a program with G1"):
        engagement([], bar(20), source="p.nc")


def test_a_profile_needs_z_rising() -> None:
    with pytest.raises(ValueError, match="z rising"):
        profile(np.array([0.0, -1.0]), np.array([10.0, 10.0]))


def test_the_standard_cuts_that_we_write_are_as_deep_as_their_protocol_says() -> None:
    """Bar after bar: between two stops of the program, each cut at its depth, feed and speed."""
    case = case_of("turning-aluminium", "siemens")
    kit = case.protocol.bar
    assert kit
    program = turning_program(case.text, source="p.nc", block_skip=True)
    bounds = [0, *program.stops, case.text.count("\n") + 1]
    found = []
    for first, last in pairwise(bounds):
        moves = [move for move in program.moves if first < move.line <= last]
        if moves:
            found += _cuts(
                engagement(moves, bar(kit.diameter_mm / 2), source="p.nc", step_mm=0.2)[0]
            )
    wanted = [(cut.depth_mm, cut.feed_mm_rev, cut.speed_rpm) for cut in run_order(case.protocol)]
    assert_allclose(found, np.array(wanted, dtype=float), atol=1e-3)


def _cuts(done: ContourEngagement) -> list[tuple[float, float, float]]:
    """Return depth, feed and speed of each line that cuts."""
    lines = np.unique(done.line[done.depth_mm > 0.01])
    return [
        (
            float(np.median(done.depth_mm[(done.line == line) & (done.depth_mm > 0.01)])),
            float(done.feed_mm_rev[done.line == line][0]),
            float(done.speed_rpm[done.line == line][0]),
        )
        for line in lines
    ]


def test_a_way_into_a_bar_away_from_the_chuck_does_not_face_it() -> None:
    """A finishing pass towards the tailstock: in by 1 mm over 2 mm of the axis, along 37 mm."""
    done, left = _cut("G0 X23 Z-39\nG1 X19 Z-37 F.2\nZ2\n", bar(20))
    first, second = _line(done, 3), _line(done, 4)
    assert done.depth_mm[first].max() < 1.0
    assert_allclose(done.removed_mm3()[second].sum(), np.pi * (20**2 - 19**2) * 37, rtol=VOLUME)
    assert_allclose(left.radius_mm(np.array([-30.0, -1.0])), [19, 19])
    face, _ = _cut("G0 X23 Z-2\nG1 X-1 Z-1.5 F.2\n", bar(20))  # a cone over the face
    at = (face.x_mm > 4.9) & (face.x_mm < 5.1)
    assert_allclose(face.depth_mm[at], 2 - 0.5 * 18 / 24, rtol=0.01)


def test_the_end_of_an_edge_lies_above_what_is_thinner_before_it() -> None:
    """Off a shoulder 0.5 mm, and 0.3 mm below the allowance of the next cylinder.

    Of that the end of the edge, 5° off the axis, meets 0.5 mm, and (0.3 - 0.5 tan 5°)/tan 5° more.
    """
    roughed = "G0 X15.3 Z2\nG1 Z-20 F.2\nX20.5\nG0 X22 Z-40.5\n"
    done, left = _cut(f"{roughed}G1 X20 Z-40 F.2\nZ-20.5\nX15\nZ2\n", bar(20.5))
    inwards = _line(done, 8)
    assert_allclose(done.depth_mm[inwards & (done.x_mm > 15.4)], 0.5, atol=0.01)
    assert_allclose(done.depth_mm[inwards].max(), 0.3 / np.tan(np.radians(5.0)), rtol=0.1)
    along = _line(done, 9) & (done.z_mm > -16) & (done.z_mm < 0)
    assert_allclose(done.depth_mm[along], 0.3, rtol=1e-9)
    assert_allclose(left.radius_mm(np.array([-10.0, -30.0])), [15, 20])


def test_a_face_is_as_deep_behind_a_change_of_feed() -> None:
    done, _ = _cut("G0 X22 Z-1.5\nG1 X9 F.2\nX0 F.1\n", bar(20))
    assert_allclose(done.depth_mm[done.x_mm < 20], 1.5, atol=1e-12)
