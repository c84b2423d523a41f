"""HDF5: one-dimensional datasets are columns; a folder with its own `t` or `cut` is a time base.

Datasets that lie under no such folder share a time base with those of equal length. A dataset of
records (compound type) is a table of its own. MATLAB v7.3 files are read alike.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any

from autodb.files.text import TextSection
from autodb.readers._base import ColumnSet, library
from autodb.readers._child import isolated, isolated_value
from autodb.readers._sliced import Cells, sliced
from autodb.readers.hdf5_columns import Vector, cells, vectors

_KEYS = ("t", "cut")
CHUNK_CACHE = 1 << 26
"""Bytes of unpacked chunks that are kept for each dataset, so that none is unpacked twice."""


def open_file(path: Path, _: TextSection) -> tuple[ColumnSet, ...]:
    """Open an HDF5 file by the names and shapes of its datasets."""
    h5py = library(path, "h5py")
    found = isolated_value(path, "HDF5", lambda: [asdict(v) for v in vectors(h5py, path)])
    grouped = _grouped([Vector(**vector) for vector in found])
    several = len(grouped) > 1
    return tuple(
        _base(h5py, path, name if several else "", columns) for name, columns in grouped.items()
    )


def _grouped(vectors: list[Vector]) -> dict[str, dict[str, Vector]]:
    """Return the columns of each time base by its name."""
    named = [v for v in vectors if not v.field and v.name.rpartition("/")[2] in _KEYS]
    homes = {(v.folder, v.rows) for v in named}
    grouped: dict[str, dict[str, Vector]] = {}
    for vector in vectors:
        home = _home(vector, homes)
        if vector.field:
            base, column = vector.dataset, vector.name
        elif home is not None:
            base, column = home or "/", vector.name.removeprefix(f"{home}/")
        else:
            base, column = f"{vector.rows} rows", vector.name
        grouped.setdefault(base, {})[column] = vector
    return grouped


def _home(vector: Vector, homes: set[tuple[str, int]]) -> str | None:
    folder = vector.folder
    while True:
        if (folder, vector.rows) in homes:
            return folder
        if not folder:
            return None
        folder = folder.rpartition("/")[0]


def _base(h5py: Any, path: Path, label: str, columns: dict[str, Vector]) -> ColumnSet:
    rows = next(iter(columns.values())).rows

    @contextmanager
    def opened() -> Iterator[Cells]:
        with h5py.File(path, "r", rdcc_nbytes=CHUNK_CACHE) as file:
            yield lambda name, span: cells(file, columns[name], span)

    units = {name: vector.unit for name, vector in columns.items()}
    blocks = sliced(path, "HDF5", rows=rows, opened=opened)
    return ColumnSet(label, tuple(columns), isolated(path, "HDF5", blocks), units)
