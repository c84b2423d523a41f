"""One file a reader: bytes on disk become named NumPy columns, or one line says why not.

A file holds one or several *time bases*: sets of columns that share one length. Each is read by
itself and in blocks; nothing is joined here.
"""

from importlib import import_module
from pathlib import Path

from autodb.errors import UnusableInput, no_such_file
from autodb.files.text import TextSection
from autodb.readers._base import BLOCK_ROWS, Columns, ColumnSet, Labels
from autodb.wording import phrase, stored_msgid

__all__ = ["BLOCK_ROWS", "MOST_COLUMNS", "READERS", "ColumnSet", "Columns", "Labels", "open_bases"]

MOST_COLUMNS = 10_000
"""Columns of a file, of all its time bases. Chosen: controls record some hundreds."""
_TEXTS = (".csv", ".txt", ".tsv", ".lvm", ".dat", ".asc", ".log", ".gz", ".zip")
READERS = {
    **dict.fromkeys(_TEXTS, "text.reading"),
    **dict.fromkeys((".xlsx", ".xlsm", ".xls", ".xlsb", ".ods"), "workbook"),
    ".parquet": "parquet",
    ".mat": "mat",
    ".h5": "hdf5",
    ".hdf5": "hdf5",
    ".tdms": "tdms",
    ".mf4": "mf4",
    ".mdf": "mf4",
    ".xml": "sinumerik",
    ".json": "edge",
}
"""The module that reads a kind of file; it is imported when a file needs it."""
UNKNOWN_KIND = stored_msgid("{file}: unknown kind of file; use {kinds}")
EMPTY = stored_msgid("{file}: the file is empty")


def reader_of(path: Path) -> str:
    """Return the module that reads the file ``path``.

    Raises UnusableInput for what is missing, or no kind of file that is read.
    """
    if path.is_dir():
        raise UnusableInput(phrase("{file}: is a folder; give one recording file", file=path))
    if not path.exists():
        raise no_such_file(path)
    reader = READERS.get(path.suffix.lower())
    if path.suffix.lower() == ".toml":
        said = phrase("{file}: a side file; give the recording that it stands beside", file=path)
        raise UnusableInput(said)
    if reader is None:
        raise UnusableInput(UNKNOWN_KIND.format(file=path, kinds=", ".join(READERS)))
    return reader


def open_bases(path: Path, stated: TextSection | None = None) -> tuple[ColumnSet, ...]:
    """Return the time bases of the file ``path``; their columns are read later, block by block.

    ``stated``: how a text table is written, as far as a side file says so.

    Raises UnusableInput for a missing, empty, unreadable or unknown kind of file, or one of more
    than MOST_COLUMNS columns.
    """
    reader = reader_of(path)
    try:
        with path.open("rb") as file:
            if not file.read(1):
                raise UnusableInput(EMPTY.format(file=path))
    except PermissionError:
        raise UnusableInput(phrase("{file}: no permission to read it", file=path)) from None
    open_file = import_module(f"autodb.readers.{reader}").open_file
    bases: tuple[ColumnSet, ...] = open_file(path, stated or TextSection())
    columns = sum(len(base.columns) for base in bases)
    if columns > MOST_COLUMNS:
        raise UnusableInput(
            phrase(
                "{file}: {columns} columns; send at most {most_columns}, only the channels "
                "that are needed",
                file=path,
                columns=columns,
                most_columns=MOST_COLUMNS,
            )
        )
    if not any(base.columns for base in bases):
        raise UnusableInput(
            phrase(
                "{file}: no columns of data; store vectors at the top level of a MAT file, "
                "one-dimensional datasets in HDF5, or channels with rows",
                file=path,
            )
        )
    return bases
