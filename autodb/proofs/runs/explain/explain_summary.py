"""What the proof of explanations found: limits, each effect, confidence, confusion."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from autodb.proofs.runs.explain.explain_score import ScoredCase, brier, confidences, reliability
from autodb.proofs.runs.found import KeptAsJson, TextTable, percent, ratio
from autodb.proofs.runs.run_file import Finished, Origin
from autodb.proofs.runs.score import exact_interval

CLEAR = 8.0  # clarity from which a decidable effect must be found
RECOVERED, OF_BEST = 0.10, 1.5
OVERLAPS = 0.5
NOTHING = "nothing"


@dataclass(frozen=True)
class Limit:
    """A share of cases with its exact 95 % interval, and what it must at least or at most be."""

    name: str
    cases: int
    count: int
    low: float
    high: float
    at_least: bool
    limit: float

    @property
    def share(self) -> float | None:
        """Share of the cases, None without one."""
        return self.count / self.cases if self.cases else None

    @property
    def passed(self) -> bool:
        """Say whether the share is within its limit; without a case nothing is shown."""
        if self.share is None:
            return False
        return self.share >= self.limit if self.at_least else self.share <= self.limit

    def cells(self) -> tuple[str, ...]:
        """Return the row of a table under LIMIT_HEADS."""
        return (
            self.name,
            str(self.cases),
            percent(self.share),
            f"{percent(self.low)} to {percent(self.high)}" if self.cases else "",
            f"{'≥' if self.at_least else '≤'} {100.0 * self.limit:g} %",
            "no case" if not self.cases else "passed" if self.passed else "FAILED",
        )


@dataclass(frozen=True)
class EffectRow:
    """One effect alone, or effects together, at one clarity; shares are None without a case.

    ``exact``: of the decidable; ``covered``: of the undecidable, named or an alternative; ``wrong``
    and ``abstained``: of all. ``dropped``: cases that cannot be as clear as wanted, in no share.
    """

    name: str
    clarity: float
    cases: int
    dropped: int
    decidable: int
    exact: float | None
    covered: float | None
    wrong: float | None
    abstained: float | None
    recovery: float | None
    best_recovery: float | None


@dataclass(frozen=True)
class ExplainSummary(KeptAsJson):
    """The score: ``bins`` are (answers, mean confidence, share right); ``confusion`` counts, for
    each hidden term of clear cases, what was named in its case, and how often."""

    origin: Origin
    seeds: tuple[int, int]
    refused: int
    limits: tuple[Limit, ...]
    effects: tuple[EffectRow, ...]
    answers: int
    brier: float | None
    bins: tuple[tuple[int, float, float], ...]
    confusion: dict[str, dict[str, int]]

    @property
    def passed(self) -> bool:
        """Say whether every share is within its limit."""
        return all(limit.passed for limit in self.limits)

    def tables(self) -> tuple[TextTable, ...]:
        """Return limits, effects, confidence, confusion."""
        return (
            TextTable("Limits", LIMIT_HEADS, tuple(one.cells() for one in self.limits)),
            TextTable("Effects", EFFECT_HEADS, tuple(_effect_cells(one) for one in self.effects)),
            TextTable(
                self._confidence_title, BIN_HEADS, tuple(_bin_cells(one) for one in self.bins)
            ),
            self._confusion(),
        )

    @property
    def _confidence_title(self) -> str:
        score = "no answer" if self.brier is None else f"Brier score {self.brier:.3f}"
        return f"Confidence of {self.answers} answers: {score}"

    def _confusion(self) -> TextTable:
        columns = sorted({name for row in self.confusion.values() for name in row})
        rows = [
            (true, *(str(row[name]) if name in row else "" for name in columns))
            for true, row in sorted(self.confusion.items())
        ]
        heads = ("hidden", *(f">{name}" for name in columns))
        return TextTable("Hidden terms and named ones, clear cases", heads, tuple(rows))


LIMIT_HEADS = ("", ">cases", ">share", ">exact 95 %", ">must be", "")
EFFECT_HEADS = (
    "hidden", ">d", ">cases", ">dropped", ">decidable", ">exact set", ">undecidable: covered",
    ">wrong", ">abstained", ">error left", ">oracle's",
)  # fmt: skip
BIN_HEADS = (">answers", ">mean confidence", ">right")


def explain_summary_of(runs: Sequence[Finished[ScoredCase]], origin: Origin) -> ExplainSummary:
    """Return the score of finished runs in the order of their seeds."""
    every = [one for run in runs for one in run.judged]
    asked = [one for one in every if one.reached]
    pairs = confidences(asked)
    return ExplainSummary(
        origin=origin,
        seeds=(runs[0].seed, runs[-1].seed),
        refused=sum(bool(one.refused) for one in asked),
        limits=limited_shares(asked),
        effects=effects(every),
        answers=len(pairs),
        brier=brier(pairs) if pairs else None,
        bins=tuple(reliability(pairs)),
        confusion=confusion(asked),
    )


def limited_shares(asked: Sequence[ScoredCase]) -> tuple[Limit, ...]:
    """Return every share that has a limit, of cases that were as clear as wanted."""
    hidden = [one for one in asked if one.terms]
    clear = [one for one in hidden if one.wanted >= CLEAR and one.decidable]
    vague = [one for one in hidden if one.wanted >= CLEAR and not one.decidable]
    faint = [one for one in hidden if one.wanted < CLEAR]
    nothing = [one for one in asked if not one.terms]
    placed = [one for one in clear if one.overlap is not None]
    return (
        _limit("decidable, d ≥ 8: exactly the hidden terms", clear, lambda o: o.exact, 0.95),
        _limit("undecidable, d ≥ 8: named or an alternative", vague, lambda o: o.covered, 0.95),
        _limit("d = 4: a wrong name", faint, lambda o: o.wrong, 0.05, at_least=False),
        _limit("d = 4: no name", faint, lambda o: o.abstained, 0.50, at_least=False),
        _limit("nothing hidden: anything named", nothing, lambda o: bool(o.named), 0.01,
               at_least=False),
        _limit("stretch shares half with the true one", placed, _placed, 0.95),
        _limit("error left ≤ 10 % or 1.5 × the oracle's", clear, recovered, 0.95),
    )  # fmt: skip


def _placed(one: ScoredCase) -> bool:
    return one.overlap is not None and one.overlap >= OVERLAPS


def recovered(one: ScoredCase) -> bool:
    """Say whether the corrected channels are about as near the truth as the oracle's."""
    if one.recovery is None or one.best_recovery is None:
        return False
    return one.recovery <= max(RECOVERED, OF_BEST * one.best_recovery)


