"""Long programs in few bytes: what is packed comes back as it was, and what a line takes."""

import tracemalloc
from itertools import pairwise

import pytest

from autodb.nc.reading.lines.blocks import PackedLines, WrittenLine, worded
from autodb.nc.reading.lines.flow import fanuc_instructions
from autodb.nc.reading.lines.instructions import Jump, RunLine
from autodb.nc.reading.paths import CuttingSpeed, FeedPerMinute, PerRev, Revolutions
from autodb.nc.reading.travels import Circle, PackedMoves, ProgramMove, ToolPlace
from autodb.nc.reading.turning_program import carried_out

MOST_BYTES = 300
"""Of a line of a program that is carried out; as objects one takes more than 1300."""


def _program(lines: int) -> str:
    moves = (f"X{k % 97}.125 Y{k % 89}.5 Z-{k % 7}.25" for k in range(lines))
    return "\n".join(["G21 G90 G17", "S900 M3", "G0 X0 Y0 Z5", "G1 F400", *moves, "M30"])


@pytest.mark.parametrize(
    "text", ["N10G1X-.5Z+3.F0.2", "/ G0 X1.0 Z-0", "T0101", "G3X1Y2I-1.J0,R2", "M30", "X5 Y-7 (µ)"]
)
def test_a_plain_line_comes_back_as_it_was(text: str) -> None:
    words = text.lstrip("/ ").split(" (", maxsplit=1)[0]
    line = worded(WrittenLine("p.nc", 7, text, optional=text[0] == "/"), words)
    assert line.words
    lines = PackedLines()
    assert lines.put(WrittenLine("q.nc", 1, "G0", words=())) == 0
    assert lines.put(line) == 1
    assert lines.at(1) == line
    assert lines.at(0).source == "q.nc"


def test_a_line_with_an_expression_and_a_jump_stay_what_they_are() -> None:
    found = fanuc_instructions("#1=3\nN5 X#1\nX2\nIF [#1 GT 0] GOTO 5\n", source="p.nc")
    kinds = [type(step).__name__ for step in found.steps]
    assert kinds == ["RunLine", "RunLine", "RunLine", "JumpToLabel"]
    setting, expression, plain = (found.steps[k] for k in range(3))
    assert isinstance(setting, RunLine) and isinstance(expression, RunLine)
    assert setting.line.settings
    assert expression.line.words[0].written == "#1"
    assert isinstance(plain, RunLine) and plain.line.text == "X2"
    loop = fanuc_instructions("WHILE [#1 LT 3] DO1\nX1\nEND1\n", source="p.nc")
    (jump, _, back) = list(loop.steps)
    assert isinstance(jump, Jump) and isinstance(back, Jump)
    assert (jump.to, back.to) == (3, 0)


def test_moves_come_back_as_they_were() -> None:
    a, b = ToolPlace(0.1, -0.0, 3.0), ToolPlace(1e-9, 2.0, -3.7)
    moves = [
        ProgramMove(a, b, None, None, 3, None),
        ProgramMove(b, a, PerRev(0.2), CuttingSpeed(180.0, None), 4, "0101", thread=True),
        ProgramMove(
            a, b, FeedPerMinute(300.0), Revolutions(900.0), 4, "2",
            circle=Circle("G18", (0.3, -4.0), left=True, turns=2), beside=("left", None),
        ),
        ProgramMove(b, a, FeedPerMinute(300.0), Revolutions(900.0), 9, "2",
                    corner=("R", 2.0, "G17")),
    ]  # fmt: skip
    packed = PackedMoves(moves)
    assert list(packed) == moves
    assert packed[-1] == moves[-1]
    assert packed[1:3] == moves[1:3]
    assert packed.line_numbers.tolist() == [3, 4, 4, 9]
    assert packed.by_way(lambda move: move.tool) == [None, "0101", "2", "2"]
    assert packed.compensated
    assert not PackedMoves(moves[:2]).compensated
    with pytest.raises(IndexError):
        packed[4]


def test_a_line_takes_few_bytes() -> None:
    """Of twice the lines the peak of reading a mill's program grows by no more than that."""
    peaks = []
    for count in (1500, 3000):
        text = _program(count)
        tracemalloc.start()
        travels = carried_out(text, source="p", lathe=False, radius_of=lambda _: 1.0).travels
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
        assert len(travels) >= count
        assert all(one.end == two.start for one, two in pairwise(travels))
    assert (peaks[1] - peaks[0]) / 1500.0 < MOST_BYTES
