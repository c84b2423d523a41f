"""Grooves by CYCLE93: what they leave of a bar, worked out by hand."""

from math import pi, radians, tan

import pytest
from numpy.testing import assert_allclose

from autodb.cutting.stock import bar
from autodb.cutting.working import WorkTool, solid, worked
from autodb.errors import UnusableInput
from autodb.nc.reading import Arc, Linear, TurningProgram, turning_program
from autodb.nc.reading.cycles.stated import Blade, StatedOfProgram

HEAD = "G18 G710 G90 G95 DIAMON\nT1 D1\nG97 S900 M4\nF0.1\nG0 X70 Z5\n"
WIDTH = 3.0


def _read(call: str, blade: Blade | None = Blade(WIDTH, 0.0)) -> TurningProgram:  # noqa: B008
    stated = StatedOfProgram(blade_of=lambda _tool: blade)
    return turning_program(HEAD + call + "\nM30\n", source="p.mpf", stated=stated)


def _removed(call: str, *, away: bool = False) -> float:
    moves = _read(call, Blade(WIDTH, WIDTH if away else 0.0)).moves
    tool = WorkTool("grooving", width_mm=WIDTH, towards_chuck=away)
    return worked(moves, solid(bar(30.0)), {None: tool}, source="p", step_mm=0.02).removed_mm3


def _ring(radius: float, width: float, deep: float) -> float:
    return pi * (radius**2 - (radius - deep) ** 2) * width


SQUARE = "CYCLE93(60,-20,8,5,0,0,0,0,0,0,0,{},{},{},0,{})"


@pytest.mark.parametrize("away", [False, True])
@pytest.mark.parametrize("how", [(0, 0, 0, 5), (0.2, 0.1, 1.5, 5), (0, 0, 2, 1), (0.2, 0, 0, 15)])
def test_a_square_groove_is_as_wide_as_its_base(how: tuple[float, ...], *, away: bool) -> None:
    """Whatever the allowances, pecks, the side that it begins at, and the corner of the blade."""
    found = _removed(SQUARE.format(*how), away=away)
    assert_allclose(found, _ring(30, 8, 5), rtol=1e-3)


def test_it_lies_on_the_side_of_its_starting_point_that_vari_says() -> None:
    for kind, low, high in ((5, -28, -20), (1, -20, -12)):
        cuts = [m for m in _read(SQUARE.format(0, 0, 0, kind)).moves if isinstance(m, Linear)]
        deep = [m.end.z_mm for m in cuts if m.end.x_mm == 25]
        assert_allclose([min(deep), max(deep) + WIDTH], [low, high], atol=1e-9)


@pytest.mark.parametrize("away", [False, True])
def test_leaning_flanks_widen_it_outwards(*, away: bool) -> None:
    """Each flank of 20° takes a ring of triangular section, deep · deep tan 20° / 2."""
    found = _removed("CYCLE93(60,-20,8,5,0,20,20,0,0,0,0,0,0,0,0,5)", away=away)
    lean = tan(radians(20))
    # ∫ 2π r (r − 25) tan 20° dr over 25 to 30, twice
    flanks = 2 * 2 * pi * lean * ((30**3 - 25**3) / 3 - 25 * (30**2 - 25**2) / 2)
    assert_allclose(found, _ring(30, 8, 5) + flanks, rtol=5e-3)


def test_corners_are_broken_outside_and_rounded_at_the_base() -> None:
    program = _read("CYCLE93(60,-20,8,5,0,0,0,-1,-1,1.2,1.2,0,0,0,0,15)")
    arcs = [move for move in program.moves if isinstance(move, Arc)]
    assert_allclose([arc.length_mm for arc in arcs], [1.2 * pi / 2] * 2)
    plain = _ring(30, 8, 5)
    chamfers = 2 * 2 * pi * 29.67 * 0.5
    fillets = 2 * 2 * pi * 25.27 * 1.2**2 * (1 - pi / 4)
    found = _removed("CYCLE93(60,-20,8,5,0,0,0,-1,-1,1.2,1.2,0,0,0,0,15)")
    assert_allclose(found - plain, chamfers - fillets, rtol=0.1)


REFUSED = {
    "blade": (SQUARE.format(0, 0, 0, 5), None, "'CYCLE93': its path depends on the blade; state"),
    "narrow": ("CYCLE93(60,-20,2,5,0,0,0,0,0,0,0,0,0,0,0,5)", Blade(3.0, 0.0), "wider than the"),
    "face": (SQUARE.format(0, 0, 0, 6), Blade(3.0, 0.0), "grooves on faces, on cones and in bores"),
}


@pytest.mark.parametrize(("call", "blade", "says"), REFUSED.values(), ids=REFUSED)
def test_what_cannot_be_cut_is_refused(call: str, blade: Blade | None, says: str) -> None:
    with pytest.raises(UnusableInput, match=says):
        _read(call, blade)
