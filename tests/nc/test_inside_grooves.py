"""What blades and drills take off: grooves in a bore, parting, holes behind a face."""

from math import pi
from pathlib import Path

import pytest
from numpy.testing import assert_allclose

from autodb.files.job import JobProgram
from autodb.forward.line_parts import Followed
from autodb.forward.programs import follow

LATHE = "O1\nG21 G40 G99\nG97 S1000 M3\nT0101\n"


def _follow(folder: Path, text: str, **said: object) -> Followed:
    path = folder / "p.nc"
    path.write_text(text)
    asked = JobProgram.model_validate({"file": str(path), **said})
    return follow(asked, units=None, diameter=None)


@pytest.mark.parametrize(("corner", "face_mm"), [("chuck", -9.0), ("away", -12.0)])
def test_a_blade_in_a_bore_grooves_outwards(tmp_path: Path, corner: str, face_mm: float) -> None:
    """A groove of Ø50 in a bore of Ø40: the ring between them, as wide as the blade.

    With the bar's face where the groove ends all of it is there, with the face 1 mm behind that
    two thirds are.
    """
    body = "G0 X38 Z2\nZ-12\nG1 X50 F.1\nX38\nG0 Z2\n"
    tools = {"other": {"kind": "grooving", "width_mm": 3.0, "corner": corner}}
    said = {"stock_diameter_mm": 80, "bore_diameter_mm": 40, "tools": tools}
    for behind_mm, share in ((0.0, 1.0), (1.0, 2.0 / 3.0)):
        found = _follow(tmp_path, LATHE + body, stock_face_mm=face_mm - behind_mm, **said)
        assert_allclose(found.removed_mm3, pi * (25**2 - 20**2) * 3.0 * share, rtol=1e-3)
        (line,) = found.lines
        assert (line.number, line.operation) == (7, "groove")
        assert 40.0 < line.steps[0]["work.diameter"] < line.steps[-1]["work.diameter"] < 50.0


def test_a_blade_widens_an_inside_groove_with_its_side(tmp_path: Path) -> None:
    body = "G0 X38 Z-12\nG1 X50 F.1\nZ-15\nX38\nG0 Z2\n"
    tools = {"other": {"kind": "grooving", "width_mm": 3.0}}
    found = _follow(tmp_path, LATHE + body, stock_diameter_mm=80, bore_diameter_mm=40, tools=tools)
    assert_allclose(found.removed_mm3, pi * (25**2 - 20**2) * 6.0, rtol=1e-3)


def test_a_blade_over_a_bored_bar_still_grooves_outside(tmp_path: Path) -> None:
    body = "G0 X82 Z-12\nG1 X70 F.1\nX82\nG0 Z2\n"
    tools = {"other": {"kind": "grooving", "width_mm": 3.0}}
    found = _follow(tmp_path, LATHE + body, stock_diameter_mm=80, bore_diameter_mm=40, tools=tools)
    assert_allclose(found.removed_mm3, pi * (40**2 - 35**2) * 3.0, rtol=1e-3)


def test_a_blade_that_goes_beyond_the_axis_leaves_no_core(tmp_path: Path) -> None:
    body = "G0 X22 Z-12\nG1 X-3 F.1\nG0 X22\n"
    tools = {"other": {"kind": "grooving", "width_mm": 3.0}}
    found = _follow(tmp_path, LATHE + body, stock_diameter_mm=20, tools=tools)
    assert_allclose(found.removed_mm3, pi * 10**2 * 3.0, rtol=1e-3)
    (line,) = found.lines
    assert_allclose(line.time_s.sum(), 60 * 10 / (0.1 * 1000), rtol=0.01)


def test_a_hole_removes_nothing_where_a_face_has_gone(tmp_path: Path) -> None:
    """1 mm of face, then a hole of Ø10 from there: the hole begins at the new face."""
    body = "G0 X42 Z-1\nG1 X0 F.2\nG0 Z5\nT0202\nG97 S800\nG0 X0 Z2\nG1 Z-20 F.1\nG0 Z5\n"
    tools = {"2": {"kind": "drill", "diameter_mm": 10.0}}
    found = _follow(tmp_path, LATHE + body, stock_diameter_mm=40, tools=tools)
    assert_allclose(found.removed_mm3, pi * (20**2 * 1.0 + 5**2 * 19.0), rtol=1e-3)


def test_a_bore_begins_at_the_face_as_it_was_cut(tmp_path: Path) -> None:
    """A bar 3 mm too long is faced and drilled; the bar that bores then moves in what is air."""
    body = (
        "G0 X62 Z0\nG1 X-1 F.2\nG0 Z2\nT0202\nG0 X0 Z2\nG1 Z-20 F.1\nG0 Z2\nT0303\n"
        "G0 X20 Z1\nX30\nG1 Z-20 F.1\nX19\nG0 Z2\n"
    )
    tools = {"2": {"kind": "drill", "diameter_mm": 20.0}, "3": {"kind": "boring"}}
    found = _follow(tmp_path, LATHE + body, stock_diameter_mm=60, stock_face_mm=3, tools=tools)
    assert_allclose(found.removed_mm3, pi * (3 * 30**2 + 20 * 15**2), rtol=1e-3)
    (bored,) = [line for line in found.lines if line.operation == "bore"]
    assert_allclose(sum(bored.time_s), 60 * 20 / (0.1 * 1000), rtol=1e-3)  # none in front of it


def test_roughing_goes_down_into_a_pocket_along_the_contour(tmp_path: Path) -> None:
    """The land in front of the pocket stays: a cylinder, a cone into the pocket, a shoulder."""
    contour = "N10 G0 X40 Z1\nG1 Z-20 F.1\nX30 Z-25\nZ-40\nN20 X62\n"
    rough = f"G0 X62 Z1\nG71 U2. R.5\nG71 P10 Q20 U0 W0 F.2\n{contour}"
    left = 20 * 20**2 + 5 * (20**2 + 20 * 15 + 15**2) / 3 + 15 * 15**2
    found = _follow(tmp_path, LATHE + rough, stock_diameter_mm=60)
    assert_allclose(found.removed_mm3, pi * (40 * 30**2 - left), rtol=1e-3)
    deepest = max(step["cutting.depth"] for line in found.lines for step in line.extremes)
    assert deepest < 2.5  # no pass takes the land
