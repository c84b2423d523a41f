"""Friction of a feed axis."""

import numpy as np
from numpy.typing import NDArray

from autodb.terms._term import Parameter, Term

Array = NDArray[np.float64]

STANDSTILL_MM_S = 0.05
"""Speed below which the direction fades out linearly: encoder noise makes no friction chatter.
Chosen: 1/20 of the slowest feed in use (60 mm/min)."""


def direction(velocity_mm_s: Array) -> Array:
    """Return the direction of motion: ±1 when moving, fading to 0 through standstill; (n,)."""
    return np.clip(velocity_mm_s / STANDSTILL_MM_S, -1.0, 1.0)


def coulomb(velocity_mm_s: Array) -> Array:
    """Coulomb friction opposes the motion with a constant level: column sgn(v), (n,).

    Effort = level · sgn(v), level in the channel's unit. At standstill the column is 0: what a
    standing axis holds is not known from this term. Source: P0 eq. for F_fr with σ = 0, F_br = F_C.
    """
    return direction(velocity_mm_s)


def viscous(velocity_mm_s: Array) -> Array:
    """Viscous friction grows in proportion to speed: column v [mm/s], (n,).

    Effort = coefficient · v. Source: P0, σ of the Stribeck law.
    """
    return velocity_mm_s


COULOMB = Term(
    name="coulomb",
    channel="axis",
    parameters=(Parameter("level", "U", "friction force that any motion must overcome"),),
    needs=("position",),
    statement="Dry friction of the guideway and screw that is the same at every speed.",
    excited_by="constant-speed passes in both directions at several speeds",
    source="P0 section 2.2; Janot, Gautier, Brunot 2019",
)
VISCOUS = Term(
    name="viscous",
    channel="axis",
    parameters=(Parameter("coefficient", "U·s/mm", "friction per speed"),),
    needs=("position",),
    statement="Friction that grows in proportion to speed, as an oil film makes it.",
    excited_by="constant-speed passes in both directions at several speeds",
    source="P0 section 2.2; Janot, Gautier, Brunot 2019",
)
