"""Profiles in very short lines: seen together, they cut what each of them cuts on its own."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.cutting import pieces
from autodb.cutting.contour import engagement
from autodb.cutting.engaged_steps import ContourEngagement
from autodb.cutting.stock import Stock, bar
from autodb.errors import UnusableInput
from autodb.nc.reading import TurningProgram, turning_program

HEAD = "G95 G97 S1000 M3\nG0 X22 Z1\n"


def _profile(away: bool, *, passes: int = 3) -> str:
    """Return a wavy profile with a shoulder, each pass deeper than the last one."""
    z_mm = np.linspace(0.0, -20.0, 170)
    body = []
    for deeper in range(1, passes + 1):
        x_mm = 20.0 - deeper + 0.8 * np.sin(z_mm / 2.0) + np.where(z_mm < -15.0, 1.5, 0.0)
        places = [f"G1 X{x:.4f} Z{z:.4f} F.2" for x, z in zip(x_mm, z_mm, strict=True)]
        first, rest = (-22.0, places[::-1]) if away else (0.5, places)
        body += ["G0 X30", f"G0 Z{first}", *rest, "G0 X30"]
    return HEAD + "\n".join(body)


def _pieces(program: TurningProgram) -> list[pieces.Piece]:
    return list(pieces.pieces_of(program.moves, step_mm=0.05))


def _engaged(text: str, *, lean: float, edge_mm: float = np.inf) -> tuple[ContourEngagement, Stock]:
    program = turning_program(text, source="p.nc", diameter=False)
    return engagement(program.moves, bar(20.5), source="p.nc", lean=lean, edge_mm=edge_mm)


def _one_by_one(
    text: str, *, lean: float, edge_mm: float = np.inf
) -> tuple[ContourEngagement, Stock]:
    """Return the same of moves whose feeds differ in the tenth digit, so that none is of a run."""
    lines = text.splitlines()
    fed = [
        line.replace("F.2", f"F{0.2 + 1e-9 * (k % 2):.10f}") if "F.2" in line else line
        for k, line in enumerate(lines)
    ]
    return _engaged("\n".join(fed), lean=lean, edge_mm=edge_mm)


@pytest.mark.parametrize("away", [False, True])
@pytest.mark.parametrize("lean", [0.0, 0.1, 0.7])
def test_a_profile_in_short_lines_is_cut_as_line_by_line(away: bool, lean: float) -> None:
    text = _profile(away)
    (together, left), (alone, left_alone) = (
        made(text, lean=lean) for made in (_engaged, _one_by_one)
    )
    assert (together.depth_mm > 0.1).mean() > 0.2
    for name in ("depth_mm", "outer_mm", "x_mm", "z_mm", "path_mm", "along_x"):
        assert_allclose(getattr(together, name), getattr(alone, name), atol=1e-9)
    assert_allclose(together.line, alone.line)
    assert_allclose(left.low_mm, left_alone.low_mm, atol=1e-9)


@pytest.mark.parametrize("feeds", [("F.2", "F.2"), ("F.2", "F.3")])
def test_a_cylinder_is_as_deep_in_short_lines_as_in_one(feeds: tuple[str, str]) -> None:
    """An edge that leans back is still in what the lines before have come along.

    So it is where the feed changes from line to line, and they are no run.
    """
    ends = [f"G1 Z{-0.05 * k:.2f} {feeds[k % 2]}" for k in range(1, 401)]
    begun = f"{HEAD}G0 X18.5 Z0.1\nG1 Z0 F.2\n"
    (whole, _), (short, left) = (
        _engaged(begun + "\n".join(some), lean=0.1) for some in (ends[-1:], ends)
    )
    depth_mm = np.interp(short.z_mm[::-1], whole.z_mm[::-1], whole.depth_mm[::-1])[::-1]
    assert_allclose(short.depth_mm[short.z_mm < -0.3], 2.0, atol=1e-9)
    assert_allclose(short.depth_mm, depth_mm, atol=0.3)
    removed = bar(20.5).volume_mm3(from_mm=-25.0) - left.volume_mm3(from_mm=-25.0)
    assert_allclose(short.removed_mm3().sum(), removed, rtol=0.01)


@pytest.mark.parametrize("lean", [0.0, 0.1])
def test_steps_take_off_what_the_stock_loses(lean: float) -> None:
    """Where a shoulder begins an edge that leans back is in it later than the cells are."""
    done, left = _engaged(_profile(False), lean=lean)
    removed = bar(20.5).volume_mm3(from_mm=-30.0) - left.volume_mm3(from_mm=-30.0)
    assert_allclose(done.removed_mm3().sum(), removed, rtol=0.02 if lean else 1e-3)


def test_lines_that_go_on_are_one_piece() -> None:
    program = turning_program(_profile(False), source="p.nc", diameter=False)
    found = _pieces(program)
    assert len(found) < 0.1 * len(program.moves)
    assert {line for piece in found for line in piece.line.tolist()} == {
        move.line for move in program.moves
    }


@pytest.mark.parametrize(
    ("edge_mm", "changed"),
    [(2.0, ("S1000", "S1000")), (np.inf, ("G97 S1000", "G96 S100")), (np.inf, ("S1000", "S900"))],
)
def test_what_is_refused_within_a_profile_names_its_own_line(
    edge_mm: float, changed: tuple[str, str]
) -> None:
    """Too deep, or at an endless speed: line 25 goes beyond the axis."""
    lines = _profile(False).replace(*changed).splitlines()
    lines[24] = "G1 X-0.5 Z-2.3 F.2"
    said: list[str] = []
    for made in (_engaged, _one_by_one):
        try:
            made("\n".join(lines), lean=0.0, edge_mm=edge_mm)
        except UnusableInput as error:
            said.append(str(error))
    assert said == said[:1] * 2 or not said
    assert bool(said) == (changed[1] != "S900")
    assert all("line 19: 2.0" in one or "line 25: G96" in one for one in said)
