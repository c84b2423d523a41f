"""Constructs of programs as controls and posts write them: read where their meaning is certain."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.errors import UnusableInput
from autodb.files.job import JobProgram
from autodb.forward.programs import follow
from autodb.nc.reading.turning_program import ReadProgram, carried_out, program_text

MILL = "O1\nG21 G17 G90 G54\nT1 M6\nS1000 M3\nG0 X0 Y0\nG43 H1 Z5.\n"
SINUMERIK = "G17 G54 G90 G710 G94\nT1 D1 M6\nS1000 M3\nG0 X0 Y0 Z5\nG1 Z-1 F100\n"
LINUXCNC = "G21 G90 G94 G64 P0.01\nT1 M6\nS1000 M3\nG0 X0 Y0 Z5\n"


def _read(text: str, *, lathe: bool = False, source: str = "p.nc") -> ReadProgram:
    radius = None if lathe else lambda _move: 0.0
    return carried_out(text, source=source, lathe=lathe, inch=False, radius_of=radius)


def _way_mm(done: ReadProgram) -> float:
    return sum(one.length_mm for one in done.travels if one.feed is not None)


def _refusal(text: str, *, lathe: bool = False, source: str = "p.nc") -> str:
    with pytest.raises(UnusableInput) as caught:
        _read(text, lathe=lathe, source=source)
    return str(caught.value)


@pytest.mark.parametrize(
    ("text", "way_mm", "time_s"),
    [
        (MILL + "G1 F0\nG1 Z-1. F60\nX10.\nM30", 16.0, 16.0),
        (MILL + "G1 Z-1. F60\nG91 G28 X0 Y0 Z100. G90\nG0 X0 Y0 Z5.\nG1 Z-1.\nM30", 12.0, 12.0),
        (MILL + "M5\nG84 Z-8. R2. F1000.\nX10.\nG80\nM30", 40.0, 2.4),
        (MILL.replace("T1 M6", "T1 T2 M6") + "G1 Z-1. F60\nM30", 6.0, 6.0),
        (LINUXCNC + "M67 E0 Q5\nM62 P1\nG33.1 Z-5 K1\nM2", 20.0, 1.2),
        (SINUMERIK + "MCALL CYCLE81(5,0,1,-3)\nCYCLE801(0,0,0,10,10,3,2)\nMCALL\nM30", 30, 18),
        (SINUMERIK + "DEF REAL AA, BB=4\nG1 X=AA+BB\nM30", 10.0, 6.0),
        ("$P.MIN%\nG15 H1\n" + MILL[3:].replace("G43", "G56") + "G1 Z-1. F60\nM2", 6.0, 6.0),
    ],
    ids=["F0", "G91 G28 G90", "tap", "two T", "G33.1", "CYCLE801", "DEF", "Okuma"],
)  # fmt: skip
def test_a_construct_of_certain_meaning_is_read(text: str, way_mm: float, time_s: float) -> None:
    text = text.replace("G21 G17", "G17") if text.startswith("$") else text
    done = _read(text)
    assert_allclose(_way_mm(done), way_mm)
    assert_allclose(done.fed_s, time_s)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("TRAORI", "'TRAORI': this moves axes together"),
        ('CYCLE800(0,"A",0,57,0,0,0,0,90,0,0,0,0,1)', "'CYCLE800': this tilts"),
        ("MIRROR X0", "'MIRROR': this mirrors"),
        ("CT X5 Y5", "'CT': this is an arc by a tangent"),
        ("OVR=50", "'OVR=50': this changes the feed"),
        ("FB=20", "'FB=20': this feed is of one block"),
        ("POS[X]=20", "'POS[X]=20': this moves an axis by itself"),
        ("G58 X5", "'G58': this shifts axes"),
        ("G1 X=R7", "'R7': nothing in the program has set 'R7'"),
        ("G1 X=$P_TOOLR", "'$P_TOOLR': nothing in the program has set"),
        ("G1 X5 A10", "'A10': this turns a rotary axis"),
        ("MCALL HOLES1(0,0,0,5,5,3)", "'MCALL': HOLES1 is a row of places"),
    ],
)
def test_what_would_move_the_tool_otherwise_is_refused(words: str, says: str) -> None:
    assert _refusal(f"{SINUMERIK}{words}\nG1 X10\nM30").startswith(f"p.nc: line 6: {says}")


def test_a_swivel_that_is_taken_back_and_a_scale_of_one_change_nothing() -> None:
    none = ("CYCLE800()", "MIRROR", "SCALE X1 Y1", "OVRX=3", "DYNFINISH", "IF $P_SIM GOTOF ENDE")
    for words in none:
        assert_allclose(_way_mm(_read(f"{SINUMERIK}{words}\nG1 X10\nENDE:\nM30")), 16.0)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("0 BEGIN PGM A MM\n1 TOOL CALL 5 Z S2000\n2 L X+9 R0 FMAX M3", "line 1: '0 BEGIN PGM'"),
        ("PARTNO A\nGOTO/1,2,3", "line 1: 'PARTNO': this is APT"),
        ("%PM\nN9000 (A)\nN10 G54", "line 1: '%PM': this is Philips' and MAHO's"),
        (
            "$A.MIN%\nG50 S2000\nG0 X90\nG85 NLAP1 D4 U0.2\nNLAP1 G81\nG1 X20\nG80\nVC1=3\nM2",
            "line 4: 'G85 NLAP1': this is Okuma's own language, of which only moves, feeds and "
            "speeds are read; write out variables, calls and contours as G0, G1, G2 and G3, or "
            "post it for Fanuc (so in line 5, 8)",
        ),
    ],
)  # fmt: skip
def test_another_language_is_refused_in_one_line(text: str, says: str) -> None:
    said = _refusal(text, lathe=True)
    assert said.startswith(f"p.nc: {says}")
    assert said.count("line ") <= 2


def test_missing_subprograms_are_named_all_at_once_and_contours_at_their_call() -> None:
    text = SINUMERIK + 'L54\nEXTCALL("PART2")\nREPORT("a",1)\nG1 X10\nM30'
    said = _refusal(text)
    for line, name in ((6, "L54"), (7, "PART2"), (8, "REPORT")):
        assert f"line {line}: '{name}': there is no subprogram of this name" in said
    turned = 'G18 G54 DIAMON\nT1 D1\nG96 S200 M4 F0.2\nG0 X52 Z2\nCYCLE62("K",0)\nM30'
    assert _refusal(turned, lathe=True).startswith("p.nc: line 5: 'K': there is no subprogram")


def test_a_program_outside_is_called_from_beside(tmp_path: Path) -> None:
    (tmp_path / "part.spf").write_text("G1 X10\nM17\n")
    path = tmp_path / "main.mpf"
    done = _read(SINUMERIK + 'EXTCALL("/_N_WKS_DIR/_N_PART_SPF")\nM30', source=str(path))
    assert_allclose(_way_mm(done), 16.0)


def test_u_and_w_on_the_way_home_do_not_tell_system_a() -> None:
    text = (
        "O1\nG90 G94 G18\nG21\nG92 S3000\nG28 U0. W0.\nT0101\nG95\nG97 S500 M3\nG0 X50. Z2.\n"
        "G1 Z-10. F.2\nM30"
    )
    assert _read(text, lathe=True).control == "fanuc-b"


def test_linuxcnc_takes_no_pecks_without_their_depth() -> None:
    text = "G21 G18 G7 G95\nT1 M6\nG97 S500 M3\nG0 X0 Z5\n{} Z-20 R2{} F0.1\nG80\nM2"
    for code in ("G83", "G73"):
        assert f"'{code}': LinuxCNC takes no pecks" in _refusal(text.format(code, ""), lathe=True)
        assert _read(text.format(code, " Q5"), lathe=True).fed_s > 0


PROFILE = (
    "G21 G18 G8 G90 G94\nT1 M6\nS1000 M3\nF100\nO100 SUB\nG0 X2 Z1\nG1 Z-5{}\nX6\n{}\nG1 X12\n"
    "O100 ENDSUB\nG0 X12 Z2\n{} Q100 D0 I1 R0.5\nM2"
)


def _least_x_mm(done: ReadProgram) -> float:
    return min(one.end.x_mm for one in done.travels if one.feed is not None and one.end.z_mm < -8)


def test_corners_of_a_profile_are_arcs_and_chamfers_that_end_where_these_would() -> None:
    plain, filleted, broken = (
        _read(PROFILE.format(corner, "Z-10", "G70"), lathe=True) for corner in ("", " A1", " C1")
    )
    assert_allclose(_way_mm(plain) - _way_mm(filleted), 2.0 - 0.5 * np.pi, atol=1e-3)
    assert_allclose(_way_mm(plain) - _way_mm(broken), 2.0 - np.sqrt(2.0), atol=1e-6)
    steps = _read(PROFILE.format("", "W-5", "G70"), lathe=True)
    assert_allclose(_way_mm(steps), _way_mm(plain))


def test_g71_1_leaves_a_pocket_g71_2_cuts_it_alone() -> None:
    neck = "G1 Z-8\nX3 Z-9\nZ-11\nX6 Z-12\nZ-15"
    whole, left, alone = (
        _read(PROFILE.format("", neck, code), lathe=True) for code in ("G71", "G71.1", "G71.2")
    )
    assert _least_x_mm(whole) == 3.0
    assert _least_x_mm(left) == 6.0
    assert _least_x_mm(alone) == 3.0
    assert _way_mm(alone) < _way_mm(whole)


def test_passes_of_g70_come_nearer_in_equal_steps_and_end_at_the_profile() -> None:
    text = PROFILE.format("", "G1 Z-10", "G70").replace("D0 I1 R0.5", "D0.4 P2")
    done = _read(text, lathe=True)
    depths = [
        one.end.x_mm for one in done.travels
        if one.feed is not None and abs(one.end.z_mm + 10) < 0.5 and one.end.x_mm < 7
    ]  # fmt: skip
    assert_allclose(sorted({round(one, 6) for one in depths}), [6.0, 6.2])


def test_subprograms_of_linuxcnc_in_fanuc_s_way_run_as_often_as_is_said() -> None:
    text = LINUXCNC + "G91\nM98 P1 L{}\nM30\nO1\nG1 X1 F60\nM99\n"
    for times in (1, 3):
        assert_allclose(_way_mm(_read(text.format(times))), times)
    assert "no cutting move" in _refusal(text.format(0))


def test_a_cycle_inside_its_own_contour_and_a_loop_left_open_are_refused() -> None:
    turned = (
        "O1\nG99\nT0101\nG97 S500 M3\nG0 X50. Z2.\nN10 G0 X20.\nG1 Z-5. F.1\nG70 P10 Q20\n"
        "N20 X50.\nM30"
    )
    assert "'G70': a cycle inside its own contour" in _refusal(turned, lathe=True)
    assert "this is never closed" in _refusal("O100 SUB\nG0 X1", lathe=True, source="a.ngc")


def test_a_contour_that_goes_back_on_itself_has_an_allowance_all_along() -> None:
    text = (
        "G18 G54 G90 G710 DIAMON G95\nT1 D1\nG97 S200 M4\nG0 X64 Z2\n"
        'CYCLE95("AA:BB",2,0.1,0.3,0.2,0.3,0.2,0.15,1,0,0,1)\n'
        "AA: G0 X20 Z1\nG1 Z-10\nX40\nX30\nZ-20\nBB: X64\nM30"
    )
    assert np.isfinite(_way_mm(_read(text, lathe=True)))


@pytest.mark.parametrize("text", ["X1e-05", "G1X2Y1E+1"])
def test_exponents_are_refused(text: str) -> None:
    assert "no control takes exponents" in _refusal(f"{MILL}G1 Z-1. F60\n{text}\nM30")


def test_a_program_in_utf_16_is_read_and_large_whole_numbers_are_noted(tmp_path: Path) -> None:
    text = MILL + "G1 Z-1. F60\nX5000\nM30"
    path = tmp_path / "p.nc"
    for encoding in ("utf-16", "utf-8-sig", "ascii"):
        path.write_bytes(text.replace("\n", "\r").encode(encoding))
        done = _read(program_text(path))
        assert_allclose(_way_mm(done), 5006.0)
        assert any("without a decimal point" in note for note in done.notes)


def test_a_path_that_no_computer_follows_is_refused_with_its_longest_move(tmp_path: Path) -> None:
    path = tmp_path / "p.nc"
    path.write_text(MILL + "G1 Z-1. F600\n" + "G3 I-9999.\n" * 40 + "M30")
    job = {
        "file": str(path), "block_mm": [-5, 5, -5, 5, -5, 0],
        "tools": {"other": {"kind": "end_mill", "diameter_mm": 4, "teeth": 2}},
    }  # fmt: skip
    with pytest.raises(UnusableInput, match=r"line 8: the path is too long .* alone is 62\.8 m"):
        follow(JobProgram.model_validate(job), units="mm", diameter=None)
