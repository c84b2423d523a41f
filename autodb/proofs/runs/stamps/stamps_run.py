"""Proof: inertia, friction and causes are right, or refused, whatever stamps a logger wrote.

A stamped recording is compared with the truth, and with its even twin: the same moves and noise,
sampled evenly and stamped so.
"""

import time
from dataclasses import dataclass

from autodb.proofs.cases.base import moves
from autodb.proofs.cases.stamps import (
    axis_rows,
    clocks,
    dates,
    joined_runs,
    missing_rows,
    positions,
    programme,
    resolutions,
    stamp_cases,
    stamped,
    time_units,
)
from autodb.proofs.cases.stamps.stamp_cases import StampCase, draw_stamped
from autodb.proofs.runs.stamps.stamp_answers import StampAnswers, answers_to

GENERATOR = (
    axis_rows, clocks, dates, joined_runs, missing_rows, moves, positions, programme, resolutions,
    stamp_cases, stamped, time_units,
)  # fmt: skip
"""All modules that draw recordings."""
WITHIN_PERCENT = 3.0
"""How far off an answer may be. Chosen: even stamps give all three within 1 % in 191 of 200."""
LONGEST_LINE = 300


@dataclass(frozen=True)
class JudgedAnswer:
    """Both answers to a recording, judged.

    ``identified``: answered, refused or broken (neither: a traceback, several lines);
    ``errors``: of inertia, viscous and Coulomb, %, None where no coefficient is given.
    ``explained``: same (as the twin's), fewer (but right), wrong, refused, broken, not asked.
    """

    identified: str
    errors: tuple[float | None, ...]
    explained: str
    causes: tuple[str, ...]
    said: str
    numbers: str

    @property
    def off(self) -> bool:
        """Say whether a coefficient is wrong, or none where no refusal says so."""
        off = (error is None or abs(error) > WITHIN_PERCENT for error in self.errors)
        return self.identified == "answered" and any(off)

    @property
    def silently_wrong(self) -> bool:
        """Say whether anything wrong was answered with exit 0."""
        return self.off or self.explained == "wrong"

    @property
    def broken(self) -> bool:
        """Say whether a command neither answered nor refused in one line."""
        return "broken" in (self.identified, self.explained)


@dataclass(frozen=True)
class JudgedStamps:
    """A recording of one kind and its even twin; ``left_out``: what the simulation lacks."""

    seed: int
    kind: str
    plain: bool
    rate_hz: float
    left_out: str
    stamped: JudgedAnswer
    twin: JudgedAnswer
    seconds: float


def run_stamps(seed: int) -> list[JudgedStamps]:
    """Draw the recording of a seed, ask about it and its twin, and judge both answers."""
    case, begun = draw_stamped(seed), time.perf_counter()
    answers = answers_to(case, case.stamped)
    seconds = time.perf_counter() - begun
    return [judged_stamps(case, answers, answers_to(case, case.twin), seconds)]


def judged_stamps(
    case: StampCase, answers: StampAnswers, twin: StampAnswers, seconds: float
) -> JudgedStamps:
    """Judge the answers to a recording and to its twin, whose own causes are held to the truth."""
    truth = frozenset({case.axis.left_out} - {""})
    return JudgedStamps(
        seed=case.seed,
        kind=case.kind.name,
        plain=case.kind.plain,
        rate_hz=case.axis.rate_hz,
        left_out=case.axis.left_out,
        stamped=_judged(answers, explained_as(answers, twin.causes, truth)),
        twin=_judged(twin, explained_as(twin, truth, truth)),
        seconds=seconds,
    )


def explained_as(answers: StampAnswers, expected: frozenset[str], truth: frozenset[str]) -> str:
    """Return how causes compare with those ``expected``, of which the ``truth`` must be named."""
    if answers.explained is None:
        return "not asked"
    if answers.explained.outcome != "answered":
        return answers.explained.outcome
    if answers.causes == expected:
        return "same"
    invented, unnamed = answers.causes - expected, (truth & expected) - answers.causes
    return "wrong" if invented or unnamed else "fewer"


def _judged(answers: StampAnswers, explained: str) -> JudgedAnswer:
    lines = [one.of_time for one in (answers.identified, answers.explained) if one is not None]
    return JudgedAnswer(
        identified=answers.identified.outcome,
        errors=tuple(answers.errors_percent().values()),
        explained=explained,
        causes=tuple(sorted(answers.causes)),
        said=next((line for line in lines if line), "")[:LONGEST_LINE],
        numbers=answers.numbers,
    )
