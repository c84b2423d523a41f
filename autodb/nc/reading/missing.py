"""Subprograms that a program calls by name or number, and that nobody has: said all at once."""

from collections.abc import Iterator

from autodb.errors import UnusableInput
from autodb.nc.reading.lines.blocks import Word, WrittenLine
from autodb.nc.reading.lines.instructions import Call, RunLine
from autodb.nc.reading.runner import NO_SUBPROGRAM, Runner

_CONTOURS = frozenset({"CYCLE95", "CYCLE62"})
"""Cycles whose first argument names a contour: a subprogram, or two labels."""


def missing_subprograms(runner: Runner) -> Iterator[UnusableInput]:
    """Yield a refusal for every call of a subprogram that is not there, in the order of lines."""
    steps = runner.instructions.steps
    for at in range(len(steps)):
        step = steps[at]
        if step.line.optional and runner.block_skip:
            continue
        if isinstance(step, Call) and not runner.has(step.unit):
            yield step.line.refusal(step.unit, NO_SUBPROGRAM)
        if isinstance(step, RunLine):
            for unit in _named(step.line):
                if not runner.has(unit):
                    yield step.line.refusal(unit, NO_SUBPROGRAM)


def _named(line: WrittenLine) -> Iterator[str]:
    """Yield what a line calls: M98 and G65 by number, contours of cycles by name."""
    words = {word.name: word for word in line.words}
    called = words.get("P")
    if isinstance(called, Word) and any(
        isinstance(word, Word) and word.code in ("M98", "G65") for word in line.words
    ):
        number = called.number or 0.0
        yield f"{number if number <= 9999 else number % 10000:.0f}"
    for word in line.words:
        if word.name in _CONTOURS and word.arguments:
            name = word.arguments[0]
            if isinstance(name, str) and name and ":" not in name:
                labels = word.name == "CYCLE62" and len(word.arguments) > 2 and word.arguments[2]
                if not labels:
                    yield name.upper()
