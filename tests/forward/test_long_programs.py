"""Programs of very many lines are followed in few bytes a line."""

import tracemalloc
from pathlib import Path

import pytest

from autodb.files.job import JobProgram, ProgramTool
from autodb.forward.along import predict_lines
from autodb.forward.prediction import ToolOf
from autodb.forward.programs import follow
from autodb.pairs.prior import any_metal

LATHE, MILL = 520, 450
"""Bytes a line: 88 of a lathe's step and 76 of a move, the others in passing; some 400 in all.
Steps that are put together once more, and moves as objects, take above 800."""
LINES = 600
AT_ONCE_MB = 50.0
"""What predictions of a milled program's lines take at once: 30 MB (160 where a block is of so many
cuts, whatever elements each has)."""


def _turned(lines: int) -> str:
    """Return a cylinder in short lines: each is a step, and all together are one cut."""
    moves = (f"X39.5 Z-{0.05 * (k + 1):.3f}" for k in range(lines))
    return "\n".join(["G21 G90 G18 G97 S900 M3 T0101", "G0 X41 Z1", "G1 G95 F0.2", *moves, "M30"])


def _milled(lines: int) -> str:
    """Return a groove in short lines, most of them above the block: steps that cut differ."""
    moves = (f"X{0.05 * (k + 1):.3f} Z{-1 if k < 150 else 1}" for k in range(lines))
    return "\n".join(["G21 G90 G17 S900 M3 T1 M6", "G0 X0 Y5 Z2", "G1 Z-1 F200", *moves, "M30"])


def _peak_bytes(job: JobProgram) -> int:
    tracemalloc.start()
    found = follow(job, units="mm", diameter=True)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert found.removed_mm3 > 0.0
    return peak


@pytest.mark.parametrize(("kind", "most"), [("lathe", LATHE), ("mill", MILL)])
def test_a_line_takes_few_bytes_up_to_its_cuts(kind: str, most: int, tmp_path: Path) -> None:
    """Of twice the lines the peak grows by no more than that for each."""
    peaks = []
    for lines in (10, LINES, 2 * LINES):  # the first loads what is loaded once
        path = tmp_path / f"{lines}.nc"
        path.write_text(_turned(lines) if kind == "lathe" else _milled(lines), encoding="utf-8")
        if kind == "lathe":
            job = JobProgram(file=str(path), stock_diameter_mm=40.0)
        else:
            tool = ProgramTool(kind="end_mill", diameter_mm=2.0, teeth=2)
            job = JobProgram(
                file=str(path), block_mm=(0.0, 201.0, 0.0, 10.0, -5.0, 0.0), tools={"other": tool}
            )
        peaks.append(_peak_bytes(job))
    assert (peaks[2] - peaks[1]) / LINES < most


def test_predictions_of_a_long_program_take_no_more_memory_than_of_a_short_one(
    tmp_path: Path,
) -> None:
    """A face in waves, in which each step is another: what lines take is not held together."""
    moves = (
        f"X{0.2 * (k % 40):.3f} Y{0.25 * (k // 40):.3f} Z{-1.0 - 0.01 * (k % 40):.3f}"
        for k in range(120)
    )
    path = tmp_path / "face.nc"
    begin = ["G21 G90 G17 S9000 M3 T1 M6", "G0 X0 Y0 Z2", "G1 Z-1 F800"]
    path.write_text("\n".join([*begin, *moves, "M30"]), encoding="utf-8")
    tool = ProgramTool(kind="end_mill", diameter_mm=2.0, teeth=2)
    block = (-2.0, 10.0, -2.0, 5.0, -5.0, 0.0)
    job = JobProgram(file=str(path), block_mm=block, tools={"other": tool})
    lines = follow(job, units="mm", diameter=True).lines
    mill = ToolOf("mill", {"diameter_mm": 2.0, "teeth": 2})
    predict_lines(any_metal(), mill, lines[:1], source="face.nc")  # loads what is loaded once
    tracemalloc.start()
    found = predict_lines(any_metal(), mill, lines[:16], source="face.nc")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert len(found) == 16
    assert peak < AT_ONCE_MB * 1e6
