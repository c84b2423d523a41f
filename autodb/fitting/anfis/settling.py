"""From near an optimum of the premises to it: Newton's steps, until nothing moves.

Levenberg's and Marquardt's steps come near quickly and then crawl along the valleys that sets which
overlap leave; where they stop depends on how a processor rounds. With g the exact gradient of the
penalised sum of squares and H its Hessian, by central differences of g, steps −H⁻¹ g end within
rounding of the optimum. A step's length is √(sᵀ H s / 2 σ²), in standard errors of the premises, σ²
the residual variance, at least what the leash takes for it;
parameters at a limit that the descent would leave are held. H is worked out anew only where steps
with the last one come nearer by less than half.

Premises learned by variable projection: near their optimum by steps, then to it.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.anfis.learned import LearningCourse, rows_apart
from autodb.fitting.anfis.premise_search import Free, PremiseSearch, free_of, projected
from autodb.fitting.anfis.premises import Premises
from autodb.fitting.anfis.standardised import LearnerRows

Array = NDArray[np.float64]

SETTLED = 1e-8
"""Length of a step, in standard errors, at which the premises are at their optimum."""
MOST_STEPS = 1000
WIDTH = 1e-4
"""Half width of the differences, in logarithms or halves of the range: their error is its square,
and only makes steps a little longer or shorter."""
SLOWER = 0.5
HALVINGS = 30
NEAR = 1e-6
"""Length of a step below which the sum of squares changes by less than its rounding."""
TOUCHING = 1e-6
"""Way to a limit, in logarithms or halves of the range, that is none: a step that is cut off there
would turn, and lead nowhere lower."""
LEAST = 1e-10
"""Share of the greatest curvature that each direction is taken to have at least."""


class PremisesNotSettled(ValueError):  # noqa: N818 - the data's state, not a program error
    """Premises that do not come to an optimum."""


class _Place:
    """Premises (q,) that are searched, with cost and, where it is asked for, gradient there."""

    def __init__(self, rows: LearnerRows, free: Free, here: Array) -> None:
        self.here, self._rows, self._free = here, rows, free
        self._premises = free.at(here)
        self._point = projected(rows, self._premises)
        self._leash = free.leash(rows, here)
        self.cost = self._point.cost + float(self._leash @ self._leash)

    @cached_property
    def gradient(self) -> Array:
        """Gradient of the penalised sum of squares (q,)."""
        change = self._free.jacobian(self._rows, self._premises, self._point)
        leash = np.sqrt(self._rows.leash) * self._leash
        return np.asarray(2.0 * (change.T @ self._point.residual + leash))

    def blocked(self, free: Free) -> NDArray[np.bool_]:
        """Return which parameters (q,) are at a limit that the descent would leave."""
        low, high = self.here <= free.low, self.here >= free.high
        return np.asarray((low & (self.gradient > 0.0)) | (high & (self.gradient < 0.0)))

    def at_limits(self, free: Free, step: Array) -> "_Place":
        """Return the place with what is next to a limit, and would go beyond, put there."""
        low = (self.here < free.low + TOUCHING) & (step < 0.0)
        high = (self.here > free.high - TOUCHING) & (step > 0.0)
        put = np.where(low, free.low, np.where(high, free.high, self.here))
        return self if np.array_equal(put, self.here) else _Place(self._rows, free, put)


def settle_premises(rows: LearnerRows, free: Free, start: Array) -> Array:
    """Return the premises (q,), as they are searched, of the optimum near ``start``.

    Raises NotSettled after MOST_STEPS.
    """
    place = _Place(rows, free, start)
    held, curvature = place.blocked(free), np.empty((0, 0))
    before = anew = length = np.inf
    for _ in range(MOST_STEPS):
        new = not curvature.size or not np.array_equal(held, place.blocked(free))
        if new:
            held = place.blocked(free)
            curvature = _curvature(rows, free, place, held)
        step = _inside(curvature, place, held, free)
        put = place.at_limits(free, step)
        if put is not place:
            place, curvature = put, np.empty((0, 0))
            continue
        length = _length(curvature, step, place, rows)
        if length < SETTLED or (new and SLOWER * anew < length < NEAR):
            return place.here  # the second: what is left is the gradient's rounding
        after = _after(rows, free, place, step, near=length < NEAR)
        if after is None and new:
            break
        anew = length if new else anew
        if after is None or length > SLOWER * before:
            curvature, before = np.empty((0, 0)), np.inf
        else:
            before = length
        place = after or place
    raise PremisesNotSettled(f"premises still move by {length:.2g} standard errors a step")


def _curvature(rows: LearnerRows, free: Free, place: _Place, held: NDArray[np.bool_]) -> Array:
    """Return the Hessian (q, q) in the directions that are not held."""
    size = len(place.here)
    matrix = np.zeros((size, size))
    for k in np.flatnonzero(~held):
        width = np.zeros(size)
        width[k] = WIDTH
        ends = [_Place(rows, free, place.here + side * width).gradient for side in (1.0, -1.0)]
        matrix[k] = (ends[0] - ends[1]) / (2.0 * WIDTH)
    matrix = 0.5 * (matrix + matrix.T)
    matrix[held] = matrix[:, held] = 0.0
    return matrix


def _step(curvature: Array, gradient: Array, held: NDArray[np.bool_]) -> Array:
    """Return Newton's step, downhill also where the curvature is not positive."""
    free = np.flatnonzero(~held)
    values, vectors = np.linalg.eigh(curvature[np.ix_(free, free)])
    size = np.maximum(np.abs(values), LEAST * np.max(np.abs(values), initial=1e-300))
    step = np.zeros_like(gradient)
    step[free] = -vectors @ (vectors.T @ gradient[free] / size)
    return step


