"""What reference mills showed: the published way against P0's errors, and autodb against both."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydantic import TypeAdapter

from autodb.prove.found import Table, ratio
from autodb.prove.mill_run import PUBLISHED, SCORED, Told
from autodb.prove.published_mill import MEAN_N, POCKET_N, SLOT_N
from autodb.prove.runs import Finished, Origin

WITHIN = 0.25
"""Share by which the published way's median error may differ from the published one."""
SLOT, POCKET = "slot, diagonal", "pocket"
PUBLISHED_N = {
    **{(SLOT, axis): error_N for axis, error_N in SLOT_N.items()},
    **{(POCKET, axis): error_N for axis, error_N in POCKET_N.items()},
}


@dataclass(frozen=True)
class Row:
    """One way in one cut on one axis: medians of the machines, N, as in ``Told``."""

    way: str
    cut: str
    axis: str
    rmse_N: float
    slow_N: float


def rows_of(runs: Sequence[Finished[Told]]) -> tuple[Row, ...]:
    """Return the medians, cut by cut, each with its ways in the order of the first run."""
    every = [one for run in runs for one in run.judged]
    ways = list(dict.fromkeys(one.way for one in every))
    cuts = list(dict.fromkeys(one.cut for one in every))
    return tuple(
        _row([one for one in every if (one.way, one.cut, one.axis) == (way, cut, axis)])
        for cut in cuts
        for axis in SCORED
        for way in ways
    )


def _row(told: list[Told]) -> Row:
    return Row(
        told[0].way,
        told[0].cut,
        told[0].axis,
        float(np.median([one.rmse_N for one in told])),
        float(np.median([one.slow_N for one in told])),
    )


def mean_N(runs: Sequence[Finished[Told]], way: str) -> float:
    """Return the mean over cuts and axes, median of the machines."""
    return float(
        np.median([np.mean([one.rmse_N for one in run.judged if one.way == way]) for run in runs])
    )


@dataclass(frozen=True)
class Gate:
    """How the published way does on reference mills: a row a cut and axis, and the mean, N."""

    origin: Origin
    seeds: tuple[int, int]
    rows: tuple[Row, ...]
    mean_N: float

    @property
    def passed(self) -> bool:
        """Say whether slot, pocket and the mean are as P0's."""
        near = [near_N(self._of(cut, axis), there) for (cut, axis), there in PUBLISHED_N.items()]
        return all([*near, near_N(self.mean_N, MEAN_N)])

    def _of(self, cut: str, axis: str) -> float:
        return next(row.rmse_N for row in self.rows if (row.cut, row.axis) == (cut, axis))

    def tables(self) -> tuple[Table, ...]:
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
            Table("Gate: RMSE of the published way, median of the machines", heads, tuple(rows)),
            Table("All cuts, median of the machines", ("cut", "axis", ">RMSE N"), every),
        )

    def to_json(self) -> str:
        """Return the summary as JSON, as ``read_gate`` reads it."""
        return GATE.dump_json(self, indent=1).decode() + "\n"


def near_N(here_N: float, there_N: float) -> bool:
    """Say whether an error is as large as a published one."""
    return abs(here_N / there_N - 1.0) <= WITHIN


def said_near(here_N: float, there_N: float) -> str:
    """Say so as a cell has it."""
    return said(near_N(here_N, there_N))


def said(passed: bool) -> str:
    """Return what a cell says of a check."""
    return "passed" if passed else "FAILED"


GATE: TypeAdapter[Gate] = TypeAdapter(Gate)


def read_gate(text: str) -> Gate:
    """Return a gate that was written; raises pydantic's ValidationError on any other."""
    return GATE.validate_json(text)


def gate_of(runs: Sequence[Finished[Told]], origin: Origin) -> Gate:
    """Return the gate of finished runs in the order of their seeds."""
    return Gate(origin, (runs[0].seed, runs[-1].seed), rows_of(runs), mean_N(runs, PUBLISHED))
