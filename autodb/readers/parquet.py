"""Parquet: one table, read in batches of rows."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import pyarrow as pa
from pyarrow import parquet

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


def open_file(path: Path, _: TextSection) -> tuple[ColumnSet, ...]:
    """Open a Parquet file by its schema."""
    try:
        with parquet.ParquetFile(path) as file:
            names = tuple(file.schema_arrow.names)
            said = {f.name: (f.metadata or {}).get(b"unit", b"") for f in file.schema_arrow}
            units = {name: unit.decode("utf-8", "replace") for name, unit in said.items()}
    except (pa.ArrowException, OSError, UnicodeDecodeError) as error:
        raise damaged(path, "Parquet", (str(error).splitlines() or [""])[0]) from None
    refuse_twice(path, names, "table")

    def blocks(numbers: Sequence[str], labels: Sequence[str]) -> Iterator[Columns]:
        row = 0
        for batch in _batches(path, [*numbers, *labels]):
            yield numpy_columns(str(path), batch, numbers, labels, row)
            row += batch.num_rows
        if not row:
            raise UnusableInput(f"{path}: no rows of data")

    return (ColumnSet("", names, blocks, units),)


def _batches(path: Path, names: list[str]) -> Iterator[pa.RecordBatch]:
    try:
        with parquet.ParquetFile(path, buffer_size=1 << 16, pre_buffer=False) as file:
            yield from file.iter_batches(batch_size=BLOCK_ROWS, columns=names)
    except (pa.ArrowException, OSError, UnicodeDecodeError) as error:
        raise damaged(path, "Parquet", (str(error).splitlines() or [""])[0]) from None
