"""Geometry of turning: what stands still, the torque arm, speeds about the axis."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from autodb.wording import msgid

Array = NDArray[np.float64]

TURNED = ("turn", "face", "taper", "contour")
"""Operations that leave a turned surface: the passive force is that off it."""
PASSIVE_AXIS = {"turn": "x", "face": "z"}
"""Axis that stands still in an operation, so that its current shows no load (P1 section 5)."""

ROLE_WORDS = {
    "Fp": msgid("passive force Fp"), "Fc": msgid("cutting force Fc"),
    "Ff": msgid("feed force Ff"), "": "",
}  # fmt: skip
FORCE_ROLES = {
    **dict.fromkeys(("turn", "bore", "thread"), ("Fp", "Fc", "Ff")),
    **dict.fromkeys(("face", "groove"), ("Ff", "Fc", "Fp")),
    **dict.fromkeys(("taper", "contour"), ("", "Fc", "")),
    "drill": ("", "", "Ff"),
}
"""What the forces along x, y and z of operations are called (ISO 3002-4); of a path that is oblique
to the axes, and of mills, those along x and z are none of these alone."""


def force_role(component: str, operations: Iterable[str]) -> str:
    """Return what a force is called in all of some operations: Fp, Fc, Ff, or nothing.

    >>> force_role("y", ["turn", "face"]), force_role("x", ["turn", "face"])
    ('Fc', '')
    """
    along = "xyz".index(component)
    roles = {FORCE_ROLES.get(operation, ("", "", ""))[along] for operation in operations}
    return roles.pop() if len(roles) == 1 else ""


def effective_radius_mm(
    diameter_mm: Array, depth_mm: Array, *, inward_rad: Array | None = None
) -> Array:
    """Return the radius at which the force acts, r_e = r_w + a_p/2 cos β, (n,), mm.

    r_w is the machined radius at the tool tip: half the work diameter (P1 section 9, β = 0). β is
    the direction of the feed, from along the axis (0) to the centre (π/2) or away from it (-π/2):
    the depth lies across it, so in facing it adds no radius.
    """
    radial = depth_mm if inward_rad is None else depth_mm * np.cos(inward_rad)
    return np.asarray(0.5 * diameter_mm + 0.5 * radial)


def torque_N_m(tangential_N: Array, radius_mm: Array) -> Array:
    """Return the spindle torque T = F_y r_e, N·m, (n,)."""
    return tangential_N * radius_mm / 1000.0


def speed_m_min(diameter_mm: Array, speed_rpm: Array) -> Array:
    """Return the cutting speed v_c = π D n / 1000, m/min, (n,)."""
    return np.pi * diameter_mm * speed_rpm / 1000.0


def speed_rpm(diameter_mm: Array, speed_m_min: Array) -> Array:
    """Return the spindle speed n = 1000 v_c / (π D), rpm, (n,); 0 where there is no diameter."""
    around_m = np.pi * diameter_mm / 1000.0
    return np.divide(speed_m_min, around_m, out=np.zeros_like(around_m), where=around_m > 0.0)
