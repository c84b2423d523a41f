"""Stock of a milled part: the height of its top over a grid, lowered by what passes through it.

In every short step of its way a mill takes off, cell by cell, what stands above its bottom. The
step's depth and the band across the feed that is engaged follow from that: the band reaches over
the cells that it lowers, and the depth is the volume over band and step, so that depth × band ×
way is the volume removed. Undercuts are not in a height. Source: geometry, derived here.
"""

from array import array
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain, pairwise
from math import atan2, ceil, degrees, hypot

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.nc.reading import Revolutions
from autodb.nc.reading.travels import ProgramMove
from autodb.wording import localized, phrase

Array = NDArray[np.float64]
Place = tuple[float, float, float]
Flat = tuple[float, float]

MOST_CELLS = 1_500_000
"""Cells of a grid. Chosen: 12 MB, and a block of 300 mm in cells of 0.25 mm."""
ACROSS = 120
"""Cells across a mill. Chosen: widths are then off by 0.8 % of its diameter at the most, volumes
of straight passes by less than 0.5 % (a test)."""
PARTS = 4
"""Parts of a cell to which a cutter's axis is rounded in each direction, so that its shape is
worked out once for each. Chosen: 0.1 % of its diameter."""
RUBS = 0.02
"""Share of a mill's cross-section that a rapid may meet: cells of walls that its cuts have left.
Chosen: twice what cells of a sixtieth leave around its rim; large blocks have such."""
FEW = 8
"""Steps of a straight move up to which plain numbers are faster than arrays. Measured."""
AT_ONCE = 50_000
"""Numbers of steps that wait for their place in the table. Chosen: 400 kB."""
MOST_STEPS = 8_000_000
"""Steps of all moves together. Chosen: 2.4 km of a mill of 6 mm, which takes minutes to follow and
0.4 GB."""
ROUNDING = 0.05
"""By what share of a step a move may be longer than its steps."""
ALONG = 20
"""Steps along a mill's diameter. Chosen: what stays between two of them is 0.03 % of it high."""


@dataclass(frozen=True)
class Cutter:
    """A mill or drill as its way sees it; ``point_mm``: how far a drill's rim is behind its tip."""

    diameter_mm: float
    corner_radius_mm: float = 0.0
    point_mm: float = 0.0

    def bottom_mm(self, off_mm: Array) -> Array:
        """Return how high its bottom is above its tip at distances from its axis, mm."""
        radius = 0.5 * self.diameter_mm
        corner = min(self.corner_radius_mm, radius)
        beyond = np.maximum(off_mm - (radius - corner), 0.0)
        rounded = corner - np.sqrt(np.maximum(corner**2 - beyond**2, 0.0))
        return np.asarray(rounded + self.point_mm * off_mm / radius)


@dataclass(frozen=True)
class MilledSteps:
    """What a mill does in every step at a feed, each (n,).

    ``low_mm`` and ``high_mm``: the band across the feed, as of ``endmill.Milled``; ``depth_mm``
    over it; ``direction_deg`` of the feed in the plane, ``plunge``: how much of it goes down, 0 to
    1; ``move``: which of the moves. Of a step of each move (m,): ``time_s_of``, ``feed_of`` mm/min
    and ``speed_of`` rpm, 0 of rapids.
    """

    time_s_of: Array
    feed_of: Array
    speed_of: Array
    depth_mm: Array
    low_mm: Array
    high_mm: Array
    direction_deg: Array
    plunge: Array
    removed_mm3: Array
    move: NDArray[np.int32]

    def time_s(self, rows: NDArray[np.intp]) -> Array:
        """Return how long steps take, s."""
        return np.asarray(self.time_s_of[self.move[rows]])

    def feed_mm_min(self, rows: NDArray[np.intp]) -> Array:
        """Return the feed of steps, mm/min."""
        return np.asarray(self.feed_of[self.move[rows]])

    def speed_rpm(self, rows: NDArray[np.intp]) -> Array:
        """Return the spindle speed of steps, rpm."""
        return np.asarray(self.speed_of[self.move[rows]])


@dataclass(frozen=True)
class _Shape:
    """A cutter's bottom over cells, endless beyond its rim, with the places of their middles.

    ``first``: the first cell, from that of the axis; ``size``: how many cells.
    """

    first: tuple[int, int]
    size: tuple[int, ...]
    bottom_mm: Array
    off_x: NDArray[np.floating]
    off_y: NDArray[np.floating]


