"""The plain law of a titanium alloy, as a paper has it."""

import numpy as np
from numpy.typing import NDArray

from autodb.cutting import shear

Array = NDArray[np.float64]

PLAIN = {
    "shear_stress": 613.0,
    "friction_angle": 19.1,
    "chip_ratio": 1.755 * 0.1**0.331,
    "K_te": 24.0,
    "K_re": 43.0,
    "K_ae": 0.0,
    "chip_ratio_thickness": 0.331,
    "shear_stress_speed": 0.0,
    "friction_speed": 0.0,
    "chip_ratio_speed": 0.0,
    "friction_rake": 0.0,
    "chip_ratio_rake": 0.0,
    "chip_flow": 0.0,
    "shear_stress_thickness": 0.0,
    "friction_thickness": 0.0,
    "flow_angle": 1.0,
    "edge_mm": 1e-9,
}
"""Ti6Al4V at rake 0: Budak, Altintas and Armarego 1996."""


def theta(**changed: float) -> Array:
    """Return coordinates of the plain law with some numbers changed."""
    return shear.law_coordinates(PLAIN | changed)
