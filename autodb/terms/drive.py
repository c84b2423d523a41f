"""Loads of a feed axis that are not friction."""

import numpy as np
from numpy.typing import NDArray

from autodb.terms._term import Parameter, Term

Array = NDArray[np.float64]


def inertia(acceleration_mm_s2: Array) -> Array:
    """Inertia takes effort in proportion to acceleration: column a [mm/s²], (n,).

    Effort = coefficient · a; where effort is force in N, mass in kg = 1000 · coefficient.
    Source: P0 section 2.2.
    """
    return acceleration_mm_s2


def gravity(position_mm: Array) -> Array:
    """A constant load acts whether the axis moves or stands: column 1, shaped as position, (n,).

    Weight of a vertical axis, a counterweight, or a constant sensor offset: one recording of a
    horizontal axis cannot tell them apart. Source: P2 (weight as the mean of up and down passes).
    """
    return np.ones_like(position_mm)


def external_load(t_s: Array, *, start_s: float, end_s: float) -> Array:
    """A load that no motion explains acts during an interval: column 1 in [start, end], else 0."""
    return ((t_s >= start_s) & (t_s <= end_s)).astype(np.float64)


INERTIA = Term(
    name="inertia",
    channel="axis",
    parameters=(Parameter("coefficient", "U·s²/mm", "effort per acceleration"),),
    needs=("position",),
    statement="Mass that must be accelerated.",
    excited_by="accelerated moves: rapids with dwells",
    source="P0 section 2.2; Janot, Gautier, Brunot 2019",
)
GRAVITY = Term(
    name="gravity",
    channel="axis",
    parameters=(Parameter("level", "U", "constant load, also at standstill"),),
    needs=(),
    statement="A constant load in one direction: weight, counterweight or a sensor's zero point.",
    excited_by="passes in both directions and a standstill",
    source="P2 section on the weight current",
    alike=("sensor_drift",),
    told_apart_by="Log the current once more with the drive disabled: a sensor's zero point stays.",
)
EXTERNAL_LOAD = Term(
    name="external_load",
    channel="axis",
    parameters=(
        Parameter("level", "U", "mean load in the interval"),
        Parameter("start", "s", "begin of the interval"),
        Parameter("end", "s", "end of the interval"),
    ),
    needs=(),
    statement="A load during one stretch of time that no motion explains: a cut, a push, a rub.",
    excited_by="the same moves again without the load",
    source="P0 section 2.2, F_ext",
)
