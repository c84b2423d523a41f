"""What Sinumerik's programs say beside moves: variables, calls, repeats; and who is told by it."""

from math import pi
from pathlib import Path

import pytest
from numpy.testing import assert_allclose

from autodb.cutting.stock import bar
from autodb.cutting.working import WorkTool, solid, worked
from autodb.errors import UnusableInput
from autodb.nc.reading import Rapid, turning_program
from autodb.nc.reading.turning_program import carried_out

HEAD = "%_N_PART_MPF\nG18 G710 G90 G95 DIAMON\nG97 S900 M4\nF0.2\nG0 X62 Z2\n"
PASS = "G0 X=R1\nG1 Z-20\nG0 X62\nZ2\n"
STEPS = pi * ((30**2 - 28**2) + (28**2 - 26**2)) * 20
"""Ø56 and then Ø52 over 20 mm of a bar of Ø60."""


def _removed(text: str, *, source: str = "p.mpf") -> float:
    moves = turning_program(text, source=source).moves
    return worked(moves, solid(bar(30.0)), {None: WorkTool()}, source="p").removed_mm3


WAYS = {
    "R of all programs": f"R1=56\nL10\nR1=R1-4\nL10\nM30\n%_N_L10_SPF\n{PASS}M17\n",
    "R set in a subprogram": f"R1=60\nL10\nL10\nM30\n%_N_L10_SPF\nR1=R1-4\n{PASS}M17\n",
    "parameters": "DOWN(56)\nDOWN(60-8,-20)\nM30\nPROC DOWN(REAL _TO, REAL FAR=-20) SAVE\n"
    "G0 X=_TO\nG1 Z=FAR\nG0 X62\nZ2\nRET\n",
    "a parameter left out": "DOWN(,56)\nDOWN(,52)\nM30\nPROC DOWN(INT NO, REAL TO)\n"
    "G0 X=TO-NO\nG1 Z-20\nG0 X62\nZ2\nM17\n",
    "REPEAT from a label": f"R1=60\nAGAIN: R1=R1-4\n{PASS}REPEAT AGAIN\nM30\n",
    "REPEAT between labels": f"R1=60\nONE: R1=R1-4\n{PASS}TWO:\nG0 X80\nREPEAT ONE TWO P=1\nM30\n",
    "REPEATB": f"R1=60\nDOWN: R1=R1-2\nREPEATB DOWN\n{PASS}REPEATB DOWN P=2\n{PASS}M30\n",
    "two jumps in a block": "R1=56\nFIRST:\nIF R1>56 GOTOF THIRD IF R1<50 GOTOF THIRD\n"
    f"{PASS}R1=R1-4\nIF R1==52 GOTOB FIRST IF R1==48 GOTOF LAST\nTHIRD: R1=20\n{PASS}"
    "LAST: M30\n",
    "labels of one name": "R1=40\nDOWN:\nGOTOF OVER\nR1=60\nOVER:\nR1=56\nDOWN:\n"
    f"{PASS}R1=R1-4\nIF R1>50 GOTOB DOWN\nM30\n",
    "CASE": "FOR R2=1 TO 2\nCASE (R2*2) OF 2 GOTOF AA 4 GOTOF BB DEFAULT GOTOF CC\n"
    "AA: R1=56\nGOTOF DD\nBB: R1=52\nGOTOF DD\nCC: R1=40\nDD: MSG(\"Ø \"<<R1<<\" (mm)\")\n"
    f"{PASS}ENDFOR\nM30\n",
}  # fmt: skip


@pytest.mark.parametrize("way", WAYS)
def test_the_same_steps_are_left_however_they_are_counted(way: str) -> None:
    assert_allclose(_removed(HEAD + WAYS[way]), STEPS, rtol=1e-6)


