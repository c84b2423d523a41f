"""What a proof of intervals found: a row a quantity."""

from collections.abc import Sequence
from dataclasses import dataclass

from autodb.proofs.runs.found import KeptAsJson, TextTable, passed_words, percent, ratio
from autodb.proofs.runs.run_file import Finished, Origin
from autodb.proofs.runs.score import SCORE_RATIO, Judged, QuantityRow, scored_quantities

COLUMNS = (
    "quantity",
    ">runs",
    ">given",
    ">held the truth",
    ">exact 95 %",
    ">must be",
    ">oracle held",
    ">median width",
    ">× oracle's",
    f">score × oracle's (≤ {SCORE_RATIO:g})",
    "",
)
"""Heads of the table."""


@dataclass(frozen=True)
class IntervalsSummary(KeptAsJson):
    """The score of a proof: where its runs came from, first and last seed, a row a quantity."""

    origin: Origin
    seeds: tuple[int, int]
    rows: tuple[QuantityRow, ...]

    @property
    def passed(self) -> bool:
        """Say whether every row is within its limits."""
        return all(row.passed for row in self.rows)

    def tables(self) -> tuple[TextTable, ...]:
        """Return the only table."""
        rows = tuple(tuple(row_cells(row)) for row in self.rows)
        return (TextTable("Intervals against the truth", COLUMNS, rows),)


def intervals_summary_of(runs: Sequence[Finished[Judged]], origin: Origin) -> IntervalsSummary:
    """Return the score of finished runs in the order of their seeds."""
    judged = [one for run in runs for one in run.judged]
    rows = scored_quantities(judged, runs=len(runs))
    return IntervalsSummary(origin, (runs[0].seed, runs[-1].seed), tuple(rows))


def row_cells(row: QuantityRow) -> list[str]:
    """Return a row of the table in the order of COLUMNS."""
    low, high = row.limits
    return [
        row.name,
        str(row.runs),
        percent(row.given),
        percent(row.share),
        f"{percent(row.share_low)} to {percent(row.share_high)}",
        f"{percent(low)} to {percent(high)}",
        percent(row.oracle_share),
        "" if row.width is None else f"{row.width:.3g} {row.unit}",
        ratio(row.width_ratio),
        ratio(row.score_ratio),
        passed_words(row.passed),
    ]
