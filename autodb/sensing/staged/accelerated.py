"""Stage five: inertia, from what effort is beyond weight and friction while the speed changes."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.sensing.staged.clusters import scores, two_ways

Array = NDArray[np.float64]
Numbers = NDArray[np.intp]

FEWEST_PARTS = 6
"""Accelerated parts of the motion that tell an inertia and how sure it is. Chosen."""


@dataclass(frozen=True)
class Inertia:
    """Effort per acceleration, in the effort's unit over mm/s², its sd, and the parts it is of."""

    value: float
    sd: float
    parts: int


def inertia_of(
    acceleration: Array,
    velocity: Array,
    left: Array,
    rows: NDArray[np.bool_],
    *,
    patch: Numbers | None = None,
) -> Inertia | None:
    """Return the inertia that ``rows`` (n,) tell by ``left`` (n,), effort less weight and friction.

    left = coefficient · a + level · sgn(v) + slope · v: friction that is off by a level or a slope
    is no inertia. White's covariance, every accelerated part a cluster; and, where given, every
    ``patch`` (n,) of the travel, whose load is off what was taken off whenever it is crossed. None
    with fewer than FEWEST_PARTS, or where the columns do not stand apart.
    """
    begun = np.diff(rows, prepend=False) & rows
    part = np.asarray(np.cumsum(begun)[rows], dtype=np.intp)
    if not len(part) or part[-1] < FEWEST_PARTS:
        return None
    v = velocity[rows]
    design = np.column_stack([acceleration[rows], np.sign(v), v])
    design_scale = np.sqrt(np.mean(design**2, axis=0))
    scaled = design / np.where(design_scale > 0, design_scale, 1.0)
    if np.linalg.matrix_rank(scaled) < scaled.shape[1]:
        return None
    inverse = np.linalg.inv(scaled.T @ scaled)
    values = inverse @ scaled.T @ left[rows]
    off = left[rows] - scaled @ values
    if patch is None:
        between = scores(scaled, off, part)[0] * part[-1] / (part[-1] - 1)
    else:
        between = two_ways(scaled, off, part, patch[rows])
    sd = np.sqrt(np.maximum(np.diag(inverse @ between @ inverse), 0.0))
    return Inertia(
        float(values[0] / design_scale[0]), float(sd[0] / design_scale[0]), int(part[-1])
    )
