"""A program as instructions in order: lines, jumps, calls and returns, whatever control wrote it.

Loops and branches of every control become jumps to places in one list. A program, a subprogram or
a section is a unit: where it begins and ends in that list.
"""

from array import array
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from autodb.errors import UnusableInput
from autodb.nc.reading.lines.blocks import PackedLines, WrittenLine
from autodb.nc.reading.lines.expressions import Expression


@dataclass(slots=True)
class RunLine:
    """RunLine the words of a line."""

    line: WrittenLine


@dataclass(slots=True)
class Jump:
    """Go on elsewhere, always or where a condition holds, or does not hold."""

    line: WrittenLine
    to: int = -1
    when: Expression | None = None
    holds: bool = True


@dataclass
class JumpToLabel:
    """Go on at a label, where a condition holds; ``label`` may have to be worked out; ``back``: at
    the last one before, where there is one."""

    line: WrittenLine
    label: str | Expression
    when: Expression | None = None
    back: bool = False


@dataclass
class Count:
    """Set a hidden counter, or take one off it."""

    line: WrittenLine
    counter: str
    to: Expression | None


@dataclass
class Call:
    """RunLine a unit with arguments, by number (#1 is the first) or by the names that the unit
    gives its parameters, some times; an argument that is left out is None, as is one of
    ``texts``."""

    line: WrittenLine
    unit: str
    arguments: tuple[Expression | None, ...] = ()
    times: Expression | None = None
    by_name: bool = False
    texts: bool = False


@dataclass
class Repeat:
    """RunLine blocks once more, some times: from a label to another, to here, or its one block."""

    line: WrittenLine
    first: str
    last: str | None = None
    block: bool = False
    times: Expression | None = None


@dataclass
class Return:
    """Go back to where the unit was called from, with a value or none."""

    line: WrittenLine
    value: Expression | None = None


Instruction = RunLine | Jump | JumpToLabel | Count | Call | Repeat | Return


class Steps:
    """Instructions in order; lines of plain words, the most of a long program, are packed."""

    def __init__(self) -> None:
        self._packed = PackedLines()
        self._places = array("q")
        self._others: dict[int, Instruction] = {}

    def append(self, step: Instruction) -> None:
        """Let an instruction stand behind the others."""
        place = self._packed.put(step.line) if isinstance(step, RunLine) else None
        if place is None:
            self._others[len(self._places)] = step
        self._places.append(-1 if place is None else place)

    def __iadd__(self, steps: "Iterable[Instruction]") -> "Steps":
        """Let instructions stand behind the others."""
        for step in steps:
            self.append(step)
        return self

    def __len__(self) -> int:
        """Return how many instructions there are."""
        return len(self._places)

    def __getitem__(self, at: int) -> Instruction:
        """Return the instruction of a place."""
        place = self._places[at]
        return self._others[at] if place < 0 else RunLine(self._packed.at(place))

    def __iter__(self) -> Iterator[Instruction]:
        """Give the instructions in order."""
        return (self[at] for at in range(len(self)))


@dataclass
class Instructions:
    """All instructions of a program and its subprograms.

    ``units``: first and last + 1 of each by name; ``labels``: places by name, of N numbers ``N10``,
    with the unit that they stand in; ``parameters`` of units: names, and what each is where a call
    leaves it out; ``main``: the unit that begins the program.
    """

    source: str
    steps: Steps = field(default_factory=Steps)
    units: dict[str, tuple[int, int]] = field(default_factory=dict)
    labels: dict[str, list[int]] = field(default_factory=dict)
    parameters: dict[str, tuple[tuple[str, Expression | None], ...]] = field(default_factory=dict)
    problems: list[UnusableInput] = field(default_factory=list)
    main: str = ""

    def label(self, name: str) -> None:
        """Let a label stand before what comes next."""
        self.labels.setdefault(name, []).append(len(self.steps))

    def place_of(
        self, name: str, unit: tuple[int, int], *, after: int = -1, back: bool = False
    ) -> int | None:
        """Return where a label stands in a unit: the next one after a place, else the first;
        ``back``: the last one up to it, where there is one."""
        inside = [at for at in self.labels.get(name, ()) if unit[0] <= at < unit[1]]
        if back and inside and inside[0] <= after:
            return [at for at in inside if at <= after][-1]
        return next((at for at in inside if at > after), inside[0] if inside else None)
