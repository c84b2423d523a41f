"""What reference axes showed: the published way against P2's errors, and autodb against both."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from autodb.proofs.machines.axis.reference_axis import AXES
from autodb.proofs.runs.axis.axis_run import (
    KNOWN,
    ORACLE,
    OURS,
    PUBLISHED,
    TERMS_ALONE,
    AxisModelErrors,
)
from autodb.proofs.runs.axis.published_axis import (
    PUBLISHED_CONTOUR,
    PUBLISHED_ERROR,
    PUBLISHED_HIGH,
)
from autodb.proofs.runs.found import KeptAsJson, TextTable, passed_words, percent, ratio
from autodb.proofs.runs.run_file import Finished, Origin

WITHIN = 0.3
"""Share by which the published way's median error may differ from the published one."""
PUBLISHED_RATIO, ORACLE_RATIO = 0.6, 1.2
"""Times the published way's error that autodb's may be, or the oracle's where that is more."""
CONTOUR = 0.05
"""Error of the contour, share of its mean current."""
WEIGHT = 0.01
"""Error of the weight."""


def _rows(
    runs: Sequence[Finished[AxisModelErrors]], ways: Sequence[str]
) -> tuple[AxisModelErrors, ...]:
    every = [one for run in runs for one in run.judged]
    return tuple(
        _row([one for one in every if (one.axis, one.way) == (axis, way)])
        for axis in AXES
        for way in ways
    )


def _row(errors: list[AxisModelErrors]) -> AxisModelErrors:
    """Return the medians of the machines."""
    weights = [one.weight for one in errors if one.weight is not None]

    def median(name: str) -> float:
        return float(np.median([getattr(one, name) for one in errors]))

    return AxisModelErrors(
        way=errors[0].way,
        axis=errors[0].axis,
        measured=median("measured"),
        true=median("true"),
        contour=median("contour"),
        contour_friction=median("contour_friction"),
        high=median("high"),
        weight=float(np.median(weights)) if weights else None,
    )


@dataclass(frozen=True)
class AxisGate(KeptAsJson):
    """How the published way does on reference axes: a row an axis."""

    origin: Origin
    seeds: tuple[int, int]
    rows: tuple[AxisModelErrors, ...]

    @property
    def passed(self) -> bool:
        """Say whether every axis is as hard as P2's."""
        return all(_as_hard(row) and _contour_as_hard(row) for row in self.rows)

    def tables(self) -> tuple[TextTable, ...]:
        """Return the only table."""
        heads = (
            "axis", ">published error of the field", ">on virtual axes", f">ratio (1 ± {WITHIN:g})",
            "", f">contour, of its current (< {percent(PUBLISHED_CONTOUR)})",
            ">friction too high ({} to {})".format(*map(percent, PUBLISHED_HIGH)), "",
        )  # fmt: skip
        rows = [
            (
                row.axis, percent(PUBLISHED_ERROR[row.axis]), percent(row.measured),
                ratio(row.measured / PUBLISHED_ERROR[row.axis]), passed_words(_as_hard(row)),
                percent(row.contour), percent(row.high), passed_words(_contour_as_hard(row)),
            )
            for row in self.rows
        ]  # fmt: skip
        return (TextTable("Gate: the published way, median of the machines", heads, tuple(rows)),)


def _as_hard(row: AxisModelErrors) -> bool:
    return abs(row.measured / PUBLISHED_ERROR[row.axis] - 1.0) <= WITHIN


def _contour_as_hard(row: AxisModelErrors) -> bool:
    low, high = PUBLISHED_HIGH
    return row.contour < PUBLISHED_CONTOUR and low <= row.high <= high


@dataclass(frozen=True)
class Fields(KeptAsJson):
    """How autodb does beside the published way and the oracle: rows of every axis and way."""

    origin: Origin
    seeds: tuple[int, int]
    rows: tuple[AxisModelErrors, ...]

    @property
    def passed(self) -> bool:
        """Say whether every axis is within its limits."""
        return all(
            self._near(axis) and self._follows(axis) and self._weighed(axis) for axis in AXES
        )

    def _of(self, axis: str, way: str) -> AxisModelErrors:
        return next(row for row in self.rows if (row.axis, row.way) == (axis, way))

    def limit(self, axis: str) -> float:
        """Return the error of the measured field that autodb may have."""
        published, best = self._of(axis, PUBLISHED).measured, self._of(axis, ORACLE).measured
        return max(PUBLISHED_RATIO * published, ORACLE_RATIO * best)

    def _near(self, axis: str) -> bool:
        return self._of(axis, OURS).measured <= self.limit(axis)

    def _follows(self, axis: str) -> bool:
        return self._of(axis, OURS).contour <= CONTOUR

    def _weighed(self, axis: str) -> bool:
        off = self._of(axis, OURS).weight
        return off is None or off <= WEIGHT

    def tables(self) -> tuple[TextTable, ...]:
        """Return what must be, and then all ways."""
        return (self._limits(), self._ways())

    def _limits(self) -> TextTable:
        heads = (
            "axis", ">field", ">× published way's", ">× oracle's", ">must be ≤", "",
            f">contour, of its current (≤ {percent(CONTOUR)})", "",
            f">weight off by (≤ {percent(WEIGHT)})", "",
        )  # fmt: skip
        rows = []
        for axis in AXES:
            row = self._of(axis, OURS)
            rows.append((
                axis, percent(row.measured),
                ratio(row.measured / self._of(axis, PUBLISHED).measured),
                ratio(row.measured / self._of(axis, ORACLE).measured), percent(self.limit(axis)),
                passed_words(self._near(axis)), percent(row.contour),
                passed_words(self._follows(axis)),
                "" if row.weight is None else f"{100.0 * row.weight:.2f} %",
                "" if row.weight is None else passed_words(self._weighed(axis)),
            ))  # fmt: skip
        return TextTable("autodb, median of the machines", heads, tuple(rows))

    def _ways(self) -> TextTable:
        heads = (
            "axis", "way", ">measured field", ">true field", ">contour, of its current",
            ">of its friction", ">friction too high", ">weight off by",
        )  # fmt: skip
        rows = tuple(
            (
                row.axis, row.way, percent(row.measured), percent(row.true), percent(row.contour),
                percent(row.contour_friction), percent(row.high),
                "" if row.weight is None else f"{100.0 * row.weight:.2f} %",
            )
            for row in self.rows
        )  # fmt: skip
        return TextTable("All ways, median of the machines", heads, rows)


def axis_gate_of(runs: Sequence[Finished[AxisModelErrors]], origin: Origin) -> AxisGate:
    """Return the gate of finished runs in the order of their seeds."""
    return AxisGate(origin, (runs[0].seed, runs[-1].seed), _rows(runs, (PUBLISHED,)))


def fields_of(runs: Sequence[Finished[AxisModelErrors]], origin: Origin) -> Fields:
    """Return the fields of finished runs in the order of their seeds."""
    rows = _rows(runs, (PUBLISHED, OURS, TERMS_ALONE, ORACLE, KNOWN))
    return Fields(origin, (runs[0].seed, runs[-1].seed), rows)
