"""A walk through a day: what is named when, and what the cuts that come next are expected to be.

The table so far is explained after every STEP cuts, which is also how often the next STEP cuts are
predicted; and at every event's cut of decision, ten cuts after it became decidable, so that "within
ten cuts" is judged at that cut and not at the next step. What comes later is never seen.
"""

import gc
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.explain.answer import Cause, ChannelAnswer
from autodb.explain.cuts.answers import answers
from autodb.explain.cuts.carried import ahead
from autodb.explain.cuts.cut_search import look_in_cuts, stack_of
from autodb.explain.engine.candidates import UNKNOWN
from autodb.proofs.machines.lathe.day import FORCES, Day, Event, draw_day
from autodb.proofs.runs.explain.explain_score import overlap
from autodb.proofs.runs.keeping.day_oracle import decidable_from
from autodb.records.tables import CutTable

Array = NDArray[np.float64]
Answers = dict[str, ChannelAnswer]

STEP = 20
WITHIN = 10
"""Cuts after an event became decidable by which it must be named."""
OVERLAPS = 0.5
"""Share of a bar's cuts and of those named together that must be of both."""


@dataclass(frozen=True)
class EventOutcome:
    """An event: when it began, was decidable, and was named.

    ``decidable``: None where never, or so late that the day ends before its cut of decision;
    ``in_time``: named at the cut of decision, ``covered``: named then or among the alternatives;
    ``named``: first explained cut at which it is named, ``stays``: first cut from which on it is;
    ``kept``: share of explained cuts from ``named`` on at which it is.
    """

    name: str
    term: str
    first: int
    decidable: int | None
    in_time: bool | None
    covered: bool | None
    named: int | None
    stays: int | None
    kept: float | None


@dataclass(frozen=True)
class Invented:
    """A name that no event stands for: where, at how many explained cuts, from the first of them.

    ``double``: each time an event that is sensed there was among its alternatives.
    """

    term: str
    channel: str
    first: int
    times: int
    double: bool


@dataclass(frozen=True)
class DayOutcome:
    """A day: its events, what was invented, how often it was explained, errors of prediction.

    Errors are root mean squares over all cuts, N, of x, y, z: of the stored model alone, of what
    was expected with the terms found before, and of what nobody can predict, the scatter.
    """

    seed: int
    explained: int
    events: tuple[EventOutcome, ...]
    invented: tuple[Invented, ...]
    alone_N: tuple[float, float, float]
    with_terms_N: tuple[float, float, float]
    scatter_N: tuple[float, float, float]

    @property
    def better(self) -> float:
        """Share by which terms lower the error of prediction, all components together."""
        alone, terms = (np.sum(np.square(one)) for one in (self.alone_N, self.with_terms_N))
        return 1.0 - float(np.sqrt(terms / alone))


def run_day(seed: int) -> list[DayOutcome]:
    """Draw the day of a seed, walk through it and judge."""
    return [walked(draw_day(seed))]


def walked(day: Day, *, step: int = STEP) -> DayOutcome:
    """Walk through a day."""
    count = day.bar.size
    decidable = {event.name: decidable_from(day, event) for event in day.events}
    decisions = {at + WITHIN for at in decidable.values() if at is not None}
    seen: dict[int, Answers] = {}
    expected = day.expected.copy()
    for at in sorted({*range(step, count + 1, step), *(d for d in decisions if d <= count)}):
        following = slice(at, at + step) if at % step == 0 and at < count else None
        seen[at], further = explained_day(day, at, following)
        if following is not None:
            expected[:, following] = further
        gc.collect()  # a search and its products hold each other, some 100 MB each time
    return DayOutcome(
        seed=day.seed,
        explained=len(seen),
        events=tuple(
            event_outcome(event, decidable[event.name], seen, count) for event in day.events
        ),
        invented=tuple(invented(day, seen)),
        alone_N=_rms(day.measured - day.expected),
        with_terms_N=_rms(day.measured - expected),
        scatter_N=_rms(day.scatter),
    )


def _rms(values: Array) -> tuple[float, float, float]:
    x, y, z = np.sqrt(np.mean(values**2, axis=1))
    return float(x), float(y), float(z)


def explained_day(day: Day, count: int, following: slice | None) -> tuple[Answers, Array]:
    """Explain the first cuts of a day; return the forces expected in those that follow (3, m)."""
    rows, includes = slice(0, count), list(day.world.parts)
    table = _table(day, rows, day.measured)
    simulation = dict(zip(FORCES, day.expected[:, rows], strict=True))
    result = look_in_cuts(stack_of(table, simulation, includes), includes)
    found = answers(table, result, frozenset(includes))
    force = np.zeros((3, 0))
    if following is not None:
        there = dict(zip(FORCES, day.expected[:, following], strict=True))
        force = ahead(result, _table(day, following), there).force
    return {name: answer for name, (answer, _) in found.items()}, force


