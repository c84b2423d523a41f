"""Stage three: friction along the travel, a straight line and the screw's turns (P2 eq. 11)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.sensing.drives.staged.clusters import lack, scores, within
from autodb.sensing.drives.staged.segments import PassSegments
from autodb.terms.drive import cogging

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Along:
    """Friction gained along the travel, the same way in both directions, effort's unit.

    ``values``: slope a mm and, with a period, cosine and sine; ``covariance`` of them; 0 on the
    mean of ``middle_mm`` (k,), the segments around the middle. ``lack``: sd of what friction at a
    place is off that, beyond the error.
    """

    values: Array
    covariance: Array
    period_mm: float | None
    middle_mm: Array
    lack: float

    def at(self, x_mm: Array) -> tuple[Array, Array]:
        """Return what friction gains (n,) at places (n,), and its sd (n,)."""
        inside = (x_mm >= self.middle_mm.min()) & (x_mm <= self.middle_mm.max())
        columns = _columns(x_mm, self.period_mm)
        columns -= _columns(self.middle_mm, self.period_mm).mean(axis=0)
        variance = np.einsum("ij,jk,ik->i", columns, self.covariance, columns)
        return columns @ self.values, np.sqrt(variance + np.where(inside, 0.0, self.lack**2))


def along_travel(
    segments: PassSegments, friction: Array, position: Array, *, period_mm: float | None,
    middle_mm: Array,
) -> Along:  # fmt: skip
    """Fit segments' friction (n,) within passes; columns are averaged over the segments as it is.

    The error is from what passes differ by, because friction is alike along the way: White's
    covariance with passes as clusters.
    """
    columns = np.column_stack([segments.means(one) for one in _columns(position, period_mm).T])
    inside = np.column_stack([within(one, segments.of) for one in (*columns.T, friction)])
    design, target = inside[:, :-1], inside[:, -1]
    inverse = np.linalg.pinv(design.T @ design)
    values = inverse @ design.T @ target
    left = target - design @ values
    between, count = scores(design, left, segments.of)
    covariance = count / max(1, count - 1) * inverse @ between @ inverse
    return Along(values, covariance, period_mm, middle_mm, lack(segments.place, left))


def _columns(x_mm: Array, period_mm: float | None) -> Array:
    if period_mm is None:
        return x_mm[:, None].copy()
    return np.column_stack([x_mm, cogging(x_mm, period_mm=period_mm)])
