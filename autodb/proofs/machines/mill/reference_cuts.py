"""Cuts of a reference mill: paths and conditions of P0's plan, and force orders of each.

P0 Table 1 (training), section 3 and Table 2 (test): slots along and across the axes, one with a
recess, a ramp, circular pockets, sides in stable and in semi-stable cut. The ramp is the one row
of Table 2 that is known whole: feed -y with z into the work, 10 mm wide, 0 to 2 mm deep,
600 mm/min, 5000 rpm. What else a cut is, where and how long, is *chosen* within Table 1.
"""

import math
from dataclasses import dataclass

from autodb.proofs.machines.mill.reference_mill_moves import Leg
from autodb.proofs.machines.mill.reference_milling import TEETH

ENTRY_MM = 5.0  # half a tool: the way into the work
SLOT_MM, SIDE_MM = 60.0, 70.0  # ways of cuts; chosen
AIR_MM = 6.0  # feed in air before and after; chosen
PLUNGE_MM_MIN = 150.0  # chosen


@dataclass(frozen=True)
class MillCut:
    """One cut: what the tool does, and the feed's direction in the plane.

    ``shaking``: a semi-stable cut, in which the axis across the feed swings.
    """

    name: str
    operation: str
    depth_mm: float
    width_mm: float
    feed_mm_min: float
    speed_rpm: float
    direction_deg: float = 0.0
    up: bool = False
    shaking: bool = False

    @property
    def feed_mm(self) -> float:
        """Feed per tooth."""
        return self.feed_mm_min / (TEETH * self.speed_rpm)

    def legs(self) -> list[Leg]:
        """The path after the approach."""
        return SHAPES[self.operation](self)


PLAN = (
    MillCut("slot, diagonal", "recessed slot", 2.0, 10.0, 500.0, 4500.0, direction_deg=40.0),
    MillCut("slot, diagonal, faster", "slot", 1.0, 10.0, 800.0, 6000.0, direction_deg=-130.0),
    MillCut("slot, slanting", "slot", 3.0, 10.0, 400.0, 5400.0, direction_deg=20.0),
    MillCut("ramp", "ramp", 2.0, 10.0, 600.0, 5000.0, direction_deg=-90.0),
    MillCut("pocket", "pocket", 2.0, 4.0, 500.0, 4500.0),
    MillCut("pocket, faster", "pocket", 1.0, 5.0, 700.0, 5400.0),
    MillCut("side, along y", "side", 4.0, 2.0, 500.0, 4500.0, direction_deg=90.0),
    MillCut("side, diagonal", "side", 3.0, 1.0, 700.0, 6000.0, direction_deg=30.0, up=True),
    MillCut("side, against x", "side", 3.0, 4.0, 400.0, 3500.0, direction_deg=180.0),
    MillCut(
        "side, semi-stable", "side", 4.0, 5.0, 500.0, 2600.0, direction_deg=180.0, shaking=True
    ),
)  # fmt: skip


def _straight(cut: MillCut, length_mm: float, depth: tuple[tuple[float, float], ...]) -> Leg:
    angle = math.radians(cut.direction_deg)
    way = (length_mm * math.cos(angle), length_mm * math.sin(angle), 0.0)
    return Leg(way, cut.feed_mm_min / 60.0, tuple((at / length_mm, k) for at, k in depth))


def _slot(cut: MillCut) -> list[Leg]:
    end = AIR_MM + SLOT_MM
    depth = ((AIR_MM, 0.0), (AIR_MM + ENTRY_MM, 1.0), (end, 1.0), (end + ENTRY_MM, 0.0))
    return [_straight(cut, end + ENTRY_MM + AIR_MM, depth)]


def _recessed_slot(cut: MillCut) -> list[Leg]:
    edges = (0.0, 22.0, 38.0, SLOT_MM)
    depth: list[tuple[float, float]] = []
    for number, edge in enumerate(edges):
        into = float(number % 2)
        depth += [(AIR_MM + edge, into), (AIR_MM + edge + ENTRY_MM, 1.0 - into)]
    return [_straight(cut, AIR_MM + SLOT_MM + ENTRY_MM + AIR_MM, tuple(depth))]


def _side(cut: MillCut) -> list[Leg]:
    end = AIR_MM + SIDE_MM
    depth = ((AIR_MM, 0.0), (AIR_MM + ENTRY_MM, 1.0), (end, 1.0), (end + ENTRY_MM, 0.0))
    return [_straight(cut, end + ENTRY_MM + AIR_MM, depth)]


def _ramp(cut: MillCut) -> list[Leg]:
    angle, length = math.radians(cut.direction_deg), SLOT_MM
    way = (length * math.cos(angle), length * math.sin(angle), -cut.depth_mm)
    speed = cut.feed_mm_min / 60.0
    up = Leg((0.0, 0.0, 10.0), speed, ((0.0, 0.0),))
    return [Leg(way, speed, ((0.0, 0.0), (1.0, 1.0)), dwell_s=0.02), up]


def _pocket(cut: MillCut) -> list[Leg]:
    """Plunge, then circles that grow by the width; counterclockwise."""
    speed = cut.feed_mm_min / 60.0
    legs = [Leg((0.0, 0.0, -cut.depth_mm), PLUNGE_MM_MIN / 60.0, ((0.0, 0.0),), dwell_s=0.3)]
    radius = 0.0
    for step_mm in (cut.width_mm, 0.75 * cut.width_mm, 0.75 * cut.width_mm):
        radius += step_mm
        legs.append(Leg((step_mm, 0.0, 0.0), speed, ((0.0, 1.0),)))
        circle = Leg((-radius, 0.0, 0.0), speed, ((0.0, 1.0),), turn_rad=2.0 * math.pi)
        legs += [circle, circle]
    return [*legs, Leg((0.0, 0.0, cut.depth_mm + 10.0), speed)]


SHAPES = {
    "slot": _slot,
    "recessed slot": _recessed_slot,
    "side": _side,
    "ramp": _ramp,
    "pocket": _pocket,
}
