"""What reference mills showed: the published way against P0's errors, and autodb against both."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from autodb.proofs.runs.found import KeptAsJson, TextTable, passed_words, percent, ratio
from autodb.proofs.runs.mill.mill_run import OURS, PUBLISHED, SCORED, ForceErrors, KeptOfAxis
from autodb.proofs.runs.mill.published_mill import MEAN_N, POCKET_N, SLOT_N
from autodb.proofs.runs.run_file import Finished, Origin

WITHIN = 0.25
"""Share by which the published way's median error may differ from the published one."""
SLOT, POCKET = "slot, diagonal", "pocket"
POCKET_RATIO, SLOT_RATIO = 0.5, 1.0
"""Times the published way's error that autodb's may be, in pockets and in slots."""
POLE_MM, POLE = 23.0, 0.01
"""Pole of the mills, and by what share autodb's may be off."""
PUBLISHED_N = {
    **{(SLOT, axis): error_N for axis, error_N in SLOT_N.items()},
    **{(POCKET, axis): error_N for axis, error_N in POCKET_N.items()},
}


@dataclass(frozen=True)
class ForceRow:
    """One way in one cut on one axis: medians of the machines, N, as in ``ForceErrors``."""

    way: str
    cut: str
    axis: str
    rmse_N: float
    slow_N: float


def force_rows_of(runs: Sequence[Finished[ForceErrors | KeptOfAxis]]) -> tuple[ForceRow, ...]:
    """Return the medians, cut by cut, each with its ways in the order of the first run."""
    every = [one for run in runs for one in run.judged if isinstance(one, ForceErrors)]
    ways = list(dict.fromkeys(one.way for one in every))
    cuts = list(dict.fromkeys(one.cut for one in every))
    return tuple(
        _row([one for one in every if (one.way, one.cut, one.axis) == (way, cut, axis)])
        for cut in cuts
        for axis in SCORED
        for way in ways
    )


def _row(errors: list[ForceErrors]) -> ForceRow:
    return ForceRow(
        errors[0].way,
        errors[0].cut,
        errors[0].axis,
        float(np.median([one.rmse_N for one in errors])),
        float(np.median([one.slow_N for one in errors])),
    )


def mean_N(runs: Sequence[Finished[ForceErrors | KeptOfAxis]], way: str) -> float:
    """Return the mean over cuts and axes, median of the machines."""
    every = [[one for one in run.judged if isinstance(one, ForceErrors)] for run in runs]
    means = [np.mean([one.rmse_N for one in errors if one.way == way]) for errors in every]
    return float(np.median(means))


@dataclass(frozen=True)
class MillGate(KeptAsJson):
    """How the published way does on reference mills: a row a cut and axis, and the mean, N."""

    origin: Origin
    seeds: tuple[int, int]
    rows: tuple[ForceRow, ...]
    mean_N: float

    @property
    def passed(self) -> bool:
        """Say whether slot, pocket and the mean are as P0's."""
        near = [near_N(self._of(cut, axis), there) for (cut, axis), there in PUBLISHED_N.items()]
        return all([*near, near_N(self.mean_N, MEAN_N)])

    def _of(self, cut: str, axis: str) -> float:
        return next(row.rmse_N for row in self.rows if (row.cut, row.axis) == (cut, axis))

    def tables(self) -> tuple[TextTable, ...]:
        """Return what must be as published, and the other cuts."""
        heads = ("cut", "axis", ">published N", ">on virtual mills", f">ratio (1 ± {WITHIN:g})", "")
        asked = [
            (cut, axis, there, self._of(cut, axis)) for (cut, axis), there in PUBLISHED_N.items()
        ]
        rows = [
            (cut, axis, f"{there:.0f}", f"{here:.1f}", ratio(here / there), said_near(here, there))
            for cut, axis, there, here in [*asked, ("mean of all", "x, y", MEAN_N, self.mean_N)]
        ]
        every = tuple((row.cut, row.axis, f"{row.rmse_N:.1f}") for row in self.rows)
        return (
            TextTable(
                "Gate: RMSE of the published way, median of the machines", heads, tuple(rows)
            ),
            TextTable("All cuts, median of the machines", ("cut", "axis", ">RMSE N"), every),
        )


@dataclass(frozen=True)
class KeptRow:
    """What autodb kept of an axis of the mills: how many poles are within POLE, of how many; the
    worst share off; how often which form; the mass' error, median and worst share.
    """

    axis: str
    near: int
    machines: int
    worst_pole: float
    forms: tuple[tuple[str, int], ...]
    mass: float
    worst_mass: float


def kept_of(runs: Sequence[Finished[ForceErrors | KeptOfAxis]]) -> tuple[KeptRow, ...]:
    """Return what was kept, axis by axis."""
    every = [one for run in runs for one in run.judged if isinstance(one, KeptOfAxis)]
    return tuple(_kept_row([one for one in every if one.axis == axis]) for axis in SCORED)


