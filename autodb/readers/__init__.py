"""One file a reader: bytes on disk become named NumPy columns, or one line says why not."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.readers.csv import read_csv
from autodb.readers.mat import read_mat
from autodb.readers.parquet import read_parquet

Columns = dict[str, NDArray[np.generic]]
READERS: dict[str, Callable[[Path], Columns]] = {
    ".csv": read_csv,
    ".parquet": read_parquet,
    ".mat": read_mat,
}


def read_columns(path: Path) -> Columns:
    """Read every column of ``path``: float64 where numeric, otherwise text; all of one length.

    Raises UnusableInput for a missing, empty, unreadable or unknown kind of file.
    """
    if path.is_dir():
        raise UnusableInput(f"{path}: is a folder; give one recording file")
    if not path.exists():
        raise UnusableInput(f"{path}: no such file")
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise UnusableInput(f"{path}: unknown kind of file; {', '.join(READERS)} would work")
    try:
        if path.stat().st_size == 0:
            raise UnusableInput(f"{path}: the file is empty")
        columns = reader(path)
    except PermissionError:
        raise UnusableInput(f"{path}: no permission to read it") from None
    if not columns or not len(next(iter(columns.values()))):
        raise UnusableInput(f"{path}: no rows of data")
    return columns