class Block:
    """The stock: ``height_mm`` over a grid from a corner, in cells of one size."""

    def __init__(
        self, low_mm: tuple[float, float, float], high_mm: tuple[float, float, float], cell: float
    ) -> None:
        size = np.subtract(high_mm, low_mm)
        self.cell_mm = max(cell, float(np.sqrt(size[0] * size[1] / MOST_CELLS)))
        self.low_mm, self.floor_mm = low_mm[:2], low_mm[2]
        shape = np.maximum(np.round(size[:2] / self.cell_mm), 1).astype(int)
        self.size_mm: Flat = (float(size[0] / shape[0]), float(size[1] / shape[1]))
        self.height_mm = np.full(tuple(shape), high_mm[2], dtype=np.float64)
        self._shapes: dict[tuple[Cutter, int, int], _Shape] = {}

    def cut(self, cutter: Cutter, at_mm: Place, along: Flat) -> tuple[float, float, float]:
        """Take off what stands above a cutter at a place; the feed goes ``along`` x and y.

        Returns the volume, and from where to where the band across the feed lies.
        """
        (i, fine_i), (j, fine_j) = (self._cell(axis, at_mm[axis]) for axis in (0, 1))
        shape = self._shape(cutter, fine_i, fine_j)
        rows, count = self.height_mm.shape
        i, j = i + shape.first[0], j + shape.first[1]
        (low_i, high_i), (low_j, high_j) = _within(i, shape.size[0], rows), _within(
            j, shape.size[1], count
        )  # fmt: skip
        if low_i >= high_i or low_j >= high_j:
            return 0.0, 0.0, 0.0
        window = self.height_mm[low_i:high_i, low_j:high_j]
        part = slice(low_i - i, high_i - i), slice(low_j - j, high_j - j)
        bottom = shape.bottom_mm[part] + at_mm[2]
        if at_mm[2] < self.floor_mm:
            np.maximum(bottom, self.floor_mm, out=bottom)
        above = np.subtract(window, bottom, out=bottom)
        np.maximum(above, 0.0, out=above)
        volume = float(above.sum())
        if volume == 0.0:
            return 0.0, 0.0, 0.0
        window -= above
        across = (along[0] * shape.off_y[:, part[1]] - along[1] * shape.off_x[part[0]])[above > 0.0]
        half, radius = 0.25 * (self.size_mm[0] + self.size_mm[1]), 0.5 * cutter.diameter_mm
        low, high = max(across.min() - half, -radius), min(across.max() + half, radius)
        return volume * self.size_mm[0] * self.size_mm[1], float(low), float(high)

    def _cell(self, axis: int, at_mm: float) -> tuple[int, int]:
        """Return in which cell a place lies, and at which of its parts."""
        return divmod(round((at_mm - self.low_mm[axis]) / self.size_mm[axis] * PARTS), PARTS)

    def _shape(self, cutter: Cutter, fine_i: int, fine_j: int) -> _Shape:
        """Return the cells under a cutter whose axis is at a part of a cell; kept, once made."""
        key = (cutter, fine_i, fine_j)
        found = self._shapes.get(key)
        if found is None:
            found = self._shapes[key] = _shape_of(cutter, self.size_mm, (fine_i, fine_j))
        return found


def _within(first: int, count: int, cells: int) -> tuple[int, int]:
    return max(first, 0), min(first + count, cells)


def _shape_of(cutter: Cutter, size_mm: Flat, fine: tuple[int, int]) -> _Shape:
    radius = 0.5 * cutter.diameter_mm
    reach = [int(np.ceil(radius / size)) + 1 for size in size_mm]
    off_x, off_y = (
        (np.arange(-reach[k], reach[k] + 1) + 0.5 - fine[k] / PARTS) * size_mm[k] for k in (0, 1)
    )
    distance = np.hypot(off_x[:, None], off_y[None, :])
    bottom = np.where(distance <= radius, cutter.bottom_mm(distance), np.inf)
    return _Shape((-reach[0], -reach[1]), bottom.shape, bottom, off_x[:, None], off_y[None, :])


def milled(
    travels: Sequence[ProgramMove], block: Block, cutters: Sequence[Cutter], *, source: str
) -> MilledSteps:
    """Return what moves do, each with its cutter, and lower the block by it.

    Raises UnusableInput naming ``source`` and the line of a rapid through the stock, or the longest
    move of a path that is too long to follow.
    """
    of_all, feeds = _counts(travels, block, cutters, source=source)
    counts = np.where(feeds, of_all, 0)
    of_moves, cells = np.zeros((3, len(counts))), np.empty((6, int(counts.sum())))
    at, rows_then = 0, array("d")
    for k, (travel, cutter) in enumerate(zip(travels, cutters, strict=True)):
        count = int(of_all[k])
        rows = _steps(travel, block, cutter, count)
        if travel.feed is None:
            if _collides(travel, cutter, rows):
                raise UnusableInput(
                    phrase(
                        "{source}: line {line}: this rapid goes through the stock; go around it or "
                        "use a feed",
                        source=source,
                        line=travel.line,
                    )
                )
            continue
        of_moves[:, k] = _of_step(travel, count)
        rows_then.extend(chain.from_iterable(rows))
        if len(rows_then) >= AT_ONCE:
            at = _put(cells, at, rows_then)
            rows_then = array("d")
    _put(cells, at, rows_then)
    move = np.repeat(np.arange(len(counts), dtype=np.int32), counts)
    time_s, feed, rpm = of_moves
    depth, low, high, direction, plunge, removed = cells
    return MilledSteps(time_s, feed, rpm, depth, low, high, direction, plunge, removed, move)


