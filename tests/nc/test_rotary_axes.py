"""Rotary axes of a mill that stand while it cuts: what is cut at the angles that a job states."""

from pathlib import Path

import pytest
from numpy.testing import assert_allclose

from autodb.errors import UnusableInput
from autodb.files.job import JobProgram
from autodb.forward.line_parts import Followed
from autodb.forward.programs import follow

HEAD = "O1\nG21 G90 G94 G17 G54\nT1 M6\nS5000 M3\n"
PASSES = {
    "0": "G0 X-10 Y10 Z5\nG1 Z-1 F300\nX60\nG0 Z50\n",
    "90": "G0 X-10 Y5 Z5\nG1 Z-2 F300\nX60\nG0 Z50\n",
    "180": "G0 X-10 Y15 Z5\nG1 Z-3 F300\nX60\nG0 Z50\n",
}
TURNS = HEAD + f"G0 A0\n{PASSES['0']}G0 A90.\n{PASSES['90']}G91 G0 A90\nG90\n{PASSES['180']}M30\n"
BLOCK = [0.0, 50.0, 0.0, 20.0, -5.0, 0.0]
TOOLS = {"other": {"kind": "end_mill", "diameter_mm": 10.0, "teeth": 4}}


def _follow(folder: Path, text: str, **said: object) -> Followed:
    path = folder / "p.nc"
    path.write_text(text)
    asked = {"file": str(path), "block_mm": BLOCK, "tools": TOOLS, **said}
    return follow(JobProgram.model_validate(asked), units=None, diameter=None)


@pytest.mark.parametrize(("angle", "which"), [(0, "0"), (90, "90"), (-180, "180"), (540, "180")])
def test_what_is_cut_at_an_angle_is_that_of_a_program_of_its_own(
    tmp_path: Path, angle: float, which: str
) -> None:
    found = _follow(tmp_path, TURNS, angles={"A": angle})
    plain = _follow(tmp_path, HEAD + PASSES[which] + "M30\n")
    assert (found.fed_s, found.removed_mm3) == (plain.fed_s, plain.removed_mm3)
    assert (
        "what is cut at other angles of the rotary axes, or while they turn, is left out"
        in found.notes
    )


def test_angles_that_are_not_stated_are_0(tmp_path: Path) -> None:
    text = HEAD + f"G0 A90 C45\n{PASSES['90']}G28 G91 Z0 A0 C0\nG90\n{PASSES['0']}M30\n"
    for angles, depth_mm in (({"A": 90, "C": 45}, 2.0), ({"A": 0}, 1.0)):
        found = _follow(tmp_path, text, angles=angles)
        assert_allclose(found.removed_mm3, 50 * 10 * depth_mm, rtol=0.02)


def test_a_machines_angle_is_that_which_is_said(tmp_path: Path) -> None:
    """G53 says a place, also among increments; G28 beside it goes home."""
    text = HEAD + f"G0 A45\nG91 G53 G0 A90\nG90\n{PASSES['90']}G28 A0\n{PASSES['0']}M30\n"
    for angle, depth_mm in ((90, 2.0), (0, 1.0)):
        found = _follow(tmp_path, text, angles={"A": angle})
        assert_allclose(found.removed_mm3, 50 * 10 * depth_mm, rtol=0.02)


def test_what_is_cut_while_an_axis_turns_is_left_out(tmp_path: Path) -> None:
    """On the way from 0 to 30° and back, over an axis that names its angle in each block."""
    turns = "G1 X20 A30\nX30 A30\nX40 A0\n"
    text = HEAD + f"G0 X-10 Y10 Z5 A0\nG1 Z-1 F300 A0\nX10 A0\n{turns}X60 A0\nG0 Z9\nM30\n"
    found = _follow(tmp_path, text, angles={"A": 0})
    assert_allclose(found.fed_s, 60 * (6 + 20 + 20) / 300)
    assert_allclose(_follow(tmp_path, text, angles={"A": 30}).fed_s, 60 * 10 / 300)


def test_holes_at_an_angle_are_drilled_there(tmp_path: Path) -> None:
    drill = {"other": {"kind": "drill", "diameter_mm": 6.0}}
    text = (
        HEAD + "G0 A0 X5 Y5 Z9\nG81 Z-3 R1 F90\nX15\nG80\nG0 A90 X5 Y5\nG81 A90 Z-2 R1\nG80\nM30\n"
    )
    assert len(_follow(tmp_path, text, tools=drill, angles={"A": 0}).lines) == 2
    assert len(_follow(tmp_path, text, tools=drill, angles={"A": 90}).lines) == 1


REFUSED = {
    "no angle stated": (TURNS, {}, "line 10: .A90..: this turns a rotary axis; .*angles in"),
    "nothing there": (TURNS, {"angles": {"A": 45}}, "nothing is cut at these angles"),
    "another zero": (
        HEAD + "G92 A0\nG0 X0 Y0 Z5\nG1 X9 F90\nM30\n", {"angles": {"A": 0}},
        "line 5: 'A0': this turns a rotary axis",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("text", "said", "why"), REFUSED.values(), ids=REFUSED)
def test_what_no_angle_tells_is_refused(
    tmp_path: Path, text: str, said: dict[str, object], why: str
) -> None:
    with pytest.raises(UnusableInput, match=why):
        _follow(tmp_path, text, **said)


def test_angles_are_those_of_a_mill() -> None:
    with pytest.raises(ValueError, match="angles goes with block_mm"):
        JobProgram.model_validate({"file": "p", "stock_diameter_mm": 60, "angles": {"A": 0}})
