"""Arrow tables become NumPy columns."""

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray


def numpy_columns(table: pa.Table) -> dict[str, NDArray[np.generic]]:
    """Return the columns of ``table``: numbers as float64 (missing: NaN), the rest as str."""
    return {name: _column(table.column(name)) for name in table.column_names}


def _column(column: pa.ChunkedArray) -> NDArray[np.generic]:
    kind = column.type
    if pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_boolean(kind):
        return np.asarray(column.cast(pa.float64()).to_numpy(), dtype=np.float64)
    if pa.types.is_null(kind):
        return np.full(len(column), np.nan)
    texts = ["" if value is None else str(value) for value in column.to_pylist()]
    return np.array(texts, dtype=np.str_)
