"""Slots of Sinumerik's mills take off what a calculation by hand says, in its time."""

from collections.abc import Iterable
from math import pi
from pathlib import Path
from typing import Any

import pytest
from numpy.testing import assert_allclose

from autodb.errors import UnusableInput
from autodb.files.job import JobProgram, ProgramTool
from autodb.forward.programs import follow
from autodb.nc.reading.turning_program import carried_out
from tests.helpers.remedies import has_remedy

HEAD = "G17 G710 G90 G94\nT1\nM6\nS3000 M3\nG0 X50 Y50 Z20\nF500\n"
TOOL_MM = 10.0
WITHIN = 0.01
BLOCK = (0.0, 100.0, 0.0, 100.0, -10.0, 0.0)
SLOT1 = (
    "SLOT1(10,0,2,{dp},{dpr},2,30,{wid},50,50,12,{sta},180,{ffd},600,2,{cdir},{fal},{vari},{more})"
)
SLOT2 = "SLOT2(10,0,2,-4,,2,60,{wid},50,50,30,10,180,200,600,2,{cdir},0,10)"
LONGHOLE = "LONGHOLE(10,0,2,,4,{num},30,50,50,12,0,{step},200,600,2)"


def _slot1(more: str = "0,0,0", **said: Any) -> str:
    plain = {"dp": -4, "dpr": "", "wid": 15, "sta": 0, "ffd": 200, "cdir": 0, "fal": 0, "vari": 10}
    return SLOT1.format(**{**plain, **said, "more": more})


def _removed_mm3(calls: str, folder: Path) -> float:
    path = folder / "p.mpf"
    path.write_text(f"{HEAD}{calls}\nM30\n", encoding="utf-8")
    tool = ProgramTool(kind="end_mill", diameter_mm=TOOL_MM, teeth=4)
    job = JobProgram(file=str(path), block_mm=BLOCK, tools={"other": tool})
    return float(follow(job, units="mm", diameter=None).removed_mm3)


def _fed_s(calls: str) -> float:
    text = f"{HEAD}{calls}\nM30\n"
    done = carried_out(text, source="p.mpf", lathe=False, radius_of=lambda _: 0.5 * TOOL_MM)
    assert done.travels[-1].end[2] == 10.0
    return float(done.fed_s)


def _time_s(across_mm: Iterable[float], down_mm: float) -> float:
    return 60.0 * (sum(across_mm) / 600.0 + down_mm / 200.0)


def _stadium_mm2(long: float, wide: float) -> float:
    return (long - wide) * wide + 0.25 * pi * wide**2


@pytest.mark.parametrize("cdir", [0, 1, 2, 3])
def test_slots_along_radii_have_their_volume_and_time(cdir: int, tmp_path: Path) -> None:
    """Two of 30 by 15 mm, 4 mm deep in two planes, once around in each: 2.5 mm off the middle."""
    call = _slot1(cdir=cdir)
    assert_allclose(_removed_mm3(call, tmp_path), 2 * 4 * _stadium_mm2(30.0, 15.0), rtol=WITHIN)
    around = 2 * 15.0 + 2 * pi * 2.5
    assert_allclose(_fed_s(call), 2 * _time_s([around, around], 2.0 + 4.0), rtol=1e-9)


@pytest.mark.parametrize("said", [{"dp": "", "dpr": 4}, {"sta": 25}, {"vari": 0}, {"vari": 1}])
def test_depth_angle_and_kind_change_no_volume(said: dict[str, Any], tmp_path: Path) -> None:
    found = _removed_mm3(_slot1(**said), tmp_path)
    assert_allclose(found, 2 * 4 * _stadium_mm2(30.0, 15.0), rtol=WITHIN)


def test_a_slot_begins_at_its_radius() -> None:
    """To the middle of one end it is 7.5 mm more; what goes along it begins there."""
    text = f"{HEAD}{_slot1(wid=10)}\nM30\n"
    done = carried_out(text, source="p.mpf", lathe=False, radius_of=lambda _: 0.5 * TOOL_MM)
    cut = [move for move in done.travels if move.feed is not None and move.end[2] == -2.0]
    assert_allclose(cut[1].start, (50.0 + 12.0 + 5.0, 50.0, -2.0), atol=1e-9)
    assert_allclose(cut[1].end, (50.0 + 12.0 + 25.0, 50.0, -2.0), atol=1e-9)


