"""How good is an answer: are its names right, how much is corrected, is it a false alarm?"""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from autodb.proofs.cases.base.case import UNKNOWN, Array, Case
from autodb.proofs.catalogue import proof
from autodb.proofs.runs.explain.explain_oracle import oracle_rms
from autodb.proofs.runs.explain.explain_score import ScoredCase, unanswered
from autodb.proofs.runs.run_file import Origin
from benchmarks.peers.problem import Answer

READ_FROM = 0.05
"""Share of the correction from which on a part of it is read."""
ALARM = 0.1
"""Share of the noise that a correction of nothing may have."""
RECOVERED = 0.5


@dataclass(frozen=True)
class Score:
    """What a method made of a case.

    ``hidden`` and ``named``: terms; ``written``: how many pieces; ``left``: error after over that
    before, None where the simulation has none; ``alarm``: of a case with nothing hidden, whether
    something was found; ``origin``: program and generator, ``version``: package of the method;
    ``failed``: why there is no answer, `time` where it took too long.
    """

    seed: int
    method: str
    kind: str
    table: bool
    decidable: bool
    hidden: tuple[str, ...]
    named: tuple[str, ...]
    written: int
    left: float | None
    alarm: bool
    seconds: float
    origin: Origin
    version: str
    failed: str = ""

    @property
    def exact(self) -> bool:
        """Say whether the named terms are the hidden ones."""
        return set(self.named) == set(self.hidden)

    @property
    def wrong(self) -> bool:
        """Say whether a term is named that is not hidden; `unknown` is no name."""
        return bool(set(self.named) - set(self.hidden) - {UNKNOWN})

    @property
    def recovered(self) -> bool:
        """Say whether at most half of the error is left."""
        return self.left is not None and self.left <= RECOVERED


def scored(case: Case, method: str, answer: Answer, *, seconds: float, version: str) -> Score:
    """Score an answer against the truth of its case."""
    named = names(answer, case.includes)
    return _score(
        unanswered(case),
        method,
        named=named,
        written=len(answer.parts),
        left=left(case, answer.correction),
        alarm=not case.hidden and (bool(named) or structure(case, answer.correction) > ALARM),
        seconds=seconds,
        version=version,
        failed="",
    )


def unscored(case: Case, method: str, *, seconds: float, why: str) -> Score:
    """Score no answer: nothing is named, nothing corrected."""
    nothing = left(case, np.zeros_like(case.measured))
    return _score(
        unanswered(case), method, named=(), written=0, left=nothing, alarm=False,
        seconds=seconds, version="", failed=why,
    )  # fmt: skip


def _score(
    truth: ScoredCase,
    method: str,
    *,
    named: tuple[str, ...],
    written: int,
    left: float | None,
    alarm: bool,
    seconds: float,
    version: str,
    failed: str,
) -> Score:
    return Score(
        seed=truth.seed,
        method=method,
        kind=truth.kind,
        table=truth.place == "cuts",
        decidable=truth.decidable,
        hidden=truth.terms,
        named=named,
        written=written,
        left=left,
        alarm=alarm,
        seconds=seconds,
        origin=origin(),
        version=version,
        failed=failed,
    )


@cache
def origin() -> Origin:
    """Return the version of autodb, and digests of the generator and of the program."""
    return replace(proof("explain").origin(), proof="peers")


def names(answer: Answer, includes: tuple[str, ...]) -> tuple[str, ...]:
    """Return the terms that a reader reads as missing: of some share, not in the simulation."""
    read = {part.term for part in answer.parts if part.term and part.share >= READ_FROM}
    return tuple(sorted(read - set(includes)))


def left(case: Case, correction: Array) -> float | None:
    """Return rms(corrected - truth)/rms(simulation - truth), None where the latter is none."""
    before = oracle_rms(case.simulated - case.truth)
    if before == 0.0:
        return None
    corrected = case.simulated + correction.reshape(case.truth.shape)
    return oracle_rms(corrected - case.truth) / before


def structure(case: Case, correction: Array) -> float:
    """Return the rms of what the simulation's own terms cannot follow of a correction.

    Over the rms of the noise; own terms are fitted to the correction by least squares.
    """
    own = case.own.reshape(len(case.own), -1)
    scaled = (own / np.max(np.abs(own), axis=1, keepdims=True)).T
    flat = correction.ravel()
    follows = scaled @ np.linalg.lstsq(scaled, flat, rcond=None)[0]
    return oracle_rms(flat - follows) / oracle_rms(case.measured - case.truth)
