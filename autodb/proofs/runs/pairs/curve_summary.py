"""What the learning curves of pairs found: errors by way and number of cuts, and cuts of plans.

Standard errors are over pairs; those of numbers of cuts come from pairs drawn again with
replacement (Efron 1979, the bootstrap). An error is the median of a pair's next cuts.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.runs.found import KeptAsJson, TextTable, passed_words, percent
from autodb.proofs.runs.pairs.curve_plans import AT, FACTORIAL, PROPOSED, RANDOM, PlannedPair
from autodb.proofs.runs.pairs.curve_run import ADDED, LEARNT, OURS, LearningErrors
from autodb.proofs.runs.run_file import Finished, Origin

Array = NDArray[np.float64]

SOON = 5
"""Cuts after which the error must be below ENOUGH."""
ENOUGH = 0.1
HALF = 0.5
"""Share of the random plan's cuts that the proposed ones may be."""
AGAIN = 1000
"""Times that pairs are drawn again."""
WIDTHS = {
    "whole": "of the next cut's force, everything included",
    "given_gain": "of its mean, given the machine's gain",
}


@dataclass(frozen=True)
class CurveRow:
    """A way and a component: mean error over pairs after each number of LEARNT and its standard
    error; ``ahead``: by how many standard errors, of the difference pair by pair, autodb's is below
    it (autodb is not ahead of itself: none). None where the way needs more cuts.
    """

    method: str
    component: str
    error: tuple[float | None, ...]
    se: tuple[float | None, ...]
    ahead: tuple[float | None, ...]

    @property
    def passed(self) -> bool:
        """Whether autodb's is low enough soon, or nowhere above by over a standard error."""
        if self.method in (OURS, ADDED):
            soon = self.error[LEARNT.index(SOON)]
            return soon is not None and soon < ENOUGH
        return all(one is None or one >= -1.0 for one in self.ahead)


@dataclass(frozen=True)
class Reached:
    """A width: the level that random cuts reach and that of the factorial, medians over pairs, and
    how many proposed cuts reach either (None: more than were made), with standard errors.
    """

    width: str
    level: float
    proposed: int | None
    proposed_se: float
    factorial_level: float
    like_factorial: int | None
    like_factorial_se: float

    @property
    def halved(self) -> bool:
        """Whether the proposed cuts are at most half of the random ones."""
        return self.proposed is not None and self.proposed <= HALF * AT[RANDOM][-1]

    @property
    def fewer(self) -> bool:
        """Whether the proposed cuts are fewer than the factorial's, for what it reaches."""
        return self.like_factorial is not None and self.like_factorial < AT[FACTORIAL][-1]


@dataclass(frozen=True)
class Course:
    """A plan: medians over pairs of both widths, and mean error with its standard error."""

    plan: str
    whole: tuple[float, ...]
    given_gain: tuple[float, ...]
    error: tuple[float, ...]
    se: tuple[float, ...]


@dataclass(frozen=True)
class CurveSummary(KeptAsJson):
    """The score. ``worse``: error after the proposed cuts that reach the level given the gain, less
    that after all random ones, mean over pairs and standard error.
    """

    origin: Origin
    seeds: tuple[int, int]
    rows: tuple[CurveRow, ...]
    reached: tuple[Reached, ...]
    courses: tuple[Course, ...]
    worse: tuple[float, float]

    @property
    def passed(self) -> bool:
        """Say whether everything is within its limits."""
        above_floor = self.reached[list(WIDTHS).index("given_gain")]
        return (
            all(row.passed for row in self.rows)
            and above_floor.halved
            and above_floor.fewer
            and self.as_near
        )

    @property
    def as_near(self) -> bool:
        """Whether proposed cuts err no more than random ones, as far as the pairs show."""
        return self.worse[0] <= self.worse[1]

    def tables(self) -> tuple[TextTable, ...]:
        """Return errors, numbers of cuts, and how the plans went."""
        return (self._errors(), self._reached(), self._courses())

    def _errors(self) -> TextTable:
        heads = ("way", "component", *(f">{n} cuts" for n in LEARNT), "")
        rows = tuple(
            (
                row.method, row.component,
                *(_plus_minus(e, s) for e, s in zip(row.error, row.se, strict=True)),
                passed_words(row.passed),
            )
            for row in self.rows
        )  # fmt: skip
        pairs = self.seeds[1] - self.seeds[0] + 1
        title = (
            f"Median error of the next cuts' mean force, mean of {pairs} pairs ± its standard error"
        )
        return TextTable(title, heads, rows)

    def _reached(self) -> TextTable:
        most, corners = AT[RANDOM][-1], AT[FACTORIAL][-1]
        heads = (
            "half-width", f">{most} random cuts reach", f">proposed (≤ {HALF * most:g})", "",
            f">the factorial's {corners} reach", f">proposed (< {corners})", "",
        )  # fmt: skip
        rows = tuple(
            (
                WIDTHS[one.width],
                percent(one.level), _count(one.proposed, one.proposed_se), passed_words(one.halved),
                percent(one.factorial_level), _count(one.like_factorial, one.like_factorial_se),
                passed_words(one.fewer),
            )
            for one in self.reached
        )  # fmt: skip
        off, se = (100.0 * one for one in self.worse)
        error = ("error, less that of random cuts at the level given the gain", "")
        rows = (*rows, (*error, f"{off:+.1f} ± {se:.1f} %", passed_words(self.as_near), "", "", ""))
        return TextTable("Cuts to a half-width, medians of pairs ± standard error", heads, rows)

    def _courses(self) -> TextTable:
        longest = max(at[-1] for at in AT.values())
        heads = ("plan", "", *(f">{n} cuts" for n in range(longest + 1)))
        rows = tuple(row for course in self.courses for row in _lines(course, longest))
        return TextTable("Plans: half-widths (medians) and errors (means) of pairs", heads, rows)


