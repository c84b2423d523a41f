"""What a nose leaves on cones that nothing compensates: against discs that are moved along."""

import re
from pathlib import Path

import numpy as np
import pytest

from autodb.files.job import JobProgram
from autodb.forward import programs
from autodb.forward.along import nose_leaves
from autodb.forward.line_parts import Followed

NOSE_MM = 0.8
CONE = "G0 X44 Z2\n{on}G1 X44 Z0 F0.2\nX{end:.6f} Z-10\n{off}G0 X62\nZ2\nM30\n"


def followed(folder: Path, *, slope: float, on: str = "", off: str = "") -> Followed:
    """Return a cone that rises by a slope towards the chuck, in a bar of 60 mm."""
    body = CONE.format(on=on, off=off, end=44.0 + 20.0 * slope)
    (folder / "p.nc").write_text("G95 G97 S1000 M3\n" + body, encoding="utf-8")
    asked = JobProgram(file=str(folder / "p.nc"), stock_diameter_mm=60.0)
    return programs.follow(asked, units=None, diameter=None)


def left_mm(slope: float) -> float:
    """Return what discs of the nose leave square to the cone, their tip moved along it."""
    along = np.linspace(0.0, 10.0, 200_001)
    x, z = 22.0 + slope * along, -along
    at = -5.0
    centre_x, centre_z = x + NOSE_MM, z + NOSE_MM
    off = at - centre_z
    under = np.abs(off) <= NOSE_MM
    surface = np.min(centre_x[under] - np.sqrt(NOSE_MM**2 - off[under] ** 2))
    return float((surface - (22.0 - slope * at)) / np.hypot(1.0, slope))


@pytest.mark.parametrize("slope", [0.25, 0.577, 0.9])
def test_what_is_said_is_what_discs_leave(tmp_path: Path, slope: float) -> None:
    found = followed(tmp_path, slope=slope)
    (said,) = nose_leaves(found.lines, found.beside, NOSE_MM)
    assert said.startswith("line 4 goes at an angle without G41 or G42")
    (most,) = re.findall(r"leaves up to ([\d.]+) mm", said)
    assert float(most) == pytest.approx(left_mm(slope), rel=0.05)


def test_nothing_is_said_of_what_is_compensated_or_straight_or_of_no_known_nose(
    tmp_path: Path,
) -> None:
    plain = followed(tmp_path, slope=0.5)
    assert list(nose_leaves(plain.lines, plain.beside, None)) == []
    beside = followed(tmp_path, slope=0.5, on="G42\n", off="G40\n")
    assert beside.beside
    assert list(nose_leaves(beside.lines, beside.beside, NOSE_MM)) == []
    straight = followed(tmp_path, slope=0.0)
    assert list(nose_leaves(straight.lines, straight.beside, NOSE_MM)) == []
