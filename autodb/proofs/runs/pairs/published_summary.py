"""How pairs of published tables are learnt: held, off and scored, beside plain least squares."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.runs.found import Check, CheckedScore, TextTable, percent, ratio
from autodb.proofs.runs.pairs.published_pairs import (
    AUTODB,
    COUNTS,
    POWER_LAW,
    TABLE_WAYS,
    TabledForce,
)
from autodb.proofs.runs.run_file import Finished, Origin
from autodb.proofs.runs.score import interval_score

Array = NDArray[np.float64]
Forces = Sequence[TabledForce]

HELD = (0.93, 0.97)
ERROR_RATIO, SCORE_RATIO = 1.05, 1.0
"""Largest error and score over the power law's."""
SHOWN = 12
"""Cuts after which tables are shown one by one."""


@dataclass(frozen=True)
class WayOfTable:
    """What one way does with one component of a table, shares of the component's mean force.

    ``held`` of its intervals; ``error``: root mean square; ``score``: mean interval score, None
    where an interval had no end.
    """

    table: str
    component: str
    cuts: int
    way: str
    forces: int
    held: float
    error: float
    score: float | None


@dataclass(frozen=True)
class PublishedPairs(CheckedScore):
    """The score of a proof of pairs of published tables."""

    origin: Origin
    seeds: tuple[int, int]
    rows: tuple[WayOfTable, ...]

    def checks(self) -> list[Check]:
        """Return coverage, error and score after each number of cuts."""
        return [check for cuts in COUNTS for check in self._checks_after(cuts)]

    def _checks_after(self, cuts: int) -> list[Check]:
        ours = self._of(cuts, AUTODB)
        held = _pooled_held(ours)
        theirs = self._of(cuts, POWER_LAW)
        error = _mean_ratio([(a.error, b.error) for a, b in zip(ours, theirs, strict=True)])
        score = _mean_ratio([(_score(a), _score(b)) for a, b in zip(ours, theirs, strict=True)])
        low, high = HELD
        bounds = f"{percent(low)} to {percent(high)}"
        return [
            (f"held after {cuts} cuts", percent(held), bounds, low <= held <= high),
            (
                f"error over the power law's after {cuts} cuts", ratio(error),
                f"≤ {ratio(ERROR_RATIO)}", error <= ERROR_RATIO,
            ),
            (
                f"interval score over the power law's after {cuts} cuts", ratio(score),
                f"≤ {ratio(SCORE_RATIO)}", score <= SCORE_RATIO,
            ),
        ]  # fmt: skip

    def _of(self, cuts: int, way: str) -> list[WayOfTable]:
        return [one for one in self.rows if one.cuts == cuts and one.way == way]

    def tables(self) -> tuple[TextTable, ...]:
        """Return limits, all tables together, and each after SHOWN cuts."""
        return (self.limits("Limits"), self._together(), self._each())

    def _together(self) -> TextTable:
        heads = (">cuts", "way", ">components", ">held", ">error (rms)", ">error, median")
        rows = []
        for cuts in COUNTS:
            for way in TABLE_WAYS:
                some = self._of(cuts, way)
                errors = np.array([one.error for one in some])
                rows.append(
                    (
                        str(cuts), way, str(len(some)), percent(_pooled_held(some)),
                        percent(float(np.sqrt(np.mean(errors**2)))),
                        percent(float(np.median(errors))),
                    )
                )  # fmt: skip
        return TextTable("All components, of their mean force", heads, tuple(rows))

    def _each(self) -> TextTable:
        heads = (
            "table", "component",
            *(f">{way}" for way in TABLE_WAYS), *(f">{way} held" for way in TABLE_WAYS),
        )  # fmt: skip
        found: dict[tuple[str, str], list[WayOfTable]] = {}
        for one in self.rows:
            if one.cuts == SHOWN:
                found.setdefault((one.table, one.component), []).append(one)
        rows = tuple(
            (*key, *(percent(one.error) for one in some), *(percent(one.held) for one in some))
            for key, some in found.items()
        )
        return TextTable(f"Error (rms) of each component after {SHOWN} cuts", heads, rows)


def published_summary_of(runs: Sequence[Finished[TabledForce]], origin: Origin) -> PublishedPairs:
    """Return the score of finished runs in the order of their seeds."""
    found: dict[tuple[str, str, int], list[TabledForce]] = {}
    for run in runs:
        for one in run.judged:
            found.setdefault((one.table, one.component, one.cuts), []).append(one)
    rows = tuple(_row(*key, way, some) for key, some in found.items() for way in TABLE_WAYS)
    return PublishedPairs(origin, (runs[0].seed, runs[-1].seed), rows)


def _row(table: str, component: str, cuts: int, way: str, some: Forces) -> WayOfTable:
    at = TABLE_WAYS.index(way)
    force, size = np.array([one.force for one in some]), some[0].size
    value = np.array([one.value[at] for one in some])
    low = np.array([-np.inf if one.low[at] is None else one.low[at] for one in some], dtype=float)
    high = np.array([np.inf if one.high[at] is None else one.high[at] for one in some], dtype=float)
    score = float(np.mean(interval_score(low, high, force))) / size
    return WayOfTable(
        table=table,
        component=component,
        cuts=cuts,
        way=way,
        forces=len(some),
        held=float(np.mean((low <= force) & (force <= high))),
        error=float(np.sqrt(np.mean((value - force) ** 2))) / size,
        score=score if np.isfinite(score) else None,
    )


def _pooled_held(some: Sequence[WayOfTable]) -> float:
    return float(np.average([one.held for one in some], weights=[one.forces for one in some]))


def _score(one: WayOfTable) -> float:
    return np.inf if one.score is None else one.score


def _mean_ratio(pairs: Sequence[tuple[float, float]]) -> float:
    """Return the geometric mean of ratios; a score without an end counts as infinitely worse."""
    return float(np.exp(np.mean([np.log(ours / theirs) for ours, theirs in pairs])))
