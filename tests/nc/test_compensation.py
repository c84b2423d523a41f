"""Compensated contours of a mill: where its centre goes, worked out by hand."""

from itertools import pairwise
from math import pi

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.errors import UnusableInput
from autodb.nc.reading.travels import ProgramMove
from autodb.nc.reading.turning_program import carried_out

HEAD = "G21 G90 G17\nT1 M6\nS1000 M3\nG0 X-30 Y-30 Z-5\n"
SQUARE = "G1 {} D1 X0 Y-20 F200\nY60\nX60\nY0\nX-20\nG40 X-30 Y-30\nM30\n"
"""Around the square from 0 to 60, begun below its left side."""


def _centre(
    body: str, radius: float = 5.0, *, control: str | None = None, source: str = "p.nc"
) -> list[ProgramMove]:
    done = carried_out(
        HEAD + body, source=source, lathe=False, control=control, radius_of=lambda _: radius
    )
    assert all(move.beside is None for move in done.travels)
    assert all(a.end == b.start for a, b in pairwise(done.travels))
    return [move for move in done.travels if move.feed is not None]


def _ends(moves: list[ProgramMove]) -> list[tuple[float, float]]:
    return [(round(move.end.x_mm, 6), round(move.end.y_mm, 6)) for move in moves]


def test_the_centre_goes_a_radius_to_the_left_of_a_square() -> None:
    """Fanuc's controls go on along both sides of an outer corner until they meet."""
    moves = _centre(SQUARE.format("G41"), control="fanuc-b")
    corners = [(-5, -20), (-5, 60), (-5, 65), (0, 65), (60, 65), (65, 65), (65, 60), (65, 0)]
    assert _ends(moves) == [*corners, (65, -5), (60, -5), (-20, -5), (-30, -30)]


def test_other_controls_go_around_an_outer_corner_by_an_arc() -> None:
    moves = _centre(SQUARE.format("G41"), source="p.ngc")
    arcs = [move for move in moves if move.circle is not None]
    assert [arc.circle.centre for arc in arcs if arc.circle] == [(0, 60), (60, 60), (60, 0)]
    assert_allclose([arc.length_mm for arc in arcs], 5 * pi / 2)
    assert not any(arc.circle.left for arc in arcs if arc.circle)


def test_to_the_right_of_the_same_square_the_mill_turns_within_it() -> None:
    moves = _centre(SQUARE.format("G42"))
    assert _ends(moves) == [(5, -20), (5, 55), (55, 55), (55, 5), (-20, 5), (-30, -30)]


def test_arcs_keep_their_centre_and_are_trimmed_where_the_next_offset_meets_them() -> None:
    """A pocket of radius 20 about 40, 0, with a flat end: x = 52 cuts it at y = ±16."""
    body = "G0 X40 Y0\nG1 G41 D1 X52 Y0 F100\nY16\nG3 X52 Y-16 I-12 J-16\nG1 Y0\nG40 X40\nM30\n"
    moves = _centre(body)
    (arc,) = [move for move in moves if move.circle is not None]
    assert arc.circle is not None
    assert arc.circle.centre == (40, 0)
    # beside both at a radius of 15 about the centre, and at x = 47
    reach = np.sqrt(15**2 - 7**2)
    assert_allclose([*arc.start[:2], *arc.end[:2]], [47, reach, 47, -reach], atol=1e-9)
    full = _centre("G0 X0 Y0\nG1 G41 D1 X20 F100\nG3 X20 Y0 I-20\nG40 G1 X0\nM30\n")
    assert_allclose([move.length_mm for move in full], [15, 2 * pi * 15, 15])


def test_heights_change_where_the_centre_is() -> None:
    body = "G0 Z2\nG41 D1 G0 X0 Y-20\nG1 Z-5 F50\nY60 F200\nG0 Z2\nG40 G0 X-30\nM30\n"
    moves = _centre(body)
    assert [tuple(move.end) for move in moves] == [(-5, -20, -5), (-5, 60, -5)]


def test_a_sharp_outer_corner_is_gone_around_and_a_smooth_join_is_none() -> None:
    sharp = _centre("G1 G41 D1 X0 Y-20 F9\nY60\nX40 Y-20\nG40 X60\nM30\n", control="fanuc-a")
    assert_allclose([move.length_mm for move in sharp[2:5]][::2], 5)
    smooth = _centre("G1 G41 D1 X0 Y-20 F9\nY40\nG2 X20 Y60 R20\nG1 X60\nG40 X80\nM30\n")
    assert len(smooth) == 5
    assert_allclose(smooth[2].length_mm, pi / 2 * 25)


def test_linuxcnc_states_the_diameter_in_the_program() -> None:
    moves = _centre("G1 G41.1 D8 X0 Y-20 F9\nY60\nX60\nG40 X70\nM2\n", source="p.ngc")
    assert _ends(moves)[:2] == [(-4, -20), (-4, 60)]


NARROW = {
    "slot": ("G1 G42 D1 X0 Y-20 F9\nY60\nX8\nY-20\nG40 X-30\n", "line 7: 'G41 or G42': a mill 5"),
    "arc": ("G1 G41 D1 X0 Y-20 F9\nY0\nG3 X-6 Y0 R3\nG1 Y-20\nG40 X-30\n", "line 7: 'G41': a mill"),
    "first": (
        "G1 F9\nG41 G2 X0 Y-20 R40\nG1 Y60\nG40 X-30\n",
        "line 6: 'G41': compensation begins",
    ),
    "plane": ("G18 G1 G41 D1 X0 Y-20 F9\nZ9\nG40 X9\n", "line 5: 'G41': a mill's radius is taken"),
}


@pytest.mark.parametrize(("body", "says"), NARROW.values(), ids=NARROW)
def test_a_contour_that_the_mill_does_not_fit_into_is_refused(body: str, says: str) -> None:
    with pytest.raises(UnusableInput, match=says):
        _centre(body)


def test_beside_by_nothing_is_the_path_as_it_stands() -> None:
    """So CAM systems write it, with small arcs whose ends are rounded off their circles."""
    body = "G1 {} D1 X0 Y0 F200\nX9\nG3 X9.104 Y.1 I0 J.1\nG1 X9 Y9\n{} X20\n"
    plain = _ends(_centre(body.format("", "")))
    assert _ends(_centre(body.format("G41", "G40"), radius=0.0)) == plain
    assert _ends(_centre(body.format("G42", "G40"), radius=0.0)) == plain


def test_in_an_inner_arc_of_its_own_radius_a_mill_turns_in_a_point() -> None:
    """A pocket's corner as round as the mill: the centre stands in it."""
    body = "G1 G41 D1 X20 Y0 F200\nX40\nG3 X45 Y5 I0 J5\nG1 Y30\nG40 X0\nM30\n"
    moves = _centre(body)
    assert _ends(moves)[1:4] == [(40, 5), (40, 5), (40, 30)]
    assert all(move.circle is None for move in moves)
    with pytest.raises(UnusableInput, match="a mill 6 mm beside this contour does not fit"):
        _centre(body, radius=6.0)
