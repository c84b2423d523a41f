"""Lines as shops write them: block skip within them, comments, names, chamfers, spindles."""

from pathlib import Path

import pytest
from numpy.testing import assert_allclose

from autodb.errors import UnusableInput
from autodb.files.job import JobProgram
from autodb.forward.line_parts import Followed
from autodb.forward.programs import follow
from autodb.nc.reading import Point, program_text, turning_program
from autodb.nc.reading.turning_program import carried_out

HEAD = "O1\nG21 G40 G99\nG97 S1000 M3\nT0101\n"
TURN = "G0 X62 Z2\nG1 X50 F.2\nZ-20\nG0 X70\n"
MILL = "O1\nG21 G90\nS900 M3\nG0 X0 Y0 Z0\nG1 X9 F90\n"


def _ends(text: str, *, block_skip: bool = False) -> list[Point]:
    return [m.end for m in turning_program(text, source="p.nc", block_skip=block_skip).moves]


def _follow(folder: Path, text: str, **said: object) -> Followed:
    path = folder / "p.nc"
    path.write_text(text)
    return follow(JobProgram.model_validate({"file": str(path), **said}), units=None, diameter=None)


def test_block_skip_within_a_line_leaves_out_what_stands_behind_it() -> None:
    body = "G0 X62 Z2 / M8\nN20 / G1 X50 F.2\nG1 Z-20 F.2 /2 X48\n"
    assert _ends(HEAD + body) == [(25, 2), (24, -20)]
    assert _ends(HEAD + body, block_skip=True) == [(31, -20)]


def test_a_division_is_no_block_skip() -> None:
    body = "#1=[#2/2]\n#3=50/2\nG0 X62 Z2\nG1 X[#3/2] F.2\n"
    assert _ends(HEAD + "#2=9\n" + body) == [(6.25, 2)]


@pytest.mark.parametrize(
    "remark",
    ["(T1020 (1/8 PARTING TOOL)", "(\n(TOOLS:\n(T1 - ROUGH)", "(A (B) C)", "(OPEN\n  (X9)"],
)
def test_remarks_that_open_twice_or_stay_open_before_others(remark: str) -> None:
    assert _ends(f"{HEAD}{remark}\n{TURN}") == _ends(HEAD + TURN)


def test_a_remark_that_stays_open_before_words_is_refused() -> None:
    with pytest.raises(UnusableInput, match=r"line 5: '\(OPEN': a bracket does not close"):
        _ends(f"{HEAD}(OPEN\n{TURN}")


@pytest.mark.parametrize("name", ["Osample( sample.TXT )", "OSHAFT", "<SHAFT-7.A>"])
def test_a_name_in_place_of_a_number_names_the_program(name: str) -> None:
    assert _ends(f"%\n{name}\n{HEAD}{TURN}".replace("O1\n", "")) == _ends(HEAD + TURN)


@pytest.mark.parametrize("system", ["G99", "G90 G95"])
def test_a_chamfer_by_the_other_axis_is_one_by_c(system: str) -> None:
    head = f"O1\nG21 {system}\nG97 S1000 M3\nT0101\nG0 X20 Z0\n"
    by_letter = "G1 X40 K-2 F.2\nZ-20 I3\nX60\nZ-30\n"
    by_c = "G1 X40 C2 F.2\nZ-20 C3\nX60\nZ-30\n"
    assert _ends(head + by_letter) == _ends(head + by_c)
    assert (20, -2) in _ends(head + by_letter)  # 2 mm along the cylinder of 40 mm


def test_p_of_a_spindle_is_read_and_another_spindle_ends_what_is_read(tmp_path: Path) -> None:
    one = "O1\nG21 G99\nT0101\nG97 S1000 M3 P11 G0 X62 Z2\nG1 X50 F.2\nZ-20\nG0 X62\n"
    two = one + "T0202\nG97 S800 M3 P12\nG0 C90 Y4\nG1 X3 F.1\nM30\n"
    assert _ends(one) == [(25, 2), (25, -20), (31, -20)]
    with pytest.raises(UnusableInput, match=r"line 9: 'P12': this starts another.*before$"):
        _ends(two)
    found = _follow(tmp_path, two, stock_diameter_mm=60, last_line=8)
    assert_allclose(found.fed_s, 60 * (6 + 22) / 200)
    with pytest.raises(UnusableInput, match="has 12 lines, and last_line is 12"):
        _follow(tmp_path, two, stock_diameter_mm=60, last_line=12)


