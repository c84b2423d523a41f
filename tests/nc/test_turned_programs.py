"""Turned and polar coordinates, round pockets and loops that never end, worked out by hand."""

from math import cos, hypot, pi, radians, sin
from time import perf_counter

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.errors import UnusableInput
from autodb.nc.reading import Rapid, runner
from autodb.nc.reading.turning_program import ReadProgram, carried_out, turning_program

HEAD = "G21 G90 G17\nT1 M6\nS1000 M3\nF100\nG0 X0 Y0 Z5\n"
LATHE = "G21 G99\nG97 S800 M3\nG0 X56 Z2\n"


def milled(body: str, *, control: str | None = None, radius_mm: float = 3.0) -> ReadProgram:
    return carried_out(
        HEAD + body, source="p.nc", lathe=False, control=control, radius_of=lambda _: radius_mm
    )


def ends(done: ReadProgram) -> list[tuple[float, float]]:
    return [(one.end.x_mm, one.end.y_mm) for one in done.travels if one.feed is not None]


def test_g68_turns_places_increments_and_arcs_about_its_centre() -> None:
    """A square and an arc, turned by 30° about (10, 5): each place by the rotation's formula."""
    body = "G1 Z-1\nG1 X20 Y5\nY15\nG91 X-10\nG90 G2 X20 Y5 I5 J-5\nG1 Z-2\n"
    plain = milled(body)
    turned = milled("G68 X10 Y5 R30\n" + body + "G69\nG1 X1 Y2\n")
    c, s = cos(radians(30)), sin(radians(30))

    def moved(x: float, y: float) -> tuple[float, float]:
        return 10 + c * (x - 10) - s * (y - 5), 5 + s * (x - 10) + c * (y - 5)

    assert_allclose(ends(turned)[1:-1], [moved(*one) for one in ends(plain)[1:]], atol=1e-6)
    assert ends(turned)[-1] == (1, 2)
    (arc,) = [one for one in turned.travels if one.circle]
    (same,) = [one for one in plain.travels if one.circle]
    assert arc.length_mm == pytest.approx(same.length_mm)
    half = same.places(np.array([0.5]))[0, :2]
    assert_allclose(arc.places(np.array([0.5]))[0, :2], moved(*half), atol=1e-6)


def test_rot_of_sinumerik_turns_shifted_coordinates() -> None:
    body = "TRANS X10 Y5\nAROT RPL=90\nG1 Z-1\nG1 X20 Y5\nROT\nG1 X1 Y2\n"
    found = ends(milled(body, control="sinumerik"))
    # (20, 5) in coordinates at (10, 5) that are turned by a right angle: (10 - 5, 5 + 20)
    assert_allclose(found[1:], [(5, 25), (1, 2)], atol=1e-6)


def test_g16_drills_a_ring_by_radius_and_angle() -> None:
    body = "G16\nG99 G81 X20 Y30 Z-4 R1\nG91 Y60 K2\nG90 G15\nG80\nG1 X1 Y2\n"
    found = milled(body)
    holes = [one for one in ends(found) if one != (1, 2)]
    assert_allclose(
        holes, [(20 * cos(radians(a)), 20 * sin(radians(a))) for a in (30, 90, 150)], atol=1e-9
    )
    assert ends(found)[-1] == (1, 2)
    with pytest.raises(UnusableInput, match="line 7: 'G16': radius or angle is missing"):
        milled("G16\nG1 X5\n")


@pytest.mark.parametrize("code,left", [("G12", False), ("G13", True)])
def test_a_round_pocket_goes_around_and_leaves_its_radius(code: str, *, left: bool) -> None:
    """Circles of 2, 4, 6, 7 mm for I5 K10 Q2 and a mill of 3; half circles in and out."""
    done = milled(f"G0 X40 Y30\nG1 Z0\n{code} I5. K10. Q2. Z-2. F100 D1\n")
    around = [one for one in done.travels if one.circle]
    radii = [one.length_mm / (2 * pi) for one in around if one.start == one.end]
    assert_allclose(radii, [2, 4, 6, 7])
    assert all(one.circle is not None and one.circle.left is left for one in around)
    halves = [one.length_mm / pi for one in around if one.start != one.end]
    assert_allclose(halves, [1, 3.5])
    reached = max(
        hypot(*(place[:2] - (40, 30)))
        for one in around
        for place in one.places(np.linspace(0.0, 1.0, 33))
    )
    assert reached == pytest.approx(7)
    assert {one.end.z_mm for one in around} == {-2.0}
    assert (done.travels[-1].end.x_mm, done.travels[-1].end.y_mm) == (40, 30)


