"""How pairs of three other laws are learnt: width and coverage by group, and plain least squares.

The exact interval of a share counts a pair once (Clopper, Pearson 1934), however many cuts it was
asked for. Differences to least squares are taken pair by pair, on the forces that both foresee;
Wilcoxon's signed ranks (1945), one-sided, adjusted over the rows of each comparison after Holm
(1979, Scand. J. Stat. 6:65).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.runs.found import KeptAsJson, TextTable, passed_words, percent, ratio
from autodb.proofs.runs.pairs.laws_groups import (
    EVERY,
    EVERYWHERE,
    GROUPS,
    INSIDE,
    ROWS,
    PairFigures,
    figures_of_pairs,
)
from autodb.proofs.runs.pairs.laws_run import AUTODB, WAYS, DrawnLaw, ForeseenForce
from autodb.proofs.runs.run_file import Finished, Origin
from autodb.proofs.runs.score import exact_interval

Array = NDArray[np.float64]
Runs = Sequence[Finished[DrawnLaw | ForeseenForce]]

WIDTH_LIMIT = 1.3
"""Width over nominal that intervals inside the range may have."""
HELD_LIMIT = 0.93
WORSE = 0.01
"""Holm-adjusted probability below which a row is worse, and below which all is better."""
PEER_WAYS = WAYS[1:]
OURS_AT = WAYS.index(AUTODB)


@dataclass(frozen=True)
class LawsRow:
    """autodb's figures of a group: medians over pairs of error, half-width (shares of the force)
    and width over nominal (None: as good as without an end); mean share of intervals that held,
    with its exact interval by pairs.
    """

    region: str
    group: str
    pairs: int
    error: float
    half: float | None
    over_nominal: float | None
    share: float
    share_low: float
    share_high: float

    @property
    def passed(self) -> bool:
        """Say whether enough held, and, inside, none too wide."""
        over = self.over_nominal
        narrow = self.region != INSIDE or (over is not None and over <= WIDTH_LIMIT)
        return narrow and self.share >= HELD_LIMIT


@dataclass(frozen=True)
class BesidePeer:
    """A group beside one peer, on the forces that both foresee, autodb's figure and the peer's:
    medians over pairs of the error and of the interval score (mean over a pair's forces).

    ``share``: of the peer's intervals that held.

    ``worse`` and ``better``: probabilities of pairs that differ so if autodb is not, of error and
    score; ``worse`` adjusted.
    """

    region: str
    group: str
    peer: str
    pairs: int
    error: tuple[float, float]
    score: tuple[float | None, float | None]
    share: float
    worse: tuple[float, float]
    better: tuple[float, float]

    @property
    def pooled(self) -> bool:
        """Say whether it is the row of all forces, where autodb must be better."""
        return self.region == EVERYWHERE

    @property
    def passed(self) -> bool:
        """Say whether autodb is not worse; of all forces, whether it is better."""
        if self.pooled:
            return max(self.better) < WORSE
        return min(self.worse) >= WORSE


@dataclass(frozen=True)
class LawsSummary(KeptAsJson):
    """The score of a proof of pairs of other laws."""

    origin: Origin
    seeds: tuple[int, int]
    rows: tuple[LawsRow, ...]
    beside: tuple[BesidePeer, ...]

    @property
    def passed(self) -> bool:
        """Say whether everything is within its limits."""
        return all(row.passed for row in self.rows) and all(one.passed for one in self.beside)

    def tables(self) -> tuple[TextTable, ...]:
        """Return intervals by group, and what least squares does beside them."""
        return (self._intervals(), self._compared())

    def _intervals(self) -> TextTable:
        heads = (
            "cuts", "forces", ">pairs", ">error", ">half-width",
            f">width × nominal (inside ≤ {WIDTH_LIMIT:g})",
            f">held (≥ {100 * HELD_LIMIT:g} %)", ">exact 95 %, by pairs", "",
        )  # fmt: skip
        rows = tuple(
            (
                one.region, one.group, str(one.pairs), percent(one.error), percent(one.half),
                ratio(one.over_nominal), percent(one.share),
                f"{percent(one.share_low)} to {percent(one.share_high)}", passed_words(one.passed),
            )
            for one in self.rows
        )  # fmt: skip
        return TextTable("Forces of the next cuts, 95 % intervals", heads, rows)

    def _compared(self) -> TextTable:
        heads = (
            "cuts", "forces", ">pairs", ">error", *(f">{peer}" for peer in PEER_WAYS), ">p",
            ">score", *(f">{peer}" for peer in PEER_WAYS), ">p",
            *(f">{peer} held" for peer in PEER_WAYS), "",
        )  # fmt: skip
        groups = dict.fromkeys((one.region, one.group) for one in self.beside)
        rows = tuple(
            _beside_cells([one for one in self.beside if (one.region, one.group) == group])
            for group in groups
        )
        return TextTable(
            "Least squares beside it: p of worse, of all forces of better, the less good of both",
            heads, rows,
        )  # fmt: skip


def _beside_cells(peers: Sequence[BesidePeer]) -> tuple[str, ...]:
    """Return the cells of a group, of which ``peers`` are in the order of PEER_WAYS."""
    first = peers[0]
    return (
        first.region, first.group, str(first.pairs),
        percent(first.error[0]), *(percent(one.error[1]) for one in peers), _chance(peers, 0),
        ratio(first.score[0]), *(ratio(one.score[1]) for one in peers), _chance(peers, 1),
        *(percent(one.share) for one in peers),
        passed_words(all(one.passed for one in peers)),
    )  # fmt: skip


def _chance(peers: Sequence[BesidePeer], which: int) -> str:
    if peers[0].pooled:
        return f"{max(one.better[which] for one in peers):.2g}"
    return f"{min(one.worse[which] for one in peers):.2g}"


def laws_summary_of(runs: Runs, origin: Origin) -> LawsSummary:
    """Return the score of finished runs in the order of their seeds."""
    pairs = [(r, g, figures_of_pairs(runs, r, belongs)) for r, g, belongs in ROWS]
    there = [one for one in pairs if one[2]]
    pooled = figures_of_pairs(runs, EVERYWHERE, GROUPS[EVERY])
    compared = (*there, (EVERYWHERE, EVERY, pooled))
    beside = tuple(
        row for peer in PEER_WAYS for row in _adjusted([_beside(*one, peer) for one in compared])
    )
    rows = tuple(_row(*one) for one in there)
    return LawsSummary(origin, (runs[0].seed, runs[-1].seed), rows, beside)


def _row(region: str, group: str, pairs: Sequence[PairFigures]) -> LawsRow:
    def over_pairs(values: Sequence[Array]) -> float:
        return float(np.median([np.median(one) for one in values]))

    half = over_pairs([one.half[:, OURS_AT] for one in pairs])
    over = over_pairs([one.half[:, OURS_AT] / one.nominal for one in pairs])

    share = float(np.mean([one.held[:, OURS_AT].mean() for one in pairs]))
    low, high = exact_interval(share * len(pairs), len(pairs))
    return LawsRow(
        region=region,
        group=group,
        pairs=len(pairs),
        error=over_pairs([one.error[:, OURS_AT] for one in pairs]),
        half=_finite(half),
        over_nominal=_finite(over),
        share=share,
        share_low=low,
        share_high=high,
    )


def _beside(region: str, group: str, pairs: Sequence[PairFigures], peer: str) -> BesidePeer | None:
    """Return a group beside a peer; None where the peer foresees none of its forces."""
    at = WAYS.index(peer)
    both = [(one, np.isfinite(one.error[:, at])) for one in pairs]
    both = [(one, told) for one, told in both if told.any()]
    if not both:
        return None
    ways = (OURS_AT, at)
    error = np.array([np.median(one.error[told][:, ways], axis=0) for one, told in both])
    score = np.array([np.mean(one.score[told][:, ways], axis=0) for one, told in both])
    apart = [values[:, 0] - values[:, 1] for values in (error, score)]
    ours, theirs = np.median(error, axis=0).tolist()
    return BesidePeer(
        region=region,
        group=group,
        peer=peer,
        pairs=len(both),
        error=(ours, theirs),
        score=(_finite(np.median(score[:, 0])), _finite(np.median(score[:, 1]))),
        share=float(np.mean([one.held[told, at].mean() for one, told in both])),
        worse=(_signed_ranks(apart[0]), _signed_ranks(apart[1])),
        better=(_signed_ranks(-apart[0]), _signed_ranks(-apart[1])),
    )


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _signed_ranks(apart: Array) -> float:
    """Return how probable so large differences are where they are as often below nought."""
    from scipy.stats import wilcoxon

    some = apart[apart != 0.0]
    if not len(some):
        return 1.0
    return float(wilcoxon(some, alternative="greater").pvalue)


def _adjusted(rows: Sequence[BesidePeer | None]) -> list[BesidePeer]:
    """Return the rows that there are, with ``worse`` adjusted over those that are not pooled."""
    there = [one for one in rows if one is not None]
    tried = [k for k, one in enumerate(there) if not one.pooled]
    for which in range(2):
        found = holm_adjusted(np.array([there[k].worse[which] for k in tried]))
        for k, worse in zip(tried, found.tolist(), strict=True):
            both = list(there[k].worse)
            both[which] = worse
            there[k] = replace(there[k], worse=(both[0], both[1]))
    return there


def holm_adjusted(p: Array) -> Array:
    """Return probabilities (n,) adjusted for that they are n: step-down after Holm 1979."""
    order = np.argsort(p)
    times = np.arange(len(p), 0, -1)
    stepped = np.minimum(np.maximum.accumulate(p[order] * times), 1.0)
    adjusted = np.empty_like(stepped)
    adjusted[order] = stepped
    return adjusted
