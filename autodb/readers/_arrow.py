"""Arrow tables become NumPy columns."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pyarrow as pa

from autodb.readers._base import Columns, as_label, as_number


def numpy_columns(
    where: str, table: Any, numbers: Sequence[str], labels: Sequence[str], first_row: int = 0
) -> Columns:
    """Return ``numbers`` of an Arrow table or batch as float64 (missing: NaN), ``labels`` as text.

    Raises UnusableInput naming the row where a number is none.
    """
    columns: Columns = {}
    for name in numbers:
        column = table.column(name)
        if pa.types.is_floating(column.type) or pa.types.is_integer(column.type):
            values = column.cast(pa.float64(), safe=False).to_numpy(zero_copy_only=False)
            columns[name] = np.asarray(values, dtype=np.float64)
        elif pa.types.is_temporal(column.type):
            columns[name] = as_number(where, name, column.to_numpy(zero_copy_only=False), first_row)
        else:
            columns[name] = as_number(where, name, _objects(column), first_row)
    for name in labels:
        columns[name] = as_label(_objects(table.column(name)))
    return columns


def _objects(column: Any) -> Any:
    return np.array([*column.to_pylist(), None], dtype=object)[:-1]
