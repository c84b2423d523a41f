"""Cycles, loops and subprograms: what they leave of the stock, worked out by hand."""

from itertools import pairwise
from math import pi

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.cutting.stock import bar
from autodb.cutting.working import WorkTool, solid, worked
from autodb.errors import UnusableInput
from autodb.nc.reading import Linear, Rapid, turning_program
from autodb.nc.reading.turning_program import ReadProgram, carried_out

FANUC = "O0001\nG21 G40 G99\nG97 S1000 M3\nT0101\n"
CONE_MM3 = pi / 3 * 10 * (20**2 + 20 * 25 + 25**2)
"""Of the contour below: Ø30 to z −20, Ø40 to z −30, a cone to Ø50 at z −40."""
CONTOUR = "N10 G0 X30\nN12 G1 Z-20 F.1\nX40\nZ-30\nX50 Z-40\nN20 X60\n"
PART_MM3 = pi * (15**2 * 20 + 20**2 * 10) + CONE_MM3


def _removed(text: str, tool: WorkTool | None = None, *, bore: float = 0.0) -> float:
    moves = turning_program(text, source="p.nc").moves
    work = solid(bar(30.0), bore_mm=bore)
    return worked(moves, work, {None: tool or WorkTool()}, source="p.nc").removed_mm3


BAR_MM3 = pi * 30**2 * 40
WAYS = {
    "G71 in two blocks": "G0 X62 Z2\nG71 U2 R.5\nG71 P10 Q20 U0 W0 F.3\n" + CONTOUR,
    "G71 in one block": "G0 X62 Z2\nG71 P10 Q20 U0 W0 D1.5 F.3\n" + CONTOUR,
    "G71 and G70": "G0 X62 Z2\nG71 U2 R.5\nG71 P10 Q20 U.5 W.1 F.3\n" + CONTOUR + "G70 P10 Q20\n",
    "G73": "G0 X70 Z5\nG73 U15 W0 R8\nG73 P10 Q20 U0 W0 F.3\n" + CONTOUR,
    "G72": "G0 X62 Z2\nG72 W2 R.5\nG72 P10 Q20 U0 W0 F.3\n"
    "N10 G0 Z-40\nN11 G1 X50 F.1\nX40 Z-30\nZ-20\nX30\nN20 Z2\n",
}  # fmt: skip


@pytest.mark.parametrize("body", WAYS.values(), ids=WAYS)
def test_a_part_is_the_same_whichever_cycle_makes_it(body: str) -> None:
    assert_allclose(_removed(FANUC + body), BAR_MM3 - PART_MM3, rtol=0.004)


def test_one_pass_cycles_make_boxes_and_cones() -> None:
    boxes = FANUC + "G0 X62 Z2\nG90 X50 Z-40 F.2\nX40 Z-30\nX30 Z-20\n"
    steps = pi * ((30**2 - 25**2) * 40 + (25**2 - 20**2) * 30 + (20**2 - 15**2) * 20)
    assert_allclose(_removed(boxes), steps, rtol=1e-6)
    faces = FANUC + "G0 X62 Z2\nG94 X30 Z-10 F.2\nZ-20\nX40 Z-30\n"
    assert_allclose(_removed(faces), pi * ((30**2 - 15**2) * 20 + (30**2 - 20**2) * 10), rtol=0.003)
    moves = turning_program(FANUC + "G0 X62 Z2\nG90 X50 Z-40 R-5 F.2\n", source="p.nc").moves
    (cone,) = [m for m in moves if isinstance(m, Linear) and m.start.x_mm != m.end.x_mm][:1]
    assert_allclose([cone.start, cone.end], [(20, 2), (25, -40)])


def test_the_systems_b_and_c_name_their_cycles_otherwise() -> None:
    """System A's G90, G92 and G94 are G77 to G79 in B, and G20, G21 and G24 in C."""
    body = "G97 S1000 M3\nG0 X62 Z2\n{} X50 Z-40 F.2\nX40 Z-30\n"
    steps = pi * ((30**2 - 25**2) * 40 + (25**2 - 20**2) * 30)
    assert_allclose(_removed("O1\nG90 G95\n" + body.format("G77")), steps, rtol=1e-6)
    moves = turning_program("O1\nG90 G95\n" + body.format("G20"), source="p", control="fanuc-c")
    done = worked(moves.moves, solid(bar(30.0)), {None: WorkTool()}, source="p")
    assert_allclose(done.removed_mm3, steps, rtol=1e-6)


