"""Parquet: one table."""

from pathlib import Path

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from pyarrow import parquet

from autodb.errors import UnusableInput
from autodb.readers._arrow import numpy_columns


def read_parquet(path: Path) -> dict[str, NDArray[np.generic]]:
    """Read a Parquet file."""
    try:
        return numpy_columns(parquet.read_table(path))
    except (pa.ArrowInvalid, pa.ArrowTypeError, OSError) as error:
        reason = str(error).splitlines()[0]
        raise UnusableInput(f"{path}: not a whole Parquet file ({reason})") from None
