"""What a caller gives: paths or data frames, columns and units, cuts of a job."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow as pa

from autodb.errors import UnusableInput, near
from autodb.files.job import Job, JobCut, read_job
from autodb.files.side import SideFile, StatedColumns, stated_side
from autodb.files.toml import checked
from autodb.records import RecordingSource, open_source
from autodb.records.frames import arrow_of, frame_columns, frame_source, is_frame, is_nothing

Given = Any
"""A file by its path, or a data frame: of pandas, or of any library that narwhals knows."""
ColumnsGiven = str | os.PathLike[str] | Mapping[str, Any] | SideFile | None
"""A side file by its path, or what it says: by channel, its column or that with its unit."""
Units = Mapping[str, str]
"""Units by column, or by channel."""


@dataclass(frozen=True)
class InMemory:
    """A data frame with what is stated of its columns; ``name``: what messages call it."""

    table: pa.Table
    side: SideFile
    name: str

    def source(self) -> RecordingSource:
        """Return what it holds."""
        return frame_source(self.table, name=self.name, side=self.side)


@dataclass(frozen=True)
class OnDisk:
    """A file with what is stated of its columns."""

    path: Path
    columns: StatedColumns

    def source(self) -> RecordingSource:
        """Return what it holds."""
        return open_source(self.path, columns=self.columns)


def taken(
    given: Given, *, columns: ColumnsGiven = None, units: Units | None = None, name: str = "frame"
) -> InMemory | OnDisk:
    """Return a recording that a caller gives; raises UnusableInput for what is none."""
    if isinstance(given, str | os.PathLike):
        if units:
            raise UnusableInput(f"{given}: units go with a data frame; state them in columns")
        return OnDisk(Path(given), _columns(columns))
    if not is_frame(given):
        raise UnusableInput(
            f"{name}: is neither a path nor a data frame but of type {type(given).__name__}; use "
            "one of them"
        )
    if isinstance(columns, str | os.PathLike):
        raise UnusableInput(f"{name}: the columns of a data frame are a dict; use one")
    side = _columns(columns) or SideFile()
    assert isinstance(side, SideFile)
    table = arrow_of(given, name=name, units=_by_column(units or {}, side))
    return InMemory(table, side, name)


def pair_taken(
    recording: Given, simulation: Given, *, columns: ColumnsGiven = None, units: Units | None = None
) -> tuple[InMemory | OnDisk, InMemory | OnDisk]:
    """Return a recording and its simulation; what is stated counts for data frames of both.

    Raises UnusableInput as ``taken``, and for a unit of a column that neither has.
    """
    side = _columns(columns)
    stated = _by_column(units or {}, side)
    there = {name: frame_columns(one) for name, one in
             (("recording", recording), ("simulation", simulation)) if is_frame(one)}  # fmt: skip
    known = sorted(set().union(*there.values()))
    for column in stated:
        if column not in known:
            raise UnusableInput(f"units: no column '{column}'{near(column, known)}")

    def one(given: Any, name: str, own_side: StatedColumns) -> InMemory | OnDisk:
        own = {column: unit for column, unit in stated.items() if column in there.get(name, ())}
        return taken(given, columns=own_side, units=own, name=name)

    simulated = _of_these(side, there["simulation"]) if "simulation" in there else None
    return one(recording, "recording", side), one(simulation, "simulation", simulated)


def _columns(said: ColumnsGiven) -> StatedColumns:
    if said is None or isinstance(said, SideFile):
        return said
    return Path(said) if isinstance(said, str | os.PathLike) else stated_side(said, where="columns")


def _by_column(units: Units, side: StatedColumns) -> dict[str, str]:
    """Return units by column, of those that are stated by channel too."""
    channels = side.channels if isinstance(side, SideFile) else {}
    named = {name: spec.column for name, spec in channels.items() if spec.column is not None}
    return {named.get(name, name): unit for name, unit in units.items()}


def _of_these(side: StatedColumns, columns: Sequence[str]) -> StatedColumns:
    """Return a side with the channels alone that these columns hold."""
    if not isinstance(side, SideFile):
        return side
    kept = {name: spec for name, spec in side.channels.items() if spec.column in columns}
    return side.model_copy(update={"channels": kept})


def job_of(given: Any, *, material: str | None, tool: str | None, lot: str | None) -> Job:
    """Return the job of a job file, or of a data frame with a row a cut, named as keys of a job.

    Raises UnusableInput naming file or row.
    """
    stated = {"material": material, "tool": tool, "lot": lot}
    if isinstance(given, Job | str | os.PathLike):
        if any(stated.values()):
            raise UnusableInput("material, tool and lot go with a data frame: a job states its own")
        return given if isinstance(given, Job) else read_job(Path(given))
    if material is None or tool is None:
        raise UnusableInput("the cuts of a data frame need material and tool")
    cuts = asked_cuts(given, name="job")
    return Job(name="cuts", material=material, tool=tool, lot=lot, cut=cuts)


def asked_cuts(given: Any, *, name: str) -> tuple[JobCut, ...]:
    """Return the cuts of a data frame, a row each; raises UnusableInput naming the row."""
    if not is_frame(given):
        raise UnusableInput(
            f"{name}: is no data frame but of type {type(given).__name__}; use one with a row a cut"
        )
    rows = arrow_of(given, name=name).to_pylist()
    return tuple(
        asked_cut(row, where=f"{name}: row {number}") for number, row in enumerate(rows, start=1)
    )


def asked_cut(said: Mapping[str, Any], *, where: str) -> JobCut:
    """Return a cut of what is said of it, but for what is not known; raises UnusableInput."""
    known = {key: value for key, value in said.items() if not is_nothing(value)}
    numbers = {key: float(value) if type(value) is int else value for key, value in known.items()}
    return checked(numbers, JobCut, where=where)
