"""Workbooks (Excel, OpenDocument): each sheet with a table is a time base.

Where a sheet's table begins, what names its columns and which units it states is found out as in a
text. A workbook is read whole: a sheet has a million rows at the most.
"""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from datetime import timedelta
from pathlib import Path
from typing import Any

import numpy as np

from autodb.errors import UnusableInput, near_words
from autodb.files.text import TextSection
from autodb.readers._base import (
    Columns,
    ColumnSet,
    as_label,
    as_number,
    library,
    refuse_twice,
)
from autodb.readers._child import isolated, isolated_value
from autodb.readers._sliced import block_rows
from autodb.readers.text.beside import lines_of_table
from autodb.readers.text.cells import UNKNOWN, is_number
from autodb.readers.text.layout import column_names, stated_units
from autodb.readers.text.rows import TablePlace, find_table, stated_table
from autodb.wording import phrase

LIBRARY = "python_calamine"
KIND = "spreadsheet"
LOOKED_AT = 200
"""Rows of a sheet that its table is looked for in. Chosen."""


@dataclass(frozen=True)
class _Sheet:
    """A sheet with a table: its columns and the first row, from 0.

    ``ends``: the row behind its last one where remarks may stand below it. ``commas``: whether a
    text such as `1,5` is a number.
    """

    name: str
    columns: list[str]
    first: int
    ends: int | None
    commas: bool
    layout: str
    units: dict[str, str] = field(default_factory=dict)


def open_file(path: Path, stated: TextSection) -> tuple[ColumnSet, ...]:
    """Open a workbook by the tables in its sheets."""
    calamine = library(path, LIBRARY)
    found = isolated_value(path, KIND, lambda: _sheets(calamine, path, stated))
    sheets = [_Sheet(**sheet) for sheet in found]
    if not sheets:
        raise UnusableInput(
            phrase("{file}: no sheet has a table with numbers below names", file=path)
        )
    return tuple(_base(calamine, path, sheet, several=len(sheets) > 1) for sheet in sheets)


def _sheets(calamine: Any, path: Path, stated: TextSection) -> list[dict[str, Any]]:
    book = calamine.CalamineWorkbook.from_path(str(path))
    names = list(book.sheet_names)
    if stated.sheet is not None and stated.sheet not in names:
        raise UnusableInput(
            phrase(
                "{file}: no sheet '{sheet}'{hint}",
                file=path,
                sheet=stated.sheet,
                hint=near_words(stated.sheet, names),
            )
        )
    found = []
    for name in [stated.sheet] if stated.sheet else names:
        cells = book.get_sheet_by_name(name).to_python(skip_empty_area=False, nrows=LOOKED_AT)
        sheet = _sheet(name, [[_text(cell) for cell in row] for row in cells], stated)
        if sheet is not None:
            refuse_twice(path, sheet.columns, f"sheet '{name}'")
            found.append(asdict(sheet))
    return found


def _sheet(name: str, rows: list[list[str]], stated: TextSection) -> _Sheet | None:
    kept = [row if any(row) else [] for row in rows]
    commas = stated.decimal != "."

    def number(cell: str) -> bool:
        return is_number(cell) or (commas and is_number(cell, ","))

    ends = lines_of_table(kept, max(map(len, kept), default=0)) if len(kept) < LOOKED_AT else None
    place = stated_table(kept, find_table(kept[:ends], number), number, stated)
    if place is None:
        return None
    named = [] if place.header is None else kept[place.header]
    names = list(stated.names) if stated.names is not None else named
    names = [*names[: place.width], *[""] * (place.width - len(names))]
    units = [] if place.units is None else kept[place.units]
    columns = column_names(names, times=False)
    return _Sheet(
        name,
        list(columns),
        place.first,
        ends,
        commas,
        _words(name, place, ends if ends is not None and any(map(any, kept[ends:])) else None),
        {columns[k]: unit for k, unit in stated_units(names, units).items()},
    )


def _words(name: str, place: TablePlace, ends: int | None) -> str:
    said = [f"sheet '{name}'"]
    said += [phrase("columns are called by their place")] if place.header is None else []
    said += (
        [phrase("row {header} names the columns", header=place.header + 1)] if place.header else []
    )
    said += (
        [phrase("row {units} has units", units=place.units + 1)] if place.units is not None else []
    )
    said += (
        [phrase("remarks from row {ends} on left out", ends=ends + 1)] if ends is not None else []
    )
    return ", ".join(said)


def _text(cell: Any) -> str:
    """Return a cell as text, a number in full."""
    return repr(cell) if isinstance(cell, float) else str(cell).strip()


def _base(calamine: Any, path: Path, sheet: _Sheet, *, several: bool) -> ColumnSet:
    def blocks(numbers: Sequence[str], labels: Sequence[str]) -> Iterator[Columns]:
        book = calamine.CalamineWorkbook.from_path(str(path))
        cells = book.get_sheet_by_name(sheet.name).to_python(skip_empty_area=False)
        rows = [
            row
            for row in cells[sheet.first : sheet.ends]
            if any(cell not in ("", None) for cell in row)
        ]
        if not rows:
            raise UnusableInput(
                phrase("{file}: no rows of data in sheet '{sheet}'", file=path, sheet=sheet.name)
            )
        place = {name: k for k, name in enumerate(sheet.columns)}
        where = f"{path}: sheet '{sheet.name}'"
        for span in block_rows(len(rows)):
            part = rows[span.start : span.stop]
            columns: Columns = {}
            for name in numbers:
                values = _cells([_value(row[place[name]], commas=sheet.commas) for row in part])
                columns[name] = as_number(where, name, values, span.start)
            for name in labels:
                columns[name] = as_label(_cells([_plain(row[place[name]]) for row in part]))
            yield columns

    return ColumnSet(
        sheet.name if several else "",
        tuple(sheet.columns),
        isolated(path, KIND, blocks),
        sheet.units,
        sheet.layout,
    )


def _cells(values: list[Any]) -> Any:
    return np.array([*values, None], dtype=object)[:-1]


def _value(cell: Any, *, commas: bool) -> Any:
    """Return a cell that shall be a number."""
    if isinstance(cell, str) and commas and is_number(cell.strip(), ","):
        return cell.strip().replace(",", ".")
    if isinstance(cell, str) and cell.strip() in UNKNOWN:
        return None
    return cell.total_seconds() if isinstance(cell, timedelta) else cell


def _plain(cell: Any) -> Any:
    """Return a cell that shall be a text: whole numbers without a decimal point."""
    return f"{cell:.15g}" if isinstance(cell, float) else cell
