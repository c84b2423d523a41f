"""The course of learning: errors step by step, and the premises of the best of them."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.anfis.premises import Premises, rule_columns
from autodb.fitting.anfis.standardised import LearnerRows

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LearningCourse:
    """The best premises so far; errors (rms, scaled) of fitted and of judged rows at every step.

    Rows held out are judged; where none are, the fitted ones.
    """

    premises: Premises
    errors: tuple[float, ...]
    judged: tuple[float, ...]

    @property
    def steps(self) -> int:
        """Steps taken."""
        return len(self.errors) - 1

    @property
    def best(self) -> int:
        """The step whose premises these are."""
        return int(np.argmin(self.judged))

    @property
    def stale(self) -> int:
        """Steps since the judged error was lowest."""
        return self.steps - self.best

    @classmethod
    def begin(
        cls, premises: Premises, consequents: Array, left: Array, judged: LearnerRows | None
    ) -> "LearningCourse":
        """Return the course before the first step; arguments as of ``then``."""
        first = cls(premises, (), ())
        return first.then(premises, consequents, left, judged)

    def then(
        self, premises: Premises, consequents: Array, left: Array, judged: LearnerRows | None
    ) -> "LearningCourse":
        """Return the course with one more step: premises, their consequents (p,), and what these
        leave of the fitted rows (n,). ``judged``: rows held out, None where none are.
        """
        error = rms_of_residuals(left)
        outside = error if judged is None else error_of(premises, consequents, judged)
        better = outside < min(self.judged, default=np.inf)
        return replace(
            self,
            premises=premises if better else self.premises,
            errors=(*self.errors, error),
            judged=(*self.judged, outside),
        )


def error_of(premises: Premises, consequents: Array, rows: LearnerRows) -> float:
    """Return the root mean square of what consequents less the plane (p,) leave, scaled."""
    return rms_of_residuals(rows.left - rule_columns(premises, rows.x) @ consequents)


def rms_of_residuals(left: Array) -> float:
    """Return the root mean square of residuals (n,)."""
    return float(np.sqrt(np.mean(left**2)))


def rows_apart(
    rows: LearnerRows, held: NDArray[np.bool_]
) -> tuple[LearnerRows, LearnerRows | None]:
    """Return the rows to fit and the rows held out to judge by, None where none is."""
    return (rows.pick(~held), rows.pick(held)) if held.any() else (rows, None)
