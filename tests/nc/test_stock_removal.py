"""Contours that CYCLE62 calls and CYCLE952 turns: what is left of a bar, worked out by hand."""

from math import pi
from pathlib import Path
from typing import Any

import pytest
from numpy.testing import assert_allclose

from autodb.cutting.stock import bar
from autodb.cutting.working import WorkTool, solid, worked
from autodb.errors import UnusableInput
from autodb.files.job import JobProgram
from autodb.forward import programs
from autodb.forward.line_parts import Followed
from autodb.nc.reading import Linear, turning_program
from autodb.nc.reading.cycles.stated import StatedOfProgram, StatedStock, StatedTurning

HEAD = 'G18 G710 G90 G95 DIAMON\nT="ROUGHER" D1\nG97 S900 M4\nF0.2\nG0 X80 Z10\n'
CALL_LINE = 7
SHAFT = "G18 G90 DIAMON\nG0 Z0 X30\nG1 Z-20\nX40\nZ-30\nX50 Z-40\nX60\n"
"""Ø30 to z −20, Ø40 to z −30, a cone to Ø50 at z −40."""
CONE_MM3 = pi / 3 * 10 * (20**2 + 20 * 25 + 25**2)
SHAFT_MM3 = pi * (15**2 * 20 + 20**2 * 10) + CONE_MM3
BAR_MM3 = pi * 30**2 * 40
WAYS = {
    "subprogram": ('("SHAFT",0,,)', "M30\n%_N_SHAFT_SPF\n" + SHAFT + "M17\n"),
    "name": ('("SHAFT",1,,)', f"M30\nE_LAB_A_SHAFT: ;#SM\n{SHAFT}E_LAB_E_SHAFT:\n"),
    "labels": ('(,2,"A1","A2")', f"M30\nA1:\n{SHAFT}A2:\nB1:\nG1 X10 Z-90\nB2:\n"),
    "labels of a subprogram": (
        '("PARTS",3,"A1","A2")',
        f"M30\n%_N_PARTS_SPF\nB1:\nG1 X10 Z9\nB2:\nA1:\n{SHAFT}A2:\nM17\n",
    ),
}
ROUGH = StatedTurning(across=False, roughs=True, finishes=False, by_axes=None)


def _called(
    *, depth: float = 2.0, ux: float = 0.0, uz: float = 0.0, u: float = 0.0, finishing: float = 0.1
) -> str:
    """Return a call in full: depth _D, allowances _UX, _UZ, _U, and the feed of both."""
    return (
        f'CYCLE952("ROUGH_1",,"",2101311,0.3,0.15,0,{depth},0.1,0.1,{ux},{uz},{u},0,1,0,0,,,,,2,2'
        f",,,0,1,,0,12,1100110,1,0,{finishing})"
    )


def _read(
    call: str,
    way: str = "name",
    *,
    how: StatedTurning | None = ROUGH,
    kind: str = "outside",
    stock: StatedStock | None = StatedStock(30.0, 0.0, 0.0),  # noqa: B008
) -> Any:
    contour, behind = WAYS[way]
    text = f"{HEAD}CYCLE62{contour}\n{call}\n{behind}"
    stated = StatedOfProgram(
        kind_of=lambda _tool: kind,
        turning_of=lambda line: how if line == CALL_LINE else None,
        stock=stock,
    )
    return turning_program(text, source="p.mpf", stated=stated).moves


def _removed(moves: Any, *, bore: float = 0.0, face: float = 0.0, kind: str = "outside") -> float:
    work = solid(bar(30.0, face_mm=face), bore_mm=bore)
    tool = WorkTool("boring" if kind == "boring" else "outside")
    return worked(moves, work, {None: tool}, source="p").removed_mm3


@pytest.mark.parametrize("way", WAYS)
def test_a_contour_is_the_same_however_it_is_called(way: str) -> None:
    assert_allclose(_removed(_read(_called(), way)), BAR_MM3 - SHAFT_MM3, rtol=0.004)


@pytest.mark.parametrize("across", [False, True])
def test_the_part_is_left_whichever_way_the_passes_go(*, across: bool) -> None:
    both = StatedTurning(across=across, roughs=True, finishes=True, by_axes=True)
    moves = _read(_called(ux=0.4, uz=0.2), how=both)
    assert_allclose(_removed(moves), BAR_MM3 - SHAFT_MM3, rtol=0.004)
    long = [m for m in moves if isinstance(m, Linear) and m.feed.mm == 0.3]
    way = [abs(m.end.x_mm - m.start.x_mm) - abs(m.end.z_mm - m.start.z_mm) for m in long]
    assert (max(way) > 15) is across
    assert {m.feed.mm for m in moves if isinstance(m, Linear)} == {0.3, 0.1}


