"""A program followed through its stock, and the steps of its lines joined into parts.

Steps that are alike are one; where more than MOST are left of a line, they are joined evenly.
"""

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.turning import TURNED
from autodb.errors import UnusableInput
from autodb.files.checksums import checksum
from autodb.files.job import JobProgram
from autodb.forward.along import ProgramLine
from autodb.nc.reading import program_text
from autodb.pairs.engaged import Conditions
from autodb.wording import phrase

Array = NDArray[np.float64]

MOST = 32
"""Steps of a line beyond which they are joined. Chosen: means of cones and arcs are off by less
than 0.1 % of what all steps give (a test)."""
MOST_LINES = 300
"""Lines of a program beyond which neighbours are joined. Chosen: an answer that can be read, and
some seconds to predict."""
CONTOUR = "contour"
ALIKE = 1e-6
"""Difference in mm, mm/rev, rpm or of a direction's cosine below which steps are alike."""


@dataclass(frozen=True)
class Followed:
    """A program followed through its stock: the lines that cut, and how long it feeds, s.

    ``tools``: what the program calls the tools that cut; ``removed_mm3`` of the stock; ``notes``:
    what was taken of the program that it does not say. ``spans_mm``: how far, by axis, a tool's
    feeds reach from their lowest to their highest place. ``beside``: lines of a lathe's program
    whose nose is compensated.
    """

    source: str
    sha256: str
    lines: tuple[ProgramLine, ...]
    fed_s: float
    tools: tuple[str, ...]
    removed_mm3: float = 0.0
    notes: tuple[str, ...] = ()
    spans_mm: Mapping[str, float] = field(default_factory=dict)
    beside: frozenset[int] = frozenset()

    @property
    def cutting_s(self) -> float:
        """How long the lines cut, s."""
        return float(sum(line.time_s.sum() for line in self.lines))

    @property
    def edges(self) -> tuple[str | None, ...]:
        """What the program calls the tools of its lines, in their order."""
        return tuple(dict.fromkeys(line.tool for line in self.lines))


def feed_spans_mm(
    fed: Iterable[tuple[str | None, Mapping[str, float], Mapping[str, float]]],
) -> dict[str, float]:
    """Return how far feeds reach, by axis: the widest of what each tool's starts and ends span."""
    reached: dict[tuple[str | None, str], tuple[float, float]] = {}
    for tool, *ends in fed:
        for place in ends:
            for axis, at in place.items():
                low, high = reached.get((tool, axis), (at, at))
                reached[tool, axis] = min(low, at), max(high, at)
    spans: dict[str, float] = {}
    for (_, axis), (low, high) in reached.items():
        spans[axis] = max(spans.get(axis, 0.0), high - low)
    return spans


_SKIPS = re.compile(r"^[^(;\r\n]*/", re.MULTILINE)
"""A line with something behind the / of block skip, as far as remarks let it be told."""


def program_of_job(asked: JobProgram) -> tuple[str, str]:
    """Return the text of a job's program, up to its last line, and the file's checksum.

    Raises UnusableInput for another program.
    """
    path = Path(asked.file)
    text = program_text(path)
    found = checksum(path)
    if asked.sha256 not in (None, found):
        raise UnusableInput(
            phrase(
                "{file}: is not the program of this job, its sha256 is {found}; use the file "
                "with {sha256}",
                file=path,
                found=found,
                sha256=asked.sha256,
            )
        )
    if asked.block_skip and not _SKIPS.search(text):
        raise UnusableInput(
            phrase("{file}: no line of it has a /; leave out block_skip", file=path)
        )
    if asked.last_line is not None:
        text = _up_to(text, asked.last_line, path)
    return text, found


def _up_to(text: str, last_line: int, path: Path) -> str:
    """Return the lines of a program up to one; raises UnusableInput where there is none behind."""
    lines = re.findall(r"[^\r\n]*(?:\r\n|\r|\n)|[^\r\n]+", text)
    if last_line >= len(lines):
        raise UnusableInput(
            phrase(
                "{file}: has {lines} lines, and last_line is {last_line}; state one before its "
                "last, or leave it out",
                file=path,
                lines=len(lines),
                last_line=last_line,
            )
        )
    return "".join(lines[:last_line])


