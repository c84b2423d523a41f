"""What a proof found, as a table: for a terminal, for a page, and as JSON."""

from collections.abc import Sequence
from dataclasses import dataclass

from pydantic import TypeAdapter

from autodb.prove.runs import Finished, Origin
from autodb.prove.score import SCORE_RATIO, Row, scored

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
"""Heads of the table; those that begin with > are right-aligned."""


@dataclass(frozen=True)
class Summary:
    """The score of a proof: where its runs came from, first and last seed, a row a quantity."""

    origin: Origin
    seeds: tuple[int, int]
    rows: tuple[Row, ...]

    @property
    def passed(self) -> bool:
        """Say whether every row is within its limits."""
        return all(row.passed for row in self.rows)

    @property
    def line(self) -> str:
        """Return where the table came from, in one line."""
        first, last = self.seeds
        return (
            f"{self.origin.proof}: {last - first + 1} runs, seeds {first} to {last}, "
            f"autodb {self.origin.version}, generator {self.origin.generator}, "
            f"product {self.origin.product}"
        )

    def to_json(self) -> str:
        """Return the summary as JSON, as ``from_json`` reads it."""
        return SUMMARY.dump_json(self, indent=1).decode() + "\n"

    @staticmethod
    def from_json(text: str) -> "Summary":
        """Return a summary that was written; raises pydantic's ValidationError on any other."""
        return SUMMARY.validate_json(text)


SUMMARY: TypeAdapter[Summary] = TypeAdapter(Summary)


def summary_of(runs: Sequence[Finished], origin: Origin) -> Summary:
    """Return the score of finished runs in the order of their seeds."""
    judged = [one for run in runs for one in run.quantities]
    rows = scored(judged, runs=len(runs))
    return Summary(origin, (runs[0].seed, runs[-1].seed), tuple(rows))


def cells(row: Row) -> list[str]:
    """Return a row of the table in the order of COLUMNS."""
    low, high = row.limits
    return [
        row.name,
        str(row.runs),
        _percent(row.given),
        _percent(row.share),
        f"{_percent(row.share_low)} to {_percent(row.share_high)}",
        f"{_percent(low)} to {_percent(high)}",
        _percent(row.oracle_share),
        "" if row.width is None else f"{row.width:.3g} {row.unit}",
        _ratio(row.width_ratio),
        _ratio(row.score_ratio),
        "passed" if row.passed else "FAILED",
    ]


def markdown(found: Summary) -> str:
    """Return the line of origin and the table as a page has it."""
    heads = [name.removeprefix(">") for name in COLUMNS]
    rules = ["---:" if name.startswith(">") else "---" for name in COLUMNS]
    rows = [heads, rules, *(cells(row) for row in found.rows)]
    table = "\n".join(f"| {' | '.join(row)} |" for row in rows)
    return f"{found.line}\n\n{table}\n"


def _percent(share: float) -> str:
    return f"{100.0 * share:.1f} %"


def _ratio(value: float | None) -> str:
    return "" if value is None else f"{value:.2f}"
