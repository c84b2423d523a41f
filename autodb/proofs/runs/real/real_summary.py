"""What the proof on real axes found: limits, by machine and term, nulls, other methods."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Self

from autodb.proofs.runs.found import Check, CheckedScore, TextTable, percent, ratio
from autodb.proofs.runs.real.real_rows import (
    GROUP_HEADS,
    NULL_HEADS,
    OURS,
    PEER_HEADS,
    NullGroup,
    PeerGroup,
    RealGroup,
    grouped,
    null_group,
    peer_group,
    real_group,
)
from autodb.proofs.runs.real.real_score import JudgedReal
from autodb.proofs.runs.run_file import Finished, Origin
from autodb.proofs.runs.score import exact_interval

SHOWN_NAMED = 0.95
LOW_NAMED, HIGH_WRONG = 0.85, 0.05
"""What the lower and the upper end of the exact 95 % intervals must be."""
MEDIAN_FIT = 1.05
SURE_RIGHT = 0.90
STRONG_NAMED, STRONG_WRONG, STRONG_FALSE, STRONG_SIZE = 0.90, 0.03, 0.02, 0.15
COUNT_HEADS = ("cases", ">all", ">asked", ">decidable", ">another name as good", ">not seen")


@dataclass(frozen=True)
class KindCount:
    """How many cases of a kind there are, and of how many the effect shows, or can be told."""

    name: str
    cases: int
    asked: int
    decidable: int

    def cells(self) -> tuple[str, ...]:
        """Return the row of a table under COUNT_HEADS."""
        return (
            self.name, str(self.cases), str(self.asked), str(self.decidable),
            str(self.asked - self.decidable), str(self.cases - self.asked),
        )  # fmt: skip


@dataclass(frozen=True)
class RealSummary(CheckedScore):
    """The score: every figure that has a limit, and the rows of the tables.

    ``sure`` and ``sure_right`` count entries at 0.9 or more. Groups are of decidable cases, but for
    that of cases in which another name is as good.
    """

    origin: Origin
    seeds: tuple[int, int]
    counts: tuple[KindCount, ...]
    shown: RealGroup
    real: RealGroup
    injected: RealGroup
    both: RealGroup
    strong: RealGroup
    others: RealGroup
    machines: tuple[RealGroup, ...]
    recordings: tuple[RealGroup, ...]
    terms: tuple[RealGroup, ...]
    tunings: tuple[RealGroup, ...]
    nulls: NullGroup
    null_rows: tuple[NullGroup, ...]
    harmed: int
    sure: int
    sure_right: int
    peers: tuple[PeerGroup, ...]
    errors: tuple[tuple[str, int], ...]

    def checks(self) -> list[Check]:
        """Return every limit: what it is, what it must be, whether it is."""
        every = self.both.cases + self.others.cases + self.nulls.cases
        fit, size = self.both.fit, self.strong.size_off
        false, twins = self.strong.false, self.strong.twins
        return [
            at_least("shown: named", self.shown.named, self.shown.cases, SHOWN_NAMED),
            at_most("shown: wrong", self.shown.wrong, self.shown.cases, 0.0),
            _lower("real and injected: named", self.both.named, self.both.cases),
            _upper("real and injected: wrong", self.both.wrong, self.both.cases),
            at_most("harmed", self.harmed, every, 0.0),
            ("held-out error / full model's, median", ratio(fit), f"≤ {MEDIAN_FIT:g}",
             fit is not None and fit <= MEDIAN_FIT),
            at_least("nulls: own terms within 30 %", self.nulls.own_ok, self.nulls.cases, 1.0),
            at_least("entries at 0.9 or more: right", self.sure_right, self.sure, SURE_RIGHT),
            at_least("injected, strong: named", self.strong.named, self.strong.cases, STRONG_NAMED),
            at_most("injected, strong: wrong", self.strong.wrong, self.strong.cases, STRONG_WRONG),
            at_most("injected, strong: named without it too", false, twins, STRONG_FALSE),
            ("injected, strong: size off, median", percent(size), f"≤ {percent(STRONG_SIZE)}",
             size is not None and size <= STRONG_SIZE),
        ]  # fmt: skip

    def tables(self) -> tuple[TextTable, ...]:
        """Return limits, counts, groups, nulls, peers, errors."""
        whole = (self.shown, self.real, self.injected, self.strong, self.both, self.others)
        return (
            self.limits("Limits"),
            TextTable("Cases", COUNT_HEADS, tuple(one.cells() for one in self.counts)),
            _groups("Cases with an effect", whole),
            _groups("By machine", self.machines),
            _groups("By recording", self.recordings),
            _groups("By term", self.terms),
            _groups("By strength and tuning", self.tunings),
            TextTable(
                "Nothing missing",
                NULL_HEADS,
                tuple(one.cells() for one in (self.nulls, *self.null_rows)),
            ),
            TextTable("Other methods", PEER_HEADS, tuple(one.cells() for one in self.peers)),
            TextTable(
                "No answer", ("said", ">cases"), tuple((said, str(n)) for said, n in self.errors)
            ),
        )

    @classmethod
    def of(cls, every: Sequence[JudgedReal], origin: Origin, seeds: tuple[int, int]) -> Self:
        """Sum up judged cases."""
        asked = [one for one in every if one.asked]
        nulls = [one for one in asked if one.null]
        clear = [one for one in asked if not one.null and one.decidable]
        real = [one for one in clear if one.kind != "injected"]
        injected = [one for one in clear if one.kind == "injected"]
        sure = [right for one in asked if not one.null for _, right in one.sure]
        return cls(
            origin,
            seeds,
            tuple(_count(kind, own) for kind, own in grouped(every, lambda o: o.kind).items()),
            shown=real_group("shown", [one for one in real if one.kind == "shown"]),
            real=real_group("shown and left out", real),
            injected=real_group("injected", injected),
            both=real_group("real and injected", clear),
            strong=real_group("injected, strong", [o for o in injected if o.strength == "strong"]),
            others=real_group(
                "another name is as good", [o for o in asked if not o.null and not o.decidable]
            ),
            machines=_by(clear, lambda one: one.machine),
            recordings=_by(clear, lambda one: one.recording),
            terms=_by(clear, lambda one: one.term),
            tunings=_by(clear, lambda one: f"{one.kind}, {one.strength or 'whole'}, {one.tuning}"),
            nulls=null_group("all", nulls),
            null_rows=tuple(
                null_group(name, own) for name, own in grouped(nulls, lambda o: o.machine).items()
            ),
            harmed=sum(one.harm for one in asked),
            sure=len(sure),
            sure_right=sum(sure),
            peers=tuple(peer_group(name, clear, nulls) for name in (OURS, *_peers_of(asked))),
            errors=_errors(asked),
        )


def real_summary_of(runs: Sequence[Finished[JudgedReal]], origin: Origin) -> RealSummary:
    """Return the score of finished runs in the order of their seeds."""
    every = [one for run in runs for one in run.judged]
    return RealSummary.of(every, origin, (runs[0].seed, runs[-1].seed))


def _peers_of(asked: Sequence[JudgedReal]) -> tuple[str, ...]:
    return tuple(next((one.peers for one in asked if one.peers), {}))


def _count(name: str, cases: Sequence[JudgedReal]) -> KindCount:
    asked = [one for one in cases if one.asked]
    return KindCount(name, len(cases), len(asked), sum(one.decidable for one in asked))


def _by(cases: Sequence[JudgedReal], key: Callable[[JudgedReal], str]) -> tuple[RealGroup, ...]:
    return tuple(real_group(name, own) for name, own in grouped(cases, key).items())


def _groups(title: str, rows: Sequence[RealGroup]) -> TextTable:
    return TextTable(title, GROUP_HEADS, tuple(one.cells() for one in rows))


def _errors(asked: Sequence[JudgedReal]) -> tuple[tuple[str, int], ...]:
    said = grouped([one for one in asked if one.error], lambda one: one.error)
    return tuple((error, len(own)) for error, own in said.items())


def _found(count: int, cases: int) -> str:
    return f"{count} of {cases}" if cases else "no case"


def at_least(name: str, count: int, cases: int, share: float) -> Check:
    """Return the limit that a share of cases is at least so large."""
    passed = cases > 0 and count >= share * cases
    return name, _found(count, cases), f"≥ {100.0 * share:g} %", passed


def at_most(name: str, count: int, cases: int, share: float) -> Check:
    """Return the limit that a share of cases is at most so large."""
    passed = cases > 0 and count <= share * cases
    return name, _found(count, cases), f"≤ {100.0 * share:g} %", passed


def _lower(name: str, count: int, cases: int) -> Check:
    low = exact_interval(count, cases)[0] if cases else 0.0
    found = f"{_found(count, cases)}, 95 % limit {percent(low)}"
    return name, found, f"limit ≥ {100.0 * LOW_NAMED:g} %", low >= LOW_NAMED


def _upper(name: str, count: int, cases: int) -> Check:
    high = exact_interval(count, cases)[1] if cases else 1.0
    found = f"{_found(count, cases)}, 95 % limit {percent(high)}"
    return name, found, f"limit ≤ {100.0 * HIGH_WRONG:g} %", high <= HIGH_WRONG
