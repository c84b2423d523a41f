"""Places of slots and holes on a block's top, found one after the other so that none meets another.

Coordinates are those of the block's top, its middle at zero. A slot begins at an edge and ends
inside; a hole is a slot without length.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import ceil, cos, hypot, radians, sin

from autodb.standard import BlockStock

Point = tuple[float, float]
STEP_MM = 1.0
"""Distance of the places that are tried."""
STEEPEST = 0.3
"""Least cosine between a slot's direction and the normal of the edge where it enters."""


@dataclass(frozen=True)
class Lane:
    """The path of a cutter's axis inside the block, and the share of its feed across the edge."""

    start: Point
    end: Point
    across: float = 1.0


def free_place(
    block: BlockStock,
    taken: Sequence[Lane],
    *,
    direction_deg: float,
    length_mm: float,
    radius_mm: float,
) -> Lane | None:
    """Return the first free place of a slot in a direction (from +x towards +y), or None."""
    angle = radians(direction_deg)
    along = (cos(angle), sin(angle))
    room = _Room(block, radius_mm + block.wall_mm, 2 * radius_mm + block.wall_mm)
    for start, across in _entries(block, along):
        end = (start[0] + along[0] * length_mm, start[1] + along[1] * length_mm)
        lane = Lane(start, end, across)
        if room.holds(end) and room.beside(start) and room.free(lane, taken):
            return lane
    return None


def hole(block: BlockStock, taken: Sequence[Lane], *, radius_mm: float) -> Lane | None:
    """Return the first free place of a hole, or None."""
    room = _Room(block, radius_mm + block.wall_mm, 2 * radius_mm + block.wall_mm)
    for x_mm in room.grid(block.size_x_mm):
        for y_mm in room.grid(block.size_y_mm):
            lane = Lane((x_mm, y_mm), (x_mm, y_mm))
            if room.free(lane, taken):
                return lane
    return None


@dataclass(frozen=True)
class _Room:
    """A block with the distances that a cutter's axis keeps from its sides and from other lanes."""

    block: BlockStock
    side_mm: float
    apart_mm: float

    def holds(self, point: Point) -> bool:
        """Say whether a point is far enough inside all four sides."""
        return all(
            half - abs(at) >= self.side_mm for at, half in zip(point, self.half, strict=True)
        )

    def beside(self, start: Point) -> bool:
        """Say whether an entry on one side is far enough from the sides next to it."""
        return any(
            half - abs(at) >= self.side_mm for at, half in zip(start, self.half, strict=True)
        )

    def free(self, lane: Lane, taken: Sequence[Lane]) -> bool:
        """Say whether a lane is far enough from all others."""
        return all(lane_distance_mm(lane, other) >= self.apart_mm for other in taken)

    def grid(self, size_mm: float) -> list[float]:
        """Return places across a side, as near to each other as they may be."""
        inside_mm = size_mm - 2 * self.side_mm
        return [
            i * self.apart_mm - inside_mm / 2 for i in range(int(inside_mm // self.apart_mm) + 1)
        ]

    @property
    def half(self) -> Point:
        """Half of the block's sides."""
        return (self.block.size_x_mm / 2, self.block.size_y_mm / 2)


def _steps(size_mm: float) -> list[float]:
    steps = ceil(size_mm / STEP_MM)
    return [-size_mm / 2 + size_mm * i / steps for i in range(steps + 1)]


def _entries(block: BlockStock, along: Point) -> Iterator[tuple[Point, float]]:
    """Yield the points of the edges where a direction leads in, with the cosine to their normal."""
    half_x, half_y = block.size_x_mm / 2, block.size_y_mm / 2
    for sign in (-1.0, 1.0):
        if -sign * along[0] >= STEEPEST:
            yield from (((sign * half_x, y), -sign * along[0]) for y in _steps(block.size_y_mm))
        if -sign * along[1] >= STEEPEST:
            yield from (((x, sign * half_y), -sign * along[1]) for x in _steps(block.size_x_mm))


def lane_distance_mm(a: Lane, b: Lane) -> float:
    """Return the distance of two lanes; 0 where they cross."""
    if _cross(a, b):
        return 0.0
    return min(
        _to_lane(a.start, b), _to_lane(a.end, b), _to_lane(b.start, a), _to_lane(b.end, a)
    )  # fmt: skip


def _to_lane(point: Point, lane: Lane) -> float:
    ux, uy = lane.end[0] - lane.start[0], lane.end[1] - lane.start[1]
    px, py = point[0] - lane.start[0], point[1] - lane.start[1]
    length = ux * ux + uy * uy
    share = min(1.0, max(0.0, (px * ux + py * uy) / length)) if length else 0.0
    return hypot(px - share * ux, py - share * uy)


def _cross(a: Lane, b: Lane) -> bool:
    sides = (
        _side(a, b.start) * _side(a, b.end),
        _side(b, a.start) * _side(b, a.end),
    )
    return sides[0] < 0 and sides[1] < 0


def _side(lane: Lane, point: Point) -> float:
    ux, uy = lane.end[0] - lane.start[0], lane.end[1] - lane.start[1]
    return ux * (point[1] - lane.start[1]) - uy * (point[0] - lane.start[0])
