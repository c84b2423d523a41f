"""Rows of the tables of real axes: cases by machine, by term and by kind, and what peers said."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from autodb.proofs.runs.found import percent, ratio
from autodb.proofs.runs.real.real_answers import NAMED_FROM, NO_NAME
from autodb.proofs.runs.real.real_score import JudgedReal, PeerScore
from autodb.proofs.runs.score import exact_interval

GROUP_HEADS = (
    "", ">cases", ">named", ">exact 95 %", ">size within 25 %", ">wrong", ">exact 95 %", ">harmed",
    ">held-out / full", ">size off", ">false", ">of which idle", ">errors",
    ">s",
)  # fmt: skip
NULL_HEADS = (
    "nulls", ">cases", ">no harm, own terms within 30 %", ">own terms within 30 %", ">idle names",
    ">harmed", ">held-out / full", ">errors", ">s",
)  # fmt: skip
PEER_HEADS = (
    "", ">cases", ">named", ">wrong", ">held-out / full", ">nulls", ">nulls without a name",
)  # fmt: skip
OURS = "autodb explain"


@dataclass(frozen=True)
class RealGroup:
    """Cases with an effect: counts of ``cases``, medians of the held-out ratio and of the size.

    ``size_off``: median of |size/true − 1| where the concealed name is named; ``false`` counts of
    ``twins`` that were answered, ``false_idle`` of those that do no work there (None: not asked).
    """

    name: str
    cases: int
    named: int
    hit: int
    wrong: int
    harmed: int
    fit: float | None
    size_off: float | None
    false: int
    twins: int
    errors: int
    seconds: float
    false_idle: int | None = None

    def cells(self) -> tuple[str, ...]:
        """Return the row of a table under GROUP_HEADS."""
        return (
            self.name, str(self.cases), share_of(self.named, self.cases),
            interval_of(self.named, self.cases), share_of(self.hit, self.cases),
            share_of(self.wrong, self.cases), interval_of(self.wrong, self.cases),
            str(self.harmed), ratio(self.fit), percent(self.size_off),
            share_of(self.false, self.twins),
            "" if self.false_idle is None else str(self.false_idle), str(self.errors),
            f"{self.seconds:.1f}",
        )  # fmt: skip


@dataclass(frozen=True)
class NullGroup:
    """Nulls: counts of ``cases``; ``idle`` of them have a sure name that does no work."""

    name: str
    cases: int
    null_ok: int
    own_ok: int
    idle: int
    harmed: int
    fit: float | None
    errors: int
    seconds: float

    def cells(self) -> tuple[str, ...]:
        """Return the row of a table under NULL_HEADS."""
        return (
            self.name, str(self.cases), share_of(self.null_ok, self.cases),
            share_of(self.own_ok, self.cases), str(self.idle), str(self.harmed), ratio(self.fit),
            str(self.errors), f"{self.seconds:.1f}",
        )  # fmt: skip


@dataclass(frozen=True)
class PeerGroup:
    """One method on cases with an effect and on nulls."""

    name: str
    cases: int
    named: int
    wrong: int
    fit: float | None
    nulls: int
    silent: int

    def cells(self) -> tuple[str, ...]:
        """Return the row of a table under PEER_HEADS."""
        return (
            self.name, str(self.cases), share_of(self.named, self.cases),
            share_of(self.wrong, self.cases), ratio(self.fit), str(self.nulls),
            share_of(self.silent, self.nulls),
        )  # fmt: skip


def share_of(count: int, cases: int) -> str:
    """Return a share as a cell has it; nothing of no case."""
    return percent(count / cases) if cases else ""


def interval_of(count: int, cases: int) -> str:
    """Return the exact 95 % interval of a share as a cell has it; nothing of no case."""
    if not cases:
        return ""
    low, high = exact_interval(count, cases)
    return f"{percent(low)} to {percent(high)}"


def median_of(values: Sequence[float | None]) -> float | None:
    """Return the median of what is known, None of nothing."""
    known = [value for value in values if value is not None]
    return float(np.median(known)) if known else None


def size_off(one: JudgedReal) -> float | None:
    """Return by what share the size of a concealed name is off, None where it is not named."""
    return None if one.size_ratio is None else abs(one.size_ratio - 1.0)


def real_group(name: str, cases: Sequence[JudgedReal]) -> RealGroup:
    """Sum up cases with an effect; one without an answer names nothing."""
    twins = [one for one in cases if one.false_name is not None]
    return RealGroup(
        name, len(cases), sum(one.named for one in cases), sum(one.hit for one in cases),
        sum(one.wrong for one in cases), sum(one.harm for one in cases),
        median_of([one.fit for one in cases]), median_of([size_off(one) for one in cases]),
        sum(bool(one.false_name) for one in twins), len(twins),
        sum(bool(one.error) for one in cases), median_of([one.seconds for one in cases]) or 0.0,
        _idle_of([one for one in twins if one.false_name]),
    )  # fmt: skip


def _idle_of(false: Sequence[JudgedReal]) -> int | None:
    """Return how many false names do no work; None where that was not asked."""
    if any(one.false_idle is None for one in false):
        return None
    return sum(bool(one.false_idle) for one in false)


def null_group(name: str, cases: Sequence[JudgedReal]) -> NullGroup:
    """Sum up nulls; one without an answer is not right."""
    return NullGroup(
        name, len(cases), sum(one.null_ok for one in cases), sum(one.own_ok for one in cases),
        sum(bool(one.idle) for one in cases), sum(one.harm for one in cases),
        median_of([one.fit for one in cases]), sum(bool(one.error) for one in cases),
        median_of([one.seconds for one in cases]) or 0.0,
    )  # fmt: skip


def peer_group(name: str, cases: Sequence[JudgedReal], nulls: Sequence[JudgedReal]) -> PeerGroup:
    """Sum up what a method said of decidable cases and of nulls."""
    said = [_peer(name, one) for one in cases]
    silent = [_peer(name, one) for one in nulls]
    return PeerGroup(
        name, len(said), sum(one.named for one in said), sum(one.wrong for one in said),
        median_of([one.fit for one in said]), len(silent), sum(one.silent for one in silent),
    )  # fmt: skip


def _peer(name: str, one: JudgedReal) -> PeerScore:
    """Return a method's score of a case; for the command's own see what was judged of it."""
    if name == OURS:
        silent = not one.error and not any(map(_is_name, one.said))
        return PeerScore(one.said, one.named, one.wrong, silent, one.fit)
    return (one.peers or {})[name]


def _is_name(said: str) -> bool:
    """Say whether an entry as it is kept, `TERM:SIZE(CONFIDENCE)`, names a term as missing."""
    term, _, rest = said.partition(":")
    sure = float(rest.rpartition("(")[2].rstrip(")"))
    return sure >= NAMED_FROM and term != NO_NAME and not term.endswith("(mistuned)")


def grouped(
    cases: Sequence[JudgedReal], key: Callable[[JudgedReal], str]
) -> dict[str, list[JudgedReal]]:
    """Return cases by a key, in the order of the keys."""
    found: dict[str, list[JudgedReal]] = {}
    for one in cases:
        found.setdefault(key(one), []).append(one)
    return dict(sorted(found.items()))
