"""Stage three: friction along the travel, a straight line and the screw's turns (P2 eq. 11)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.sensing.staged.segments import Segments
from autodb.terms.drive import cogging

Array = NDArray[np.float64]
Numbers = NDArray[np.intp]


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
    segments: Segments, friction: Array, position: Array, *, period_mm: float | None,
    middle_mm: Array,
) -> Along:  # fmt: skip
    """Fit segments' friction (n,) within passes; columns are averaged over the segments as it is.

    The error is from what passes differ by, because friction is alike along the way: White's
    covariance with passes as clusters.
    """
    columns = np.column_stack([segments.means(one) for one in _columns(position, period_mm).T])
    within = np.column_stack([_within(one, segments.of) for one in (*columns.T, friction)])
    design, target = within[:, :-1], within[:, -1]
    inverse = np.linalg.pinv(design.T @ design)
    values = inverse @ design.T @ target
    left = target - design @ values
    names, at = np.unique(segments.of, return_inverse=True)
    scores = np.zeros((len(names), design.shape[1]))
    np.add.at(scores, at, design * left[:, None])
    few = len(names) / max(1, len(names) - 1)
    covariance = few * inverse @ (scores.T @ scores) @ inverse
    return Along(values, covariance, period_mm, middle_mm, _lack(segments.place, left))


def _columns(x_mm: Array, period_mm: float | None) -> Array:
    if period_mm is None:
        return x_mm[:, None].copy()
    return np.column_stack([x_mm, cogging(x_mm, period_mm=period_mm)])


def _within(values: Array, of: Numbers) -> Array:
    """Return values (n,) less the mean of their pass."""
    count = np.bincount(of)
    mean = np.bincount(of, values) / np.maximum(count, 1)
    return np.asarray(values - mean[of])


def _lack(place: Numbers, left: Array) -> float:
    """Return the sd of places' means beyond what passes of a place differ by."""
    _, at, count = np.unique(place, return_inverse=True, return_counts=True)
    mean = np.bincount(at, left) / count
    freedom = float(np.sum(count - 1))
    if freedom <= 0:
        return 0.0
    own = float(np.sum((left - mean[at]) ** 2)) / freedom
    return float(np.sqrt(max(0.0, float(np.mean(mean**2) - own * np.mean(1.0 / count)))))
