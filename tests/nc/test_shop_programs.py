"""What programs of shops and schools hold beside moves, and what becomes of it."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.cutting.stock import bar
from autodb.cutting.working import WorkTool, solid, worked
from autodb.errors import UnusableInput
from autodb.files.job import JobProgram
from autodb.forward.programs import follow
from autodb.forward.sides import above_axis
from autodb.nc.reading import Arc, Linear, TurningProgram, turning_program
from autodb.nc.reading.controls import FANUC_A, control_of
from autodb.nc.reading.turning_program import carried_out

HEAD = "O1\nG21 G40 G99\nG97 S1000 M3\nT0101\n"
TURN = "G0 X62 Z2\nG1 X50 F.2\nZ-20\nG0 X70\n"


def _read(body: str, head: str = HEAD, **how: float) -> TurningProgram:
    return turning_program(head + body, source="p.nc", **how)  # type: ignore[arg-type]


def _cuts(program: TurningProgram) -> list[Linear | Arc]:
    return [move for move in program.moves if isinstance(move, Linear | Arc)]


SILENT = {
    "simulator": "[BILLET X60 Z70\n[TOOLDEF T1 D10\n",
    "print": "DPRNT[DATE*#3011[60]]\nPOPEN\nPCLOS\n",
    "empty number": "N M8\nN\n",
    "path modes": "G187 P2 E.05\nG5.1 Q1\nG61.1\nG5 P10000\n",
}


@pytest.mark.parametrize("lines", SILENT.values(), ids=SILENT)
def test_lines_that_move_nothing_change_nothing(lines: str) -> None:
    plain = [(move.start, move.end) for move in _read(TURN).moves]
    assert [(move.start, move.end) for move in _read(lines + TURN).moves] == plain


def test_what_stands_behind_the_end_of_a_file_is_none() -> None:
    assert _read(TURN + "M30%").moves
    assert _read(TURN + "M30\n\x1a\x00garbage").moves


def test_a_builders_word_is_taken_to_move_nothing_and_said() -> None:
    notes = _read("M155\n" + TURN + "M155\nM203 S500\n").notes
    assert notes == tuple(
        f"M{n} is the machine builder's word: taken to move no axis" for n in (155, 203)
    )
    with pytest.raises(UnusableInput, match="line 5: 'M198': this M is not read"):
        _read("M198 P1000\n" + TURN)


def test_path_tolerances_of_linuxcnc_stand_beside_motion() -> None:
    text = "G7 G18 G21 G95\nG97 S900 M3\nG64 P0.01 Q0.01 G0 X62 Z2\nG1 X50 F.2\nM2\n"
    assert len(turning_program(text, source="p.ngc").moves) == 1


def test_an_arc_without_a_radius_is_a_line_on_fanucs_controls() -> None:
    body = "G0 X20 Z0\nG3 X30 Z-5 R5 F.1\nX40\nG1 Z-9\n"
    program = _read(body)
    assert [type(move) for move in _cuts(program)] == [Arc, Linear, Linear]
    assert "straight lines" in program.notes[0]
    with pytest.raises(UnusableInput, match=r"'\w+': state an arc with either"):
        turning_program("G18 G90 DIAMON\nS900 M3\nF.1 " + body.replace("R5", "CR=5"), source="p")


def test_arcs_that_nearly_close_are_spirals() -> None:
    program = _read("G0 X20 Z0\nG3 X30.06 Z-5 K-5 F.1\n")
    (arc,) = _cuts(program)
    assert arc.end == (15.03, -5)
    assert "0.1 mm off their circles" in program.notes[0]


def test_a_way_from_where_nobody_says_is_none_of_a_cut() -> None:
    program = _read("G1 X62 Z2 F.5\nX50\nZ-20\n")
    assert [(move.start, move.end) for move in _cuts(program)] == [
        ((31, 2), (25, 2)), ((25, 2), (25, -20)),
    ]  # fmt: skip
    assert "line 5: nothing says where X and Z is before this move" in program.notes[0]
    above = carried_out("G21 S900 M3\nG1 X9 Y9 F900\nG0 Z2\nG1 Z-1\nX20\n", source="p", lathe=False)
    assert [t.end.x_mm for t in above.travels if t.feed] == [9, 20]


def test_with_the_spindle_stopped_a_bar_is_pulled_not_cut() -> None:
    pull = "M5\nG98\nG0 X0 Z5\nG1 Z-10 F500\nG1 Z20\nM3\nG99\n"
    program = _read(TURN + pull + "G0 X62 Z2\nG1 X40 F.2\n")
    assert len(_cuts(program)) == 3
    assert "the spindle stands since line 9" in program.notes[0]


def test_after_a_cycle_of_holes_motion_goes_on_as_before() -> None:
    holes = "G0 X0 Y0 Z9\nG81 X5 Y5 Z-3 R1 F90\nX15\nG80\nX0\nZ30\n"
    travels = carried_out("O1\nG21 G90 G54\nS900 M3\n" + holes, source="p", lathe=False).travels
    assert (travels[-1].feed, tuple(travels[-1].end)) == (None, (0, 5, 30))


def test_finishing_goes_on_where_the_tool_was_changed() -> None:
    """What nobody says: where the turret is; the contour's first block says where to go."""
    contour = "N10 G0 X30\nN12 G1 Z-20 F.1\nN20 X60\n"
    body = f"G0 X62 Z2\nG71 U2 R.5\nG71 P10 Q20 U0 W0 F.3\n{contour}G28 U0 W0\nT0202\nG0 Z2\n"
    found = _cuts(_read(body + "G70 P10 Q20\n"))
    assert [move.end for move in found[-2:]] == [(15, -20), (30, -20)]


