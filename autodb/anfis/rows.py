"""What a learner sees: scaled rows less the plane through all of them, and the ridge."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RIDGE = 1e-10
"""Weight of the plain regression in the consequents, for each row and in scaled columns: a rule
that no row fires keeps that plane, all others are changed by about 1e-10 of themselves."""


@dataclass(frozen=True)
class Rows:
    """Scaled inputs (n, d), what the plane leaves of the scaled values (n,), the plane (d + 1,).

    ``ridge``: by how much the squared distance of the consequents from the plane is weighed
    against the sum of squared residuals.
    """

    x: Array
    left: Array
    plane: Array
    ridge: float

    def pick(self, which: NDArray[np.bool_]) -> "Rows":
        """Return some of the rows."""
        return Rows(self.x[which], self.left[which], self.plane, self.ridge)


def rows(x: Array, values: Array, ridge: float = RIDGE) -> Rows:
    """Return what is learned from scaled inputs (n, d) and scaled values (n,)."""
    planes = np.column_stack([np.ones(len(x)), x])
    plane = np.asarray(np.linalg.lstsq(planes, values, rcond=None)[0], dtype=np.float64)
    return Rows(x, values - planes @ plane, plane, ridge * len(x))
