"""Stock of a milled part: the height of its top over a grid, lowered by what passes through it.

In every short step of its way a mill takes off, cell by cell, what stands above its bottom. The
step's depth and the band across the feed that is engaged follow from that: the band reaches over
the cells that it lowers, and the depth is the volume over band and step, so that depth × band ×
way is the volume removed. Undercuts are not in a height. Source: geometry, derived here.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.nc.reading.travels import ProgramMove

Array = NDArray[np.float64]

MOST_CELLS = 1_500_000
"""Cells of a grid. Chosen: 12 MB, and a block of 300 mm in cells of 0.25 mm."""
ACROSS = 60
"""Cells across a mill. Chosen: widths are then off by 1.7 % of its diameter at the most, volumes
of straight passes by less than 0.5 % (a test)."""
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
    1; ``move``: which of the moves.
    """

    time_s: Array
    feed_mm_min: Array
    speed_rpm: Array
    depth_mm: Array
    low_mm: Array
    high_mm: Array
    direction_deg: Array
    plunge: Array
    removed_mm3: Array
    move: NDArray[np.int_]


class Block:
    """The stock: ``height_mm`` over a grid from a corner, in cells of one size."""

    def __init__(
        self, low_mm: tuple[float, float, float], high_mm: tuple[float, float, float], cell: float
    ) -> None:
        size = np.subtract(high_mm, low_mm)
        self.cell_mm = max(cell, float(np.sqrt(size[0] * size[1] / MOST_CELLS)))
        self.low_mm, self.floor_mm = low_mm[:2], low_mm[2]
        shape = np.maximum(np.round(size[:2] / self.cell_mm), 1).astype(int)
        self.size_mm = size[:2] / shape
        self.height_mm = np.full(tuple(shape), high_mm[2], dtype=np.float64)

    def cut(self, cutter: Cutter, at_mm: Array, along: Array) -> tuple[float, float, float]:
        """Take off what stands above a cutter at a place, (3,); the feed goes ``along`` x and y.

        Returns the volume, and from where to where the band across the feed lies.
        """
        radius = 0.5 * cutter.diameter_mm
        spans = [self._span(axis, at_mm[axis], radius) for axis in (0, 1)]
        off = [
            self.low_mm[axis] + (np.arange(*spans[axis]) + 0.5) * self.size_mm[axis] - at_mm[axis]
            for axis in (0, 1)
        ]
        if not (off[0].size and off[1].size):
            return 0.0, 0.0, 0.0
        distance = np.hypot(off[0][:, None], off[1][None, :])
        window = self.height_mm[slice(*spans[0]), slice(*spans[1])]
        bottom = np.maximum(at_mm[2] + cutter.bottom_mm(distance), self.floor_mm)
        above = np.where(distance <= radius, np.maximum(window - bottom, 0.0), 0.0)
        taken = above > 0.0
        if not taken.any():
            return 0.0, 0.0, 0.0
        window -= above
        across = (along[0] * off[1][None, :] - along[1] * off[0][:, None])[taken]
        half = 0.25 * float(self.size_mm.sum())
        low, high = max(across.min() - half, -radius), min(across.max() + half, radius)
        return float(above.sum() * self.size_mm.prod()), float(low), float(high)

    def _span(self, axis: int, at_mm: float, radius: float) -> tuple[int, int]:
        first = (at_mm - radius - self.low_mm[axis]) / self.size_mm[axis]
        last = (at_mm + radius - self.low_mm[axis]) / self.size_mm[axis]
        most = self.height_mm.shape[axis]
        return int(np.clip(np.floor(first), 0, most)), int(np.clip(np.ceil(last), 0, most))


def milled(
    travels: Sequence[ProgramMove], block: Block, cutters: Sequence[Cutter], *, source: str
) -> MilledSteps:
    """Return what moves do, each with its cutter, and lower the block by it.

    Raises UnusableInput naming ``source`` and the line of a rapid through the stock.
    """
    columns: list[list[tuple[float, ...]]] = []
    for k, (travel, cutter) in enumerate(zip(travels, cutters, strict=True)):
        rows = _steps(travel, block, cutter, k)
        if travel.feed is None and any(row[8] > 0.01 for row in rows):
            raise UnusableInput(
                f"{source}: line {travel.line}: this rapid goes through the stock; go around it or "
                "use a feed"
            )
        if travel.feed is not None:
            columns.append(rows)
    found = np.array([row for rows in columns for row in rows], dtype=np.float64).T
    time_s, feed, rpm, depth, low, high, direction, plunge, removed, move = found
    return MilledSteps(
        time_s, feed, rpm, depth, low, high, direction, plunge, removed, move.astype(int)
    )


def _steps(travel: ProgramMove, block: Block, cutter: Cutter, k: int) -> list[tuple[float, ...]]:
    """Return the rows of a move: nothing is taken off where it is a rapid upwards."""
    step_mm = max(block.cell_mm, cutter.diameter_mm / ALONG)
    count = max(int(np.ceil(travel.length_mm / step_mm)), 1)
    ends = travel.places(np.arange(count + 1) / count)
    ways = np.diff(ends, axis=0)
    rpm = 0.0 if travel.speed is None else float(travel.speed.at_rpm(np.ones(1))[0])
    time_s = travel.time_s() / count
    length_mm = travel.length_mm / count
    feed = 60.0 * length_mm / time_s if time_s > 0 else 0.0
    rows: list[tuple[float, ...]] = []
    for way, at in zip(ways, ends[1:], strict=True):
        flat = float(np.hypot(way[0], way[1]))
        whole = max(float(np.linalg.norm(way)), 1e-12)
        along = way[:2] / flat if flat > 1e-9 else np.array([1.0, 0.0])
        volume, low, high = block.cut(cutter, at, along)
        width = high - low
        depth = volume / (flat * width) if flat > 1e-9 and width > 0 else 0.0
        direction = float(np.degrees(np.arctan2(along[1], along[0])))
        plunge = max(-float(way[2]), 0.0) / whole
        rows.append((time_s, feed, rpm, depth, low, high, direction, plunge, volume, float(k)))
    return rows