def test_a_subprogram_beside_the_program_has_its_parameters(tmp_path: Path) -> None:
    body = "PROC DOWN(REAL TO)\nG0 X=TO\nG1 Z-20\nG0 X62\nZ2\nM17\n"
    (tmp_path / "DOWN.SPF").write_text(body, encoding="utf-8")
    text = HEAD + "DOWN(56)\nDOWN(52)\nM30\n"
    assert_allclose(_removed(text, source=str(tmp_path / "p.mpf")), STEPS, rtol=1e-6)


def test_a_subprogram_is_the_file_of_its_name_and_never_its_caller(tmp_path: Path) -> None:
    """MAIN_DOWN ends like DOWN, and A_DOWN comes before it."""
    body = "PROC DOWN\nG0 X{}\nG1 Z-20\nG0 X62\nZ2\nM17\n"
    (tmp_path / "A_DOWN.SPF").write_text(body.format(40), encoding="utf-8")
    (tmp_path / "DOWN.SPF").write_text(body.format(56), encoding="utf-8")
    text = HEAD + "DOWN\nM30\n"
    source = tmp_path / "MAIN_DOWN.MPF"
    source.write_text(text, encoding="utf-8")
    found = _removed(text, source=str(source))
    assert_allclose(found, pi * (30**2 - 28**2) * 20, rtol=1e-6)
    (tmp_path / "DOWN.SPF").unlink()
    assert_allclose(_removed(text, source=str(source)), pi * (30**2 - 20**2) * 20, rtol=1e-6)
    (tmp_path / "A_DOWN.SPF").unlink()
    with pytest.raises(UnusableInput, match="there is no subprogram of this name"):
        _removed(text, source=str(source))


REFUSED = {
    "too many": ("DOWN(1,2)\nM30\nPROC DOWN(REAL A)\nG1 X=A\nM17\n", "'DOWN': this takes 1 arg"),
    "none declared": ("L10(5)\nM30\n%_N_L10_SPF\nG1 X1\nM17\n", "'L10': this takes 0 arguments"),
    "VAR": ("DOWN(1)\nM30\nPROC DOWN(VAR REAL A)\nM17\n", "'VAR REAL A': use parameters that are"),
    "text": ('DOWN("A")\nM30\nPROC DOWN(REAL A)\nM17\n', "'DOWN': a text as an argument is not"),
    "cycle": ("POCKET1(1,2,3)\nM30\n", "'POCKET1': this cycle is not read; write out its moves"),
    "label": ("REPEAT NOWHERE P=2\nM30\n", "'NOWHERE': there is no block of this label"),
    "case": ("CASE R1 OF 1 GO A\nM30\n", r"use CASE \(…\) OF 1 GOTOF A 2 GOTOF B DEFAULT GOTOF C"),
    "AR": ("G3 X20 I1 AR=90\nM30\n", "'AR=90': state AR with the arc's end or with its centre"),
    "AR of a turn": ("G3 X20 AR=360\nM30\n", "'AR=360': use an angle between 0 and 360"),
    "MSG": ('MSG("a"\nM30\n', "a bracket does not close"),
}


@pytest.mark.parametrize(("body", "says"), REFUSED.values(), ids=REFUSED)
def test_what_is_not_read_of_them_is_refused(body: str, says: str) -> None:
    with pytest.raises(UnusableInput, match=f"p.mpf: line [0-9]+: .*{says}"):
        turning_program(HEAD + "G1 Z0\n" + body, source="p.mpf")


@pytest.mark.parametrize(
    "word", ["MCALL CYCLE82(10,0,1,-22,,0)", 'MSG("A")', "G1 X=IC(2)", "CYCLE85(9,0,1,-5,,0,9,9)"]
)
def test_words_with_brackets_tell_the_control(word: str) -> None:
    """What stands in brackets is a comment elsewhere, and was left out before it was asked."""
    text = f"G90 G17 F900 S4000 M3\nG0 X50 Y30 Z50\nG1 Z40\n{word}\nX10\nMCALL\nM30\n"
    text = text if "MCALL" in word else text.replace("MCALL\n", "")
    assert carried_out(text, source="p.nc", lathe=False).control == "sinumerik"
    comment = "O0001\nG90 G17 F900 S4000 M3\nG0 X50 Y30 Z50\n(MSG CYCLE82)\nG1 Z40\nM30\n"
    assert carried_out(comment, source="p.nc", lathe=False).control != "sinumerik"


