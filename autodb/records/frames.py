"""A table in memory as a recording: its columns are named and converted as those of a file are."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import narwhals as nw
import numpy as np
import pyarrow as pa
from narwhals.exceptions import DuplicateError

from autodb import readers
from autodb.errors import UnusableInput, near_words
from autodb.files.side import SideFile
from autodb.files.text import TextSection
from autodb.readers._base import numpy_columns, refuse_twice
from autodb.records.source import RecordingSource, assembled_source
from autodb.wording import phrase

UNIT = b"unit"
"""Key under which a column of an Arrow table, and of the Parquet file of it, says its unit."""


def is_frame(given: object) -> bool:
    """Say whether something is a data frame: of pandas, or of any library that narwhals knows."""
    if nw.dependencies.is_into_dataframe(given):
        return True
    return isinstance(nw.from_native(given, pass_through=True), nw.LazyFrame)


def arrow_of(frame: Any, *, name: str, units: Mapping[str, str] | None = None) -> pa.Table:
    """Return a data frame as an Arrow table whose columns say the ``units`` that are stated.

    An index of pandas that has a name is a column as well, one of times is `t`. ``name``: of the
    frame in messages.

    Raises UnusableInput for columns that stand twice, and a unit of a column that is not there.
    """
    made = _known_as(name, frame)
    columns = [str(column) for column in made.columns]
    if not columns or not len(made):
        raise UnusableInput(phrase("{name}: no rows of data", name=name))
    stated = dict(units or {})
    for column in stated:
        if column not in columns:
            raise UnusableInput(
                phrase(
                    "{name}: units: no column '{column}'{hint}",
                    name=name,
                    column=column,
                    hint=near_words(column, columns),
                )
            )
    arrays = [_array(made[column]) for column in made.columns]
    fields = [
        pa.field(column, array.type, metadata=_said(stated.get(column)))
        for column, array in zip(columns, arrays, strict=True)
    ]
    return pa.table(arrays, schema=pa.schema(fields))


def frame_columns(frame: Any) -> list[str]:
    """Return the names of a data frame's columns, and of its index where it has one."""
    return [str(column) for column in nw.from_native(_with_index(frame)).collect_schema().names()]


def frame_source(table: pa.Table, *, name: str, side: SideFile) -> RecordingSource:
    """Return what a table of ``arrow_of`` is; raises UnusableInput as ``open_source`` does."""

    def blocks(numbers: Sequence[str], labels: Sequence[str]) -> Iterator[readers.Columns]:
        yield numpy_columns(name, table, numbers, labels)

    said = {field.name: (field.metadata or {}).get(UNIT, b"").decode() for field in table.schema}
    base = readers.ColumnSet("", tuple(table.column_names), blocks, said)
    if side.csv != TextSection():
        raise UnusableInput(
            phrase("{name}: [csv] says how a text file is written; leave it out", name=name)
        )
    return assembled_source(Path(name), [base], side)


def _known_as(name: str, frame: Any) -> "nw.DataFrame[Any]":
    try:
        made = nw.from_native(_with_index(frame))
    except DuplicateError:
        refuse_twice(Path(name), map(str, frame.columns), "frame")
        raise
    return made.collect("pyarrow") if isinstance(made, nw.LazyFrame) else made


def _with_index(frame: Any) -> Any:
    """Return a frame with its index among its columns, where that has a name or is a time."""
    index = nw.maybe_get_index(nw.from_native(frame))
    if index is None:
        return frame
    if list(index.names) != [None]:
        return frame.reset_index()
    return frame.rename_axis("t").reset_index() if index.dtype.kind in "mM" else frame


def _array(column: "nw.Series[Any]") -> Any:
    """Return a column as Arrow has it; of mixed cells the text of each, for the reader to judge."""
    try:
        array = column.to_arrow()
    except (pa.ArrowException, TypeError):
        cells = column.to_list()
        return pa.array([None if is_nothing(cell) else str(cell) for cell in cells], pa.string())
    return array.combine_chunks() if isinstance(array, pa.ChunkedArray) else array


def is_nothing(cell: object) -> bool:
    """Say whether a cell holds nothing."""
    return cell is None or (isinstance(cell, float) and bool(np.isnan(cell)))


def _said(unit: str | None) -> dict[bytes, bytes] | None:
    return None if unit is None else {UNIT: unit.encode()}