def test_a_job_leaves_out_what_is_behind_a_slash(tmp_path: Path) -> None:
    text = HEAD + "/2 M98 P8001\n" + TURN
    with pytest.raises(UnusableInput, match="line 5: '8001': there is no subprogram"):
        _follow(tmp_path, text, stock_diameter_mm=60)
    found = _follow(tmp_path, text, stock_diameter_mm=60, block_skip=True)
    assert_allclose(found.fed_s, 60 * (6 + 22) / 200)
    with pytest.raises(UnusableInput, match="no line of it has a /; leave out block_skip"):
        _follow(tmp_path, HEAD + "(4/5 OFF)\n" + TURN, stock_diameter_mm=60, block_skip=True)


def test_a_job_says_what_the_spindle_turns_at_where_the_program_does_not(tmp_path: Path) -> None:
    text = "G21 G90 G94\nT1 M6\nG0 X-10 Y10 Z5\nG1 Z-1 F300\nX60\nM30\n"
    asked = {
        "block_mm": [0, 50, 0, 20, -5, 0],
        "tools": {"1": {"kind": "end_mill", "diameter_mm": 10.0, "teeth": 2}},
    }
    with pytest.raises(UnusableInput, match=r"no spindle speed .* or speed_rpm in the job"):
        _follow(tmp_path, text, **asked)
    (line,) = _follow(tmp_path, text, **asked, speed_rpm=9000).lines
    assert line.fastest_rpm == 9000
    (line,) = _follow(tmp_path, text.replace("F300", "F300 S500 M3"), **asked, speed_rpm=9000).lines
    assert line.fastest_rpm == 500


FORMS = {
    "small letters": MILL.lower().encode(),
    "tabs": MILL.replace(" ", "\t").encode(),
    "ends of DOS": MILL.replace("\n", "\r\n").encode() + b"\x1a\x00\x00",
    "ends of old Macs": MILL.replace("\n", "\r").encode(),
    "a mark of UTF-8": b"\xef\xbb\xbf" + MILL.encode(),
    "UTF-16": MILL.encode("utf-16"),
    "umlauts of Latin-1": MILL.replace("O1", "O1 (FRÄSER FÜR GEHÄUSE Ø60)").encode("latin-1"),
    "Cyrillic": MILL.replace("O1", "O1 (КОРПУС НАСОСА)").encode("cp1251"),
    "zeros around it": bytes(400) + MILL.encode() + bytes(4000),
    "percent signs": b"%\n" + MILL.encode() + b"%\n",
}


@pytest.mark.parametrize("form", FORMS)
def test_a_program_is_the_same_in_every_form_of_its_file(tmp_path: Path, form: str) -> None:
    path = tmp_path / "p.nc"
    path.write_bytes(FORMS[form])
    plain = carried_out(MILL, source="p", lathe=False).travels
    done = carried_out(program_text(path), source="p", lathe=False).travels
    assert [(t.start, t.end) for t in done] == [(t.start, t.end) for t in plain]


def test_how_far_a_groove_draws_back_counts_ten_thousandths_of_an_inch() -> None:
    """R10 in inches is 254 mm as it stands: no peck draws back so far."""
    head = "O1\nG20 G99\nG97 S1000 M3\nT0101\nG0 X2. Z-1.\n"
    short, point = (head + f"G75 R{back}\nG75 X1.9 P100 F.005\n" for back in ("10", ".001"))
    plain = turning_program(point, source="p.nc").moves
    assert [move.end for move in turning_program(short, source="p.nc").moves] == [
        move.end for move in plain
    ]