def test_a_macro_turns_steps_that_its_loop_counts() -> None:
    loop = (
        "G0 X62 Z2\n#1=58\nWHILE[#1GE40]DO1\nG0 X#1\nG1 Z-[#1-30] F.2\nG0 U2\nZ2\n#1=#1-2\nEND1\n"
    )
    steps = [pi * ((x / 2 + 1) ** 2 - (x / 2) ** 2) * (x - 30) for x in range(58, 39, -2)]
    assert_allclose(_removed(FANUC + loop), sum(steps), rtol=1e-6)
    call = "G0 X62 Z2\nM98 P0030002\nM30\nO0002\nG0 U-4\nG1 W-12 F.2\nG0 U2\nW12\nU-2\nM99\n"
    thrice = pi * (30**2 - 25**2) * 10  # 58, 54 and 50 mm
    assert_allclose(_removed(FANUC + call), thrice, rtol=1e-6)
    macro = "G65 P9 A58 B-20\nM30\nO0009\nG0 X62 Z2\nX#1\nG1 Z#2 F.2\nG0 X62\nM99\n"
    assert_allclose(_removed(FANUC + macro), pi * (30**2 - 29**2) * 20, rtol=1e-6)


def test_other_controls_say_the_same_steps() -> None:
    steps = pi * ((30**2 - 28**2) + (28**2 - 26**2)) * 20
    linuxcnc = (
        "G7 G21 G18 G95\nG97 S900 M3\nG0 X62 Z2\n#<x>=56\no100 while [#<x> GE 52]\nG0 X#<x>\n"
        "G1 Z-20 F.2\nG0 X62\nZ2\n#<x>=[#<x>-4]\no100 endwhile\nM2\n"
    )
    assert_allclose(_removed(linuxcnc), steps, rtol=1e-6)
    sinumerik = (
        "G18 G710 G90 G95 DIAMON\nG97 S900 M4\nG0 X62 Z2\nR1=56\nAGAIN:\nG0 X=R1\nG1 Z-20 F.2\n"
        "G0 X62\nZ2\nR1=R1-4\nIF R1>=52 GOTOB AGAIN\nM30\n"
    )
    assert_allclose(_removed(sinumerik), steps, rtol=1e-6)
    inner = sinumerik.replace("R1=56\nAGAIN:\n", "FOR R1=0 TO 1\n").replace("X=R1", "X=56-4*R1")
    inner = inner.replace("R1=R1-4\nIF R1>=52 GOTOB AGAIN", "ENDFOR")
    assert_allclose(_removed(inner), steps, rtol=1e-6)


def test_contours_of_sinumerik_and_linuxcnc_leave_the_part() -> None:
    """CYCLE95 takes the outermost place of the contour for the stock: Ø60."""
    head = "G18 G710 G90 G95 DIAMON\nG97 S900 M4\nG0 X70 Z5\n"
    cycle = 'CYCLE95("SHAFT",2,0,0,0,0.3,0.2,0.1,9,0,0,0.5)\nM30\n'
    shaft = "%_N_SHAFT_SPF\nG1 X30 Z0\nZ-20\nX40\nZ-30\nX50 Z-40\nX60\nM17\n"
    assert_allclose(_removed(head + cycle + shaft), BAR_MM3 - PART_MM3, rtol=0.004)
    linuxcnc = (
        "G7 G21 G18 G95\nG97 S900 M3\nF.2\no10 sub\nG0 X30 Z2\nG1 Z-20\nX40\nZ-30\nX50 Z-40\nX62\n"
        "o10 endsub\nG0 X62 Z2\nG71 Q10 X62 Z2 D0.3 I1.5 R0.5\nG70 Q10 X62 Z2 D0\nM2\n"
    )
    assert_allclose(_removed(linuxcnc), BAR_MM3 - PART_MM3, rtol=0.004)


def test_grooves_pecks_and_a_bore_take_what_their_tools_are_wide() -> None:
    groove = FANUC + "G0 X62 Z-10\nG75 R.5\nG75 X50 Z-14 P2000 Q2000 F.08\n"
    blade = WorkTool("grooving", width_mm=3.0)
    assert_allclose(_removed(groove, blade), pi * (30**2 - 25**2) * 7, rtol=1e-3)
    drill = FANUC + "G0 X0 Z2\nG74 R1\nG74 Z-30 Q8000 F.1\n"
    hole = _removed(drill, WorkTool("drill", diameter_mm=20.0))
    assert_allclose(hole, pi * 10**2 * 30, rtol=1e-3)
    bore = FANUC + "G0 X20 Z2\nX24\nG1 Z-40 F.1\nG0 X20\nZ2\n"
    assert_allclose(
        _removed(bore, WorkTool("boring"), bore=10.0), pi * (12**2 - 10**2) * 40, rtol=1e-3
    )
    with pytest.raises(UnusableInput, match="goes through the stock"):
        _removed(bore, bore=10.0)