def _limit(
    name: str,
    cases: Sequence[ScoredCase],
    counts: Callable[[ScoredCase], bool],
    limit: float,
    *,
    at_least: bool = True,
) -> Limit:
    count = sum(counts(one) for one in cases)
    low, high = exact_interval(count, len(cases)) if cases else (0.0, 1.0)
    return Limit(name, len(cases), count, low, high, at_least, limit)


def effects(every: Sequence[ScoredCase]) -> tuple[EffectRow, ...]:
    """Return a row of each effect alone and of two and three together, at each clarity."""
    groups: dict[tuple[str, float], list[ScoredCase]] = {}
    for one in every:
        if one.terms:
            groups.setdefault((group(one), one.wanted), []).append(one)
    return tuple(_effect(*key, cases) for key, cases in sorted(groups.items()))


def group(one: ScoredCase) -> str:
    """Return where the effect is hidden, and which: a kind alone, or how many together."""
    return f"{one.place}: {one.kind if len(one.terms) == 1 else f'{len(one.terms)} effects'}"


def _effect(name: str, clarity: float, every: Sequence[ScoredCase]) -> EffectRow:
    cases = [one for one in every if one.reached]
    decidable = [one for one in cases if one.decidable]
    return EffectRow(
        name=name,
        clarity=clarity,
        cases=len(cases),
        dropped=len(every) - len(cases),
        decidable=len(decidable),
        exact=_share([one.exact for one in decidable]),
        covered=_share([one.covered for one in cases if not one.decidable]),
        wrong=_share([one.wrong for one in cases]),
        abstained=_share([one.abstained for one in cases]),
        recovery=_median([one.recovery for one in cases]),
        best_recovery=_median([one.best_recovery for one in cases]),
    )


def _share(held: Sequence[bool]) -> float | None:
    return sum(held) / len(held) if held else None


def _median(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.median(known)) if known else None


def confusion(asked: Sequence[ScoredCase]) -> dict[str, dict[str, int]]:
    """Return how often what was named for each hidden term, in decidable cases of d ≥ CLEAR.

    A hidden term that was named counts for itself. One that was not counts for every named term of
    its case that is not hidden, or for `nothing`. Cases without anything hidden: row `nothing`.
    """
    found: dict[str, Counter[str]] = {}
    for one in asked:
        if not one.terms:
            found.setdefault(NOTHING, Counter()).update(one.found or {NOTHING})
        elif one.decidable and one.wanted >= CLEAR:
            others = sorted(one.found - set(one.terms)) or [NOTHING]
            for term in one.terms:
                named = [term] if term in one.found else others
                found.setdefault(term, Counter()).update(named)
    return {term: dict(sorted(counts.items())) for term, counts in found.items()}


def _effect_cells(one: EffectRow) -> tuple[str, ...]:
    shares = (one.exact, one.covered, one.wrong, one.abstained)
    return (
        one.name,
        f"{one.clarity:g}",
        str(one.cases),
        str(one.dropped),
        str(one.decidable),
        *(percent(share) for share in shares),
        ratio(one.recovery),
        ratio(one.best_recovery),
    )


def _bin_cells(one: tuple[int, float, float]) -> tuple[str, ...]:
    answers, confidence, right = one
    return str(answers), f"{confidence:.3f}", percent(right)
