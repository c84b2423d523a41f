"""Linear-edge cutting law: each machine component is a chip part plus an edge part.

F_i = K_ic · a_p · f + K_ie · a_p for i = x (radial), y (tangential), z (axial)

K_ic [N/mm²] scales with the chip's cross-section a_p·f, K_ie [N/mm] with the engaged edge length,
taken as a_p. Both hold for one work-tool pair and one operation's geometry. Source: P1 section 3
(Armarego's edge coefficients, written per machine axis); valid over the feeds that were cut.
"""

import numpy as np
from numpy.typing import NDArray

from autodb.fitting import Gaussian

Array = NDArray[np.float64]

COMPONENTS = ("x", "y", "z")
PARAMETERS = ("K_c", "K_e")
PARAMETER_UNITS = ("N/mm²", "N/mm")

PRIOR = Gaussian(mean=np.zeros(2), covariance=np.diag([5000.0**2, 500.0**2]))
"""Nothing known: wide enough for any metal, centred on no force. Chosen, not measured."""


def design(feed_mm: Array, depth_mm: Array) -> Array:
    """Return the columns (a_p f, a_p), shape (n, 2), that multiply (K_c, K_e)."""
    return np.column_stack([depth_mm * feed_mm, depth_mm])