def _counts(
    travels: Sequence[ProgramMove], block: Block, cutters: Sequence[Cutter], *, source: str
) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Return in how many steps each move is followed, and which are at a feed."""
    moves = [
        (_count(travel, block, cutter), travel.feed is not None)
        for travel, cutter in zip(travels, cutters, strict=True)
    ]
    of_all = np.array([count for count, _ in moves], dtype=np.int64)
    if of_all.sum() > MOST_STEPS:
        longest = travels[int(np.argmax(of_all))]
        raise UnusableInput(
            phrase(
                "{source}: line {line}: the path is too long to follow; this move alone is "
                "{length} m: correct it, or split the program",
                source=source,
                line=longest.line,
                length=localized(f"{longest.length_mm / 1000.0:.3g}"),
            )
        )
    return of_all, np.array([feeds for _, feeds in moves], dtype=np.bool_)


def _put(cells: Array, at: int, rows: "array[float]") -> int:
    """Put rows of steps into columns from a place on, and return where the next ones go."""
    found = np.frombuffer(rows, dtype=np.float64).reshape(-1, len(cells))
    cells[:, at : at + len(found)] = found.T
    return at + len(found)


def _collides(travel: ProgramMove, cutter: Cutter, rows: Sequence[tuple[float, ...]]) -> bool:
    """Return whether a rapid takes off more than what the grid leaves at walls and in steps."""
    area_mm2 = 0.25 * np.pi * cutter.diameter_mm**2
    leaves_mm3 = 0.01 + RUBS * area_mm2 * travel.length_mm / len(rows)
    return any(row[5] > leaves_mm3 for row in rows)


def _count(travel: ProgramMove, block: Block, cutter: Cutter) -> int:
    """Return in how many steps a move is followed."""
    step_mm = max(block.cell_mm, cutter.diameter_mm / ALONG)
    return max(ceil(travel.length_mm / step_mm - ROUNDING), 1)


def _of_step(travel: ProgramMove, count: int) -> tuple[float, float, float]:
    """Return what each step of a move has: its time, s, feed, mm/min, and spindle speed, rpm."""
    time_s = travel.time_s() / count
    length_mm = travel.length_mm / count
    feed = 60.0 * length_mm / time_s if time_s > 0 else 0.0
    return time_s, feed, _rpm(travel)


def _steps(
    travel: ProgramMove, block: Block, cutter: Cutter, count: int
) -> list[tuple[float, ...]]:
    """Return depth, band, direction, plunge and volume of a move's steps.

    Nothing is taken off where it is a rapid upwards.
    """
    ends = _ends(travel, count)
    rows: list[tuple[float, ...]] = []
    for (x0, y0, z0), (x, y, z) in pairwise(ends):
        wx, wy, wz = x - x0, y - y0, z - z0
        flat = hypot(wx, wy)
        along = (wx / flat, wy / flat) if flat > 1e-9 else (1.0, 0.0)
        volume, low, high = block.cut(cutter, (x, y, z), along)
        width = high - low
        depth = volume / (flat * width) if flat > 1e-9 and width > 0 else 0.0
        direction = degrees(atan2(along[1], along[0]))
        plunge = max(-wz, 0.0) / max(hypot(flat, wz), 1e-12)
        rows.append((depth, low, high, direction, plunge, volume))
    return rows


def _ends(travel: ProgramMove, count: int) -> list[list[float]]:
    """Return the places at the ends of a move's steps."""
    if travel.circle is not None or count > FEW:
        return [[*one] for one in travel.places(np.arange(count + 1) / count).tolist()]
    (x, y, z), to = travel.start, travel.end
    wx, wy, wz = to.x_mm - x, to.y_mm - y, to.z_mm - z
    shares = [k / count for k in range(count + 1)]
    return [[x + share * wx, y + share * wy, z + share * wz] for share in shares]


def _rpm(travel: ProgramMove) -> float:
    """Return the speed of a mill's spindle in a move, 0 in a rapid."""
    if isinstance(travel.speed, Revolutions):
        return travel.speed.rpm
    return 0.0 if travel.speed is None else float(travel.speed.at_rpm(np.ones(1))[0])
