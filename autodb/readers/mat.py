"""MATLAB v5: vectors and the columns of matrices are channels, those of structs by `struct.field`.

Scalars and the rest are ignored. An array of structs, or of cells with arrays, has a time base for
each; v7.3 is HDF5.
"""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from autodb.errors import UnusableInput
from autodb.files.text import TextSection
from autodb.readers import hdf5
from autodb.readers._base import Columns, ColumnSet, as_label, as_number
from autodb.readers._child import isolated, isolated_value
from autodb.readers.hdf5_columns import LONGER, MOST_BESIDE
from autodb.wording import phrase

MOST_STRUCTS = 1000
"""Structs of one array that are looked at. Chosen: a struct a cut, of some hundred cuts."""
_NUMBERS = {"double", "single", "logical"} | {
    f"{u}int{n}" for u in ("", "u") for n in (8, 16, 32, 64)
}
_HOLDING = ("struct", "cell")
"""Classes of MATLAB that are read; objects, such as a timetable, are not."""
_KINDS = "fiub"


def open_file(path: Path, stated: TextSection) -> tuple[ColumnSet, ...]:
    """Open a MAT file; vectors of one length, and of one struct of an array, share a time base."""
    with path.open("rb") as file:
        if b"MATLAB 7.3" in file.read(128):
            return hdf5.open_file(path, stated)
    found = isolated_value(path, "MAT", lambda: list(_lengths(path)))
    bases: dict[tuple[str, int], dict[str, str]] = {}
    for within, name, variable, rows in found:
        bases.setdefault((within, rows), {})[name] = variable
    several = len(bases) > 1
    return tuple(
        _base(path, within, names, _label(within, rows, bases) if several else "")
        for (within, rows), names in bases.items()
    )


def _label(within: str, rows: int, bases: Mapping[tuple[str, int], object]) -> str:
    alone = sum(other == within for other, _ in bases) == 1
    return within if within and alone else f"{within} {rows} rows".strip()


def _lengths(path: Path) -> Iterator[tuple[str, str, str, int]]:
    """Yield of each column the struct of an array that it lies in, its name, variable and rows."""
    for variable, columns in _variables(path).items():
        for (within, name), values in columns.items():
            yield within, name, variable, len(values)


_Named = dict[tuple[str, str], Any]
"""Columns by the struct of an array that they lie in, and their name."""


def _variables(path: Path, wanted: list[str] | None = None) -> dict[str, _Named]:
    """Return the columns of each variable of a file; ``wanted``: of these alone."""
    from scipy.io import loadmat, whosmat

    try:
        kinds = {name: kind for name, _, kind in whosmat(path)}
    except TypeError:
        raise UnusableInput(
            phrase(
                "{file}: holds an object that only MATLAB reads; save its numbers as arrays or "
                "structs",
                file=path,
            )
        ) from None
    held = [name for name, kind in kinds.items() if kind in _NUMBERS or kind in _HOLDING]
    wanted = held if wanted is None else [name for name in wanted if name in held]
    found: dict[str, _Named] = {}
    for name, value in loadmat(path, variable_names=wanted, simplify_cells=True).items():
        if not name.startswith("__"):
            _take(found.setdefault(name, {}), "", name, value)
    return found


def _take(found: _Named, within: str, name: str, value: Any) -> None:
    """Take in a variable, the fields of a struct, or each struct of an array."""
    if isinstance(value, Mapping):
        for field, inner in value.items():
            _take(found, within, f"{name}.{field}", inner)
    elif _are_all(value, Mapping) and not within:
        for place, struct in enumerate(value[:MOST_STRUCTS], start=1):
            for field, inner in struct.items():
                _take(found, f"{name}({place})", str(field), inner)
    elif _are_all(value, np.ndarray) and not within:
        for place, cell in enumerate(value[:MOST_STRUCTS], start=1):
            _take(found, f"{name}{{{place}}}", name, cell)
    elif isinstance(value, np.ndarray) and value.dtype.kind in _KINDS:
        rows, beside = max(value.shape, default=0), min(value.shape, default=0)
        if value.ndim == 1 and rows > 1:
            found[within, name] = value
        elif value.ndim == 2 and 0 < beside <= MOST_BESIDE and rows >= LONGER * beside:
            columns = value.T if value.shape[0] == rows else value
            for place, column in enumerate(columns, start=1):
                found[within, f"{name} {place}"] = column


def _are_all(value: Any, kind: type) -> bool:
    """Say whether a value is an array of structs, or of cells that hold arrays."""
    listed = isinstance(value, list) or (isinstance(value, np.ndarray) and value.dtype == object)
    return listed and len(value) > 0 and all(isinstance(one, kind) for one in value)


def _base(path: Path, within: str, variables: dict[str, str], label: str) -> ColumnSet:
    def blocks(numbers: Sequence[str], labels: Sequence[str]) -> Iterator[Columns]:
        wanted = sorted({variables[name] for name in (*numbers, *labels)})
        found = _variables(path, wanted)
        read = {name: found[variables[name]][within, name] for name in (*numbers, *labels)}
        columns: Columns = {name: as_number(str(path), name, read[name]) for name in numbers}
        yield columns | {name: as_label(read[name]) for name in labels}

    return ColumnSet(label, tuple(variables), isolated(path, "MAT", blocks))
