"""Lines of a program that are answered together, where they are very many."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.files.job import JobProgram
from autodb.forward import along, line_parts, programs
from autodb.forward.line_parts import Followed
from tests.helpers.known_pairs import INSERT, known


def _work_J(found: Followed) -> float:
    cuts = along.predict_lines(known(), INSERT, found.lines, source=found.source)
    times = [line.time_s.sum() for line in found.lines]
    return float(np.dot([cut.power_W.value for cut in cuts], times))


def test_short_lines_that_turn_this_way_and_that_are_one_along_a_contour(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A profile of steps and cones is as many rows as lines, or five; time and work are equal."""
    steps = [f"X{50 + 0.2 * k:g} Z{-2 * k - 1}\nZ{-2 * k - 2}\n" for k in range(10)]
    path = tmp_path / "p.nc"
    path.write_text("G95 G97 S1000 M3\nG0 X50 Z1\nG1 Z0 F.2\n" + "".join(steps), encoding="utf-8")
    asked = JobProgram(file=str(path), stock_diameter_mm=60.0)
    alone = programs.follow(asked, units=None, diameter=None)
    monkeypatch.setattr(line_parts, "MOST_LINES", 5)
    few = programs.follow(asked, units=None, diameter=None)
    assert {line.operation for line in alone.lines} == {"taper", "turn"}
    assert [line.operation for line in few.lines] == ["contour"] * 5
    assert few.lines[0].name == "lines 4 to 7"
    assert_allclose(few.cutting_s, alone.cutting_s, rtol=1e-12)
    assert_allclose(_work_J(few), _work_J(alone), rtol=0.001)
