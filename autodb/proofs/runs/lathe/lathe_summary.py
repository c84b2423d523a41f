"""What calibrating reference lathes found: a row an axis, and a row of all axes."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.machines.lathe.reference_lathe import REGRESSION
from autodb.proofs.runs.found import KeptAsJson, TextTable, passed_words, percent, ratio
from autodb.proofs.runs.lathe.lathe_run import AXES, AxisErrors
from autodb.proofs.runs.lathe.published_lathe import PUBLISHED_RMSE_N
from autodb.proofs.runs.run_file import Finished, Origin

Array = NDArray[np.float64]

WITHIN = 0.2
"""Share by which the published calibration's median may differ from the published error."""
ORACLE_RATIO = 1.2
"""Times the oracle's median error that autodb's may be."""
SLOPE_WITHIN = 0.02
"""The slope of reference over estimate may differ so much from 1."""
HELD = (0.93, 0.97)
"""Share of 95 % intervals that must hold the force."""
SURE = 3.29
"""Standard errors, 99.9 %, by which the share of few machines may be outside."""


@dataclass(frozen=True)
class PairedRatio:
    """An error over another one of the same machine: its median, and that one's 95 % interval."""

    median: float
    low: float
    high: float

    @classmethod
    def of(cls, errors: Array, others: Array) -> Self:
        """Return it of the errors of machines; ends are order statistics (sign test)."""
        from scipy.stats import binom

        ratios = np.sort(errors / others)
        least = int(binom.ppf(0.025, len(ratios), 0.5))
        low, high = ratios[max(least - 1, 0)], ratios[min(len(ratios) - least, len(ratios) - 1)]
        return cls(float(np.median(ratios)), float(low), float(high))

    def __str__(self) -> str:
        """Return it as a cell has it."""
        return f"{self.median:.3f} ({self.low:.3f} to {self.high:.3f})"


@dataclass(frozen=True)
class LatheRow:
    """An axis: median errors of the machines, N; share of intervals that hold, and its standard
    error over machines; autodb's and the oracle's error over the published calibration's.
    """

    plan: str
    axis: str
    cuts: int
    rmse_N: float
    published_N: float | None
    published_method_N: float
    rules_N: float | None
    oracle_N: float
    held: float
    held_se: float
    to_published: PairedRatio
    oracle_to_published: PairedRatio

    @property
    def as_hard(self) -> bool:
        """Whether the published calibration shows the published error, where one is printed."""
        return (
            self.published_N is None
            or abs(self.published_method_N / self.published_N - 1.0) <= WITHIN
        )

    @property
    def better(self) -> bool:
        """Whether autodb's error is below the published calibration's, machine by machine."""
        return self.to_published.high < 1.0

    @property
    def near(self) -> bool:
        """Whether autodb's error is near the oracle's."""
        return self.rmse_N < ORACLE_RATIO * self.oracle_N

    @property
    def covered(self) -> bool:
        """Whether the share of intervals that hold is as stated, as far as the machines show."""
        slack = SURE * self.held_se
        return HELD[0] - slack <= self.held <= HELD[1] + slack


