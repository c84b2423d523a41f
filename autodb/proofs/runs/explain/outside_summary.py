"""What the proof beside physics outside the vocabulary found: own terms, confidence, each kind."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from autodb.proofs.runs.explain.explain_score import brier, reliability
from autodb.proofs.runs.explain.explain_summary import BIN_HEADS, LIMIT_HEADS, Limit
from autodb.proofs.runs.explain.outside_run import Answered
from autodb.proofs.runs.found import KeptAsJson, TextTable, percent, ratio
from autodb.proofs.runs.run_file import Finished, Origin
from autodb.proofs.runs.score import exact_interval

WRONGLY = 0.03
"""Share of cases in which an own term that is right may be called mistuned."""
BRIER = 0.10
LEAST = 40
"""Answers in a bin of the reliability."""
KIND_HEADS = (
    "hidden", ">cases", ">right name", ">wrong name", ">own term wrongly mistuned",
    ">error left",
)  # fmt: skip


@dataclass(frozen=True)
class OutsideRow:
    """One kind of hidden physics: shares of its cases, and the median error left."""

    name: str
    cases: int
    right: int
    wrong: int
    mistuned: int
    left: float | None


@dataclass(frozen=True)
class OutsideSummary(KeptAsJson):
    """The score; ``briers``: of all entries, of missing and of mistuned ones."""

    origin: Origin
    seeds: tuple[int, int]
    refused: int
    limits: tuple[Limit, ...]
    rows: tuple[OutsideRow, ...]
    answers: int
    briers: tuple[float | None, float | None, float | None]
    bins: tuple[tuple[int, float, float], ...]

    @property
    def passed(self) -> bool:
        """Say whether every share is within its limit, and confidence is calibrated."""
        score = self.briers[0]
        return all(one.passed for one in self.limits) and score is not None and score <= BRIER

    def tables(self) -> tuple[TextTable, ...]:
        """Return limits, kinds, confidence."""
        scores = ", ".join(
            f"{name} {'none' if score is None else f'{score:.3f}'}"
            for name, score in zip(("all", "missing", "mistuned"), self.briers, strict=True)
        )
        return (
            TextTable("Limits", LIMIT_HEADS, tuple(one.cells() for one in self.limits)),
            TextTable("What is hidden", KIND_HEADS, tuple(_cells(one) for one in self.rows)),
            TextTable(
                f"Confidence of {self.answers} answers: Brier score {scores} (must be ≤ {BRIER:g})",
                BIN_HEADS,
                tuple((str(n), f"{sure:.3f}", percent(right)) for n, sure, right in self.bins),
            ),
        )


def outside_summary_of(runs: Sequence[Finished[Answered]], origin: Origin) -> OutsideSummary:
    """Return the score of finished runs in the order of their seeds."""
    asked = [one for run in runs for one in run.judged if one.reached]
    outside = [one for one in asked if one.outside]
    inside = [one for one in asked if not one.outside]
    pairs = _pairs(asked, ("missing", "mistuned"))
    return OutsideSummary(
        origin=origin,
        seeds=(runs[0].seed, runs[-1].seed),
        refused=sum(bool(one.refused) for one in asked),
        limits=tuple(
            _limit(f"own term that is right called mistuned, {what}", some)
            for what, some in (
                ("all", asked), ("outside the vocabulary", outside), ("inside it", inside),
            )
        ),
        rows=tuple(_row(kind, asked) for kind in dict.fromkeys(one.kind for one in asked)),
        answers=len(pairs),
        briers=(
            _brier(pairs),
            _brier(_pairs(asked, ("missing",))),
            _brier(_pairs(asked, ("mistuned",))),
        ),
        bins=tuple(reliability(pairs, least=LEAST)),
    )  # fmt: skip


def _pairs(asked: Sequence[Answered], kinds: tuple[str, ...]) -> list[tuple[float, bool]]:
    return [(e.confidence, e.right) for one in asked for e in one.entries if e.kind in kinds]


def _brier(pairs: list[tuple[float, bool]]) -> float | None:
    return brier(pairs) if pairs else None


def _limit(name: str, cases: Sequence[Answered]) -> Limit:
    count = sum(bool(one.named("mistuned", right=False)) for one in cases)
    low, high = exact_interval(count, len(cases)) if cases else (0.0, 1.0)
    return Limit(name, len(cases), count, low, high, at_least=False, limit=WRONGLY)


def _row(kind: str, asked: Sequence[Answered]) -> OutsideRow:
    cases = [one for one in asked if one.kind == kind]
    left = [one.left for one in cases if one.left is not None]
    return OutsideRow(
        name=f"{kind}{' (outside)' if cases[0].outside else ''}",
        cases=len(cases),
        right=sum(bool(one.named("missing", right=True)) for one in cases),
        wrong=sum(
            any(e.term != "unknown" for e in one.named("missing", right=False)) for one in cases
        ),
        mistuned=sum(bool(one.named("mistuned", right=False)) for one in cases),
        left=float(np.median(left)) if left else None,
    )


def _cells(one: OutsideRow) -> tuple[str, ...]:
    counts = (str(n) for n in (one.cases, one.right, one.wrong, one.mistuned))
    return (one.name, *counts, ratio(one.left))
