"""Parquet: one table, read in batches of rows; a struct is a column for each of its fields.

A list of fixed length is a column for each of its places.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path

import pyarrow as pa
from pyarrow import compute, parquet

from autodb.errors import UnusableInput
from autodb.files.text import TextSection
from autodb.readers._base import (
    BLOCK_ROWS,
    Columns,
    ColumnSet,
    damaged,
    numpy_columns,
    refuse_twice,
)
from autodb.wording import phrase

Way = tuple[str | int, ...]
"""How a column is reached: a column of the file, then fields of a struct or a place in a list."""


def open_file(path: Path, _: TextSection) -> tuple[ColumnSet, ...]:
    """Open a Parquet file by its schema."""
    try:
        with parquet.ParquetFile(path) as file:
            ways = [way for field in file.schema_arrow for way in _ways((field.name,), field.type)]
            said = {f.name: (f.metadata or {}).get(b"unit", b"") for f in file.schema_arrow}
    except (pa.ArrowException, OSError, UnicodeDecodeError) as error:
        raise damaged(path, "Parquet", (str(error).splitlines() or [""])[0]) from None
    named = [(_called(way), way) for way in ways]
    refuse_twice(path, [name for name, _ in named], "table")
    reached = dict(named)

    def blocks(numbers: Sequence[str], labels: Sequence[str]) -> Iterator[Columns]:
        row = 0
        wanted = [*numbers, *labels]
        for batch in _batches(path, list(dict.fromkeys(str(reached[n][0]) for n in wanted))):
            flat = {name: _column(batch, reached[name]) for name in wanted}
            table = pa.table(flat) if flat else batch
            yield numpy_columns(str(path), table, numbers, labels, row)
            row += batch.num_rows
        if not row:
            raise UnusableInput(phrase("{file}: no rows of data", file=path))

    units = {_called(way): said[str(way[0])].decode("utf-8", "replace") for way in ways}
    return (ColumnSet("", tuple(reached), blocks, units),)


def _ways(way: Way, kind: pa.DataType) -> Iterator[Way]:
    if pa.types.is_struct(kind):
        for field in kind:
            yield from _ways((*way, field.name), field.type)
    elif pa.types.is_fixed_size_list(kind):
        yield from ((*way, place) for place in range(kind.list_size))
    else:
        yield way


def _called(way: Way) -> str:
    """Return the name of a column: `log.position` of a struct, `force 1` of a list."""
    *fields, last = way
    if isinstance(last, int):
        return f"{'.'.join(map(str, fields))} {last + 1}"
    return ".".join(map(str, way))


def _column(batch: pa.RecordBatch, way: Way) -> pa.Array:
    column = batch.column(str(way[0]))
    for step in way[1:]:
        column = (
            compute.list_element(column, step)
            if isinstance(step, int)
            else compute.struct_field(column, step)
        )
    return column


def _batches(path: Path, names: list[str]) -> Iterator[pa.RecordBatch]:
    try:
        with parquet.ParquetFile(path, buffer_size=1 << 16, pre_buffer=False) as file:
            yield from file.iter_batches(batch_size=BLOCK_ROWS, columns=names)
    except (pa.ArrowException, OSError, UnicodeDecodeError) as error:
        raise damaged(path, "Parquet", (str(error).splitlines() or [""])[0]) from None
