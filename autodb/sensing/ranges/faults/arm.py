"""The arm at which a cut's tangential force turns the spindle."""

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.turning import effective_radius_mm
from autodb.records import CutTable

Array = NDArray[np.float64]


def torque_arm_mm(table: CutTable) -> Array | None:
    """Return the torque arm (n,) of every cut, mm; None where diameter or depth is not known."""
    if "work.diameter" not in table or "cutting.depth" not in table:
        return None
    facing = np.array([o == "face" for o in table.texts.get("operation", [""] * len(table))])
    return effective_radius_mm(table["work.diameter"], table["cutting.depth"], facing=facing)
