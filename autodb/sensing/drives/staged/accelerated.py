"""Stage five: inertia, from what effort is beyond weight and friction while the speed changes."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.groups import small_sample
from autodb.sensing.drives.staged.clusters import one_out, scores

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
    is no inertia. Its error is by leaving out one accelerated part at a time; or, where given and
    that is more, White's with every ``patch`` (n,) of the travel a cluster, whose load is off what
    was taken off whenever it is crossed. None with fewer than FEWEST_PARTS, or where the columns do
    not stand apart.
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
    target = left[rows]
    values = np.linalg.lstsq(scaled, target, rcond=None)[0]
    variance = one_out(scaled, target, part)[0, 0] * small_sample(int(part[-1]) - 1)
    if patch is not None:
        variance = max(variance, _of_patches(scaled, target - scaled @ values, patch[rows]))
    scale = float(design_scale[0])
    return Inertia(float(values[0]) / scale, float(np.sqrt(variance)) / scale, int(part[-1]))


def _of_patches(design: Array, left: Array, patch: Numbers) -> float:
    """Return the variance of the first coefficient where errors are alike within patches."""
    inverse = np.linalg.inv(design.T @ design)
    between, count = scores(design, left, patch)
    few = max(1, count - 1)
    return float((inverse @ between @ inverse)[0, 0] * count / few * small_sample(few))
