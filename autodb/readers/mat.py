"""MATLAB v5: n×1 and 1×n arrays are channels, scalars and the rest are ignored; v7.3 is HDF5."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from autodb.files.text import TextSection
from autodb.readers import hdf5
from autodb.readers._base import Columns, ColumnSet, as_label, as_number
from autodb.readers._child import isolated, isolated_value

_NUMBERS = {"double", "single", "logical"} | {
    f"{u}int{n}" for u in ("", "u") for n in (8, 16, 32, 64)
}


def open_file(path: Path, stated: TextSection) -> tuple[ColumnSet, ...]:
    """Open a MAT file; vectors of one length share a time base."""
    from scipy.io import whosmat

    with path.open("rb") as file:
        if b"MATLAB 7.3" in file.read(128):
            return hdf5.open_file(path, stated)
    by_length: dict[int, list[str]] = {}
    for name, shape, kind in isolated_value(path, "MAT", lambda: whosmat(path)):
        if kind in _NUMBERS and sum(n > 1 for n in shape) == 1 and min(shape) > 0:
            by_length.setdefault(max(shape), []).append(name)
    several = len(by_length) > 1
    return tuple(
        _base(path, f"{rows} rows" if several else "", names) for rows, names in by_length.items()
    )


def _base(path: Path, label: str, names: list[str]) -> ColumnSet:
    from scipy.io import loadmat

    def blocks(numbers: Sequence[str], labels: Sequence[str]) -> Iterator[Columns]:
        wanted = [*numbers, *labels]
        found = loadmat(path, variable_names=wanted)
        columns: Columns = {}
        for name in numbers:
            columns[name] = as_number(str(path), name, np.asarray(found[name]).ravel())
        for name in labels:
            columns[name] = as_label(np.asarray(found[name]).ravel())
        yield columns

    return ColumnSet(label, tuple(names), isolated(path, "MAT", blocks))
