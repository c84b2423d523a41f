"""Masses of a machine's slides from what each of its axes moves (P0 equations 8 to 10)."""

import math
from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Mass:
    """A mass and its standard deviation, kg."""

    kg: float
    sd_kg: float


def own_masses(moved: Mapping[str, Mass], carried_by: Mapping[str, str | None]) -> dict[str, Mass]:
    """Return the mass of each slide alone: what its axis moves less what the axes on it move.

    ``moved``: the effective mass of each axis; ``carried_by``: the axis that each one rides on,
    None the bed. P0: x moves m_x + m_z, y moves m_x + m_y + m_z, z moves m_z, where z rides on x
    and x on y. Errors of different axes are independent. Raises KeyError where an axis that rides
    on another has no effective mass.
    """
    riding = {
        axis: [other for other, below in carried_by.items() if below == axis] for axis in moved
    }
    return {
        axis: Mass(
            moved[axis].kg - sum(moved[other].kg for other in riding[axis]),
            math.hypot(moved[axis].sd_kg, *(moved[other].sd_kg for other in riding[axis])),
        )
        for axis in moved
    }
