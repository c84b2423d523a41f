"""How good is an explanation: are the terms right that it names, and is the channel corrected?"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from autodb.explain.answer import ChannelAnswer, Explained
from autodb.proofs.cases.base.case import UNKNOWN, Case
from autodb.proofs.cases.mill.mill_cases import MillCase
from autodb.proofs.runs.explain.explain_oracle import oracle_rms, oracle_verdict

Interval = tuple[float, float]


@dataclass(frozen=True)
class NamedEntry:
    """An entry of an answer: where it stands, what it names and how surely."""

    channel: str
    term: str
    confidence: float
    alternatives: tuple[str, ...]


@dataclass(frozen=True)
class ScoredCase:
    """A case, what its oracle says, and the answer.

    ``place``: an `axis`, a table of `cuts`, or the waveform of a `mill`.
    ``clarities`` in the order of ``terms``; ``named``: entries of kind `missing`; ``overlap``:
    shared length of stretches over that of both, None without a true one; ``recovery``: rms error
    of the corrected channel over that of the simulation, None without error; ``margin`` and
    ``best_recovery``: the oracle's. Of a case whose effects cannot show as clearly as wanted there
    is no answer. ``refused``: why there is none though it was asked for.
    """

    seed: int
    kind: str
    place: str
    wanted: float
    reached: bool
    tuning: str
    terms: tuple[str, ...]
    clarities: tuple[float, ...]
    margin: float | None
    decidable: bool
    best_recovery: float | None
    named: tuple[NamedEntry, ...] = ()
    overlap: float | None = None
    recovery: float | None = None
    refused: str = ""

    @property
    def found(self) -> frozenset[str]:
        """Terms that are named, `unknown` among them."""
        return frozenset(one.term for one in self.named)

    @property
    def exact(self) -> bool:
        """Say whether the named terms are the hidden ones."""
        return self.found == frozenset(self.terms)

    @property
    def covered(self) -> bool:
        """Say whether each hidden term is named or an alternative."""
        others = {term for one in self.named for term in one.alternatives}
        return frozenset(self.terms) <= self.found | others

    @property
    def wrong(self) -> bool:
        """Say whether a term is named that is not hidden; `unknown` is no name."""
        return bool(self.found - set(self.terms) - {UNKNOWN})

    @property
    def abstained(self) -> bool:
        """Say whether nothing is named, or only `unknown`."""
        return self.found <= {UNKNOWN}


def unanswered(case: Case) -> ScoredCase:
    """Return a case with its truth and the oracle's verdict, before it is explained."""
    judged = oracle_verdict(case)
    return ScoredCase(
        seed=case.seed,
        kind=case.kind,
        place=_place(case),
        wanted=case.wanted,
        reached=case.reached,
        tuning=case.tuning,
        terms=tuple(one.term for one in case.hidden),
        clarities=tuple(one.clarity for one in case.hidden),
        margin=judged.margin,
        decidable=judged.decidable,
        best_recovery=judged.recovery,
    )


def _place(case: Case) -> str:
    if isinstance(case, MillCase):
        return "mill"
    return "cuts" if case.table else "axis"


def answer_entries(answers: Mapping[str, ChannelAnswer]) -> tuple[NamedEntry, ...]:
    """Return what an answer says is missing, in every channel."""
    return tuple(
        NamedEntry(channel, cause.term, cause.confidence, cause.alternatives)
        for channel, answer in answers.items()
        for cause in answer.missing
        if cause.kind == "missing"
    )


def stretches(answers: Mapping[str, ChannelAnswer]) -> list[Interval]:
    """Return every stretch that an answer confines a mismatch to."""
    return [stretch for answer in answers.values() for stretch in answer.where.intervals]


def overlap(given: Sequence[Interval], true: Interval, *, step: float) -> float:
    """Return the length that stretches share with the true one over the length of them together.

    ``step``: what a stretch is longer than the difference of its ends; 1 of cut numbers, 0 of s.
    """
    if not given:
        return 0.0
    ends = np.unique([*(end for a, b in given for end in (a, b + step)), true[0], true[1] + step])
    middles, lengths = 0.5 * (ends[1:] + ends[:-1]), np.diff(ends)
    ours = np.any([(a < middles) & (middles < b + step) for a, b in given], axis=0)
    theirs = (true[0] < middles) & (middles < true[1] + step)
    return float(np.sum(lengths[ours & theirs]) / np.sum(lengths[ours | theirs]))


def answer_recovery(case: Case, explained: Explained) -> float | None:
    """Return the error of the corrected channels over the simulation's; None where it has none."""
    before = oracle_rms(case.simulated - case.truth)
    if before == 0.0:
        return None
    traces = [explained.traces[name].corrected for name in case.explained]
    corrected = np.reshape(np.array(traces), case.truth.shape)
    return oracle_rms(corrected - case.truth) / before


def brier(pairs: Iterable[tuple[float, bool]]) -> float:
    """Return the mean squared difference of confidence and rightness (Brier 1950)."""
    return float(np.mean([(confidence - right) ** 2 for confidence, right in pairs]))


def confidences(scored: Iterable[ScoredCase]) -> list[tuple[float, bool]]:
    """Return confidence and rightness of every entry that names a term or `unknown`."""
    return [(n.confidence, n.term in one.terms) for one in scored for n in one.named]


def reliability(
    pairs: Sequence[tuple[float, bool]], *, least: int = 100
) -> list[tuple[int, float, float]]:
    """Return bins of at least ``least`` answers in the order of confidence.

    Each: how many, their mean confidence, the share of them that is right. The last takes the rest.
    """
    ordered = np.array(sorted(pairs), dtype=np.float64).reshape(-1, 2)
    count = max(len(ordered) // least, 1)
    parts = np.array_split(ordered, count)
    return [(len(p), float(np.mean(p[:, 0])), float(np.mean(p[:, 1]))) for p in parts if len(p)]
