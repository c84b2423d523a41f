"""From rows to a fitted system: premises learned from several starts, then the consequents."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.anfis.learned import LearningCourse
from autodb.fitting.anfis.monotone import Monotone
from autodb.fitting.anfis.premises import Premises, rule_columns
from autodb.fitting.anfis.prior_weight import rows_weighed
from autodb.fitting.anfis.settling import Projection
from autodb.fitting.anfis.standardised import LearnerRows, Scaling, rows, scaling
from autodb.fitting.anfis.sums import consequent_sums, posterior
from autodb.fitting.anfis.system import (
    Anfis,
    ConsequentPrior,
    Hull,
    leverages,
    with_best_consequents,
)

Array = NDArray[np.float64]


class Learner(Protocol):
    """What finds premises: ``Projection`` or ``Hybrid``."""

    @property
    def courses(self) -> int:
        """Courses of learning from each start: where priors weigh, the noise is known after one."""
        ...

    def learn(self, rows: LearnerRows, start: Premises, held: NDArray[np.bool_]) -> LearningCourse:
        """Return the course of learning from a start; rows ``held`` (n,) are only judged by."""
        ...


def fit_anfis(
    inputs: Array,
    values: Array,
    starts: Sequence[Premises],
    *,
    learner: Learner | None = None,
    held: NDArray[np.bool_] | None = None,
    monotone: Monotone | None = None,
) -> Anfis:
    """Fit a Sugeno system to inputs (n, d) and values (n,).

    ``starts``: premises to learn from (``nearby(grid((2, 2)))``); those that end with the lowest
    residual variance, ``monotone`` heeded, are kept. ``held`` (n,): rows kept from learning;
    learning stops, and a start wins, by the error on them. Then the consequents are fitted to all
    rows. ``learner``: variable projection unless another is given.

    Raises Unvarying where an input does not vary, TooFewRows where nothing is left for the
    residual, NotMonotone.
    """
    scale = scaling(inputs, values)
    given = rows(scale.inputs(inputs), scale.values(values))
    apart = np.zeros(len(values), dtype=np.bool_) if held is None else held
    courses = [_course(learner or Projection(), given, start, apart) for start in starts]
    models = [
        _settled(c.premises, scale, given, learned=c.premises.vector.size, monotone=monotone)
        for c in courses
    ]
    judged = [one.variance for one in models] if held is None else [min(c.judged) for c in courses]
    return models[int(np.argmin(judged))]


def fit_consequents(
    inputs: Array, values: Array, premises: Premises, *, monotone: Monotone | None = None
) -> Anfis:
    """Fit the consequents alone; the premises, in scaled inputs, are known.

    Raises as ``fit_anfis``.
    """
    scale = scaling(inputs, values)
    given = rows(scale.inputs(inputs), scale.values(values))
    return _settled(premises, scale, given, learned=0, monotone=monotone)


def _course(
    learner: Learner, given: LearnerRows, start: Premises, held: NDArray[np.bool_]
) -> LearningCourse:
    """Return the learner's last course: priors weigh what the noise before says, less each time.

    A bad first fit counts as noise and keeps the first course smooth.
    """
    course = None
    for _ in range(learner.courses):
        weights = rows_weighed(given.pick(~held), start)
        course = learner.learn(
            replace(given, ridge=weights.ridge, leash=weights.leash), start, held
        )
        start = course.premises
    assert course is not None
    return course


def _settled(
    premises: Premises,
    scale: Scaling,
    given: LearnerRows,
    *,
    learned: int,
    monotone: Monotone | None,
) -> Anfis:
    columns = rule_columns(premises, given.x)
    tallied, ridge = consequent_sums(columns, given.left), rows_weighed(given, premises).ridge
    hull = Hull(
        scale.middle - scale.half,
        scale.middle + scale.half,
        given.x.std(axis=0),
        float(leverages(columns, posterior(tallied, ridge).root).max()),
    )
    return with_best_consequents(
        premises, scale, ConsequentPrior(given.plane, ridge), tallied,
        hull=hull, learned=learned, monotone=monotone,
    )  # fmt: skip
