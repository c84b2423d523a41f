"""Proof: what is right in a simulation is not called mistuned, whatever else is missing."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from autodb.errors import UnusableInput
from autodb.explain import explain
from autodb.explain.answer import ChannelAnswer
from autodb.proofs.cases.axis.outside import Outside, draw_outside
from autodb.proofs.runs.explain.explain_oracle import oracle_rms
from autodb.records.tables import Recording

RIGHT = 0.005
"""Relative error of an own term up to which the simulation has it right."""


@dataclass(frozen=True)
class AnswerEntry:
    """What an answer says: a term, `missing` or `mistuned`, how surely, and whether it is so."""

    term: str
    kind: str
    confidence: float
    right: bool


@dataclass(frozen=True)
class Answered:
    """A case and its answer; ``left``: error of the corrected channel over the simulation's."""

    seed: int
    kind: str
    outside: bool
    wanted: float
    reached: bool
    tuning: str
    entries: tuple[AnswerEntry, ...] = ()
    left: float | None = None
    refused: str = ""

    def named(self, kind: str, *, right: bool) -> list[AnswerEntry]:
        """Return the entries of a kind that are right or wrong."""
        return [one for one in self.entries if one.kind == kind and one.right == right]


def run_outside(seed: int) -> list[Answered]:
    """Draw the case of a seed, explain it and judge the answer."""
    return [judged_case(draw_outside(seed))]


def judged_case(case: Outside) -> Answered:
    """Return the answer of a case, judged; none where it cannot show as clearly as wanted."""
    about = (case.seed, case.kind, "unknown" in case.terms, case.wanted, case.reached, case.tuning)
    if not case.reached:
        return Answered(*about)
    recording = Recording(Path(f"case-{case.seed}.csv"), case.channels)
    simulation = Recording(Path(f"case-{case.seed}-simulation.csv"), case.simulation)
    try:
        explained = explain(recording, simulation, includes=list(case.includes))
    except UnusableInput as error:
        return Answered(*about, refused=str(error))
    before = oracle_rms(case.simulation["x.current"] - case.truth)
    after = oracle_rms(explained.traces["x.current"].corrected - case.truth)
    return Answered(
        *about,
        entries=judged_entries(case, explained.explanation.channels["x.current"]),
        left=after / before if before > 0.0 else None,
    )


def judged_entries(case: Outside, answer: ChannelAnswer) -> tuple[AnswerEntry, ...]:
    """Return what an answer says, each with whether it is so."""
    return tuple(
        AnswerEntry(
            cause.term,
            cause.kind,
            cause.confidence,
            cause.term in case.terms
            if cause.kind == "missing"
            else bool(np.abs(case.factors.get(cause.term, 1.0) - 1.0) > RIGHT),
        )
        for cause in answer.missing
    )
