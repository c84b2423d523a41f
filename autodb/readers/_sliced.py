"""Columns of formats that give any rows of any column, as blocks."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack
from pathlib import Path
from typing import Any

import numpy as np

from autodb.readers._base import (
    BLOCK_ROWS,
    Blocks,
    Columns,
    as_label,
    as_number,
    damaged,
    undamaged,
)

Cells = Callable[[str, range], Any]
"""Returns the cells of one column in a range of rows."""


def sliced(
    path: Path,
    kind: str,
    *,
    rows: int,
    opened: Callable[[], AbstractContextManager[Cells]],
) -> Blocks:
    """Return the blocks of columns of ``rows`` rows; ``opened`` opens the file to read cells."""

    def part(cells: Cells, name: str, span: range) -> Any:
        values = np.asarray(undamaged(path, kind, lambda: cells(name, span)))
        if len(values) != len(span):
            reached = span.start + len(values)
            raise damaged(path, kind, f"column '{name}' ends early, at row {reached}")
        return values

    def blocks(numbers: Sequence[str], labels: Sequence[str]) -> Iterator[Columns]:
        with ExitStack() as stack:
            cells = undamaged(path, kind, lambda: stack.enter_context(opened()))
            for span in block_rows(rows):
                columns: Columns = {}
                for name in numbers:
                    values = part(cells, name, span)
                    columns[name] = as_number(str(path), name, values, span.start)
                for name in labels:
                    columns[name] = as_label(part(cells, name, span))
                yield columns

    return blocks


def block_rows(rows: int) -> Iterator[range]:
    """Yield the rows of each block."""
    for start in range(0, rows, BLOCK_ROWS):
        yield range(start, min(start + BLOCK_ROWS, rows))