def test_roughing_leaves_its_allowances_and_finishing_takes_them(tmp_path: Path) -> None:
    """1 mm at the edge and 0.5 mm of the floor; finished at once, at 300 mm/min."""
    allowed: dict[str, Any] = {"fal": 1, "more": "0,300,0,0.5"}
    left = 2 * 3.5 * _stadium_mm2(28.0, 13.0)
    whole = 2 * 4 * _stadium_mm2(30.0, 15.0)
    assert_allclose(_removed_mm3(_slot1(vari=11, **allowed), tmp_path), left, rtol=WITHIN)
    both = f"{_slot1(vari=11, **allowed)}\n{_slot1(vari=12, **allowed)}"
    assert_allclose(_removed_mm3(both, tmp_path), whole, rtol=WITHIN)
    assert_allclose(_removed_mm3(_slot1(vari=10, **allowed), tmp_path), whole, rtol=WITHIN)
    rough, fine = 30.0 + 2 * pi * 1.5, 30.0 + 2 * pi * 2.5
    expected = _time_s([rough, rough, 2.0 * fine], 2.0 + 3.5 + 2.0 + 4.0)
    assert_allclose(_fed_s(_slot1(vari=10, **allowed)), 2 * expected, rtol=1e-9)


@pytest.mark.parametrize("cdir", [0, 1])
@pytest.mark.parametrize("wide", [10.0, 14.0])
def test_slots_along_the_circle_have_their_volume_and_time(
    wide: float, cdir: int, tmp_path: Path
) -> None:
    """Two of 60° at a radius of 30 mm, with round ends; there and back where the tool fills it."""
    call = SLOT2.format(wid=wide, cdir=cdir)
    area = (pi / 3.0) * 30.0 * wide + 0.25 * pi * wide**2
    assert_allclose(_removed_mm3(call, tmp_path), 2 * 4 * area, rtol=WITHIN)
    beside = 0.5 * wide - 5.0
    way = 10.0 * pi if beside == 0.0 else 20.0 * pi + 2 * pi * beside
    assert_allclose(_fed_s(call), 2 * _time_s([way, way], 2.0 + 4.0), rtol=1e-9)


@pytest.mark.parametrize(("count", "step"), [(1, 0), (3, 0), (3, 40)])
def test_long_holes_have_their_volume_and_time(count: int, step: int, tmp_path: Path) -> None:
    """As wide as the tool, 20 mm there in the first plane and back in the second."""
    call = LONGHOLE.format(num=count, step=step)
    found = _removed_mm3(call, tmp_path)
    assert_allclose(found, count * 4 * _stadium_mm2(30.0, 10.0), rtol=WITHIN)
    assert_allclose(_fed_s(call), count * _time_s([20.0, 20.0], 2.0 + 4.0), rtol=1e-9)


REFUSED = {
    "too large a tool": (_slot1(wid=8), "not between a quarter and half"),
    "too small a tool": (_slot1(wid=24), "not between a quarter and half"),
    "to and fro": (_slot1(vari=30), "VARI is not read"),
    "a direction": (_slot1(cdir=4), "CDIR is not read"),
    "no depth": (_slot1(dp=""), "the depth is missing"),
    "upwards": (_slot1(dp=4), "DP is not below RFP"),
    "no number": (LONGHOLE.format(num=0, step=0), "NUM is not a number of slots"),
    "a whole circle": (SLOT2.format(wid=10, cdir=0).replace(",60,", ",360,"), "AFSL is"),
    "modes": (LONGHOLE.format(num=1, step=0)[:-1] + ",7)", "more than 15 arguments"),
    "a turned plane": (f"ROT RPL=20\n{_slot1()}", "not in a turned plane"),
    "fast into the block": (_slot1(vari=0, ffd=0), "rapid"),
}  # fmt: skip


@pytest.mark.parametrize(("calls", "says"), REFUSED.values(), ids=REFUSED)
def test_what_is_not_read_of_slots_is_refused(calls: str, says: str, tmp_path: Path) -> None:
    with pytest.raises(UnusableInput, match=says) as refused:
        _removed_mm3(calls, tmp_path)
    assert has_remedy(str(refused.value))