def test_roughing_leaves_its_allowances_and_finishing_takes_them() -> None:
    """UX is of the radius, UZ along the axis; U square to the contour, which has a cone."""
    axes = StatedTurning(across=False, roughs=True, finishes=False, by_axes=True)
    left = BAR_MM3 - _removed(_read(_called(ux=0.5, uz=0.0, u=9.0), how=axes))
    thick = pi * (15.5**2 * 20 + 20.5**2 * 10 + 10 / 3 * (20.5**2 + 20.5 * 25.5 + 25.5**2))
    assert_allclose(left, thick, rtol=0.002)
    contour = StatedTurning(across=False, roughs=True, finishes=False, by_axes=False)
    around = BAR_MM3 - _removed(_read(_called(ux=9.0, u=0.5), how=contour))
    # Shoulders of 5 mm and of 5 mm, lengths of the cylinders and of the cone at its slant
    area = 2 * pi * (15 * 20 + 20 * 10 + 22.5 * (125**0.5)) + pi * (20**2 - 15**2 + 30**2 - 25**2)
    assert_allclose(around - SHAFT_MM3, 0.5 * area, rtol=0.06)
    once = StatedTurning(across=False, roughs=False, finishes=True, by_axes=None)
    assert_allclose(_removed(_read(_called(), how=once)), BAR_MM3 - SHAFT_MM3, rtol=0.004)


def test_passes_are_as_deep_as_the_call_says_from_the_stock_on() -> None:
    moves = _read(_called(depth=3.0), stock=StatedStock(33.0, 1.5, 0.0))
    cuts = [m for m in moves if isinstance(m, Linear) and m.start.x_mm == m.end.x_mm]
    levels = sorted({m.start.x_mm for m in cuts}, reverse=True)
    assert levels == [30, 27, 24, 21, 20, 18, 15]
    assert max(m.start.z_mm for m in cuts) == 1.5 + 1.0


def test_a_bore_is_turned_from_inside() -> None:
    bore = "G18 G90 DIAMON\nG0 Z0 X50\nG1 Z-10\nX40\nZ-25\nX24\n"
    text = f'{HEAD.replace("X80", "X18")}CYCLE62("B",1,,)\n{_called()}\nM30\nE_LAB_A_B:\n{bore}'
    stated = StatedOfProgram(
        kind_of=lambda _tool: "boring",
        turning_of=lambda _line: ROUGH,
        stock=StatedStock(30.0, 0.0, 10.0),
    )
    moves = turning_program(text + "E_LAB_E_B:\n", source="p.mpf", stated=stated).moves
    expected = pi * ((25**2 - 10**2) * 10 + (20**2 - 10**2) * 15)
    assert_allclose(_removed(moves, bore=10.0, kind="boring"), expected, rtol=0.004)


def test_of_two_contours_the_second_is_the_finished_one() -> None:
    call = f'CYCLE62(,2,"A1","A2")\n{_called()}\nM30\n'
    blank = 'CYCLE62(,2,"B1","B2")\n'
    behind = f"B1:\nG1 X64 Z2\nZ-50\nB2:\nA1:\n{SHAFT}A2:\n"
    stated = StatedOfProgram(turning_of=lambda _line: ROUGH, stock=StatedStock(30.0, 0.0, 0.0))
    moves = turning_program(HEAD + blank + call + behind, source="p.mpf", stated=stated).moves
    assert_allclose(_removed(moves), BAR_MM3 - SHAFT_MM3, rtol=0.004)
    with pytest.raises(UnusableInput, match="line 9: 'CYCLE952': the contour is missing; call it"):
        turning_program(HEAD + blank * 2 + call + behind, source="p.mpf", stated=stated)


@pytest.mark.parametrize("unit", ["G710", "G700"])
def test_lengths_and_feeds_of_the_cycles_count_in_the_programs_unit(unit: str) -> None:
    """One shaft of Ø1.5 inch in a bar of Ø60 mm, by either cycle, in either unit."""
    f = 1.0 if unit == "G700" else 25.4
    shaft = f"G0 Z0 X{1.5 * f}\nG1 Z-{f}\nX{60 / 25.4 * f}\n"
    head = (
        HEAD.replace("G710", unit)
        .replace("X80 Z10", f"X{3 * f} Z{f}")
        .replace("F0.2", f"F{0.008 * f}")
    )
    by_952 = _called(depth=0.08 * f).replace(",0.3,0.15,", f",{0.012 * f},0,")
    by_95 = f'CYCLE95("A1:A2",{0.08 * f},0,0,0,{0.012 * f},0,0,1)'
    stated = StatedOfProgram(turning_of=lambda _line: ROUGH, stock=StatedStock(30.0, 0.0, 0.0))
    for call in (f'CYCLE62(,2,"A1","A2")\n{by_952}', by_95):
        text = f"{head}{call}\nM30\nA1:\n{shaft}A2:\n"
        moves = turning_program(text, source="p.mpf", stated=stated).moves
        assert_allclose(_removed(moves), pi * (30**2 - 19.05**2) * 25.4, rtol=0.004)
        assert_allclose([m.feed.mm for m in moves if isinstance(m, Linear)], 0.012 * 25.4)