@dataclass(frozen=True)
class LatheSummary(KeptAsJson):
    """The score: a row an axis, and the slope of reference over estimate of all axes."""

    origin: Origin
    seeds: tuple[int, int]
    rows: tuple[LatheRow, ...]
    slope: float

    @property
    def passed(self) -> bool:
        """Say whether everything is within its limits."""
        axes = all(row.as_hard and row.better and row.near and row.covered for row in self.rows)
        return axes and self.straight

    @property
    def straight(self) -> bool:
        """Say whether the slope is 1 as far as it must be."""
        return abs(self.slope - 1.0) <= SLOPE_WITHIN

    def tables(self) -> tuple[TextTable, ...]:
        """Return the gate, autodb's errors, and each machine's beside the published way's."""
        return (self._gate(), self._errors(), self._paired())

    def _gate(self) -> TextTable:
        heads = (
            "axis",
            ">test cuts",
            ">published",
            ">on virtual lathes",
            f">ratio (1 ± {WITHIN:g})",
            "",
        )
        rows = tuple(
            (
                row.axis, str(row.cuts), f"{row.published_N:.0f} N",
                f"{row.published_method_N:.1f} N",
                ratio(row.published_method_N / row.published_N), passed_words(row.as_hard),
            )
            for row in self.rows
            if row.published_N is not None
        )  # fmt: skip
        return TextTable("Gate: the published calibration, median error", heads, rows)

    def _errors(self) -> TextTable:
        heads = (
            "axis", "plan of", ">autodb", ">its ANFIS alone", ">as published", ">oracle",
            f">× oracle's (≤ {ORACLE_RATIO:g})", "", ">95 % intervals that hold", "",
        )  # fmt: skip
        rows = [
            (
                row.axis, row.plan, f"{row.rmse_N:.1f} N",
                "too few cuts" if row.rules_N is None else f"{row.rules_N:.1f} N",
                f"{row.published_method_N:.1f} N",
                f"{row.oracle_N:.1f} N", ratio(row.rmse_N / row.oracle_N), passed_words(row.near),
                f"{percent(row.held)} ± {percent(row.held_se)}", passed_words(row.covered),
            )
            for row in self.rows
        ]  # fmt: skip
        slope = f"slope of reference over estimate, all axes (1 ± {SLOPE_WITHIN:g})"
        rows.append(
            (slope, "", "", "", "", "", f"{self.slope:.3f}", passed_words(self.straight), "", "")
        )
        return TextTable("Median errors on test cuts", heads, tuple(rows))

    def _paired(self) -> TextTable:
        heads = ("axis", "plan of", ">autodb (upper end < 1)", "", ">oracle")
        rows = tuple(
            (
                row.axis, row.plan, str(row.to_published), passed_words(row.better),
                str(row.oracle_to_published),
            )
            for row in self.rows
        )  # fmt: skip
        return TextTable(
            "Error over the published calibration's of the same lathe: median (95 %)", heads, rows
        )


def lathe_summary_of(runs: Sequence[Finished[AxisErrors]], origin: Origin) -> LatheSummary:
    """Return the score of finished runs in the order of their seeds."""
    every = [one for run in runs for one in run.judged]
    rows = [
        _row([one for one in every if (one.plan, one.axis) == (plan.name, axis)])
        for plan in AXES
        for axis in AXES[plan]
    ]
    return LatheSummary(origin, (runs[0].seed, runs[-1].seed), tuple(rows), _slope(every))


def _row(errors: list[AxisErrors]) -> LatheRow:
    plan, axis = errors[0].plan, errors[0].axis
    rules = [one.rules_N for one in errors if one.rules_N is not None]
    shares = np.array([one.held / one.cuts for one in errors])
    ours, published, oracle = (
        np.array([getattr(one, name) for one in errors])
        for name in ("ours_N", "published_N", "oracle_N")
    )
    return LatheRow(
        plan=plan,
        axis=axis,
        cuts=errors[0].cuts,
        rmse_N=float(np.median(ours)),
        published_N=PUBLISHED_RMSE_N[axis] if plan == REGRESSION.name else None,
        published_method_N=float(np.median(published)),
        rules_N=float(np.median(rules)) if rules else None,
        oracle_N=float(np.median(oracle)),
        held=float(shares.mean()),
        held_se=float(shares.std(ddof=1) / np.sqrt(len(shares))) if len(shares) > 1 else 0.0,
        to_published=PairedRatio.of(ours, published),
        oracle_to_published=PairedRatio.of(oracle, published),
    )


def _slope(errors: Sequence[AxisErrors]) -> float:
    """Return the slope of a straight line of the force over the estimate, all cuts together."""
    n = sum(one.cuts for one in errors)
    estimate, reference, squared, product = (
        sum(getattr(one, name) for one in errors)
        for name in ("estimate", "reference", "squared", "product")
    )
    return float((product - estimate * reference / n) / (squared - estimate**2 / n))
