"""Linear-edge cutting law: a chip part, an edge part, and what the nose takes off.

F_i = K_ic · a_p · f + K_ie · a_p + K_in for i = x (radial), y (tangential), z (axial)

K_ic [N/mm²] scales with the chip's cross-section a_p·f, K_ie [N/mm] with the engaged edge length,
taken as a_p, and K_in [N] is constant: the nose radius turns part of the edge away from the feed,
the same part at every depth above it, and so shifts a component by a constant. All hold for one
work-tool pair and one operation's geometry. Source of chip and edge part: P1 section 3 (Armarego),
written per machine axis; the constant is our departure, because without it a rounded insert's feed
force at small depths is predicted too high with a narrow interval. Valid over the depths and feeds
that were cut, at depths above the nose radius.
"""

import numpy as np
from numpy.typing import NDArray

from autodb.fitting import Gaussian

Array = NDArray[np.float64]

NAME = "linear_edge_nose"
COMPONENTS = ("x", "y", "z")
PARAMETERS = ("K_c", "K_e", "K_n")
PARAMETER_UNITS = ("N/mm²", "N/mm", "N")

PRIOR = Gaussian(mean=np.zeros(3), covariance=np.diag([5000.0**2, 500.0**2, 100.0**2]))
"""Nothing known: wide enough for any metal, centred on no force; the nose's constant within ± 200 N
of none. Chosen, not measured."""


def design(feed_mm: Array, depth_mm: Array) -> Array:
    """Return the columns (a_p f, a_p, 1), shape (n, 3), that multiply (K_c, K_e, K_n)."""
    return np.column_stack([depth_mm * feed_mm, depth_mm, np.ones_like(depth_mm)])
