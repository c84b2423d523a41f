"""What a learner sees: scaled rows less the plane through all of them, and two prior weights."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LearnerRows:
    """Scaled inputs (n, d), what the plane leaves of the scaled values (n,), the plane (d + 1,).

    ``ridge`` and ``leash``: how much the squared distance of the consequents from the plane, and of
    the premises from their start, weighs against the sum of squared residuals.
    """

    x: Array
    left: Array
    plane: Array
    ridge: float
    leash: float

    def pick(self, which: NDArray[np.bool_]) -> "LearnerRows":
        """Return some of the rows."""
        return replace(self, x=self.x[which], left=self.left[which])


def rows(x: Array, values: Array) -> LearnerRows:
    """Return what is learned from scaled inputs (n, d) and scaled values (n,), no weights yet."""
    planes = np.column_stack([np.ones(len(x)), x])
    plane = np.asarray(np.linalg.lstsq(planes, values, rcond=None)[0], dtype=np.float64)
    return LearnerRows(x, values - planes @ plane, plane, 0.0, 0.0)