def test_depths_without_a_point_count_least_increments_where_they_are_large() -> None:
    contour = "N10 G0 X30\nN12 G1 Z-20 F.1\nN20 X60\n"
    ways = [
        "G71 U2. R.5\nG71 P10 Q20 U.4 W.1 F.3\n", "G71 U2000 R500\nG71 P10 Q20 U400 W100 F.3\n",
    ]  # fmt: skip
    plain, counted = (
        [move.end for move in _read("G0 X62 Z2\n" + way + contour).moves] for way in ways
    )
    assert_allclose(plain, counted)


def _turned(text: str, tool: WorkTool | None = None) -> float:
    moves, _ = above_axis(turning_program(text, source="p.nc", highest_rpm=3000).moves)
    return worked(moves, solid(bar(30.0)), {None: tool or WorkTool()}, source="p").removed_mm3


def test_tools_below_the_axis_cut_the_same() -> None:
    body = "G0 X62 Z2\nX40\nG1 Z-9 F.2\nG3 X50 Z-14 R5\nG0 X70\n"
    below = body.replace("X", "X-").replace("G3", "G2")
    assert_allclose(_turned(HEAD + below), _turned(HEAD + body), rtol=1e-12)
    moves, notes = above_axis(_read(below).moves)
    assert notes == ("X is below 0 where tools 0101 cut: seen from above the axis",)
    assert min(move.end.x_mm for move in moves) > 0


def test_passes_on_the_axis_and_past_it_take_off_the_last_core() -> None:
    """Down to a core of 2 mm in front of z = -5, then at the axis, then past it."""
    steps = "G0 X62 Z2\n" + "".join(
        f"G1 X{x} F.2\nZ-5\nG0 X62\nZ2\n" for x in (30, 4, "{}")
    )  # fmt: skip
    for last in ("0", "-1.6"):
        assert_allclose(_turned(HEAD + steps.format(last)), np.pi * 30**2 * 5, rtol=1e-6)


def test_a_blade_goes_along_an_arc() -> None:
    groove = "G0 X62 Z-10\nG1 X54 F.1\nG2 X58 Z-12 R2\nG1 X62\n"
    wide = WorkTool("grooving", width_mm=3.0)
    plain = _turned(HEAD + "G0 X62 Z-10\nG1 X54 F.1\nX62\n", wide)
    assert _turned(HEAD + groove, wide) > plain


def test_the_machines_highest_speed_stands_for_a_limit_of_g96() -> None:
    face = "G21 G99\nG96 S200 M3\nT0101\nG0 X62 Z0\nG1 X-1 F.2\n"
    assert _turned(face) >= 0
    with pytest.raises(UnusableInput, match=r"state max_speed_rpm in the machine's \[spindle\]"):
        worked(
            turning_program(face, source="p").moves, solid(bar(30.0, face_mm=1.0)),
            {None: WorkTool()}, source="p",
        )  # fmt: skip


def test_refusals_of_one_kind_are_said_once() -> None:
    body = "M5\nG0 X20 Z0\nG1 Z-5 F.1\nM3\nG1 Z-6\nM5\nG1 Z-7\n"
    with pytest.raises(UnusableInput, match=r"line 7: 'G1': the spindle .* \(so in line 11\)$"):
        _read(body)


def test_long_lists_of_places_tell_no_control() -> None:
    text = "G28 U0 W0\n" + "".join(f"N{k} X{k % 50}.5 Z-{k}.25\n" for k in range(2000))
    assert control_of(text) is FANUC_A


def test_a_cycle_of_holes_states_where_its_first_hole_is() -> None:
    text = "O1\nG21 G90\nS900 M3\nG0 Z50\nG81 X6 Y14 Z-2 R2 F90\nY10\nG80\n"
    travels = carried_out(text, source="p", lathe=False).travels
    assert [tuple(t.end) for t in travels if t.feed] == [(6, 14, -2), (6, 10, -2)]


def test_a_block_of_the_program_itself_is_called() -> None:
    body = "G0 X62 Z2\nM98 Q100 L3\nM30\nN100 G0 U-4\nG1 W-12 F.2\nG0 U2\nW12\nU-2\nM99\n"
    assert [move.end.x_mm for move in _cuts(_read(body))] == [29, 27, 25]


def test_a_blade_that_widens_its_groove_cuts_to_either_side(tmp_path: Path) -> None:
    """Its z force is said to be that of a cut towards the chuck."""
    path = tmp_path / "p.nc"
    path.write_text(HEAD + "G0 X62 Z-10\nG1 X54 F.1\nZ-12\nG0 X62\nZ-10\nG1 X54\nZ-8\nX62\n")
    blade = {"other": {"kind": "grooving", "width_mm": 3.0}}
    asked = JobProgram.model_validate({"file": str(path), "stock_diameter_mm": 60, "tools": blade})
    found = follow(asked, units=None, diameter=None)
    assert found.notes == (
        "a blade cuts away from the chuck in lines 11: its z is that of a cut towards it",
    )
    there, back = (next(line for line in found.lines if line.number == n) for n in (7, 11))
    assert there.steps == back.steps


@pytest.mark.parametrize("words", ["G0 C90.", "G0 X20. Y3.", "G83 Z-15. R2. Q3000 F0.08\nC90."])
def test_where_driven_tools_cut_a_lathes_program_may_end_before(words: str) -> None:
    with pytest.raises(UnusableInput, match=r"by last_line in the job$"):
        _read(f"S900 M3\nG0 X40. Z5.\n{words}\n")
