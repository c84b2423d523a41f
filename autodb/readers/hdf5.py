"""HDF5: one-dimensional datasets are columns; a folder with its own `t` or `cut` is a time base.

Datasets that lie under no such folder share a time base with those of equal length. A dataset of
records (compound type) is a table of its own. MATLAB v7.3 files are read alike.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from autodb.errors import UnusableInput
from autodb.files.text import TextSection
from autodb.readers._base import ColumnSet, library
from autodb.readers._child import isolated, isolated_value
from autodb.readers._sliced import Cells, sliced

_KEYS = ("t", "cut")
CHUNK_CACHE = 1 << 26
"""Bytes of unpacked chunks that are kept for each dataset, so that none is unpacked twice."""


@dataclass(frozen=True)
class _Vector:
    """A dataset with one long side, or a field of a dataset of records."""

    dataset: str
    rows: int
    field: str = ""
    unit: str = ""

    @property
    def folder(self) -> str:
        """Folder that the dataset lies in; empty for the root."""
        return self.dataset.rpartition("/")[0]


def open_file(path: Path, _: TextSection) -> tuple[ColumnSet, ...]:
    """Open an HDF5 file by the names and shapes of its datasets."""
    h5py = library(path, "h5py")
    found = isolated_value(path, "HDF5", lambda: [asdict(v) for v in _vectors(h5py, path)])
    grouped = _grouped([_Vector(**vector) for vector in found])
    several = len(grouped) > 1
    return tuple(
        _base(h5py, path, name if several else "", columns) for name, columns in grouped.items()
    )


def _vectors(h5py: Any, path: Path) -> list[_Vector]:
    found: list[_Vector] = []

    def visit(name: str, item: Any) -> None:
        if not isinstance(item, h5py.Dataset) or name.startswith("#refs#"):
            return
        if item.external or item.is_virtual:
            raise UnusableInput(
                f"{path}: the rows of '{name}' lie in another file; use a file that holds the "
                "rows itself"
            )
        if not item.shape or sum(n != 1 for n in item.shape) != 1 or 0 in item.shape:
            return
        if item.dtype.names and item.ndim == 1:
            found.extend(_Vector(name, len(item), field) for field in item.dtype.names)
        elif _is_column(item):
            found.append(_Vector(name, max(item.shape), unit=_unit(item)))

    with h5py.File(path, "r") as file:
        file.visititems(visit)
    return found


def _unit(item: Any) -> str:
    said = item.attrs.get("unit", item.attrs.get("units", ""))
    return said.decode("utf-8", "replace") if isinstance(said, bytes) else str(said)


def _is_column(item: Any) -> bool:
    if item.dtype.kind in "SO":
        return bool(item.ndim == 1)
    return item.dtype.kind in "fiub" and item.attrs.get("MATLAB_class") != b"char"


def _grouped(vectors: list[_Vector]) -> dict[str, dict[str, _Vector]]:
    """Return the columns of each time base by its name."""
    homes = {(v.folder, v.rows) for v in vectors if v.dataset.rpartition("/")[2] in _KEYS}
    grouped: dict[str, dict[str, _Vector]] = {}
    for vector in vectors:
        home = _home(vector, homes)
        if vector.field:
            base, column = vector.dataset, vector.field
        elif home is not None:
            base, column = home or "/", vector.dataset.removeprefix(f"{home}/")
        else:
            base, column = f"{vector.rows} rows", vector.dataset
        grouped.setdefault(base, {})[column] = vector
    return grouped


def _home(vector: _Vector, homes: set[tuple[str, int]]) -> str | None:
    folder = vector.folder
    while True:
        if (folder, vector.rows) in homes:
            return folder
        if not folder:
            return None
        folder = folder.rpartition("/")[0]


def _base(h5py: Any, path: Path, label: str, columns: dict[str, _Vector]) -> ColumnSet:
    rows = next(iter(columns.values())).rows

    @contextmanager
    def opened() -> Iterator[Cells]:
        with h5py.File(path, "r", rdcc_nbytes=CHUNK_CACHE) as file:
            yield lambda name, span: _cells(file, columns[name], span)

    units = {name: vector.unit for name, vector in columns.items()}
    blocks = sliced(path, "HDF5", rows=rows, opened=opened)
    return ColumnSet(label, tuple(columns), isolated(path, "HDF5", blocks), units)


def _cells(file: Any, vector: _Vector, rows: range) -> Any:
    data = file[vector.dataset]
    span = slice(rows.start, rows.stop)
    where = tuple(span if n == vector.rows else slice(None) for n in data.shape)
    values = np.asarray(data[where]).ravel()
    values = values[vector.field] if vector.field else values
    if values.dtype.kind in "SO":
        return np.array(
            [v.decode("utf-8", "replace") if isinstance(v, bytes) else v for v in values],
            dtype=object,
        )
    return values