def test_a_round_pocket_goes_deeper_by_steps() -> None:
    done = milled("G0 X0 Y0\nG1 Z0\nG91 G13 I8. Z-1. L3 F100 D1\nG90\n")
    assert sorted({one.end.z_mm for one in done.travels if one.circle}) == [-3.0, -2.0, -1.0]
    for body, said in (
        ("G13 I2. Z-1 D1\n", "a tool of radius 3 mm does not fit"),
        ("G13 K9. Z-1 D1\n", "state the radius I"),
        ("G13 I5. K9. Q0. Z-1 D1\n", "this step is too small"),
    ):
        with pytest.raises(UnusableInput, match=said):
            milled(body)


def test_what_stays_unread_of_turned_coordinates_is_said() -> None:
    for body, said in (
        ("G18\nG68 X0 Z0 R5\n", "turned coordinates are read in the plane of X and Y"),
        ("G68 X0 Y0\n", "state the angle R"),
        ("G68 X0 Y0 R5\nG68 X0 Y0 R5\n", "turned already"),
        ("G68 X0 Y0 R5\nG52 X3\n", "coordinates are turned here"),
    ):
        with pytest.raises(UnusableInput, match=said):
            milled(body + "G1 X5\n")
    with pytest.raises(UnusableInput, match="'G68': this turns coordinates"):
        turning_program(LATHE + "G68 X0 Z0 R5\nG1 Z-5 F.1\n", source="p.nc")


@pytest.mark.parametrize(
    "body,line,word",
    [
        ("N10 G1 Z-5 F.1\nG0 Z2\nGOTO 10\n", 6, "GOTO 10"),
        ("WHILE[1EQ1]DO1\nEND1\n", 5, "END1"),
        ("#1=0\nWHILE[#1LT5]DO1\nG1 Z-5 F.1\nG0 Z2\nEND1\n", 8, "END1"),
    ],
)
def test_a_loop_in_which_nothing_changes_is_refused_at_once(
    body: str, line: int, word: str
) -> None:
    begun = perf_counter()
    with pytest.raises(UnusableInput, match=f"line {line}: '{word}': this loop never ends"):
        turning_program(LATHE + body + "M30\n", source="p.nc")
    assert perf_counter() - begun < 1.0


def test_a_loop_that_counts_the_wrong_way_ends_in_a_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runner, "MOST_AGAIN", 200)
    body = "#1=0\nWHILE[#1LT5]DO1\nG1 Z-5 F.1\nG0 Z2\n#1=#1-1\nEND1\nM30\n"
    with pytest.raises(UnusableInput, match="line 9: 'END1': this loop has gone back 200 times"):
        turning_program(LATHE + body, source="p.nc")
    monkeypatch.setattr(runner, "MOST_BLOCKS", 100)
    with pytest.raises(UnusableInput, match="more than 100 blocks have run"):
        turning_program(LATHE + body, source="p.nc")


def test_loops_within_loops_and_loops_that_ask_for_places_run_to_their_ends(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(runner, "MOST_AGAIN", 20)
    within = "WHILE[#1LT15]DO1\n#2=0\nWHILE[#2LT15]DO2\nG1 X#2\n#2=#2+1\nEND2\n#1=#1+1\nEND1\n"
    assert len(ends(milled(f"#1=0\n{within}"))) >= 15 * 14
    by_place = "WHILE[#5043GT-6]DO1\nG91 G1 Z-1\nG90 X10\nX0\nEND1\n"
    assert min(one.end.z_mm for one in milled(by_place).travels) == -6.0


@pytest.mark.parametrize(("unit", "mm"), [("G21", 1.0), ("G20", 25.4)])
@pytest.mark.parametrize("name", ["#<_x>", "#5420"])
def test_linuxcnc_tells_x_as_a_radius_in_g7_too(unit: str, mm: float, name: str) -> None:
    """Its macros double it: from Ø2 the next place is Ø3, by whichever name it is asked for."""
    text = f"G7 G18 {unit} G95\nG97 S900 M3\nF.01\nG0 X2 Z1\nG1 X[{name} * 2 + 1]\nM2\n"
    (move,) = turning_program(text, source="p.ngc").moves
    assert_allclose([move.start.x_mm, move.end.x_mm], [mm, 1.5 * mm])
    radii = text.replace("G7", "G8").replace("* 2 + 1", "+ 1")
    (move,) = turning_program(radii, source="p.ngc").moves
    assert_allclose([move.start.x_mm, move.end.x_mm], [2 * mm, 3 * mm])


@pytest.mark.parametrize("cycle", ["G73 X0 Z-20 R1 Q5 F.1", "G71 Q10 X62 Z2 I2 F.1"])
def test_the_feed_in_a_block_of_a_linuxcnc_cycle_holds_for_it(cycle: str) -> None:
    contour = "o10 sub\nG0 X50\nG1 Z-20\nX62\no10 endsub\n"
    text = f"G7 G18 G21 G95\nG97 S900 M3\nF.2\n{contour}G0 X62 Z2\n{cycle}\nM2\n"
    fed = [m for m in turning_program(text, source="p.ngc").moves if not isinstance(m, Rapid)]
    assert {move.feed.mm for move in fed} == {0.1}