@pytest.mark.parametrize(
    ("level", "begins_mm"), [("R-3.", 2), ("R1.", 1), ("R-3000", 2), ("R7.", 5)]
)
def test_where_a_lathes_cycle_of_a_hole_begins_to_feed(level: str, begins_mm: float) -> None:
    """From Z5: R-3 counts from there, as on Fanuc; R1 is a place, as on Haas."""
    text = f"O1\nG21 G99\nG97 S1000 M3\nT0101\nG0 X0 Z5.\nG83 Z-20. {level} F.1\nG80\n"
    (drilled,) = (move for move in turning_program(text, source="p.nc").moves if move.end[1] == -20)
    assert drilled.start.z_mm == begins_mm


def test_what_stands_behind_the_end_is_not_read_on_linuxcnc() -> None:
    """Only subprograms behind it may be called."""
    text = (
        "G21 G18 G7 G95\nG97 S900 M3\nM98 P5\nM2\nprint [x]\nO5\nG0 X62 Z2\nG1 X50 F.2\nM99\nwhat\n"
    )
    with pytest.raises(UnusableInput, match=r"^p.ngc: line 10: 'W': a word without a number"):
        turning_program(text, source="p.ngc")
    moves = turning_program(text.replace("what\n", ""), source="p.ngc").moves
    assert [move.end.x_mm for move in moves] == [25]
    sub = "G21 G18 G7 G95\nG97 S900 M3\no<a> call\nM30\n???\no<a> sub\nG0 X62 Z2\nG1 X50 F.2\n"
    sub += "o<a> endsub\n???"
    assert [move.end.x_mm for move in turning_program(sub, source="p.ngc").moves] == [25]


CALLS = {
    "fanuc": ("O1\nG21 G90 G94 G17\nT1 M6\nS900 M3\n", "M98 P8001\n", "8001"),
    "macro": ("O1\nG21 G90 G94 G17\nT1 M6\nS900 M3\n", "G65 P9023 A1. B2.\n", "9023"),
    "sinumerik": ("G710 G90 G94 G17\nT1 D1\nM6\nS900 M3\nR1=2\n", "L9023\n", "l9023"),
    "sinumerik with arguments": (
        "G710 G90 G94 G17\nT1 D1\nM6\nS900 M3\nR1=2\n", "CHECK_TOOL(1,2.5)\n", "CHECK_TOOL",
    ),
    "linuxcnc": ("G21 G90 G94 G17\nT1 M6\nS900 M3\nG64 P.1\n", "o<probe> call [1]\n", "probe"),
}  # fmt: skip


@pytest.mark.parametrize(("head", "call", "name"), CALLS.values(), ids=CALLS)
def test_a_job_leaves_out_subprograms_that_cut_nothing(
    tmp_path: Path, head: str, call: str, name: str
) -> None:
    body = "G0 X-10 Y10 Z5\nG1 Z-1 F300\nX60\n"
    asked = {
        "block_mm": [0, 50, 0, 20, -5, 0],
        "tools": {"other": {"kind": "end_mill", "diameter_mm": 10.0, "teeth": 4}},
    }
    with pytest.raises(UnusableInput, match="or name it in the job's left_out"):
        _follow(tmp_path, head + call + body + "M30\n", **asked)
    plain = _follow(tmp_path, head + body + "M30\n", **asked)
    found = _follow(tmp_path, head + call + body + "M30\n", **asked, left_out=[name])
    assert (found.fed_s, found.removed_mm3) == (plain.fed_s, plain.removed_mm3)
    with pytest.raises(UnusableInput, match=r"calls no subprogram '\w+' that is missing"):
        _follow(tmp_path, head + body + "M30\n", **asked, left_out=[name])


def test_where_the_tool_is_behind_a_subprogram_that_is_left_out_is_not_known(
    tmp_path: Path,
) -> None:
    body = TURN + "M98 P8001\nG1 Z-30\n"
    with pytest.raises(UnusableInput, match="line 10: 'G1': the start is not known in X"):
        _follow(tmp_path, HEAD + body, stock_diameter_mm=60, left_out=["8001"])
