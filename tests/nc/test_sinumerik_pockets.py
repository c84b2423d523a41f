"""Pockets of Sinumerik's mills take off what a calculation by hand says, in its time."""

from math import pi
from pathlib import Path

import pytest
from numpy.testing import assert_allclose

from autodb.errors import UnusableInput
from autodb.files.job import JobProgram, ProgramTool
from autodb.forward.line_parts import Followed
from autodb.forward.programs import follow
from autodb.nc.reading.turning_program import carried_out
from tests.helpers.remedies import has_remedy

HEAD = "G17 G710 G90 G94\nT1\nM6\nS3000 M3\nG0 X10 Y10 Z20\nF500\n"
TOOL_MM = 10.0
WITHIN = 0.01
RECTANGLE = "POCKET3(10,0,2,-6,60,40,8,{x},{y},{turn},2,{fal},{fald},600,200,{cdir},{vari},4)"
CIRCLE = "POCKET4(10,0,2,-4,20,40,30,{mid},0,0,600,200,{cdir},{vari},5,,,{rad1},{dp1})"
WHOLE = (60 * 40 - (4 - pi) * 8**2) * 6


def _followed(calls: str, folder: Path) -> Followed:
    path = folder / "p.mpf"
    path.write_text(f"{HEAD}{calls}\nM30\n", encoding="utf-8")
    tool = ProgramTool(kind="end_mill", diameter_mm=TOOL_MM, teeth=4)
    job = JobProgram(
        file=str(path), block_mm=(0.0, 80.0, 0.0, 60.0, -10.0, 0.0), tools={"other": tool}
    )
    return follow(job, units="mm", diameter=None)


def _rectangle(**said: float) -> str:
    plain = {"x": 40, "y": 30, "turn": 0, "fal": 0, "fald": 0, "cdir": 0, "vari": 11}
    return RECTANGLE.format(**{**plain, **said})


def _circle(**said: float) -> str:
    return CIRCLE.format(**{"cdir": 0, "vari": 11, "mid": 4, "rad1": 0, "dp1": 0, **said})


@pytest.mark.parametrize("cdir", [0, 1, 2, 3])
def test_a_rectangle_has_its_volume(cdir: int, tmp_path: Path) -> None:
    assert_allclose(_followed(_rectangle(cdir=cdir), tmp_path).removed_mm3, WHOLE, rtol=WITHIN)


def test_a_turned_rectangle_has_its_volume(tmp_path: Path) -> None:
    assert_allclose(_followed(_rectangle(turn=15), tmp_path).removed_mm3, WHOLE, rtol=WITHIN)


def test_roughing_leaves_its_allowances_and_finishing_takes_them(tmp_path: Path) -> None:
    """1 mm at the wall, whose corners have 7 mm then, and 0.5 mm of the floor."""
    rough = _rectangle(fal=1, fald=0.5)
    left = (58 * 38 - (4 - pi) * 7**2) * 5.5
    assert_allclose(_followed(rough, tmp_path).removed_mm3, left, rtol=WITHIN)
    finish = _rectangle(fal=1, fald=0.5, vari=12)
    assert_allclose(_followed(f"{rough}\n{finish}", tmp_path).removed_mm3, WHOLE, rtol=WITHIN)


@pytest.mark.parametrize("cdir", [0, 1])
def test_a_circle_has_its_volume_and_time(cdir: int, tmp_path: Path) -> None:
    """Rings of 5, 10 and 15 mm, out to the last and back to the middle; down from 2 mm above."""
    found = _followed(_circle(cdir=cdir), tmp_path)
    assert_allclose(found.removed_mm3, pi * 20**2 * 4, rtol=WITHIN)
    text = f"{HEAD}{_circle(cdir=cdir)}\nM30\n"
    done = carried_out(text, source="p.mpf", lathe=False, radius_of=lambda _: 0.5 * TOOL_MM)
    around_mm = 2 * pi * (5 + 10 + 15) + 15 + 15
    assert_allclose(done.fed_s, 60 * (around_mm / 600 + 6 / 200), rtol=1e-9)
    assert done.travels[-1].end == (40.0, 30.0, 10.0)


def test_a_helix_goes_down_by_its_pitch(tmp_path: Path) -> None:
    """From 2 mm above to 2 mm deep, in four turns of 3 mm, once around, and again from there."""
    call = _circle(vari=21, mid=2, rad1=3, dp1=1)
    assert_allclose(_followed(call, tmp_path).removed_mm3, pi * 20**2 * 4, rtol=WITHIN)
    done = carried_out(
        f"{HEAD}{call}\nM30\n", source="p.mpf", lathe=False, radius_of=lambda _: 0.5 * TOOL_MM
    )
    turns = [move for move in done.travels if move.circle is not None and move.circle.turns]
    assert [round(move.circle.turns + 1) for move in turns if move.circle] == [4, 2]


REFUSED = {
    "too large a tool": ("POCKET4(10,0,2,-4,5,40,30,4,0,0,600,200,0,11)", "does not fit into this"),
    "to and fro": (_rectangle(vari=31), "_VARI is not read"),
    "in part": ("POCKET4(10,0,2,-4,20,40,30,4,0,0,600,200,0,11,5,12)", "that is there in part"),
    "a corner": (
        "POCKET3(10,0,2,-6,-60,40,8,0,0,0,2,0,0,600,200,0,11)",
        "measured from its corner",
    ),
    "upwards": ("POCKET4(10,0,2,4,20,40,30,4,0,0,600,200,0,11)", "DP is not below RFP"),
    "modes": (_rectangle()[:-1] + ",0,0,0,0,0,7)", "more than 23 arguments"),
    "a turned plane": (f"ROT RPL=20\n{_rectangle()}", "not in a turned plane"),
    "a pitch": (_circle(vari=21), "a helix needs _RAD1 and _DP1"),
    "fast into the block": (_circle(vari=1), "rapid"),
}


@pytest.mark.parametrize(("calls", "says"), REFUSED.values(), ids=REFUSED)
def test_what_is_not_read_of_a_pocket_is_refused(calls: str, says: str, tmp_path: Path) -> None:
    with pytest.raises(UnusableInput, match=says) as refused:
        _followed(calls, tmp_path)
    assert has_remedy(str(refused.value))