def _plus_minus(value: float | None, se: float | None) -> str:
    if value is None or se is None:
        return ""
    return f"{100.0 * value:.1f} ± {100.0 * se:.1f} %"


def _count(cuts: int | None, se: float) -> str:
    return f"more than {AT[PROPOSED][-1]}" if cuts is None else f"{cuts} ± {se:.1f}"


def _lines(course: Course, longest: int) -> list[tuple[str, ...]]:
    """Return a plan's widths and errors as rows, a cell for each number of cuts."""
    kinds = {
        WIDTHS["whole"]: [percent(one) for one in course.whole],
        WIDTHS["given_gain"]: [percent(one) for one in course.given_gain],
        "error": [_plus_minus(e, s) for e, s in zip(course.error, course.se, strict=True)],
    }
    return [
        (course.plan, what, *_placed(dict(zip(AT[course.plan], cells, strict=True)), longest))
        for what, cells in kinds.items()
    ]


def _placed(cells: dict[int, str], longest: int) -> list[str]:
    return [cells.get(n, "") for n in range(longest + 1)]


def curve_summary_of(
    runs: Sequence[Finished[LearningErrors | PlannedPair]], origin: Origin
) -> CurveSummary:
    """Return the score of finished runs in the order of their seeds."""
    every = [one for run in runs for one in run.judged]
    rows = curve_rows_of([one for one in every if isinstance(one, LearningErrors)])
    plans = [one for one in every if isinstance(one, PlannedPair)]
    by_plan = {name: [one for one in plans if one.plan == name] for name in AT}
    courses = tuple(_course(name, own) for name, own in by_plan.items())
    reached = tuple(_reached(width, by_plan) for width in WIDTHS)
    worse = _worse(by_plan, reached[list(WIDTHS).index("given_gain")])
    return CurveSummary(origin, (runs[0].seed, runs[-1].seed), rows, reached, courses, worse)


def curve_rows_of(every: Sequence[LearningErrors]) -> tuple[CurveRow, ...]:
    """Return a row for each way and component, autodb's among them."""
    kinds = list(dict.fromkeys((one.method, one.component) for one in every))
    table = {
        kind: np.array(
            [one.errors for one in every if (one.method, one.component) == kind], dtype=np.float64
        )
        for kind in kinds
    }
    return tuple(_row(kind, table[kind], table[OURS, kind[1]]) for kind in kinds)


def _row(kind: tuple[str, str], errors: Array, ours: Array) -> CurveRow:
    """Return the row of errors (pairs, numbers of cuts); what is no number was not given."""
    with np.errstate(invalid="ignore", divide="ignore"):
        ahead = (errors - ours).mean(axis=0) / _se(errors - ours)
    return CurveRow(*kind, _given(errors.mean(axis=0)), _given(_se(errors)), _given(ahead))


def _given(values: Array) -> tuple[float | None, ...]:
    return tuple(float(v) if np.isfinite(v) else None for v in values)


def _se(values: Array) -> Array:
    """Return the standard error of the mean over pairs, the first axis."""
    return np.asarray(values.std(axis=0, ddof=1) / np.sqrt(len(values)))


def _course(name: str, own: Sequence[PlannedPair]) -> Course:
    errors = np.array([one.errors for one in own])
    whole, given_gain = (np.median(widths_of(own, width), axis=0) for width in WIDTHS)
    return Course(
        name, *(tuple(v.tolist()) for v in (whole, given_gain, errors.mean(axis=0), _se(errors)))
    )


def widths_of(own: Sequence[PlannedPair], width: str) -> Array:
    """Return a width of every pair (pairs, cuts)."""
    return np.array([getattr(one, width) for one in own])


def _reached(width: str, by_plan: dict[str, list[PlannedPair]]) -> Reached:
    table = {name: widths_of(own, width) for name, own in by_plan.items()}
    level, factorial_level = (float(np.median(table[n][:, -1])) for n in (RANDOM, FACTORIAL))
    proposed = table[PROPOSED]
    return Reached(
        width=width,
        level=level,
        proposed=cuts_to(level, proposed),
        proposed_se=_se_cuts(proposed, table[RANDOM]),
        factorial_level=factorial_level,
        like_factorial=cuts_to(factorial_level, proposed),
        like_factorial_se=_se_cuts(proposed, table[FACTORIAL]),
    )


def cuts_to(level: float, widths: Array) -> int | None:
    """Return how many cuts it takes until the median over pairs of widths (pairs, 0 to n cuts) is
    at a level or below, None where it never is.
    """
    below = np.median(widths, axis=0) <= level
    return int(np.argmax(below)) if below.any() else None


def _se_cuts(widths: Array, to: Array) -> float:
    """Return the standard error of the cuts that reach what all of another plan's do.

    Of pairs drawn again; where the level is not reached, one more than were made count.
    """
    drawn = np.random.default_rng(0).integers(len(widths), size=(AGAIN, len(widths)))
    levels = np.median(to[:, -1][drawn], axis=1)
    below = np.median(widths[drawn], axis=1) <= levels[:, None]
    counts = np.where(below.any(axis=1), np.argmax(below, axis=1), widths.shape[1])
    return float(np.std(counts))


def _worse(by_plan: dict[str, list[PlannedPair]], level: Reached) -> tuple[float, float]:
    """Return the difference of errors at the level of a width, and its standard error."""
    at = AT[PROPOSED][-1] if level.proposed is None else level.proposed
    pairs = zip(by_plan[PROPOSED], by_plan[RANDOM], strict=True)
    apart = np.array([one.errors[at] - other.errors[-1] for one, other in pairs])
    return float(apart.mean()), float(_se(apart))