@pytest.mark.parametrize("word", ["Y0", "Y0.", "Y=IC(0)"])
def test_a_lathes_y_may_be_told_to_stand(word: str) -> None:
    found = turning_program(f"{HEAD}G0 X56 {word}\nG1 Z-20\nG0 X62\n", source="p.mpf").moves
    plain = turning_program(f"{HEAD}G0 X56\nG1 Z-20\nG0 X62\n", source="p.mpf").moves
    assert [(m.start, m.end, isinstance(m, Rapid)) for m in found] == [
        (m.start, m.end, isinstance(m, Rapid)) for m in plain
    ]
    with pytest.raises(UnusableInput, match=r"'Y1': only moves of X and Z are read"):
        turning_program(f"{HEAD}G0 X56 Y1\nG1 Z-20\n", source="p.mpf")


OPENED = {
    "half a circle": ("G3 X-10 Y0 AR=180", 10 * pi, (-10, 0)),
    "to the right": ("G2 X0 Y10 AR=270", 15 * pi, (0, 10)),
    "about a centre": ("G3 I-10 J0 AR=90", 5 * pi, (0, 10)),
    "about a place": ("G2 I=AC(0) J=AC(0) AR=90", 5 * pi, (0, -10)),
    "in turned coordinates": ("ROT Z90\nG3 I0 J10 AR=90", 5 * pi, (0, 10)),
}


@pytest.mark.parametrize(("words", "way_mm", "to"), OPENED.values(), ids=OPENED)
def test_an_arc_is_told_by_its_opening(words: str, way_mm: float, to: tuple[float, float]) -> None:
    """From X10 Y0: a chord of 20 mm over 180°, one of 14.1 mm over 270°, quarters of 10 mm."""
    text = f"%_N_P_MPF\nG17 G710 G90 S900 M3\nG0 X10 Y0 Z0\nF100\n{words}\nM30\n"
    done = carried_out(text, source="p.mpf", lathe=False)
    arc = done.travels[len(done.travels) - 1]
    assert_allclose(arc.length_mm, way_mm)
    assert_allclose(arc.end[:2], to, atol=1e-6)


@pytest.mark.parametrize("end", ["M17", "RET", "M2", ""])
def test_the_end_of_a_contours_subprogram_is_not_that_of_the_program(end: str) -> None:
    rough, finish = (
        f'CYCLE95("SHAFT",2,{left},{left},0,0.2,0.1,0.1,{kind},0,0,0)\n'
        for left, kind in ((0.5, 1), (0, 5))
    )
    contour = f"%_N_SHAFT_SPF\nG1 X40 Z0\nZ-20\nX62\n{end}\n"
    text = f"{HEAD}{rough}T2 D1\n{finish}M30\n{contour}"
    lines = {move.line for move in turning_program(text, source="p.mpf").moves}
    assert lines == {6, 8}
    assert_allclose(_removed(text), pi * (30**2 - 20**2) * 20, rtol=1e-3)


def test_what_moves_nothing_may_name_what_nothing_sets() -> None:
    """CYCLE832 says its way of machining by a name of the control; G75 the number of its place."""
    said = (
        'CYCLE832(0.05,_ROUGH,1)\nWORKPIECE(,,,"CYLINDER",0,0,-80,-60,60)\nG75 Z0 FP=1\nG0 X62 Z2\n'
    )
    assert_allclose(_removed(f"{HEAD}{said}R1=56\n{PASS}M30\n"), pi * (30**2 - 28**2) * 20)