def _inside(curvature: Array, place: _Place, held: NDArray[np.bool_], free: Free) -> Array:
    """Return the step with all parameters held at whose limits it would leave the range."""
    while True:
        step = _step(curvature, place.gradient, held)
        low, high = place.here <= free.low, place.here >= free.high
        beyond = ~held & ((low & (step < 0.0)) | (high & (step > 0.0)))
        if not beyond.any():
            return step
        held = held | beyond


def _length(curvature: Array, step: Array, place: _Place, rows: LearnerRows) -> float:
    """Return the length of a step in standard errors of the premises."""
    noise = max(place.cost / max(len(rows.left), 1), rows.leash)
    return float(np.sqrt(abs(step @ curvature @ step) / (2.0 * noise)))


def _after(
    rows: LearnerRows, free: Free, place: _Place, step: Array, *, near: bool
) -> _Place | None:
    """Return the place after a step, halved until it is lower; None where none is.

    ``near``: the sum of squares no longer changes, but the gradient does.
    """
    for _ in range(HALVINGS):
        there = _Place(rows, free, np.clip(place.here + step, free.low, free.high))
        if near or there.cost <= place.cost:
            return there
        step = 0.5 * step
    return None


@dataclass(frozen=True)
class Projection:
    """Learn by variable projection, to the optimum of the penalised sum of squares.

    Steps bring it near, until ``idle`` in a row lower the sum by less than ``smallest_gain`` of it;
    ``settling`` takes it from there. It stops short of that after ``most_steps``, and, where rows
    are held out to stop by, where the error on these has not fallen for ``patience`` steps.
    """

    most_steps: int = 200
    smallest_gain: float = 1e-5
    idle: int = 5
    patience: int = 20

    courses: ClassVar[int] = 2
    """Each to its optimum."""

    def learn(self, rows: LearnerRows, start: Premises, held: NDArray[np.bool_]) -> LearningCourse:
        """Return the premises that fit the rows, or the held-out ones among them, best.

        Raises NotSettled where they do not come to an optimum.
        """
        fitted, judged = rows_apart(rows, held)
        free = free_of(start, rows.x)
        search = PremiseSearch.begin(fitted, free)
        point = search.point
        course = LearningCourse.begin(search.premises, point.consequents, point.left, judged)
        slow = 0
        while course.steps < self.most_steps:
            after = search.after(fitted, free)
            if after is None:
                break
            gain = 1.0 - after.cost / search.cost
            search, slow = after, slow + 1 if gain < self.smallest_gain else 0
            point = search.point
            course = course.then(search.premises, point.consequents, point.left, judged)
            if slow >= self.idle or (held.any() and course.stale >= self.patience):
                break
        if held.any() or course.steps >= self.most_steps:
            return course
        there = free.at(settle_premises(fitted, free, search.here))
        point = projected(fitted, there)
        return replace(course.then(there, point.consequents, point.left, None), premises=there)
