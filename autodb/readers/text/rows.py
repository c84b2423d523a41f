"""Where a table begins: the line that names its columns, a row of units, the first row of data."""

import re
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from autodb.files.channels import is_channel
from autodb.files.text import TextSection
from autodb.files.units import is_any_unit
from autodb.readers.text.cells import UNKNOWN, bare_unit

Cells = Sequence[str]
ALIKE = 0.8
"""Share of rows that must look like the table's for a line to be its first one. Chosen."""
AHEAD = 20
"""Rows looked at behind a line that may be the first of the table. Chosen."""
LONGEST_UNIT = 10
"""A longer text in a row of units is none, ours or not. Chosen: `micrometer`."""
_DATE = re.compile(r"\d{1,4}[./:-]\d{1,2}[./:-]\d")
_BRACKETS = (("(", ")"), ("[", "]"))
WRITTEN_OUT = frozenset(
    ("second", "volt", "ampere", "amp", "watt", "newton", "meter", "kelvin", "celsius", "hertz")
)
"""Units as scopes write them out, with a capital or without."""
COUNTED = 4
"""As many columns numbered from 0 or 1 are names that a library counted, not a row. Chosen."""


@dataclass(frozen=True)
class TablePlace:
    """Which lines of a text are what, counted from 0; None: there is no such line.

    ``width``: cells of a row. ``fit``: the share of cells, of rows of that width, that are a
    number or empty.
    """

    header: int | None
    units: int | None
    first: int
    width: int
    fit: float


def find_table(rows: Sequence[Cells], number: Callable[[str], bool]) -> TablePlace | None:
    """Find a table among lines split into cells; None where none has numbers below each other.

    ``number`` says whether a cell is one.
    """
    width = _width(rows, number)
    if width == 0:
        return None
    of_table = [row for row in rows if len(row) == width]
    numeric = numeric_columns(of_table, width, number)
    if not numeric:
        return None
    fits = [is_row(row, width, numeric, number) for row in rows]
    first = _first(rows, fits)
    if first is None:
        return None
    above = _above(rows, first, width, number)
    if above is None:
        return None
    header, units = above
    if header is None and _counted(rows[first]) and any(fits[first + 1 :]):
        header, first = first, first + 1
    return TablePlace(header, units, first, width, _fit(rows[first:], fits[first:], number))


def stated_table(
    rows: Sequence[Cells],
    found: TablePlace | None,
    number: Callable[[str], bool],
    stated: TextSection,
) -> TablePlace | None:
    """Return where a table begins as stated, else as found; None where that is no line."""
    lines = (stated.header_line, stated.units_line, stated.first_line)
    if all(line is None for line in lines):
        return found
    header, units, first = lines
    begins = max(header or 0, units or 0) if first is None else first - 1
    begins = next((line for line in range(begins, len(rows)) if rows[line]), len(rows))
    if begins == len(rows) or max(header or 0, units or 0) > begins:
        return None
    if header is None:
        names = found.header if found is not None and found.first == begins else None
    else:
        names = header - 1 if header else None
    fits = [bool(row) for row in rows[begins:]]
    return TablePlace(
        names,
        units - 1 if units else None,
        begins,
        len(rows[begins]),
        _fit(rows[begins:], fits, number),
    )


def _fit(rows: Sequence[Cells], fits: Sequence[bool], number: Callable[[str], bool]) -> float:
    """Return the share of the cells of rows that are numbers or empty, in rows that fit."""
    known = sum(
        number(cell) or cell in UNKNOWN
        for row, fit in zip(rows, fits, strict=True)
        for cell in (row if fit else ())
    )
    return known / max(sum(map(len, rows)), 1)


def _width(rows: Sequence[Cells], number: Callable[[str], bool]) -> int:
    """Return how many cells most rows with numbers have, from the half of the lines on."""
    later = rows[len(rows) // 2 :]
    counts = Counter(len(row) for row in later if any(number(cell) for cell in row))
    return counts.most_common(1)[0][0] if counts else 0


def numeric_columns(rows: Sequence[Cells], width: int, number: Callable[[str], bool]) -> list[int]:
    """Return the places of columns that hold numbers, in the lower half of the rows."""
    later = rows[len(rows) // 2 :]
    found = []
    for place in range(width):
        known = [cell for row in later if (cell := row[place]) not in UNKNOWN]
        if known and sum(map(number, known)) >= ALIKE * len(known):
            found.append(place)
    return found


def is_row(row: Cells, width: int, numeric: list[int], number: Callable[[str], bool]) -> bool:
    """Say whether a line is a row of the table: its columns of numbers hold some, and no text."""
    if len(row) != width:
        return False
    known = [cell for place in numeric if (cell := row[place]) not in UNKNOWN]
    return bool(known) and all(map(number, known))


def _first(rows: Sequence[Cells], fits: Sequence[bool]) -> int | None:
    """Return the first line from which on nearly all lines are rows of the table."""
    for line, fit in enumerate(fits):
        ahead = [f for row, f in zip(rows[line:], fits[line:], strict=True) if row][:AHEAD]
        if fit and sum(ahead) >= ALIKE * len(ahead):
            return line
    return None


def _above(
    rows: Sequence[Cells], first: int, width: int, number: Callable[[str], bool]
) -> tuple[int | None, int | None] | None:
    """Return the lines of names and of units above the first row; None where names do not fit it.

    A line right above it that has several cells, but not a name for each column, says that the
    cells of the rows are not what they seem.
    """
    lines = [line for line in range(first) if any(rows[line]) and not _is_setting(rows[line])][-2:]
    fits = [_names(rows[line], width) and not any(map(number, rows[line])) for line in lines]
    if not lines or not fits[-1]:
        beside = lines and lines[-1] == first - 1 and len(rows[first - 1]) > 1
        return None if beside else (None, None)
    if len(lines) == 2 and are_units(rows[lines[1]]):
        names = rows[lines[0]]
        if fits[0] or (_names(names, width) and names[0] and not number(names[0])):
            return lines[0], lines[1]  # scopes call their channels by numbers
    return lines[-1], None


def _is_setting(row: Cells) -> bool:
    """Say whether a line is a remark on a setting, like `#timebase=80(us)`, behind a separator."""
    return any(cell.startswith("#") and "=" in cell for cell in row)


def _names(row: Cells, width: int) -> bool:
    """Say whether a line has a name for each column, none a date; a separator may end it."""
    fits = len(row) == width or (len(row) == width + 1 and not row[-1])
    return fits and not any(map(_DATE.match, row))


def are_units(row: Cells) -> bool:
    """Say whether cells are units: at least half of them known, or in brackets, none of them long.

    >>> are_units(["s", "mm", "V"]), are_units(["t", "x.position"]), are_units(["(ms)", "(mV)"])
    (True, False, True)
    """
    said = [cell for cell in row if cell]
    if not said or any(len(bare_unit(cell)) > LONGEST_UNIT for cell in said):
        return False
    known = [c for c in said if (c[0], c[-1]) in _BRACKETS or _is_unit(bare_unit(c))]
    return len(known) >= 0.5 * len(said)


def _is_unit(cell: str) -> bool:
    """Say whether a cell is a unit of anything: `t` is our time, no tonne."""
    written_out = cell.casefold() in WRITTEN_OUT
    return written_out or (is_any_unit(cell) and not is_channel(cell))


def _counted(row: Cells) -> bool:
    """Say whether a row is 0, 1, 2 … or 1, 2, 3 …: names that a library counted."""
    counts = [[str(k) for k in range(start, start + len(row))] for start in (0, 1)]
    return len(row) >= COUNTED and list(row) in counts
