"""How the cuts of a table are fed: their direction, the arm of their torque, which axes move."""

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.turning import PASSIVE_AXIS, effective_radius_mm
from autodb.records import CutTable

Array = NDArray[np.float64]

OBLIQUE = ("taper", "contour")
"""Operations whose cuts state the direction of their feed."""


def operations_of(table: CutTable) -> list[str]:
    """Return the operation of each cut (n,), empty where it is not said."""
    return table.texts.get("operation", [""] * len(table))


def inward_rad(table: CutTable) -> Array:
    """Return the direction of turned cuts' feed (n,): 0 along the axis, π/2 to the centre.

    An oblique cut that does not state it counts as one along the axis.
    """
    stated = table.get("cutting.direction")
    oblique = np.zeros(len(table)) if stated is None else np.nan_to_num(np.radians(stated))
    operations = operations_of(table)
    facing = np.array([one == "face" for one in operations])
    leans = np.array([one in OBLIQUE for one in operations])
    return np.where(facing, 0.5 * np.pi, np.where(leans, oblique, 0.0))


def torque_arm_mm(table: CutTable) -> Array | None:
    """Return the torque arm (n,) of every cut, mm; None where diameter or depth is not known."""
    if "work.diameter" not in table or "cutting.depth" not in table:
        return None
    return effective_radius_mm(
        table["work.diameter"], table["cutting.depth"], inward_rad=inward_rad(table)
    )


def moving(table: CutTable, axis: str) -> NDArray[np.bool_]:
    """Return which rows move the axis: a passive one stands still, its current shows nothing."""
    return np.array([PASSIVE_AXIS.get(operation) != axis for operation in operations_of(table)])