def test_a_thread_takes_equal_sections_down_to_its_root() -> None:
    """M20 × 1.5, 0.92 mm high: the V's area is h² tan 30° by the pitch, over 25 mm."""
    thread = FANUC + "G0 X22 Z5\nG76 P010060 Q50 R.05\nG76 X18.16 Z-20 P920 Q300 F1.5\n"
    moves = turning_program(thread, source="p.nc").moves
    roots = [m.end.x_mm for m in moves if isinstance(m, Linear)]
    assert_allclose(roots[-1], 9.08, atol=1e-9)
    assert all(b <= a for a, b in pairwise(roots))
    depth = 10.0 - np.array(roots[:-1])
    assert_allclose(depth[:3], 0.3 * np.sqrt([1, 2, 3]), rtol=1e-9)
    found = worked(moves, solid(bar(10.0)), {None: WorkTool()}, source="p.nc")
    area = 0.92**2 * np.tan(pi / 6)
    assert_allclose(found.removed_mm3, area * 2 * pi * 9.08 * 20 / 1.5, rtol=0.05)
    box = FANUC + "G0 X22 Z5\nG92 X19.2 Z-20 F1.5\nX18.6\nX18.16\n"
    cuts = [m for m in turning_program(box, source="p").moves if isinstance(m, Linear)]
    assert [m.end.x_mm for m in cuts] == [9.6, 9.3, 9.08]
    assert all(m.thread and m.feed.mm == 1.5 for m in cuts)


def _mill(body: str, head: str = "G21 G90 G17\nS1000 M3\n") -> ReadProgram:
    return carried_out(head + body, source="p.nc", lathe=False)


def test_holes_of_a_mill_are_drilled_from_r_to_z() -> None:
    for code, times in (("G81", 1), ("G83 Q4", 1), ("G85", 2), ("G73 Q4", 1)):
        holes = f"G0 X0 Y0 Z20\nG98 {code} X10 Y0 Z-12 R2 F100\nX20\nG91 X10 L3\nG80\n"
        done = _mill(holes)
        deep = [t for t in done.travels if t.feed is not None and t.end.z_mm == -12.0]
        assert [t.end.x_mm for t in deep] == [10, 20, 30, 40, 50]
        fed = sum(t.length_mm for t in done.travels if t.feed is not None)
        again = 0.254 * 5 * 3 if "Q" in code else 0.0
        assert_allclose(fed, 5 * 14 * times + again, rtol=1e-9)


def test_helices_planes_and_polar_words_go_where_they_say() -> None:
    helix = _mill("G0 X10 Y0 Z0\nG3 X10 Y0 Z-3 I-10 F100\n").travels[-1]
    assert_allclose(helix.length_mm, np.hypot(2 * pi * 10, 3))
    for plane, arc in (("G18", "G2 X20 Z0 I10 K0"), ("G19", "G3 Y20 Z0 J10 K0")):
        done = _mill(f"{plane}\nG0 X0 Y0 Z0\n{arc} F100\n").travels[-1]
        assert_allclose(done.length_mm, pi * 10)
        assert_allclose(done.places(np.array([0.5]))[0, 2], -10)
    polar = carried_out("S9 M3\nF9\nG0 X0 Y0 Z0\nG1 @10 ^90\n", source="p.ngc", lathe=False)
    assert_allclose(polar.travels[-1].end, (0, 10, 0), atol=1e-9)


def test_corners_are_rounded_and_broken_between_their_moves() -> None:
    body = "G0 X20 Z2\nG1 Z-10 {} F.1\nX40\nZ-30\n"
    plain = turning_program(FANUC + body.format(""), source="p.nc").moves
    whole = sum(m.length_mm for m in plain if not isinstance(m, Rapid))
    for word, shorter in (("R3", 3 * (2 - pi / 2)), ("C3", 3 * (2 - np.sqrt(2))), (",R3", None)):
        moves = turning_program(FANUC + body.format(word), source="p.nc").moves
        way = sum(m.length_mm for m in moves if not isinstance(m, Rapid))
        expected = shorter if shorter is not None else 3 * (2 - pi / 2)
        assert_allclose(whole - way, expected)
        assert all(a.end == b.start for a, b in pairwise(moves))
    with pytest.raises(UnusableInput, match="line 6: a corner of 30 mm does not fit"):
        turning_program(FANUC + body.format("R30"), source="p.nc")
    angled = turning_program(FANUC + "G0 X20 Z2\nG1 Z-8 A170 F.1\n", source="p.nc").moves[-1]
    assert_allclose(angled.end.x_mm, 10 - 10 * np.tan(np.radians(170)))
