"""The friction field of a sweep as P2 segments it: mean current of each speed, way and segment."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.machines.axis.reference_axis import Traced
from autodb.proofs.machines.axis.reference_moves import PITCH_MM, speeds_mm_s

Array = NDArray[np.float64]

SEGMENT_MM = PITCH_MM / 3.0
"""P2, section III A: a third of the screw's pitch."""
AT_SPEED = 1e-3
"""Share by which a row's speed may differ from its pass'."""
WHOLE = 0.5
"""Share of the median rows of a segment below which a pass did not cross all of it at its speed."""


@dataclass(frozen=True)
class Cells:
    """Segments (n,) of passes: speed mm/s with the sign of the direction, middle mm, mean current A
    over all repeats.
    """

    v_mm_s: Array
    x_mm: Array
    current_A: Array

    def of(self, current_A: Array) -> "Cells":
        """Return the same segments with another current."""
        return replace(self, current_A=current_A)

    @property
    def weights(self) -> Array:
        """Weights (n,) by which every speed and direction counts alike; their sum is 1."""
        _, at, count = np.unique(self.v_mm_s, return_inverse=True, return_counts=True)
        return np.asarray(1.0 / (count[at] * len(count)))


@dataclass(frozen=True)
class SweepSegments:
    """Where the segments of a sweep lie: the cell of each row (n,), -1 for none."""

    cell: NDArray[np.intp]
    rows: Array
    v_mm_s: Array
    x_mm: Array

    def cells(self, current_A: Array) -> Cells:
        """Return means over the segments of a current (n,)."""
        return Cells(self.v_mm_s, self.x_mm, self.means(current_A))

    def means(self, values: Array) -> Array:
        """Return means over the segments of values (n,)."""
        inside = self.cell >= 0
        total = np.bincount(self.cell[inside], values[inside], len(self.rows))
        return np.asarray(total / self.rows)


def segments(made: Traced) -> SweepSegments:
    """Return the segments of an axis' three repeats; what is not at a speed of P2 is left out."""
    motion, speeds = made.sweep.motion, speeds_mm_s()
    size = np.abs(motion.v)
    nearest = np.argmin(np.abs(size[:, None] - speeds), axis=1)
    steady = np.abs(size - speeds[nearest]) <= AT_SPEED * speeds[nearest]
    steady &= motion.t < made.began_s[-1]
    number = np.floor(motion.x / SEGMENT_MM).astype(np.intp)
    places = int(number.max()) + 1
    key = (2 * nearest + (motion.v > 0)) * places + number
    count = np.bincount(key[steady], minlength=2 * len(speeds) * places)
    table = np.where(count > 0, count, np.nan).reshape(-1, places)
    usual = np.array([np.nanmedian(row) if np.any(row > 0) else np.inf for row in table])
    whole = np.flatnonzero((table >= WHOLE * usual[:, None]).ravel())
    cell = np.full(count.size, -1, dtype=np.intp)
    cell[whole] = np.arange(len(whole))
    pace = speeds[whole // places // 2] * np.where(whole // places % 2, 1.0, -1.0)
    return SweepSegments(
        cell=np.where(steady, cell[key], -1),
        rows=count[whole].astype(np.float64),
        v_mm_s=pace,
        x_mm=np.asarray((whole % places + 0.5) * SEGMENT_MM),
    )
