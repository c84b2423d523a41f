"""What walks through days found: when events are named, what is invented, what terms predict."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from autodb.proofs.runs.found import KeptAsJson, TextTable, passed_words, percent
from autodb.proofs.runs.keeping.day_run import WITHIN, DayOutcome, EventOutcome, Invented
from autodb.proofs.runs.run_file import Finished, Origin

BETTER = 0.30
"""Share by which terms found must lower the error of predictions, on every day."""
KINDS = (
    ("warm-up", "warm-up"),
    ("wear of the first edge", "wear of edge 1"),
    ("wear after an edge change", "wear of edge"),
    ("hard bar", "hard bar"),
    ("drifting sensor", "drifting sensor"),
)
"""Rows, and how the names of their events begin; an event is counted in the first that fits."""


@dataclass(frozen=True)
class EventRow:
    """Events of one kind: how many, decidable in their day, named within ten cuts of that.

    ``covered``: named then or among the alternatives to a name; ``ever``: of those decidable, named
    at some time; ``late``: median of the cuts from decidable to named, below 0 where named before;
    ``kept``: mean share of later explanations in which a named event is named.
    """

    name: str
    events: int
    decidable: int
    in_time: int
    covered: int
    ever: int
    late: float | None
    kept: float | None

    @property
    def passed(self) -> bool:
        """Say whether every decidable event is named in time; without one nothing is shown."""
        return 0 < self.decidable == self.in_time


@dataclass(frozen=True)
class DaySummary(KeptAsJson):
    """The score: a row a kind of event, invented names, and what predictions gain.

    ``invented``: term, component, days, explained cuts and whether a true event was among the
    alternatives each time; ``better``: of each day in the order of seeds; errors are root mean
    squares over all days, N, of x, y, z.
    """

    origin: Origin
    seeds: tuple[int, int]
    rows: tuple[EventRow, ...]
    explained: int
    invented: tuple[tuple[str, str, int, int, bool], ...]
    days_with_invented: int
    better: tuple[float, ...]
    alone_N: tuple[float, ...]
    with_terms_N: tuple[float, ...]
    scatter_N: tuple[float, ...]

    @property
    def predicts(self) -> bool:
        """Say whether terms lower the error by as much as they must on every day."""
        return min(self.better) >= BETTER

    @property
    def passed(self) -> bool:
        """Say whether everything is within its limits."""
        return all(row.passed for row in self.rows) and not self.invented and self.predicts

    def tables(self) -> tuple[TextTable, ...]:
        """Return the events, the invented names and the predictions."""
        return (self._events(), self._invented(), self._predictions())

    def _events(self) -> TextTable:
        heads = (
            "event", ">events", ">decidable", f">named within {WITHIN} cuts (100 %)",
            ">or among alternatives", ">named at all", ">median cuts late", ">kept", "",
        )  # fmt: skip
        rows = tuple(
            (
                row.name, str(row.events), str(row.decidable), _of(row.in_time, row.decidable),
                _of(row.covered, row.decidable), _of(row.ever, row.decidable),
                "" if row.late is None else f"{row.late:+.0f}", percent(row.kept),
                passed_words(row.passed),
            )
            for row in self.rows
        )  # fmt: skip
        return TextTable("Events of the day", heads, rows)

    def _invented(self) -> TextTable:
        heads = (
            "name that no event stands for", "component", ">days", f">of {self.explained} answers",
            "an event among its alternatives", "",
        )  # fmt: skip
        rows = [
            (term, channel, str(days), str(times), "always" if double else "not always", "")
            for term, channel, days, times, double in self.invented
        ]
        of = f"{self.days_with_invented} of {len(self.better)}"
        rows.append(("any (none)", "", of, "", "", passed_words(not self.invented)))
        return TextTable("Invented", heads, tuple(rows))

    def _predictions(self) -> TextTable:
        heads = ("error of predictions", ">x", ">y", ">z", f">better (≥ {percent(BETTER)})", "")
        better = np.array(self.better)
        rows = (
            ("stored model alone", *_newtons(self.alone_N), "", ""),
            ("with the terms found", *_newtons(self.with_terms_N),
             f"{percent(float(np.median(better)))}, worst day {percent(float(better.min()))}",
             passed_words(self.predicts)),
            ("scatter alone", *_newtons(self.scatter_N), "", ""),
        )  # fmt: skip
        return TextTable("Predictions of the next cuts", heads, rows)


def _of(count: int, whole: int) -> str:
    return f"{count} of {whole}"


def _newtons(values: Sequence[float]) -> list[str]:
    return [f"{value:.1f} N" for value in values]


def day_summary_of(runs: Sequence[Finished[DayOutcome]], origin: Origin) -> DaySummary:
    """Return the score of finished runs in the order of their seeds."""
    days = [one for run in runs for one in run.judged]
    return DaySummary(
        origin=origin,
        seeds=(runs[0].seed, runs[-1].seed),
        rows=tuple(_rows([event for day in days for event in day.events])),
        explained=sum(day.explained for day in days),
        invented=tuple(_names([one for day in days for one in day.invented])),
        days_with_invented=sum(bool(day.invented) for day in days),
        better=tuple(day.better for day in days),
        alone_N=_pooled([day.alone_N for day in days]),
        with_terms_N=_pooled([day.with_terms_N for day in days]),
        scatter_N=_pooled([day.scatter_N for day in days]),
    )


def _rows(events: list[EventOutcome]) -> list[EventRow]:
    kind = [next(row for row, begins in KINDS if event.name.startswith(begins)) for event in events]
    return [
        _row(name, [event for event, of in zip(events, kind, strict=True) if of == name])
        for name, _ in KINDS
    ]


def _row(name: str, events: list[EventOutcome]) -> EventRow:
    """Return the row of one kind of event."""
    decided = [event for event in events if event.decidable is not None]
    late = [
        e.named - e.decidable for e in decided if e.named is not None and e.decidable is not None
    ]
    kept = [event.kept for event in events if event.kept is not None]
    return EventRow(
        name=name,
        events=len(events),
        decidable=len(decided),
        in_time=sum(bool(event.in_time) for event in decided),
        covered=sum(bool(event.covered) for event in decided),
        ever=sum(event.named is not None for event in decided),
        late=float(np.median(late)) if late else None,
        kept=float(np.mean(kept)) if kept else None,
    )


def _names(invented: list[Invented]) -> list[tuple[str, str, int, int, bool]]:
    """Return every invented name of a component, most frequent first."""
    by_name: dict[tuple[str, str], list[Invented]] = {}
    for one in invented:
        by_name.setdefault((one.term, one.channel), []).append(one)
    rows = [
        (term, channel, len(of), sum(one.times for one in of), all(one.double for one in of))
        for (term, channel), of in by_name.items()
    ]
    return sorted(rows, key=lambda row: (-row[3], row[:2]))


def _pooled(errors: Sequence[tuple[float, float, float]]) -> tuple[float, ...]:
    return tuple(np.sqrt(np.mean(np.square(errors), axis=0)).tolist())
