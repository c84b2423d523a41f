"""Weight on a rotary axis: a mass off its axis, which turns with the angle, beside a constant load.

A cos θ + B sin θ = level · cos(θ − phase): the load is largest at the phase.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

TILT_NAMES = ("weight_cosine", "weight_sine")
"""What the two coefficients of a weight that turns are called before they are level and phase."""
CONSTANT = "constant load"
"""Column of a constant beside a weight that turns."""
ACROSS = "gravity across"
"""Column of a weight that turns a quarter of a turn behind its phase."""


def term_of(column: str) -> str:
    """Return the term that a column of a rotary axis' simulation is of, or its own name."""
    return "gravity" if column in (CONSTANT, ACROSS) else column


def own_tilt(angle_deg: Array, phase_deg: float) -> Mapping[str, Array]:
    """Return a weight's column (n, 1) from its phase on, and the one across it."""
    angle = np.radians(angle_deg - phase_deg)[:, None]
    return {"gravity": np.cos(angle), ACROSS: np.sin(angle)}


def level_and_phase(weight: Array, covariance: Array) -> dict[str, tuple[float, float]]:
    """Return level and phase [deg] with their sd from (A, B) and their covariance (2, 2)."""
    cosine, sine = float(weight[0]), float(weight[1])
    level = max(float(np.hypot(cosine, sine)), 1e-300)
    along, across = np.array([cosine, sine]) / level, np.array([-sine, cosine]) / level
    level_sd = float(np.sqrt(along @ covariance @ along))
    turn_sd = float(np.sqrt(across @ covariance @ across)) / level
    phase = float(np.arctan2(sine, cosine))
    return {
        "level": (level, level_sd),
        "phase": (float(np.degrees(phase)), float(np.degrees(turn_sd))),
    }
