"""Which control a program is told to be for, where words of several stand in it."""

from math import pi

import pytest
from numpy.testing import assert_allclose

from autodb.errors import UnusableInput
from autodb.nc.reading import Revolutions, turning_program
from autodb.nc.reading.controls import FANUC_A, FANUC_B, LINUXCNC, control_of
from autodb.nc.reading.cycles.stated import StatedOfProgram
from autodb.nc.reading.turning_program import carried_out

CYCLE = "G71 U2. R1.\nG71 P10 Q20 U.4 W.1 F.3\nN10 G0 X30.\nG1 Z-20. F.1\nN20 X60.\n"


@pytest.mark.parametrize("word", ["M68", "M67", "M65", "M62", "G8 P1"])
def test_chucks_and_look_ahead_do_not_tell_linuxcnc(word: str) -> None:
    text = f"O7\nG99\nT0101\n{word}\nG97 S900 M3\nG0 X62. Z2.\n{CYCLE}M30\n"
    assert control_of(text) is FANUC_A
    assert turning_program(text, source="p.nc").moves


@pytest.mark.parametrize("word", ["M62 P1", "M66 P0 L3 Q5", "M67 E0 Q.5", "M68 E0 Q1", "M61 Q3"])
def test_outputs_with_their_letters_do(word: str) -> None:
    assert control_of(f"G21 G18\n{word}\nG1 X5 F100\n") is LINUXCNC


def test_the_allowances_of_cycles_tell_no_system() -> None:
    head = "O7\nG21 G90 G18\nG92 S3000\nG28 U0.\nT0101\nG95 G97 S900 M3\nG0 X62. Z2.\n"
    assert control_of(head + CYCLE) is FANUC_B
    assert control_of(head.replace("G90 ", "").replace("G95", "G99") + CYCLE) is FANUC_A
    moves = turning_program(head + CYCLE, source="p.nc").moves
    assert_allclose(min(move.end.x_mm for move in moves), 15.2)  # 30 mm and 0.4 left of them


def test_a_speed_of_none_is_what_the_dial_sets() -> None:
    """Posts of routers write M3 S0 where the spindle has a knob; another S counts from there on."""
    text = "G21 G90\nM4 S0\nG0 X0 Y0 Z0\nG1 X9 F90\nS500\nX0\nS0\nX9\n"
    done = carried_out(text, source="p", lathe=False, stated=StatedOfProgram(speed_rpm=8000.0))
    assert [move.speed for move in done.travels] == [
        Revolutions(8000.0),
        Revolutions(500.0),
        Revolutions(8000.0),
    ]
    assert "the program says S0: the spindle turns at speed_rpm of the job" in done.notes
    with pytest.raises(UnusableInput, match="line 4: 'G1': no spindle speed"):
        carried_out(text, source="p", lathe=False)


def test_centres_may_be_places_where_the_job_says_so() -> None:
    """Half a circle of 10 mm about X30 Y20 by places; as ways from its start it is none."""
    text = "O1\nG21 G90\nS500 M3\nG0 X30 Y10 Z0\nG3 X30 Y30 I30 J20 F90\nG91.1\nG3 Y10 I0 J-10\n"
    stated = StatedOfProgram(centres_are_places=True)
    for control in ("fanuc-b", "linuxcnc"):
        done = carried_out(text, source="p", lathe=False, control=control, stated=stated)
        assert_allclose([move.length_mm for move in done.travels], [10 * pi, 10 * pi])
    with pytest.raises(UnusableInput, match=r"line 5: 'I30': .* state centres = .places. in the"):
        carried_out(text, source="p", lathe=False)
    with pytest.raises(UnusableInput, match=r"within 0.01 mm$"):
        carried_out(text.replace("J20", "J21"), source="p", lathe=False)


def test_some_words_with_two_digits_are_the_builders_but_on_linuxcnc() -> None:
    done = carried_out(
        "O7\nG21 G90\nM90\nS900 M3\nG0 X0 Y0 Z0\nG1 X9 F90\n", source="p", lathe=False
    )
    assert "M90 is the machine builder's word: taken to move no axis" in done.notes
    for text in ("O7\nM91\n", "O7\nM96 P3\n", "G64 P.1\nM90\n"):
        with pytest.raises(UnusableInput, match="this M is not read"):
            carried_out(f"{text}S900 M3\nG1 X9 Y0 Z0 F90\nX0\n", source="p", lathe=False)


def test_okumas_arcs_have_l_for_their_radius() -> None:
    """A quarter from Ø40 to Ø50 by 5 mm, behind words of the first spindle and of a C axis."""
    text = "G140\nG136\nG50 S2000\nT010101\nG97 S900 M3\nG95\nG0 X40 Z0\nG3 X50 Z-5 L5 F.2\nM2\n"
    arc = turning_program(text, source="p.min").moves[-1]
    assert_allclose(arc.length_mm, 2.5 * pi)
    with pytest.raises(UnusableInput, match="line 1: 'G136': this G is not read"):
        turning_program(text.replace("G140\n", ""), source="p.nc", control="fanuc-a")