@dataclass(frozen=True)
class LineRows:
    """Steps that cut, by line, operation and tool: each of ``lines`` with its ``rows``.

    ``number``, ``operation`` and ``tool`` (m,) of each line, the latter two as places in
    ``operations`` and ``tools``; its steps are ``rows`` (n,) from ``begins`` (m + 1,) on.
    """

    number: NDArray[np.intp]
    operation: NDArray[np.intp]
    tool: NDArray[np.signedinteger]
    begins: NDArray[np.intp]
    rows: NDArray[np.intp]
    operations: Sequence[str]
    tools: Sequence[str | None]


def line_rows(
    rows: NDArray[np.intp],
    number: NDArray[np.intp],
    operation: NDArray[np.intp],
    tool: NDArray[np.signedinteger],
    *,
    operations: Sequence[str],
    tools: Sequence[str | None],
) -> LineRows:
    """Return steps (n,) put together by line, operation and tool, in the order of their firsts.

    ``operation`` and ``tool`` (n,) as in `LineRows`.
    """
    key = (number * len(operations) + operation) * max(len(tools), 1) + tool
    _, first, which = np.unique(key, return_index=True, return_inverse=True)
    order = np.argsort(first, kind="stable")
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    place = rank[which]
    sizes = np.bincount(place, minlength=len(order))
    firsts = first[order]
    return LineRows(
        number[firsts], operation[firsts], tool[firsts], np.append(0, np.cumsum(sizes)),
        rows[np.argsort(place, kind="stable")], operations, tools,
    )  # fmt: skip


@dataclass(frozen=True)
class CalledLine:
    """A line, or a run of lines: number of the first, operation, name, and what calls its tool."""

    number: int
    operation: str
    name: str
    tool: str | None


def lines_joined(
    found: LineRows, said: Callable[[Collection[int]], Mapping[int, str]]
) -> Iterator[tuple[CalledLine, NDArray[np.intp]]]:
    """Yield every line with its steps; of very many, runs of lines of one tool as one.

    ``said``: what gives the texts of some lines.
    """
    parts = list(_parts(found))
    numbers = found.number
    texts = said({int(numbers[a]) for a, b in parts if numbers[a] == numbers[b - 1]})
    for a, b in parts:
        first, last = int(numbers[a]), int(numbers[b - 1])
        name = (
            f"line {first}: {texts.get(first, '')}"
            if last == first
            else (f"lines {first} to {last}")
        )
        called = CalledLine(first, _operation(found, a, b), name, found.tools[int(found.tool[a])])
        yield called, found.rows[found.begins[a] : found.begins[b]]


def _parts(found: LineRows) -> Iterator[tuple[int, int]]:
    """Yield from which line to which lines are one: neighbours of one operation and one tool.

    Where that leaves too many, as of a profile in very short lines, neighbours that turn, in
    whatever direction, are one.
    """
    count = len(found.number)
    many = -(-count // MOST_LINES)
    ends = _ends(found.operation, found.tool)
    if len(ends) > MOST_LINES:
        turns = np.array([name in TURNED for name in found.operations])
        ends = _ends(np.where(turns[found.operation], -1, found.operation), found.tool)
    begin = 0
    for end in ends:
        for at in range(begin, end, many):
            yield at, min(at + many, end)
        begin = end


def _ends(operation: NDArray[np.intp], tool: NDArray[np.signedinteger]) -> list[int]:
    """Return behind which lines (m,) runs of one operation and one tool end."""
    changes = (np.diff(operation) != 0) | (np.diff(tool) != 0)
    return [*(1 + np.flatnonzero(changes)).tolist(), len(operation)] if len(operation) else []


def _operation(found: LineRows, a: int, b: int) -> str:
    """Return what lines do together: turning in several directions is along a contour."""
    done = set(found.operation[a:b].tolist())
    return found.operations[done.pop()] if len(done) == 1 else CONTOUR


def part_begins(columns: Array) -> NDArray[np.intp]:
    """Return at which steps (n, k) parts of a line begin: where something changes, MOST at most."""
    changes = np.any(np.abs(np.diff(columns, axis=0)) > ALIKE, axis=1)
    begins = np.append(0, np.flatnonzero(changes) + 1)
    if len(begins) <= MOST:
        return begins
    return np.unique(np.linspace(0, len(columns), MOST, endpoint=False).astype(np.intp))


def step_conditions(columns: Mapping[str, Array]) -> tuple[Conditions, ...]:
    """Return columns by channel as conditions of each step."""
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    return tuple(dict(zip(columns, row, strict=True)) for row in rows)
