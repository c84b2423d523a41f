"""A long program in few bytes: its lines, and the moves that they make, kept as plain numbers.

A program of a milled shape has hundreds of thousands of lines that are alike: a letter and a number
a few times over. As objects each takes 800 bytes, and 600 more for its move.
"""

from array import array
from collections.abc import Callable, Iterable, Iterator, Sequence
from struct import Struct
from typing import TypeVar, overload

import numpy as np
from numpy.typing import NDArray

from autodb.nc.reading.blocks import Word, WrittenLine
from autodb.nc.reading.paths import Feed, Speed
from autodb.nc.reading.travels import Beside, Circle, ProgramMove, ToolPlace

Said = TypeVar("Said")
_PLACES = Struct("8d")
"""Start, end and an arc's centre, as they lie in the numbers of a move."""
_LINE, _WORD, _NUMBER = "\x1d", "\x1e", "\x1f"
"""Separators in a packed line (ASCII), which no text of a program has."""
_SEPARATORS = frozenset({_LINE, _WORD, _NUMBER})


class PackedLines:
    """Lines by their places; those of plain words are packed, and come back as they were put in."""

    def __init__(self) -> None:
        self._text = bytearray()
        self._begins = array("q", [0])
        self._numbers = array("q")
        self._sources: dict[str, int] = {}
        self._named: list[str] = []

    def __len__(self) -> int:
        """Return how many lines are kept."""
        return len(self._numbers)

    def put(self, line: WrittenLine) -> int | None:
        """Keep a line of plain words and return its place; None: it is of another kind."""
        if line.settings or not all(map(_is_plain, line.words)):
            return None
        if not _SEPARATORS.isdisjoint(line.text):
            return None
        source = self._sources.setdefault(line.source, len(self._sources))
        if source == len(self._named):
            self._named.append(line.source)
        words = _WORD.join(f"{one.name}{_NUMBER}{one.written}" for one in line.words)
        packed = f"{source}{'/' if line.optional else ''}{_LINE}{line.text}{_LINE}{words}"
        self._text += packed.encode()
        self._begins.append(len(self._text))
        self._numbers.append(line.line)
        return len(self._numbers) - 1

    def at(self, place: int) -> WrittenLine:
        """Return the line of a place."""
        packed = self._text[self._begins[place] : self._begins[place + 1]].decode()
        source, text, rest = packed.split(_LINE)
        made = (one.split(_NUMBER) for one in rest.split(_WORD)) if rest else ()
        words = tuple(Word(name, written, float(written)) for name, written in made)
        named = self._named[int(source.removesuffix("/"))]
        return WrittenLine(named, self._numbers[place], text, source.endswith("/"), words)


def _is_plain(word: object) -> bool:
    """Return whether a word is a name and the number that is written behind it, and no more."""
    if not isinstance(word, Word) or word.step is not None or word.arguments:
        return False
    if word.number is None or not _SEPARATORS.isdisjoint(word.name + word.written):
        return False
    try:
        return float(word.written) == word.number
    except ValueError:
        return False


class PackedMoves(Sequence[ProgramMove]):
    """Moves of a program in three axes, in order; each is made anew where it is asked for."""

    def __init__(self, moves: Iterable[ProgramMove] = ()) -> None:
        self._places = array("d")
        self._lines = array("q")
        self._ways = array("i")
        self._kept: list[_Way] = []
        self._known: dict[_Way, int] = {}
        self.extend(moves)

    def append(self, move: ProgramMove) -> None:
        """Keep a move behind the others."""
        circle = move.circle
        centre = (0.0, 0.0) if circle is None else circle.centre
        turns = None if circle is None else (circle.plane, circle.left, circle.turns)
        way = move.feed, move.speed, move.tool, move.thread, move.corner, move.beside, turns
        found = self._known.setdefault(way, len(self._kept))
        if found == len(self._kept):
            self._kept.append(way)
        self._places.extend((*move.start, *move.end, *centre))
        self._lines.append(move.line)
        self._ways.append(found)

    def extend(self, moves: Iterable[ProgramMove]) -> None:
        """Keep moves behind the others."""
        for move in moves:
            self.append(move)

    def __len__(self) -> int:
        """Return how many moves there are."""
        return len(self._lines)

    @overload
    def __getitem__(self, place: int) -> ProgramMove: ...
    @overload
    def __getitem__(self, place: slice) -> list[ProgramMove]: ...
    def __getitem__(self, place: int | slice) -> ProgramMove | list[ProgramMove]:
        """Return a move, or some."""
        if isinstance(place, slice):
            return [self._made(k) for k in range(*place.indices(len(self)))]
        if not -len(self) <= place < len(self):
            raise IndexError(place)
        return self._made(place % len(self))

    def __iter__(self) -> Iterator[ProgramMove]:
        """Give the moves in order."""
        return map(self._made, range(len(self)))

    @property
    def line_numbers(self) -> NDArray[np.int64]:
        """The line of each move (m,)."""
        return np.array(self._lines, dtype=np.int64)

    @property
    def ends_mm(self) -> NDArray[np.float64]:
        """Start and end of each move (m, 6): x, y and z of both."""
        return np.array(self._places, dtype=np.float64).reshape(-1, 8)[:, :6]

    @property
    def compensated(self) -> bool:
        """Whether any move goes beside a contour."""
        return any(way[5] is not None for way in self._kept)

    def by_way(self, said: Callable[[ProgramMove], Said]) -> list[Said]:
        """Return what is said of each move; asked once of those alike but for their places."""
        known: dict[int, Said] = {}
        for k, way in enumerate(self._ways):
            if way not in known:
                known[way] = said(self._made(k))
        return [known[way] for way in self._ways]

    def _made(self, k: int) -> ProgramMove:
        x0, y0, z0, x, y, z, u, v = _PLACES.unpack_from(self._places, k * _PLACES.size)
        feed, speed, tool, thread, corner, beside, turns = self._kept[self._ways[k]]
        circle = None if turns is None else Circle(turns[0], (u, v), turns[1], turns[2])
        return ProgramMove(
            ToolPlace(x0, y0, z0), ToolPlace(x, y, z), feed, speed, self._lines[k], tool, circle,
            thread, corner, beside,
        )  # fmt: skip


_Way = tuple[
    Feed | None,
    Speed | None,
    str | None,
    bool,
    tuple[str, float, str] | None,
    Beside | None,
    tuple[str, bool, int] | None,
]
"""What moves have in common: feed, speed, tool, thread, corner, side, and how an arc turns."""
