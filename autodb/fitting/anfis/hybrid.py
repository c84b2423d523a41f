"""Jang's hybrid learning: consequents by least squares, premises one gradient step an epoch.

Forward the consequents are the least-squares ones; backward, these held, the premises move against
the gradient of the sum of squares, Δψ = −κ ∇E/|∇E| (Jang 1993, equations 8 and 9). The step size κ
grows by a tenth after four errors falling in a row and shrinks by a tenth after two combinations of
one up and one down in a row (section III.C there). Here inputs are scaled, so κ is in halves of
the training range. As published, nothing but the rows counts: the ridge is what double precision
asks for, and centres leave the training range where that fits; widths and slopes stay within the
limits of variable projection.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.anfis.learned import LearningCourse, rows_apart
from autodb.fitting.anfis.premise_search import changes, projected
from autodb.fitting.anfis.premises import Premises, premise_limits
from autodb.fitting.anfis.prior_weight import LEAST_RIDGE
from autodb.fitting.anfis.standardised import LearnerRows

Array = NDArray[np.float64]

GROWS, SHRINKS = 1.1, 0.9


@dataclass(frozen=True)
class Hybrid:
    """Learn as Jang does: ``epochs`` with the first step size ``step``."""

    epochs: int = 100
    step: float = 0.1

    courses: ClassVar[int] = 1

    def learn(self, rows: LearnerRows, start: Premises, held: NDArray[np.bool_]) -> LearningCourse:
        """Return the premises of the epoch that fits the rows, or the held-out ones, best."""
        fitted, judged = rows_apart(replace(rows, ridge=LEAST_RIDGE * len(rows.x)), held)
        low, high = free_centres(start, rows.x)
        here = start.at(np.clip(start.vector, low, high))
        point = projected(fitted, here)
        course = LearningCourse.begin(here, point.consequents, point.left, judged)
        step, changed = self.step, 0
        for epoch in range(self.epochs):
            gradient = -2.0 * changes(fitted, here, point)[0].T @ point.left
            size = float(np.linalg.norm(gradient))
            if size == 0.0:
                break
            here = start.at(np.clip(here.vector - step * gradient / size, low, high))
            point = projected(fitted, here)
            course = course.then(here, point.consequents, point.left, judged)
            factor = factor_of(course.errors[changed:])
            if factor != 1.0:
                step, changed = step * factor, epoch + 1
        return course


def free_centres(start: Premises, x: Array) -> tuple[Array, Array]:
    """Return the lowest and highest parameters (q,) as ``premise_limits``, centres without any."""
    low, high = premise_limits(start, x)
    count = start.membership.count
    low[count - 1 :: count], high[count - 1 :: count] = -np.inf, np.inf
    return low, high


def factor_of(errors: Sequence[float]) -> float:
    """Return what the step size is multiplied by after these errors, the last one newest."""
    falls = np.diff(errors[-5:]) < 0
    if len(falls) < 4:
        return 1.0
    if falls.all():
        return GROWS
    return SHRINKS if list(falls) in ([False, True] * 2, [True, False] * 2) else 1.0
