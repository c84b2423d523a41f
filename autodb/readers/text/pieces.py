"""Lines of a text table become Arrow columns, piece by piece, or one line says which row is odd."""

import csv as plain
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from operator import methodcaller
from pathlib import Path

import pyarrow as pa
from pyarrow import csv

from autodb.errors import UnusableInput
from autodb.readers._base import not_a_number
from autodb.readers.text.cells import SPACE, UNKNOWN, is_number, on_one_line
from autodb.readers.text.layout import TextLayout
from autodb.readers.text.presets import NO_ROWS
from autodb.wording import msgid, phrase, stored_msgid

REMARK = b"#"
"""Begins a remark in most files that have some."""
WORKS = msgid(
    "give each row a cell for each column, or state under [csv] in the side file "
    "how the table is written"
)
OTHER_LENGTH = stored_msgid(
    "{file}: row {row} has {fields} fields, the header names {count} columns; give each row a "
    "cell for each column, or state under [csv] in the side file how the table is written"
)


@dataclass(frozen=True)
class TextPiece:
    """Whole lines of a file; ``first_row`` rows of data stand before them."""

    path: Path
    text: bytes
    layout: TextLayout
    first_row: int

    def parse(self, numbers: Sequence[int], labels: Sequence[int]) -> pa.Table:
        """Return the columns at these places as float64 and text, called by their place.

        Raises UnusableInput naming the row.
        """
        piece = replace(self, text=tidied(self.text, self.layout))
        try:
            return piece.read(numbers, labels)
        except (pa.ArrowException, UnicodeDecodeError, UnusableInput) as error:
            for text in (_on_one_line(piece.text), _without(piece.text, REMARK)):
                if text != piece.text:  # remarks may begin below what was looked at
                    return replace(piece, text=text).parse(numbers, labels)
            if isinstance(error, UnusableInput):
                raise
            reason = (str(error).splitlines() or [""])[0]
            raise UnusableInput(piece.fault(numbers, reason)) from None

    def read(self, numbers: Sequence[int], labels: Sequence[int]) -> pa.Table:
        """Return the columns; raises what Arrow raises, UnusableInput for a quote left open."""
        layout = self.layout
        kinds = {str(place): pa.float64() for place in numbers}
        kinds |= {str(place): pa.string() for place in labels}
        table = csv.read_csv(
            pa.BufferReader(self.text),
            read_options=csv.ReadOptions(column_names=[str(k) for k in range(len(layout.names))]),
            parse_options=csv.ParseOptions(delimiter=layout.separator),
            convert_options=csv.ConvertOptions(
                include_columns=list(kinds),
                column_types=kinds,
                decimal_point=layout.decimal,
                null_values=[*sorted(UNKNOWN), " "],
            ),
        )
        self._refuse_open_quote(table.num_rows)
        return table

    def _refuse_open_quote(self, rows: int) -> None:
        """Raise UnusableInput where a quote that does not close has swallowed rows."""
        if b'"' not in self.text:
            return
        lines = [line for line in self.text.splitlines() if line]
        if len(lines) == rows:
            return
        odd = next((i for i, line in enumerate(lines) if line.count(b'"') % 2), 0)
        raise UnusableInput(
            phrase(
                "{file}: row {odd}: a quote opens and does not close on its line; write quotes "
                "in pairs, or double them inside a text",
                file=self.path,
                odd=self.first_row + odd + 1,
            )
        )

    def fault(self, numbers: Sequence[int], reason: str) -> str:
        """Return the line that names the first row at fault."""
        lines = self.text.decode("utf-8", "replace").splitlines()
        try:
            cells = plain.reader(lines, delimiter=self.layout.separator)
            rows = (row for row in cells if row)
            for number, row in enumerate(rows, start=self.first_row + 1):
                fault = self._fault_of_row(number, row, numbers)
                if fault:
                    return fault
        except plain.Error as error:
            reason = str(error)
        return phrase(
            "{file}: not a table of text ({reason}); {works}",
            file=self.path,
            reason=reason,
            works=phrase(WORKS),
        )

    def _fault_of_row(self, number: int, row: list[str], numbers: Sequence[int]) -> str:
        names = self.layout.names
        if len(row) != len(names):
            return OTHER_LENGTH.format(
                file=self.path, row=number, fields=len(row), count=len(names)
            )
        for place in numbers:
            cell = row[place].strip()
            if cell not in UNKNOWN and not is_number(cell, self.layout.decimal):
                return not_a_number(str(self.path), names[place], number, cell)
        return ""


def tidied(text: bytes, layout: TextLayout) -> bytes:
    """Return lines as Arrow reads them: no remarks, single spaces, all cells, no thousands."""
    for mark in (*NO_ROWS, layout.comment):
        said = mark.encode()
        if said[:1] in text and said in text and said:  # one byte is found ten times as fast
            text = _without(text, said)
    if layout.separator == SPACE:
        text = _single_spaced(text)
    if layout.thousands:
        text = _ungrouped(text, layout)
    if layout.short_rows:
        text = _filled(text, layout.separator.encode(), len(layout.names))
    return text


def _on_one_line(text: bytes) -> bytes:
    """Return lines with the cells between quotes on one line each."""
    if b'"' not in text:
        return text
    return on_one_line(text.decode("utf-8", "surrogateescape")).encode("utf-8", "surrogateescape")


def _without(text: bytes, mark: bytes) -> bytes:
    """Return lines without those that begin with ``mark``."""
    return re.sub(rb"(?m)^" + re.escape(mark) + rb".*\n?", b"", text)


def _single_spaced(text: bytes) -> bytes:
    """Return lines with one space between cells and none at their ends."""
    text = text.replace(b"\t", b" ").replace(b"\r\n", b"\n")
    while b"  " in text:
        text = text.replace(b"  ", b" ")
    text = text.replace(b"\n ", b"\n").replace(b" \n", b"\n")
    return text.removeprefix(b" ").removesuffix(b" ")


def _ungrouped(text: bytes, layout: TextLayout) -> bytes:
    """Return lines whose numbers have nothing between thousands."""
    between = re.escape(layout.thousands.encode())
    cell = rb"(?<![^" + re.escape(layout.separator.encode()) + rb'\n"])'
    number = cell + rb"[+-]?\d{1,3}(?:" + between + rb"\d{3})+(?![\d" + between + rb"])"
    mark = layout.thousands.encode()
    return re.sub(number, lambda found: found[0].replace(mark, b""), text)


def _filled(text: bytes, separator: bytes, cells: int) -> bytes:
    """Return lines with empty cells at the end of those that end early, and none beyond the last.

    A line of empty cells alone is none.
    """
    text = text.replace(b"\r\n", b"\n").removesuffix(b"\n")
    there: set[int] = set(map(methodcaller("count", separator), text.split(b"\n")))
    if len(there) == 1 and 0 <= (lacking := cells - 1 - min(there)) < cells - 1:
        ending = separator * lacking + b"\n"
        return text.replace(b"\n", ending) + ending
    lines = []
    for line in text.splitlines():
        lacking = cells - 1 - line.count(separator)
        if lacking < 0 and not line.endswith(separator * -lacking):
            lines.append(line)  # a row with too many cells, which Arrow refuses
        elif line.strip(separator + b" "):
            lines.append(line + separator * lacking if lacking > 0 else _cut(line, -lacking))
    return b"\n".join(lines) + b"\n" if lines else b""


def _cut(line: bytes, over: int) -> bytes:
    return line[:-over] if over else line
