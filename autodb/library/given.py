"""What a caller gives: paths or data frames, columns and units, cuts of a job."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow as pa

from autodb.errors import UnusableInput, near
from autodb.files.side import SideFile, StatedColumns, stated_side
from autodb.records.frames import arrow_of, frame_columns, frame_source, is_frame
from autodb.records.source import RecordingSource, open_source

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


def _of_these(side: StatedColumns, columns: Sequence[str]) -> SideFile | None:
    """Return what is stated of these columns alone; a side file on the disk is the recording's."""
    if not isinstance(side, SideFile):
        return None
    kept = {name: spec for name, spec in side.channels.items() if spec.column in columns}
    return side.model_copy(update={"channels": kept})
