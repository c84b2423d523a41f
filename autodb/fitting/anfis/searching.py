"""Premises learned by variable projection: near their optimum by steps, then to it."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.anfis.learned import LearningCourse, rows_apart
from autodb.fitting.anfis.premises import Premises
from autodb.fitting.anfis.projection import PremiseSearch, free_of, projected
from autodb.fitting.anfis.rows import LearnerRows
from autodb.fitting.anfis.settling import settle_premises


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

    def learn(self, rows: LearnerRows, start: Premises, held: NDArray[np.bool_]) -> LearningCourse:
        """Return the premises that fit the rows, or the held-out ones among them, best.

        Raises NotSettled where they do not come to an optimum.
        """
        fitted, judged = rows_apart(rows, held)
        free = free_of(start, rows.x)
        search = PremiseSearch.begin(fitted, free)
        point = search.point
        told = LearningCourse.begin(search.premises, point.consequents, point.left, judged)
        slow = 0
        while told.steps < self.most_steps:
            after = search.after(fitted, free)
            if after is None:
                break
            gain = 1.0 - after.cost / search.cost
            search, slow = after, slow + 1 if gain < self.smallest_gain else 0
            point = search.point
            told = told.then(search.premises, point.consequents, point.left, judged)
            if slow >= self.idle or (held.any() and told.stale >= self.patience):
                break
        if held.any() or told.steps >= self.most_steps:
            return told
        there = free.at(settle_premises(fitted, free, search.here))
        point = projected(fitted, there)
        return replace(told.then(there, point.consequents, point.left, None), premises=there)
