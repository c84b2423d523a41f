"""CSV: comma, one header line, UTF-8."""

import csv as plain
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
from pyarrow import csv

from autodb.errors import UnusableInput
from autodb.files.csvtext import restored
from autodb.readers._base import (
    Columns,
    ColumnSet,
    Labels,
    Numbers,
    not_a_number,
    numpy_columns,
    refuse_twice,
)

BLOCK_BYTES = 1 << 24
LONGEST_LINE = 1 << 24
_WORKS = "use commas between columns, points in numbers and one header line"
_UNKNOWN = csv.ConvertOptions().null_values
"""Texts that stand for a number that is not known."""


def open_file(path: Path) -> tuple[ColumnSet, ...]:
    """Open a comma-separated file by its header line."""
    names = tuple(_named(path, _header(path)))

    def blocks(numbers: Sequence[str], labels: Sequence[str]) -> Iterator[Columns]:
        row = 0
        for text in _whole_lines(path):
            piece = _Piece(path, text, names, row)
            table = piece.parse(numbers, labels)
            row += table.num_rows
            columns = numpy_columns(str(path), table, numbers, labels)
            yield columns | {name: _restored(columns[name]) for name in labels}
        if not row:
            raise UnusableInput(f"{path}: no rows of data below the header line")

    return (ColumnSet("", names, blocks),)


def _restored(labels: Labels | Numbers) -> Labels:
    """Return texts as they were before a formula among them was made neutral."""
    return np.array([restored(text) for text in labels.tolist()], dtype=np.str_)


def _header(path: Path) -> list[str]:
    with path.open("rb") as file:
        line = file.readline(LONGEST_LINE)
    if b"\x00" in line:
        raise UnusableInput(f"{path}: the header is not UTF-8 text; save it as UTF-8")
    try:
        text = line.decode("utf-8-sig").rstrip("\r\n")
    except UnicodeDecodeError:
        raise UnusableInput(f"{path}: the header is not UTF-8; save it as UTF-8") from None
    try:
        names = next(plain.reader([text]), [])
    except plain.Error as error:
        raise UnusableInput(f"{path}: no header line ({error}); {_WORKS}") from None
    if len(names) <= 1 and any(mark in text for mark in ";\t|"):
        raise UnusableInput(f"{path}: columns are not separated by commas: '{text[:60]}'; {_WORKS}")
    if not any(name.strip() for name in names):
        raise UnusableInput(f"{path}: the header line names no column; {_WORKS}")
    return names


def _named(path: Path, header: list[str]) -> list[str]:
    """Return the columns' names without spaces around them; one without a name gets its place."""
    names = [name.strip() or f"column {place}" for place, name in enumerate(header, start=1)]
    refuse_twice(path, names, "header")
    return names


def _whole_lines(path: Path) -> Iterator[bytes]:
    """Yield the rows below the header in pieces that end with a line."""
    with path.open("rb") as file:
        file.readline(LONGEST_LINE)
        rest = b""
        while piece := file.read(BLOCK_BYTES):
            cut = piece.rfind(b"\n") + 1
            if cut:
                yield rest + piece[:cut]
                rest = piece[cut:]
            else:
                rest += piece
            if len(rest) > LONGEST_LINE:
                raise UnusableInput(f"{path}: a line of more than {LONGEST_LINE} bytes; {_WORKS}")
        if rest.strip():
            yield rest


@dataclass(frozen=True)
class _Piece:
    """Whole lines of a file; ``first_row`` rows of data stand before them."""

    path: Path
    text: bytes
    names: tuple[str, ...]
    first_row: int

    def parse(self, numbers: Sequence[str], labels: Sequence[str]) -> pa.Table:
        """Return the columns as float64 and text; raises UnusableInput naming the row."""
        kinds = {**dict.fromkeys(numbers, pa.float64()), **dict.fromkeys(labels, pa.string())}
        try:
            table = csv.read_csv(
                pa.BufferReader(self.text),
                read_options=csv.ReadOptions(column_names=self.names),
                convert_options=csv.ConvertOptions(include_columns=list(kinds), column_types=kinds),
            )
            self._refuse_open_quote(table.num_rows)
            return table
        except (pa.ArrowException, UnicodeDecodeError) as error:
            reason = (str(error).splitlines() or [""])[0]
            raise UnusableInput(self._fault(numbers, reason)) from None

    def _refuse_open_quote(self, rows: int) -> None:
        """Raise UnusableInput where a quote that does not close has swallowed rows."""
        if b'"' not in self.text:
            return
        lines = [line for line in self.text.splitlines() if line]
        if len(lines) == rows:
            return
        odd = next((i for i, line in enumerate(lines) if line.count(b'"') % 2), 0)
        raise UnusableInput(
            f"{self.path}: row {self.first_row + odd + 1}: a quote opens and does not close on "
            "its line; write quotes in pairs, or double them inside a text"
        )

    def _fault(self, numbers: Sequence[str], reason: str) -> str:
        """Return the line that names the first row at fault."""
        lines = self.text.decode("utf-8", "replace").splitlines()
        try:
            rows = (row for row in plain.reader(lines) if row)
            for number, row in enumerate(rows, start=self.first_row + 1):
                fault = self._fault_of_row(number, row, numbers)
                if fault:
                    return fault
        except plain.Error as error:
            reason = str(error)
        return f"{self.path}: not a comma-separated table in UTF-8 ({reason}); {_WORKS}"

    def _fault_of_row(self, number: int, row: list[str], numbers: Sequence[str]) -> str:
        if len(row) != len(self.names):
            return (
                f"{self.path}: row {number} has {len(row)} fields, the header names "
                f"{len(self.names)} columns; {_WORKS}"
            )
        for name, cell in zip(self.names, row, strict=True):
            if name in numbers and not _is_number(cell):
                return not_a_number(str(self.path), name, number, cell)
        return ""


def _is_number(cell: str) -> bool:
    if cell.strip() in _UNKNOWN:
        return True
    try:
        float(cell)
    except ValueError:
        return False
    return True
