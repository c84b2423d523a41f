"""What is true of a drawn axis, as numbers that an estimator of any form can be asked for.

Each is linear in the coefficients of the axis' own columns (the cogging's period is its own value
plus a coefficient of 0), so that its uncertainty follows from theirs.
"""

from dataclasses import dataclass

import numpy as np

from autodb.proofs.machines.axis.axes import FRICTION, DrawnAxis, EffortColumn, axis_columns
from autodb.proofs.machines.axis.motion import TrueMotion
from autodb.proofs.machines.lathe.process import Array

FRICTION_MM_S = (10.0, -10.0, 50.0, -50.0, 150.0, -150.0)
EFFORT_AT = ((150.0, 30.0), (320.0, -30.0), (150.0, -100.0), (320.0, 100.0))  # mm, mm/s


@dataclass(frozen=True)
class TrueQuantity:
    """A true value = offset + row . coefficients; row (p,) in the order of ``columns``."""

    name: str
    unit: str
    row: Array
    truth: float
    offset: float = 0.0


def friction_name(v_mm_s: float) -> str:
    """Name of the friction at a velocity: signed, without weight, averaged over the travel."""
    return f"friction at {v_mm_s:+g} mm/s"


def effort_name(x_mm: float, v_mm_s: float) -> str:
    """Name of the whole current in steady motion at a place."""
    return f"current at {x_mm:g} mm, {v_mm_s:+g} mm/s"


NAMES = (
    "inertia",
    "weight",
    *(friction_name(v) for v in FRICTION_MM_S),
    *(effort_name(x, v) for x, v in EFFORT_AT),
    "position friction",
    "cogging amplitude",
    "cogging period",
)


def quantities(axis: DrawnAxis, motion: TrueMotion) -> list[TrueQuantity]:
    """Everything that is asked of an axis; cogging and position friction only where it has them.

    Friction at a velocity is averaged over the travel of the recording: it is linear in position,
    so that is friction at the middle. The whole current is friction + weight + cogging.
    """
    middle_mm = 0.5 * float(np.min(motion.x) + np.max(motion.x))
    terms = np.array([column.term for column in _at(axis, 0.0, 0.0)])
    truth = np.array([column.coefficient for column in _at(axis, 0.0, 0.0)])

    def linear(name: str, unit: str, row: Array, offset: float = 0.0) -> TrueQuantity:
        return TrueQuantity(name, unit, row, float(offset + row @ truth), offset)

    def own(
        name: str, unit: str, term: str, *, after: int = 0, offset: float = 0.0
    ) -> TrueQuantity:
        at = int(np.argmax(terms == term)) + after
        return linear(name, unit, np.eye(terms.size)[at], offset)

    asked = [own("inertia", "A·s²/mm", "inertia"), own("weight", "A", "gravity")]
    for v in FRICTION_MM_S:
        row = _row(axis, middle_mm, v) * np.isin(terms, FRICTION)
        asked.append(linear(friction_name(v), "A", row))
    asked += [linear(effort_name(x, v), "A", _row(axis, x, v)) for x, v in EFFORT_AT]
    if axis.position_A_mm:
        asked.append(own("position friction", "A/mm", "position_friction"))
    if axis.cogging_A:
        asked.append(own("cogging amplitude", "A", "cogging"))
        asked.append(own("cogging period", "mm", "cogging", after=2, offset=axis.cogging_mm))
    return asked


def _at(axis: DrawnAxis, x_mm: float, v_mm_s: float) -> list[EffortColumn]:
    """Columns of one sample at a place, in steady motion."""
    x, v, a = (np.array([value]) for value in (x_mm, v_mm_s, 0.0))
    return axis_columns(axis, x_mm=x, v_mm_s=v, a_mm_s2=a)


def _row(axis: DrawnAxis, x_mm: float, v_mm_s: float) -> Array:
    return np.array([column.values[0] for column in _at(axis, x_mm, v_mm_s)])