@pytest.mark.parametrize("behind", [True, False])
def test_cycle95_takes_labels_behind_it_and_behind_the_end(*, behind: bool) -> None:
    """What comes right behind the call is the contour alone: the program goes on behind it."""
    contour = "A1: G1 X30 Z0\nZ-20\nX40\nZ-30\nX50 Z-40\nA2: X60\n"
    rest = "G0 X80\nM30\n"
    text = HEAD + 'CYCLE95("A1:A2",2,0,0,0,0.3,0,0,1)\n'
    text += contour + rest if behind else rest + contour
    moves = turning_program(text, source="p.mpf").moves
    assert_allclose(_removed(moves), BAR_MM3 - SHAFT_MM3, rtol=0.004)
    assert moves[-1].end.x_mm == 40.0


REFUSED = {
    "no meaning": (_called(), None, "says what _VARI 2101311 does; state cut and passes in"),
    "no depth": (_called(depth=0), ROUGH, "the depth of a pass is missing; state _D"),
    "allowance": (_called(ux=0.2), ROUGH, "state allowance in .program.cycle952.7. of the job"),
    "residual": (
        'CYCLE952("R2","BLANK1","",2101311,0.3)', ROUGH, "residual stock of BLANK1.*write out its",
    ),
    "grooves": (_called().replace("2,2,,,0", "2,2,3,10,0"), ROUGH, "several grooves"),
    "limits": (_called().replace("1,0,0,,,,,2", "1,0,0,40,,,,2"), ROUGH, "limits of the machined"),
    "channels": (_called().replace("0110,1,0,", "0110,1,5,"), ROUGH, "cutting by two channels"),
    "too many": (_called().replace(")", ",1)"), ROUGH, "more than 34 arguments"),
}  # fmt: skip


@pytest.mark.parametrize(("call", "how", "says"), REFUSED.values(), ids=REFUSED)
def test_what_cannot_be_read_truly_is_refused(
    call: str, how: StatedTurning | None, says: str
) -> None:
    with pytest.raises(UnusableInput, match=rf"p.mpf: line {CALL_LINE}: 'CYCLE952': .*{says}"):
        _read(call, how=how)


def test_tools_and_ways_that_cut_otherwise_are_refused() -> None:
    with pytest.raises(UnusableInput, match="a tool of kind 'grooving' removes no stock along a"):
        _read(_called(), kind="grooving")
    across = StatedTurning(across=True, roughs=True, finishes=False, by_axes=None)
    with pytest.raises(UnusableInput, match="facing inside a bore is not read; write out"):
        _read(_called(), how=across, kind="boring")
    both = StatedTurning(across=False, roughs=True, finishes=True, by_axes=None)
    second = _called().replace("0.0,0,1,0,0,,", "0.0,0.3,1,0,0,,")
    with pytest.raises(UnusableInput, match="an allowance for a second finishing cut"):
        _read(second, how=both)


@pytest.mark.parametrize("call", ["", '("SHAFT",2,,)', '(,1,"A1","A2")', '("SHAFT",7,,)'])
def test_a_call_that_names_no_contour_is_refused(call: str) -> None:
    with pytest.raises(UnusableInput, match=r"'CYCLE62': this calls no contour; use \(.NAME.,0\)"):
        turning_program(f"{HEAD}CYCLE62{call or '()'}\nG1 X9\n", source="p.mpf")


def test_a_job_states_what_its_calls_do(tmp_path: Path) -> None:
    """Two calls: one roughs 0.5 mm over the contour, the other finishes with another tool."""
    again = 'T="FINISHER" D1\nG0 X80 Z10\nCYCLE62("SHAFT",1,,)\n'
    text = f'{HEAD}CYCLE62("SHAFT",1,,)\n{_called(u=0.5)}\n{again}{_called(depth=0)}\n'
    path = tmp_path / "shaft.mpf"
    path.write_text(text + WAYS["name"][1], encoding="utf-8")
    calls = {
        "7": {"cut": "along", "passes": "roughing", "allowance": "contour"},
        "11": {"cut": "along", "passes": "finishing"},
    }

    def followed(cycle952: dict[str, Any], **said: Any) -> Followed:
        stock = {"stock_diameter_mm": 60.0}
        asked = {"file": str(path), **stock, "cycle952": cycle952, **said}
        return programs.follow(JobProgram.model_validate(asked), units=None, diameter=None)

    found = followed(calls)
    assert_allclose(found.removed_mm3, BAR_MM3 - SHAFT_MM3, rtol=0.004)
    assert {line.operation for line in found.lines} == {"turn", "taper"}
    assert any("CYCLE952 cuts as the job states" in note for note in found.notes)
    assert {line.number for line in found.lines} == {7, 11}
    with pytest.raises(UnusableInput, match=r"line 11: .*program.cycle952.11. of the job"):
        followed({"7": calls["7"]})
    with pytest.raises(UnusableInput, match=r"line 12 calls no CYCLE952, and program.cycle952.12"):
        followed(calls | {"12": calls["11"]})
    with pytest.raises(ValueError, match="cycle952 goes with a lathe's stock, and block_mm is"):
        followed(calls, stock_diameter_mm=None, block_mm=[0, 1, 0, 1, 0, 1])
    with pytest.raises(ValueError, match="pattern"):
        followed({"line 7": calls["7"]})
