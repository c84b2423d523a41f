"""Planes that a mill tilts while it stands: what is cut in the one that a job names by its line."""

from pathlib import Path

import pytest
from numpy.testing import assert_allclose

from autodb.errors import UnusableInput
from autodb.files.job import JobProgram
from autodb.forward.line_parts import Followed
from autodb.forward.programs import follow

BLOCK = [0.0, 50.0, 0.0, 20.0, -9.0, 0.0]
TOOLS = {"other": {"kind": "end_mill", "diameter_mm": 10.0, "teeth": 4}}


def _pass(depth_mm: float) -> str:
    """A slot of 10 mm along a block of 50 mm."""
    return f"G0 X-10 Y10\nG0 Z5\nG1 Z-{depth_mm:g} F300\nG1 X60\nG0 Z9\n"


SIEMENS = (
    "%_N_P_MPF\nG17 G710 G90 G94 G54\nCYCLE800()\nT1 M6\nS5000 M3\n" + _pass(1)  # lines 6 to 10
    + 'CYCLE800(1,"TC1",0,57,0,0,0,0,45,0,0,0,0,-1)\n' + _pass(2)  # from line 11
    + 'CYCLE800(1,"TC1",0,57,0,0,5,0,45,0,0,0,0,-1)\n' + _pass(3)  # from line 17
    + 'CYCLE800(1,"TC1",1,57,0,0,0,0,0,30,0,0,0,-1)\n' + _pass(4)  # from line 23, on that before
    + 'CYCLE800(1,"TC1",0,57,0,0,0,0,45,0,0,0,0,-1)\n' + _pass(2)  # from line 29, as line 11
    + "CYCLE800()\n" + _pass(5) + "M30\n"
)  # fmt: skip
FANUC = (
    "O1\nG17 G21 G90 G94 G54\nT1 M6\nS5000 M3\n" + _pass(1)  # lines 5 to 9
    + "G68.2 X0 Y0 Z0 I0 J45. K0\nG53.1\n" + _pass(2) + "G69\n"  # from line 10
    + "G68.2 X0 Y0 Z0 I90. J45. K0\nG53.1\n" + _pass(3) + "G69\n"  # from line 18
    + "G91 G28 Z0\nG90\nG0 B0 C0\n" + _pass(4) + "M30\n"
)  # fmt: skip


def _follow(folder: Path, text: str, **said: object) -> Followed:
    path = folder / "p.nc"
    path.write_text(text)
    asked = {"file": str(path), "block_mm": BLOCK, "tools": TOOLS, **said}
    return follow(JobProgram.model_validate(asked), units=None, diameter=None)


@pytest.mark.parametrize(
    ("text", "line", "depth_mm"),
    [
        (SIEMENS, 0, 5), (SIEMENS, 11, 2), (SIEMENS, 29, 2), (SIEMENS, 17, 3), (SIEMENS, 23, 4),
        (FANUC, 0, 4), (FANUC, 10, 2), (FANUC, 18, 3),
    ],
)  # fmt: skip
def test_what_is_cut_in_a_plane_is_that_of_a_program_of_its_own(
    tmp_path: Path, text: str, line: int, depth_mm: float
) -> None:
    """A slot of 50 by 10 mm, the deepest of those in the plane."""
    found = _follow(tmp_path, text, plane=line)
    assert_allclose(found.removed_mm3, 50 * 10 * depth_mm, rtol=0.02)
    others = "that are tilted" if line == 0 else f"than that of line {line}"
    assert any("what is cut in" in note and others in note for note in found.notes)


def test_a_plane_has_the_time_of_its_moves_alone(tmp_path: Path) -> None:
    """Down at 300 mm/min from 5 mm above, and 70 mm along: twice in the plane of line 11."""
    assert_allclose(_follow(tmp_path, SIEMENS, plane=17).fed_s, 60 * (5 + 3 + 70) / 300)
    assert_allclose(_follow(tmp_path, SIEMENS, plane=11).fed_s, 2 * 60 * (5 + 2 + 70) / 300)


def test_what_is_cut_while_an_axis_turns_is_left_out(tmp_path: Path) -> None:
    text = FANUC.replace("G1 X60\nG0 Z9\nG69", "G1 X20\nG1 X60 B30.\nG0 Z9\nG69", 1)
    found = _follow(tmp_path, text, plane=10)
    assert_allclose(found.fed_s, 60 * (5 + 2 + 30) / 300)


REFUSED = {
    "no plane stated": (
        SIEMENS,
        {},
        r"line 11: 'CYCLE800': this tilts .* plane = 0 .*\(so in line 17",
    ),
    "no plane of Fanuc": (FANUC, {}, "line 10: 'G68.2': this tilts the plane; state the number"),
    "a line of a move": (FANUC, {"plane": 7}, "line 7 tilts no plane; .* one of the lines 10, 18"),
    "upright": (
        "G0 X0 Y0 Z5\nS99 M3\nG1 X9 F90\n",
        {"plane": 2},
        "no line of this program tilts the plane; leave plane out",
    ),
}


@pytest.mark.parametrize(("text", "said", "why"), REFUSED.values(), ids=REFUSED)
def test_where_a_job_does_not_look_is_refused(
    tmp_path: Path, text: str, said: dict[str, object], why: str
) -> None:
    with pytest.raises(UnusableInput, match=why):
        _follow(tmp_path, text, **said)


def test_a_plane_is_that_of_a_mill() -> None:
    with pytest.raises(ValueError, match="plane goes with block_mm"):
        JobProgram.model_validate({"file": "p", "stock_diameter_mm": 60, "plane": 0})
