"""What of an HDF5 file is a column: a vector, a field of records, one of a few in a matrix."""

import pickletools
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from autodb.errors import UnusableInput
from autodb.wording import phrase

MOST_BESIDE = 64
"""Columns of a matrix that are channels; a wider one is a picture or a spectrum. Chosen."""
LONGER = 4
"""A matrix of channels has as many times more rows than columns at the least. Chosen."""


@dataclass(frozen=True)
class Vector:
    """A dataset with one long side, a column of a matrix, or a field of a dataset of records.

    ``place``: which of several numbers in a row; ``across``: rows lie along the second side.
    """

    dataset: str
    rows: int
    name: str
    field: str = ""
    place: int | None = None
    across: bool = False
    unit: str = ""

    @property
    def folder(self) -> str:
        """Folder that the dataset lies in; empty for the root."""
        return self.dataset.rpartition("/")[0]


def vectors(h5py: Any, path: Path) -> list[Vector]:
    """Return the columns of a file; raises UnusableInput for rows in another file."""
    found: list[Vector] = []

    def visit(name: str, item: Any) -> None:
        if not isinstance(item, h5py.Dataset) or name.startswith(("#refs#", "#subsystem#")):
            return
        if "MATLAB_object_decode" in item.attrs:  # a timetable's reference to what it holds
            return
        if item.external or item.is_virtual:
            raise UnusableInput(
                phrase(
                    "{file}: the rows of '{name}' lie in another file; use a file that holds the "
                    "rows itself",
                    file=path,
                    name=name,
                )
            )
        if not item.shape or 0 in item.shape:
            return
        if item.dtype.names:
            found.extend(_fields(name, item) if item.ndim == 1 else ())
        elif sum(n != 1 for n in item.shape) <= 1 and max(item.shape) > 1:
            if _is_column(item):
                found.append(Vector(name, max(item.shape), name, unit=_unit(item)))
        elif item.ndim == 2:
            found.extend(_matrix(name, item))

    with h5py.File(path, "r") as file:
        file.visititems(visit)
    return found


def _fields(name: str, item: Any) -> Iterator[Vector]:
    """Yield the fields of records; one of several numbers as that many columns."""
    for field in item.dtype.names:
        shape = item.dtype[field].shape
        if not shape:
            yield Vector(name, len(item), field, field)
        elif len(shape) == 1 and shape[0] <= MOST_BESIDE:
            names = _named_by_pandas(item, field, shape[0])
            for place in range(shape[0]):
                yield Vector(name, len(item), names[place], field, place)


def _named_by_pandas(item: Any, field: str, width: int) -> list[str]:
    """Return the names of the numbers of a block, as pandas wrote them down, else their places.

    They are a pickle, whose texts are read without running it.
    """
    counted = [f"{field} {place}" for place in range(1, width + 1)]
    written = item.attrs.get(f"{field}_kind")
    if not isinstance(written, bytes | np.bytes_):
        return counted
    try:
        said = [value for _, value, _ in pickletools.genops(bytes(written))]
    except Exception:  # a damaged pickle fails in any way
        return counted
    names = [value for value in said if isinstance(value, str)]
    return names if len(names) == width else counted


def _matrix(name: str, item: Any) -> Iterator[Vector]:
    """Yield the columns of a matrix that is longer than wide; MATLAB's and pandas' lie across."""
    rows, beside = max(item.shape), min(item.shape)
    if not _is_column(item) or beside > MOST_BESIDE or rows < LONGER * beside:
        return
    items = name.removesuffix("_values") + "_items"
    written = item.parent.get(items.rpartition("/")[2]) if name.endswith("_values") else None
    names = [f"{name} {place}" for place in range(1, beside + 1)]
    if written is not None and len(written) == beside:
        names = [v.decode("utf-8", "replace") if isinstance(v, bytes) else str(v) for v in written]
    across = item.shape[1] == rows
    for place in range(beside):
        yield Vector(name, rows, names[place], place=place, across=across, unit=_unit(item))


def _unit(item: Any) -> str:
    said = item.attrs.get("unit", item.attrs.get("units", ""))
    return said.decode("utf-8", "replace") if isinstance(said, bytes) else str(said)


def _is_column(item: Any) -> bool:
    if item.dtype.kind in "SO":
        return bool(item.ndim == 1)
    return item.dtype.kind in "fiub" and item.attrs.get("MATLAB_class") != b"char"


def cells(file: Any, vector: Vector, rows: range) -> Any:
    """Return the cells of a column in a range of rows."""
    data = file[vector.dataset]
    span = slice(rows.start, rows.stop)
    if vector.place is not None and not vector.field:
        values = data[vector.place, span] if vector.across else data[span, vector.place]
    else:
        where = tuple(span if n == vector.rows else slice(None) for n in data.shape)
        values = np.asarray(data[where])
        values = values[vector.field] if vector.field else values.ravel()
        values = values if vector.place is None else values[:, vector.place]
    values = np.asarray(values)
    if values.dtype.kind in "SO":
        return np.array(
            [v.decode("utf-8", "replace") if isinstance(v, bytes) else v for v in values],
            dtype=object,
        )
    return values
