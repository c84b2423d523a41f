"""What a program makes the tool do, in three axes: rapids, straight moves, arcs and helices."""

from array import array
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from math import atan2, dist, hypot, tau
from struct import Struct
from typing import NamedTuple, TypeVar, overload

import numpy as np
from numpy.typing import NDArray

from autodb.nc.reading.paths import Feed, FeedPerMinute, Revolutions, Speed

Array = NDArray[np.float64]

PLANES = {"G17": (0, 1, 2), "G18": (2, 0, 1), "G19": (1, 2, 0)}
"""Axes of each plane: the two in it, so that G3 turns from first to second, and the third."""


Beside = tuple[str, float | None]
"""A side, left or right, and a distance in mm or None."""


class ToolPlace(NamedTuple):
    """A place of the tool tip, mm; x of a lathe is the radius."""

    x_mm: float
    y_mm: float
    z_mm: float


@dataclass(frozen=True)
class Circle:
    """An arc's plane, its centre there, whether it turns to the left (G3), and whole turns more."""

    plane: str
    centre: tuple[float, float]
    left: bool
    turns: int = 0


@dataclass(frozen=True, slots=True)
class ProgramMove:
    """A move from place to place; a rapid has no feed; ``thread``: it follows the spindle's angle.

    ``tool``: as the program calls it; ``corner``: kind, size in mm and plane of what stands
    between it and the next move, until that is known; ``beside``: on which side of it a tool goes,
    and how far if the program says so; of a mill until its own path is known.
    """

    start: ToolPlace
    end: ToolPlace
    feed: Feed | None
    speed: Speed | None
    line: int
    tool: str | None
    circle: Circle | None = None
    thread: bool = False
    corner: tuple[str, float, str] | None = None
    beside: Beside | None = None

    @property
    def _round(self) -> tuple[float, float, float, float]:
        """Angle of the start, angle passed, radius at the start and at the end."""
        assert self.circle is not None
        u, v, _ = PLANES[self.circle.plane]
        (cu, cv), (s, e) = self.circle.centre, (self.start, self.end)
        begin = atan2(s[v] - cv, s[u] - cu)
        turned = (atan2(e[v] - cv, e[u] - cu) - begin) % tau
        if hypot(e[u] - s[u], e[v] - s[v]) < 1e-9:
            turned = tau if self.circle.left else 0.0
        turned = turned if self.circle.left else turned - tau
        turned += tau * self.circle.turns * (1 if self.circle.left else -1)
        return begin, turned, hypot(s[u] - cu, s[v] - cv), hypot(e[u] - cu, e[v] - cv)

    @property
    def length_mm(self) -> float:
        """Length of the way, mm."""
        if self.circle is None:
            return dist(self.end, self.start)
        w = PLANES[self.circle.plane][2]
        _, turned, first, last = self._round
        return hypot(abs(turned) * (first + last) / 2, self.end[w] - self.start[w])

    def places(self, shares: Array) -> Array:
        """Return places (n, 3), mm, at shares of the way, 0 to 1."""
        if self.circle is None:
            return np.asarray(self.start) + shares[:, None] * np.subtract(self.end, self.start)
        u, v, w = PLANES[self.circle.plane]
        begin, turned, first, last = self._round
        angle = begin + shares * turned
        radius = first + shares * (last - first)
        found = np.empty((len(shares), 3))
        found[:, u] = self.circle.centre[0] + radius * np.cos(angle)
        found[:, v] = self.circle.centre[1] + radius * np.sin(angle)
        found[:, w] = self.start[w] + shares * (self.end[w] - self.start[w])
        return found

    def time_s(self) -> float:
        """Return how long a move at a feed takes at its spindle speed, s; a rapid takes none.

        At a constant cutting speed, the mean over the way of what it takes at each radius.
        """
        if self.feed is None or self.speed is None:
            return 0.0
        if isinstance(self.feed, FeedPerMinute):
            return 60.0 * self.length_mm / self.feed.mm
        if isinstance(self.speed, Revolutions):
            return 60.0 * self.length_mm / (self.feed.mm * self.speed.rpm)
        steps = max(int(np.ceil(self.length_mm / 0.05)), 1)
        x_mm = self.places((np.arange(steps) + 0.5) / steps)[:, 0]
        return float(np.mean(60.0 * self.length_mm / (self.feed.mm * self.speed.at_rpm(x_mm))))


Record = Callable[[ProgramMove], None]
"""What keeps a move."""


Said = TypeVar("Said")
_PLACES = Struct("8d")
"""Start, end and an arc's centre, as they lie in the numbers of a move."""


class PackedMoves(Sequence[ProgramMove]):
    """Moves of a program in three axes, in order; each is made anew where it is asked for.

    As objects each takes 600 bytes; so it takes 76.
    """

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
