"""How good are 95 % intervals: how often they hold the truth, how wide they are, Gneiting's score.

Source of the score: Gneiting, Raftery 2007, Strictly proper scoring rules, prediction, and
estimation, J. Am. Stat. Assoc. 102:359. Of the exact interval of a share: Clopper, Pearson 1934,
Biometrika 26:404.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEVEL = 0.95
Z = 1.959963984540054
"""Standard normal quantile at (1 + LEVEL)/2."""
MANY_RUNS = 2000
COVERAGE = (0.93, 0.97)
"""Limits of the share from MANY_RUNS runs on; for fewer runs the binomial band around LEVEL."""
BAND = 0.999
SCORE_RATIO = 1.2
POOLED = "all quantities"


@dataclass(frozen=True)
class Judged:
    """One quantity of one run: truth, value and interval given (None: none), oracle's interval."""

    name: str
    unit: str
    truth: float
    value: float | None
    low: float | None
    high: float | None
    oracle_low: float
    oracle_high: float

    @property
    def given(self) -> bool:
        """Say whether an interval was given, both ends of it."""
        return self.low is not None and self.high is not None

    @property
    def holds(self) -> bool:
        """Say whether an interval was given and holds the truth."""
        return (
            self.low is not None and self.high is not None and self.low <= self.truth <= self.high
        )


@dataclass(frozen=True)
class QuantityRow:
    """The score of one quantity, or of all; shares are of ``runs``, ratios to the oracle's.

    ``width``: median width in ``unit``; ``width_ratio``: median of the ratios; ``score_ratio``
    as the function says; None where no interval was given. ``limits``: of ``share``.
    """

    name: str
    unit: str
    runs: int
    given: float
    share: float
    share_low: float
    share_high: float
    limits: tuple[float, float]
    oracle_share: float
    width: float | None
    width_ratio: float | None
    score_ratio: float | None

    @property
    def passed(self) -> bool:
        """Say whether share and score are within their limits."""
        low, high = self.limits
        scored = self.score_ratio is not None and self.score_ratio <= SCORE_RATIO
        return low <= self.share <= high and scored


def exact_interval(held: float, runs: int) -> tuple[float, float]:
    """Return the exact 95 % interval of a share that was held in ``held`` of ``runs`` (0..runs)."""
    from scipy.stats import beta

    tail = 0.5 * (1.0 - LEVEL)
    low = float(beta.ppf(tail, held, runs - held + 1)) if held > 0 else 0.0
    high = float(beta.ppf(1.0 - tail, held + 1, runs - held)) if held < runs else 1.0
    return low, high


def binomial_band(runs: int) -> tuple[float, float]:
    """Return the shares between which 99.9 % of proofs of ``runs`` fall whose level is right."""
    from scipy.stats import binom

    low, high = binom.interval(BAND, runs, LEVEL)
    return float(low) / runs, float(high) / runs


def coverage_limits(runs: int) -> tuple[float, float]:
    """Return what a share must lie between: COVERAGE from MANY_RUNS on, else the binomial band."""
    return COVERAGE if runs >= MANY_RUNS else binomial_band(runs)


def interval_score(low: Array, high: Array, truth: Array) -> Array:
    """Return the interval score (n,): width + 2/α · how far the truth is outside, α = 1 − LEVEL.

    In the unit of the quantity; the smaller the better. Source: Gneiting, Raftery 2007.
    """
    outside = np.maximum(low - truth, 0.0) + np.maximum(truth - high, 0.0)
    return np.asarray(high - low + 2.0 / (1.0 - LEVEL) * outside, dtype=np.float64)


def scored_quantities(judged: Sequence[Judged], *, runs: int) -> list[QuantityRow]:
    """Return a row for each quantity in the order of its first appearance, then one for all.

    Quantities of one run share its noise: the row of all counts as ``runs`` observations.
    """
    names = list(dict.fromkeys(one.name for one in judged))
    rows = []
    for name in names:
        own = [one for one in judged if one.name == name]
        rows.append(_row(name, own[0].unit, own, runs=len(own)))
    return [*rows, _row(POOLED, "", judged, runs=runs)]


def _row(name: str, unit: str, judged: Sequence[Judged], *, runs: int) -> QuantityRow:
    """Score intervals; one that was not given does not hold the truth, and has no width."""
    share = float(np.mean([one.holds for one in judged]))
    low, high = exact_interval(share * runs, runs)
    oracle = [one.oracle_low <= one.truth <= one.oracle_high for one in judged]
    given = [one for one in judged if one.given]
    table = np.array(
        [(o.low, o.high, o.truth, o.oracle_low, o.oracle_high) for o in given], dtype=np.float64
    ).reshape(-1, 5)
    widths, best = table[:, 1] - table[:, 0], table[:, 4] - table[:, 3]
    return QuantityRow(
        name=name,
        unit=unit,
        runs=runs,
        given=len(given) / len(judged),
        share=share,
        share_low=low,
        share_high=high,
        limits=coverage_limits(runs),
        oracle_share=float(np.mean(oracle)),
        width=float(np.median(widths)) if given and unit else None,
        width_ratio=float(np.median(widths / best)) if given else None,
        score_ratio=score_ratio(table) if given else None,
    )


def score_ratio(table: Array) -> float:
    """Return the mean score over the oracle's; rows (low, high, truth, oracle low, high), (n, 5).

    Both scores are divided by the oracle's width in that run: axes with little noise weigh as much
    as those with much, and quantities of different units can be put together.
    """
    low, high, truth, oracle_low, oracle_high = table.T
    best = oracle_high - oracle_low
    ours = interval_score(low, high, truth) / best
    oracles = interval_score(oracle_low, oracle_high, truth) / best
    return float(np.mean(ours) / np.mean(oracles))
