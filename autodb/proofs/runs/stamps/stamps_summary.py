"""What the proof of stamps found: by kind, how many are answered, how far off, how many wrongly."""

import hashlib
import re
from collections.abc import Sequence
from dataclasses import dataclass

from autodb.proofs.runs.explain.explain_summary import LIMIT_HEADS, Limit
from autodb.proofs.runs.found import KeptAsJson, TextTable, percent
from autodb.proofs.runs.run_file import Finished, Origin
from autodb.proofs.runs.score import exact_interval
from autodb.proofs.runs.stamps.stamps_run import JudgedAnswer, JudgedStamps

KIND_HEADS = (
    "stamps", ">n", ">refused", ">answered", ">worst error", ">explain same", ">fewer", ">refused",
    ">wrong", ">silently wrong", ">broken",
)  # fmt: skip
SAID_HEADS = ("stamps", "said of the first recording")
FILE = re.compile(r"^(time: |autodb: )?recording\.csv: (t: )?")
ALL = "all"
TWINS = "even twins of all"


@dataclass(frozen=True)
class KindRow:
    """One kind: how many recordings, how many of them refused, and so on; the worst error in %.

    ``not_given``: answered with exit 0, without a coefficient that was asked for. ``said``: of the
    first of them, what was done about its stamps or why it was refused.
    """

    name: str
    n: int
    refused: int
    worst: float | None
    not_given: int
    same: int
    fewer: int
    unexplained: int
    misnamed: int
    silently_wrong: int
    broken: int
    said: str = ""

    def cells(self) -> tuple[str, ...]:
        """Return the row of a table under KIND_HEADS."""
        worst = "" if self.worst is None else f"{self.worst:.2f} %"
        if self.not_given:
            worst = f"{worst}{', ' if worst else ''}none in {self.not_given}"
        counts = (self.same, self.fewer, self.unexplained, self.misnamed, self.silently_wrong,
                  self.broken)  # fmt: skip
        answered = percent(1.0 - self.refused / self.n)
        return (self.name, str(self.n), str(self.refused), answered, worst, *map(str, counts))


@dataclass(frozen=True)
class StampsSummary(KeptAsJson):
    """The score; ``numbers``: digest of every number of the answers to even twins.

    Of two programs that answer the same to even recordings it is equal.
    """

    origin: Origin
    seeds: tuple[int, int]
    limits: tuple[Limit, ...]
    rows: tuple[KindRow, ...]
    numbers: str

    @property
    def passed(self) -> bool:
        """Say whether nothing is silently wrong or broken, and no even recording is refused."""
        return all(one.passed for one in self.limits)

    def tables(self) -> tuple[TextTable, ...]:
        """Return limits, kinds, and what was said of them."""
        return (
            TextTable("Limits", LIMIT_HEADS, tuple(one.cells() for one in self.limits)),
            TextTable(
                f"Kinds of stamps (numbers of the even twins: {self.numbers})",
                KIND_HEADS,
                tuple(one.cells() for one in self.rows),
            ),
            TextTable(
                "What is done about them",
                SAID_HEADS,
                tuple((one.name, one.said) for one in self.rows if one.said),
            ),
        )


def stamps_summary_of(runs: Sequence[Finished[JudgedStamps]], origin: Origin) -> StampsSummary:
    """Return the score of finished runs in the order of their seeds."""
    every = [one for run in runs for one in run.judged]
    stamped, twins = [one.stamped for one in every], [one.twin for one in every]
    plain = [*(one.stamped for one in every if one.plain), *twins]
    kinds = dict.fromkeys(one.kind for one in every)
    by_kind = (_row(kind, [one.stamped for one in every if one.kind == kind]) for kind in kinds)
    return StampsSummary(
        origin=origin,
        seeds=(runs[0].seed, runs[-1].seed),
        limits=(
            _none("silently wrong", [one.silently_wrong for one in stamped]),
            _none("neither answered nor refused in one line", [one.broken for one in stamped]),
            _none("even stamps refused", [_refused(one) for one in plain]),
            _none("even stamps answered wrongly", [one.off for one in plain]),
        ),
        rows=(*by_kind, _row(ALL, stamped), _row(TWINS, twins)),
        numbers=hashlib.sha256("".join(one.numbers for one in twins).encode()).hexdigest()[:16],
    )


def _refused(one: JudgedAnswer) -> bool:
    return "refused" in (one.identified, one.explained)


def _none(name: str, found: Sequence[bool]) -> Limit:
    """Return the limit of what must never be, with the exact interval of its share."""
    low, high = exact_interval(sum(found), len(found)) if found else (0.0, 1.0)
    return Limit(name, len(found), sum(found), low, high, at_least=False, limit=0.0)


def _row(name: str, answers: Sequence[JudgedAnswer]) -> KindRow:
    answered = [one for one in answers if one.identified == "answered"]
    errors = [abs(error) for one in answered for error in one.errors if error is not None]
    explained = [one.explained for one in answers]
    return KindRow(
        name=name,
        n=len(answers),
        refused=sum(one.identified == "refused" for one in answers),
        worst=max(errors, default=None),
        not_given=sum(None in one.errors for one in answered),
        same=explained.count("same"),
        fewer=explained.count("fewer"),
        unexplained=explained.count("refused"),
        misnamed=explained.count("wrong"),
        silently_wrong=sum(one.silently_wrong for one in answers),
        broken=sum(one.broken for one in answers),
        said="" if name in (ALL, TWINS) else FILE.sub("", answers[0].said),
    )