def _kept_row(kept: list[KeptOfAxis]) -> KeptRow:
    poles = [abs(one.pole_mm / POLE_MM - 1.0) for one in kept]
    masses = [abs(one.moved_kg / one.true_kg - 1.0) for one in kept]
    forms = [one.form for one in kept]
    return KeptRow(
        axis=kept[0].axis,
        near=sum(pole <= POLE for pole in poles),
        machines=len(kept),
        worst_pole=max(poles),
        forms=tuple((form, forms.count(form)) for form in dict.fromkeys(sorted(forms))),
        mass=float(np.median(masses)),
        worst_mass=max(masses),
    )


@dataclass(frozen=True)
class ForcesGate(KeptAsJson):
    """How autodb does beside the published way: a row a cut, axis and way, means of the ways, and
    what was kept of the axes.
    """

    origin: Origin
    seeds: tuple[int, int]
    rows: tuple[ForceRow, ...]
    means_N: tuple[tuple[str, float], ...]
    kept: tuple[KeptRow, ...]

    @property
    def passed(self) -> bool:
        """Say whether pockets, slots and poles are within their limits."""
        return all(self._ratio(row) <= self._limit(row) for row in self._limited()) and all(
            row.near == row.machines for row in self.kept
        )

    def _limited(self) -> list[ForceRow]:
        """Return autodb's rows that have a limit."""
        return [row for row in self.rows if row.way == OURS and self._limit(row) < np.inf]

    @staticmethod
    def _limit(row: ForceRow) -> float:
        kinds = {"pocket": POCKET_RATIO, "slot": SLOT_RATIO}
        return next((limit for kind, limit in kinds.items() if row.cut.startswith(kind)), np.inf)

    def _ratio(self, row: ForceRow) -> float:
        at = (PUBLISHED, row.cut, row.axis)
        there = next(one for one in self.rows if (one.way, one.cut, one.axis) == at)
        return row.rmse_N / there.rmse_N

    def tables(self) -> tuple[TextTable, ...]:
        """Return what must be, what was kept, and all ways."""
        return (self._limits(), self._axes(), self._ways(), self._means())

    def _limits(self) -> TextTable:
        heads = ("cut", "axis", ">autodb N", ">× published way's", ">must be ≤", "")
        rows = tuple(
            (
                row.cut, row.axis, f"{row.rmse_N:.1f}", ratio(self._ratio(row)),
                ratio(self._limit(row)), passed_words(self._ratio(row) <= self._limit(row)),
            )
            for row in self._limited()
        )  # fmt: skip
        return TextTable("autodb: RMSE, median of the machines", heads, rows)

    def _axes(self) -> TextTable:
        heads = (
            "axis", f">pole within {percent(POLE)} of {POLE_MM:g} mm", ">worst off by", "",
            "cogging kept as", ">moved mass off by", ">worst",
        )  # fmt: skip
        rows = tuple(
            (
                row.axis, f"{row.near} of {row.machines}", f"{100.0 * row.worst_pole:.2f} %",
                passed_words(row.near == row.machines),
                ", ".join(f"{form} ({count})" for form, count in row.forms),
                f"{100.0 * row.mass:.2f} %", f"{100.0 * row.worst_mass:.2f} %",
            )
            for row in self.kept
        )  # fmt: skip
        return TextTable("What autodb keeps of the axes", heads, rows)

    def _ways(self) -> TextTable:
        heads = ("cut", "axis", "way", ">RMSE N", ">up to 10 Hz")
        rows = tuple(
            (row.cut, row.axis, row.way, f"{row.rmse_N:.1f}", f"{row.slow_N:.1f}")
            for row in self.rows
        )
        return TextTable("All ways, median of the machines", heads, rows)

    def _means(self) -> TextTable:
        rows = tuple((way, f"{mean:.1f}") for way, mean in self.means_N)
        return TextTable(
            "Mean over cuts and axes, median of the machines", ("way", ">RMSE N"), rows
        )


def near_N(here_N: float, there_N: float) -> bool:
    """Say whether an error is as large as a published one."""
    return abs(here_N / there_N - 1.0) <= WITHIN


def said_near(here_N: float, there_N: float) -> str:
    """Say so as a cell has it."""
    return passed_words(near_N(here_N, there_N))


def mill_gate_of(runs: Sequence[Finished[ForceErrors | KeptOfAxis]], origin: Origin) -> MillGate:
    """Return the gate of finished runs in the order of their seeds."""
    return MillGate(
        origin, (runs[0].seed, runs[-1].seed), force_rows_of(runs), mean_N(runs, PUBLISHED)
    )


def forces_of(runs: Sequence[Finished[ForceErrors | KeptOfAxis]], origin: Origin) -> ForcesGate:
    """Return the forces of finished runs in the order of their seeds."""
    rows = force_rows_of(runs)
    ways = dict.fromkeys(row.way for row in rows)
    means = tuple((way, mean_N(runs, way)) for way in ways)
    return ForcesGate(origin, (runs[0].seed, runs[-1].seed), rows, means, kept_of(runs))
