"""Geometry of turning: what stands still, the torque arm, power."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

PASSIVE_AXIS = {"turn": "x", "face": "z"}
"""Axis that stands still in an operation, so that its current shows no load (P1 section 5)."""


def effective_radius_mm(
    diameter_mm: Array, depth_mm: Array, *, facing: NDArray[np.bool_] | None = None
) -> Array:
    """Return the torque arm r_e = r_w + a_p/2, (n,), mm.

    r_w is the machined radius at the tool tip: half the work diameter (P1 section 9). In facing the
    depth lies along the axis, so the arm is r_w itself.
    """
    radial = depth_mm if facing is None else np.where(facing, 0.0, depth_mm)
    return 0.5 * diameter_mm + 0.5 * radial


def torque_N_m(tangential_N: Array, radius_mm: Array) -> Array:
    """Return the spindle torque T = F_y r_e, N·m, (n,)."""
    return tangential_N * radius_mm / 1000.0


def power_W(tangential_N: Array, speed_m_min: Array) -> Array:
    """Return the cutting power P = F_y v_c / 60, W, (n,), v_c in m/min."""
    return tangential_N * speed_m_min / 60.0


def speed_m_min(diameter_mm: Array, speed_rpm: Array) -> Array:
    """Return the cutting speed v_c = π D n / 1000, m/min, (n,)."""
    return np.pi * diameter_mm * speed_rpm / 1000.0
