"""Programs of schools: tools that no M6 changes, machine places behind a feed, feeds."""

from pathlib import Path

import pytest
from numpy.testing import assert_allclose

from autodb.errors import UnusableInput
from autodb.files.job import JobProgram
from autodb.forward.line_parts import Followed
from autodb.forward.programs import follow
from autodb.nc.reading import Linear, turning_program
from autodb.nc.reading.turning_program import carried_out

LATHE = "O1\nG21 G40 G99\nG97 S1000 M3\nT0101\n"
MILL = "G21 G90 G94 G17\n{}S5000 M3\nG0 X-10 Y10 Z5\nG1 Z-1 F300\nX60\nM30\n"
MILLS = {"1": {"kind": "end_mill", "diameter_mm": 10.0, "teeth": 2}}


def _follow(folder: Path, text: str, **said: object) -> Followed:
    path = folder / "p.nc"
    path.write_text(text)
    asked = JobProgram.model_validate({"file": str(path), **said})
    return follow(asked, units=None, diameter=None)


@pytest.mark.parametrize("call", ["T1\n", "T1 (M6 SCREWS)\n", "T1 M6\n"])
def test_the_tool_that_t_names_cuts_where_no_m6_changes_one(tmp_path: Path, call: str) -> None:
    found = _follow(tmp_path, MILL.format(call), block_mm=[0, 50, 0, 20, -5, 0], tools=MILLS)
    assert found.tools == ("1",)
    assert any("no M6 changes a tool" in note for note in found.notes) == ("T1 M6" not in call)
    assert_allclose(found.removed_mm3, 50 * 10 * 1, rtol=0.02)


def test_a_tool_that_is_only_readied_is_not_the_one_that_cuts() -> None:
    text = MILL.format("T1 M6\nT2\n")
    travels = carried_out(text, source="p.nc", lathe=False).travels
    assert {travel.tool for travel in travels} == {"1"}


def test_a_mill_that_no_program_and_no_job_names_is_asked_for(tmp_path: Path) -> None:
    with pytest.raises(UnusableInput, match=r"calls no tool before this.*\[program\.tools\.other"):
        _follow(tmp_path, MILL.format(""), block_mm=[0, 50, 0, 20, -5, 0], tools=MILLS)


def test_fanucs_controls_go_fast_to_a_place_of_the_machine() -> None:
    body = "G0 X62 Z2\nG1 X50 F.2\nZ-20\nG53 X200 Z100\n"
    moves = turning_program(LATHE + body, source="p.nc").moves
    assert [type(move) for move in moves] == [Linear, Linear]
    with pytest.raises(UnusableInput, match="line 8: 'G53': this cuts in machine coordinates"):
        turning_program(LATHE + body.replace("G53 X", "G1 G53 X"), source="p.nc")
    radii = body.replace("X200 Z100", "X1 Z1")
    with pytest.raises(UnusableInput, match="'G53': this cuts in machine coordinates"):
        turning_program("G7 G18 G21 G95\nG97 S900 M3\n" + radii, source="p.ngc")


def test_feeds_beyond_any_tool_are_refused_in_all_their_lines(tmp_path: Path) -> None:
    body = "G0 X62 Z2\nG1 X50 F200\nZ-20\nX62\nG0 Z2\nG1 X49 F.2\n"
    with pytest.raises(UnusableInput, match=r"line 6: a feed of 200 .* \(so in line 7, 8\)$"):
        _follow(tmp_path, LATHE + body, stock_diameter_mm=60)


def test_a_job_says_what_feeds_count_where_the_program_does_not(tmp_path: Path) -> None:
    silent = LATHE.replace(" G99", "")
    body = "G0 X62 Z2\nG1 X58 F200\nZ-20\nX62\n"
    found = _follow(tmp_path, silent + body, stock_diameter_mm=60, feeds="minute")
    assert_allclose(found.fed_s, 60 * (2 + 22 + 2) / 200, rtol=1e-9)
    assert not any("what feeds count" in note for note in found.notes)
    again = body.replace("G1 X58 F200", "G99 G1 X58 F.2")
    found = _follow(tmp_path, silent + again, stock_diameter_mm=60, feeds="minute")
    assert_allclose(found.fed_s, 60 * (2 + 22 + 2) / (0.2 * 1000), rtol=1e-9)
    with pytest.raises(ValueError, match="feeds goes with a lathe's stock"):
        JobProgram.model_validate({"file": "p", "block_mm": [0, 1, 0, 1, 0, 1], "feeds": "minute"})
