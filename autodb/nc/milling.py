"""Paths of slots and holes in a block, block after block.

Program coordinates: x and y from the middle of the block's top, z up from it. Every rapid stays
outside the block; a slot is entered from the side, at its depth.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from math import cos, radians, sin

from autodb.errors import UnusableInput
from autodb.nc.placing import Lane, free_place, hole
from autodb.nc.steps import CutPath, StraightMove, feed, rapid
from autodb.standard import BlockStock, CutProtocol, StandardCut


@dataclass(frozen=True)
class _Job:
    """One cut about to be made: its lane, feed, mm/min, and distances, mm."""

    cut: StandardCut
    lane: Lane
    feed_mm_min: float
    radius_mm: float
    clearance_mm: float
    air_mm: float


@dataclass(frozen=True)
class _Top:
    """The top of the block in the vice; ``taken`` grows with every cut."""

    protocol: CutProtocol
    block: BlockStock
    radius_mm: float
    taken: list[Lane] = field(default_factory=list)

    def place(self, cut: StandardCut) -> Lane | None:
        """Return a free place for a cut, which it then takes, or None."""
        found = _PLACES[cut.operation](self, cut)
        if found is not None:
            self.taken.append(found)
        return found


def milling_paths(
    protocol: CutProtocol, block: BlockStock, cuts: Sequence[StandardCut], *, clearance_mm: float
) -> Iterator[CutPath]:
    """Yield the path of each cut in turn.

    Raises UnusableInput naming a cut that no block holds, or what the protocol does not state.
    """
    diameter_mm = protocol.geometry.diameter_mm
    if diameter_mm is None:
        raise UnusableInput(
            f"protocol '{protocol.name}': geometry.diameter_mm is missing; state it"
        )
    top = _Top(protocol, block, diameter_mm / 2)
    for cut in cuts:
        _refuse_what_is_not_made(protocol, block, cut)
        lane = top.place(cut)
        new_stock = lane is None
        if lane is None:
            top.taken.clear()
            lane = top.place(cut)
        if lane is None:
            raise UnusableInput(
                f"protocol '{protocol.name}': cut '{cut.name}': the block has no place for it; "
                "use a larger block"
            )
        per = _feed_mm_min(protocol, cut)
        job = _Job(cut, lane, per, top.radius_mm, clearance_mm, protocol.air_s * per / 60.0)
        deep_mm, moves = _MADE[cut.operation](job)
        yield CutPath(cut, moves, "z", deep_mm + clearance_mm, new_stock)


def _refuse_what_is_not_made(protocol: CutProtocol, block: BlockStock, cut: StandardCut) -> None:
    where = f"protocol '{protocol.name}': cut '{cut.name}'"
    if cut.operation not in _MADE:
        raise UnusableInput(f"{where}: use 'slot' and 'drill' on a block")
    if cut.length_mm is None:
        raise UnusableInput(f"{where}: length_mm is missing; state it")
    if cut.operation == "slot" and cut.feed_direction_deg is None:
        raise UnusableInput(f"{where}: feed_direction_deg is missing; state it")
    deep_mm = cut.depth_mm or cut.length_mm
    if deep_mm > block.height_mm - block.wall_mm:
        raise UnusableInput(
            f"{where}: {deep_mm:g} mm deep leaves less than wall_mm = {block.wall_mm:g} of the "
            f"block's height_mm = {block.height_mm:g}"
        )


def _feed_mm_min(protocol: CutProtocol, cut: StandardCut) -> float:
    if cut.feed_mm_rev is not None:
        return cut.feed_mm_rev * cut.speed_rpm
    if protocol.geometry.teeth is None:
        raise UnusableInput(f"protocol '{protocol.name}': geometry.teeth is missing; state it")
    return cut.feed_mm * protocol.geometry.teeth * cut.speed_rpm


def _slot_place(top: _Top, cut: StandardCut) -> Lane | None:
    return free_place(
        top.block,
        top.taken,
        direction_deg=cut.feed_direction_deg or 0.0,
        length_mm=cut.length_mm or 0.0,
        radius_mm=top.radius_mm,
    )


def _hole_place(top: _Top, cut: StandardCut) -> Lane | None:  # noqa: ARG001 - one form for both
    return hole(top.block, top.taken, radius_mm=top.radius_mm)


def _slot(job: _Job) -> tuple[float, tuple[StraightMove, ...]]:
    """Go down beside the block, feed in through its side to the slot's end, and up."""
    angle = radians(job.cut.feed_direction_deg or 0.0)
    before_mm = (job.radius_mm + job.clearance_mm) / job.lane.across + job.air_mm
    x_mm = job.lane.start[0] - before_mm * cos(angle)
    y_mm = job.lane.start[1] - before_mm * sin(angle)
    depth_mm = job.cut.depth_mm or 0.0
    moves = (
        rapid(x=x_mm, y=y_mm),
        rapid(z=job.clearance_mm),
        feed(job.feed_mm_min, z=-depth_mm),
        feed(job.feed_mm_min, x=job.lane.end[0], y=job.lane.end[1]),
        feed(job.feed_mm_min, z=job.clearance_mm),
    )
    return depth_mm, moves


def _drill(job: _Job) -> tuple[float, tuple[StraightMove, ...]]:
    """Feed down from the air into the hole, and up."""
    depth_mm = job.cut.length_mm or 0.0
    moves = (
        rapid(x=job.lane.start[0], y=job.lane.start[1]),
        rapid(z=job.clearance_mm + job.air_mm),
        feed(job.feed_mm_min, z=-depth_mm),
        feed(job.feed_mm_min, z=job.clearance_mm),
    )
    return depth_mm, moves


_PLACES: dict[str, Callable[[_Top, StandardCut], Lane | None]] = {
    "slot": _slot_place,
    "drill": _hole_place,
}
_MADE: dict[str, Callable[[_Job], tuple[float, tuple[StraightMove, ...]]]] = {
    "slot": _slot,
    "drill": _drill,
}
