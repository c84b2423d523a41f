"""How the cuts of a table are fed: their direction, the arm of their torque, which axes move."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.turning import PASSIVE_AXIS, effective_radius_mm
from autodb.sensing.ranges.validity import LEAST_FEED_MM_S

if TYPE_CHECKING:
    from autodb.records.tables import CutTable

Array = NDArray[np.float64]
Rows = NDArray[np.bool_]

OBLIQUE = ("taper", "contour")
"""Operations whose cuts state the direction of their feed."""
TURNING = ("turn", "face", *OBLIQUE)


def operations_of(table: "CutTable") -> list[str]:
    """Return the operation of each cut (n,), empty where it is not said."""
    return table.texts.get("operation", [""] * len(table))


def turned_cuts(table: "CutTable") -> Rows:
    """Return which cuts turn, by what is said of them, shape (n,)."""
    milled = "cutting.width" in table
    return np.array([o in TURNING or (not o and not milled) for o in operations_of(table)])


def oblique_cuts(table: "CutTable") -> Rows:
    """Return which cuts (n,) are fed by both axes of a lathe, or by its cross slide alone."""
    return np.isin(operations_of(table), ("face", *OBLIQUE))


def feeds_outward(table: "CutTable") -> Rows:
    """Return which faces (n,) are cut away from the axis.

    By x.velocity where it is recorded, or a ``cutting.direction`` below 0.
    """
    facing = np.array([one == "face" for one in operations_of(table)])
    stated = table.get("cutting.direction")
    away = np.zeros(len(table)) if stated is None else np.nan_to_num(stated)
    return facing & ((_velocity(table, "x") >= LEAST_FEED_MM_S) | (away < 0.0))


def z_runs_back(table: "CutTable") -> Rows:
    """Return which cuts (n,) feed away from the chuck, by z.velocity where it is recorded."""
    return _velocity(table, "z") >= LEAST_FEED_MM_S


def mill_feed(table: "CutTable") -> tuple[Array, Array]:
    """Return x and y (n,) of the direction that a mill feeds in; NaN where it is not known.

    As ``cutting.direction`` states it, else as the axes' velocities have it.
    """
    stated = table.get("cutting.direction")
    angle = np.full(len(table), np.nan) if stated is None else np.radians(stated)
    x, y = _velocity(table, "x"), _velocity(table, "y")
    runs = np.hypot(x, y) >= LEAST_FEED_MM_S
    angle = np.where(np.isfinite(angle), angle, np.where(runs, np.arctan2(y, x), np.nan))
    return np.cos(angle), np.sin(angle)


def _velocity(table: "CutTable", axis: str) -> Array:
    """Return an axis' mean velocity in each cut (n,); 0 where it was not recorded."""
    velocity = table.get(f"{axis}.velocity")
    return np.zeros(len(table)) if velocity is None else np.nan_to_num(velocity)


def inward_rad(table: "CutTable") -> Array:
    """Return the direction of turned feeds (n,): 0 along the axis, π/2 to the centre, -π/2 away.

    An oblique cut that does not state it counts as one along the axis.
    """
    stated = table.get("cutting.direction")
    oblique = np.zeros(len(table)) if stated is None else np.nan_to_num(np.radians(stated))
    operations = operations_of(table)
    facing = np.array([one == "face" for one in operations])
    leans = np.array([one in OBLIQUE for one in operations])
    square = np.where(feeds_outward(table), -0.5 * np.pi, 0.5 * np.pi)
    return np.where(facing, square, np.where(leans, oblique, 0.0))


def torque_arm_mm(table: "CutTable") -> Array | None:
    """Return the torque arm (n,) of every cut, mm; None where diameter or depth is not known."""
    if "work.diameter" not in table or "cutting.depth" not in table:
        return None
    return effective_radius_mm(
        table["work.diameter"], table["cutting.depth"], inward_rad=inward_rad(table)
    )


def moving(table: "CutTable", axis: str) -> Rows:
    """Return which rows move the axis: one that stands still shows no load in its current.

    By what the operation feeds, and by the axis' velocity where it is recorded.
    """
    fed = np.array([PASSIVE_AXIS.get(operation) != axis for operation in operations_of(table)])
    velocity = table.get(f"{axis}.velocity")
    return fed if velocity is None else fed & ~(np.abs(velocity) < LEAST_FEED_MM_S)