def _table(day: Day, rows: slice, forces: Array | None = None) -> CutTable:
    """Return some cuts as they are read from a file, forces only where they are given."""
    channels = {name: values[rows] for name, values in day.channels.items()}
    if forces is not None:
        channels |= dict(zip(FORCES, forces[:, rows], strict=True))
    texts = {"operation": ["turn"] * len(channels["cut"])}
    return CutTable(Path(f"day-{day.seed}.csv"), channels, texts)


# Which event is named


def names_it(answers_now: Answers, event: Event, count: int) -> bool:
    """Say whether an answer for the first cuts of a day names an event.

    Its term must be missing in a component that it acts on; wear of an edge with a rate of that
    edge that is above zero for sure, a run of harder cuts with cuts that are mostly its own.
    """
    return any(
        cause.kind == "missing"
        and cause.term == event.term
        and _this_one(cause, answer, event, count)
        for answer in _sensed(answers_now, event, count)
        for cause in answer.missing
    )


def covers_it(answers_now: Answers, event: Event, count: int) -> bool:
    """Say whether an answer names an event, or has its term among the alternatives to a name."""
    return names_it(answers_now, event, count) or any(
        event.term in cause.alternatives
        for answer in _sensed(answers_now, event, count)
        for cause in answer.missing
    )


def _sensed(answers_now: Answers, event: Event, count: int) -> list[ChannelAnswer]:
    """Return the answers of the components that an event acts on in the first cuts."""
    sensed = np.any(event.part[:, :count] != 0.0, axis=1)
    return [answers_now[name] for name, there in zip(FORCES, sensed, strict=True) if there]


def _this_one(cause: Cause, answer: ChannelAnswer, event: Event, count: int) -> bool:
    if event.edge:
        rate = cause.parameters.get(f"rate edge {event.edge}")
        alone = cause.parameters["rate"] if event.edge == 1 else None
        shown = rate or alone
        return shown is not None and shown.low > 0
    if event.term == "hard_spot":
        true = float(event.first), float(min(event.last, count))
        return any(overlap([one], true, step=1.0) >= OVERLAPS for one in answer.where.intervals)
    return True


def event_outcome(
    event: Event, decidable: int | None, seen: dict[int, Answers], count: int
) -> EventOutcome:
    """Return when an event was named."""
    named = {at: names_it(now, event, at) for at, now in seen.items() if at >= event.first}
    first = next((at for at, there in named.items() if there), None)
    since = [there for at, there in named.items() if first is not None and at >= first]
    decision = None if decidable is None else decidable + WITHIN
    if decision is not None and decision > count:
        decidable = decision = None
    return EventOutcome(
        name=event.name,
        term=event.term,
        first=event.first,
        decidable=decidable,
        in_time=None if decision is None else named[decision],
        covered=None if decision is None else covers_it(seen[decision], event, decision),
        named=first,
        stays=_always_from(named),
        kept=None if first is None else float(np.mean(since)),
    )


def _always_from(named: dict[int, bool]) -> int | None:
    """Return the first cut from which on all are true, None where the last one is not."""
    found = None
    for at, there in named.items():
        found = (at if found is None else found) if there else None
    return found


# What was invented


def invented(day: Day, seen: dict[int, Answers]) -> Iterator[Invented]:
    """Give every name that no event stands for, once for each component."""
    found: dict[tuple[str, str], list[tuple[int, bool]]] = {}
    for at, now in seen.items():
        for channel, term, others in _wrong(day, now, at):
            begun = {e.term for e in _begun(day, channel, at)}
            found.setdefault((term, channel), []).append((at, bool(begun & set(others))))
    for (term, channel), times in found.items():
        yield Invented(term, channel, times[0][0], len(times), all(double for _, double in times))


def _wrong(day: Day, now: Answers, count: int) -> Iterator[tuple[str, str, Sequence[str]]]:
    """Give component, term and alternatives of each wrong name; runs of harder cuts one by one."""
    for channel, answer in now.items():
        begun = _begun(day, channel, count)
        terms = {event.term for event in begun}
        named = [c for c in answer.missing if c.kind == "missing" and c.term != UNKNOWN]
        for cause in named:
            if cause.term not in terms and cause.term != "hard_spot":
                yield channel, cause.term, cause.alternatives
        true = [(float(e.first), float(e.last)) for e in begun if e.term == "hard_spot"]
        hard = [cause.alternatives for cause in named if cause.term == "hard_spot"]
        for stretch in answer.where.intervals:
            if hard and not any(overlap([stretch], one, step=1.0) > 0.0 for one in true):
                yield channel, "hard_spot", hard[0]


def _begun(day: Day, channel: str, count: int) -> list[Event]:
    """Return the events that act on a component in the first cuts."""
    at = FORCES.index(channel)
    return [event for event in day.events if np.any(event.part[at, :count] != 0.0)]
