"""The layout of a text table, detected from its first lines; what the side file states holds."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from autodb.errors import UnusableInput
from autodb.files.text import TextSection
from autodb.readers.text import source
from autodb.readers.text.beside import (
    labels_before,
    lines_of_table,
    stated_step_s,
    table_above_remarks,
)
from autodb.readers.text.cells import SPACE, is_number, on_one_line, split, thousands_marks
from autodb.readers.text.clocks import with_clocks
from autodb.readers.text.known import by_preset
from autodb.readers.text.layout import TextLayout, column_names, stated_units
from autodb.readers.text.presets import NO_ROWS
from autodb.readers.text.rows import (
    AHEAD,
    ALIKE,
    TablePlace,
    are_units,
    is_row,
    numeric_columns,
    stated_table,
)
from autodb.wording import phrase, stored_msgid

SEPARATORS = ("\t", ";", ",", "|", SPACE)
COMMENTS = ("#", "//", "%")
STATED = {"tab": "\t", "space": SPACE}
MOST_CELLS = 20_000
"""Cells of a file that its layout is detected from; of at least FEWEST_LINES lines. Chosen."""
FEWEST_LINES = 60
FITTING = 0.25
"""Share of cells that are numbers or empty below which a text is no table. Chosen: a table of cuts
has some columns of text."""
_TREES = re.compile(r"\s*([{\[]\s*[\"{\[]|<\?xml|<!DOCTYPE|<html)", re.IGNORECASE)
MOSTLY = 0.5
"""Rows of the beginning of a long file over the lines above them, below which it is no table: lines
of a log that look like rows once. Chosen."""
PLAIN_LINES = 20
"""Lines by which a plain table is known. Chosen."""
NO_TABLE = stored_msgid(
    "{file}: no table in it, no lines with numbers below each other; state under [csv] in the "
    "side file where one begins and what separates its columns"
)
NOT_AS_STATED = stored_msgid("{file}: no table as [csv] in the side file states; leave it out")
A_TREE = stored_msgid("{file}: {kind}, not a table; export it as CSV, a column a channel")


def detected(path: Path, stated: TextSection) -> TextLayout:
    """Return the layout of a text file.

    Raises UnusableInput where it is no text, names no column, or is not as stated.
    """
    beginning = source.beginning_of(path)
    encoding, mark = source.encoding_of(beginning)
    encoding = stated.encoding or encoding
    text = source.decoded(path, beginning[mark:], encoding)
    _refuse_trees(path, text)
    if "\x00" in text:
        raise source.other_format(path, beginning) or UnusableInput(
            phrase("{file}: not text, there are zeros in it; save it as UTF-8", file=path)
        )
    lines = lines_of(text)
    if '"' in text and not is_plain(lines) and is_plain(lines_of(on_one_line(text))):
        lines = lines_of(on_one_line(text))
    whole = len(beginning) < source.SAMPLE_BYTES
    found = None
    if stated.model_dump(exclude={"encoding"}, exclude_none=True):
        found = _best(lines, stated, whole=whole)
        if found is None:
            raise UnusableInput(NOT_AS_STATED.format(file=path))
    elif not is_plain(lines):
        said = _said_separator(lines)
        found = by_preset(lines) or _best(
            ["", *lines[1:]] if said else lines, TextSection(separator=said), whole=whole
        )
    found = with_clocks(path, found or _plain(path, lines), lines, stated)
    return replace(found, encoding=encoding)


def _refuse_trees(path: Path, text: str) -> None:
    """Raise UnusableInput for JSON and XML, in which numbers may stand below each other too."""
    found = _TREES.match(text)
    if found:
        kind = "JSON" if found[1][0] in "{[" else "XML"
        raise UnusableInput(A_TREE.format(file=path, kind=kind))


def lines_of(text: str) -> list[str]:
    """Return the lines of a text without what ends them."""
    return [line.rstrip("\r") for line in text.split("\n")]


def _said_separator(lines: Sequence[str]) -> str | None:
    """Return what a first line `sep=;` says, as spreadsheets write it."""
    first = lines[0].strip().strip('"')
    return first[4:5] or None if first.lower().startswith("sep=") else None


def is_plain(lines: Sequence[str]) -> bool:
    """Say whether lines are a header and rows with commas between cells and points in numbers."""
    header = split(lines[0], ",")
    rows = [split(line, ",") for line in lines[1 : PLAIN_LINES + 1] if line]
    if (
        len(header) < 2
        or any(map(is_number, header))
        or any(map(_is_odd, lines[: PLAIN_LINES + 1]))
    ):
        return False
    alike = [row for row in rows if len(row) == len(header)]
    if len(alike) < ALIKE * len(rows) or not alike:
        return not rows
    if any("," in cell and is_number(cell, ",") for row in rows for cell in row):
        return False
    of_numbers = numeric_columns(alike, len(header), is_number)
    if of_numbers:
        return is_row(alike[0], len(header), of_numbers, is_number)
    return not are_units(alike[0])


def _is_odd(line: str) -> bool:
    """Say whether a line is a remark, or has what may separate cells in place of commas."""
    return line.lstrip().startswith(COMMENTS) or any(mark in line for mark in ";\t|")


def _plain(path: Path, lines: Sequence[str]) -> TextLayout:
    names = split(lines[0], ",")
    if not any(names):
        raise UnusableInput(
            phrase(
                "{file}: the first line names no column; {works}",
                file=path,
                works=phrase(source.WORKS),
            )
        )
    below = [split(line, ",") for line in lines[1 : PLAIN_LINES + 1] if line]
    alike = sum(len(row) == len(names) for row in below)
    ragged = alike < 0.5 * len(below) and len(set(map(len, below))) > 1
    alone = len(names) == 1 and not any(is_number(line.strip()) for line in lines[1:])
    if alone or ragged:
        raise UnusableInput(NO_TABLE.format(file=path))
    if all(map(is_number, names)):
        return TextLayout(column_names([""] * len(names)), first=0, header=None)
    return TextLayout(column_names(names), units=stated_units(names, ()))


@dataclass(frozen=True)
class _Attempt:
    """A separator and marks in numbers, and where they find a table."""

    separator: str
    decimal: str
    thousands: str
    rows: list[list[str]]
    place: TablePlace


def _best(lines: Sequence[str], stated: TextSection, *, whole: bool) -> TextLayout | None:
    """Return the layout that makes the most cells numbers; None where none makes a table.

    ``whole``: whether these are all lines of the file.
    """
    comment = stated.comment or _comment(lines)
    kept = ["" if _is_no_row(line, comment) else line for line in lines]
    attempts = list(_attempts(kept, stated))
    best = max(attempts, key=lambda one: one.place.fit, default=None)
    if best is None or best.place.fit < FITTING:
        return None
    place = best.place
    if not whole and len(best.rows) - place.first < MOSTLY * place.first:
        return None
    found = _layout(lines, best, comment, stated)
    ends = lines_of_table(best.rows, place.width, place.first) if whole else len(best.rows)
    remarks = any(any(row) for row in best.rows[ends:]) and len(best.rows) == len(lines)
    return replace(found, ends=ends) if remarks else found


def _attempts(lines: Sequence[str], stated: TextSection) -> Iterator[_Attempt]:
    said = stated.separator
    for separator in [STATED.get(said, said)] if said else SEPARATORS:
        rows = _split(lines, separator)
        for decimal, thousands in _marks(rows, stated):
            number = partial(is_number, decimal=decimal, thousands=thousands)
            place = stated_table(rows, table_above_remarks(rows, number), number, stated)
            if place is not None and (place.width > 1 or said):
                yield _Attempt(separator, decimal, thousands, rows, place)


def _split(lines: Sequence[str], separator: str) -> list[list[str]]:
    """Return lines as cells, as many lines as have MOST_CELLS; empty lines have none."""
    rows: list[list[str]] = []
    cells = 0
    for line in lines:
        rows.append(split(line, separator) if line.strip() else [])
        cells += len(rows[-1])
        if cells > MOST_CELLS and len(rows) >= FEWEST_LINES:
            break
    return rows


def _marks(rows: list[list[str]], stated: TextSection) -> Iterator[tuple[str, str]]:
    """Yield decimal marks and thousands separators that numbers may have, plain points first."""
    for decimal in (stated.decimal,) if stated.decimal else (".", ","):
        yield decimal, stated.thousands or ""
    if stated.thousands is None:
        for between, mark in sorted(
            {found for row in rows for c in row if (found := thousands_marks(c))}
        ):
            other = mark or ("," if between == "." else ".")
            if other == (stated.decimal or other):
                yield other, between


def _comment(lines: Sequence[str]) -> str:
    """Return what some lines begin with that are no rows; empty where none does."""
    for mark in COMMENTS:
        marked = [line.lstrip().startswith(mark) for line in lines]
        if any(marked) and not all(marked):
            return mark
    return ""


def _is_no_row(line: str, comment: str) -> bool:
    begins = line.lstrip()
    return begins.startswith(NO_ROWS) or bool(comment and begins.startswith(comment))


def _layout(lines: Sequence[str], best: _Attempt, comment: str, stated: TextSection) -> TextLayout:
    place, rows = best.place, best.rows
    number = partial(is_number, decimal=best.decimal, thousands=best.thousands)
    header, names = place.header, [] if place.header is None else rows[place.header]
    labels: list[str] = []
    if header is None and comment and stated.header_line is None:
        header, names = _commented_names(lines, best, comment)
    if header is None and stated.names is None:
        labels = labels_before(rows[place.first : place.first + AHEAD], place.width, number)
    if stated.names is not None:
        names = list(stated.names)
    names = [*(names or labels)[: place.width]]
    names += [""] * (place.width - len(names))
    units = [] if place.units is None else rows[place.units]
    later = any(_is_no_row(line, comment) for line in lines[place.first : len(rows)] if line)
    return TextLayout(
        column_names(names),
        first=place.first,
        header=header,
        units_line=place.units,
        separator=best.separator,
        decimal=best.decimal,
        thousands=best.thousands,
        comment=(comment or NO_ROWS[0]) if later else "",
        short_rows=bool(stated.short_rows),
        units=stated_units(names, units),
        steps_s=_steps(lines, best, number, labelled=any(labels)),
        labelled=any(labels),
    )


def _steps(
    lines: Sequence[str], best: _Attempt, number: partial[bool], *, labelled: bool
) -> dict[int, float]:
    """Return the step of time of each column of numbers, where lines above state one.

    None of those with a name before each number is a time.
    """
    place = best.place
    rows = [row for row in best.rows[place.first :] if len(row) == place.width]
    numeric = numeric_columns(rows, place.width, number)
    step_s = stated_step_s(lines[: place.first], rows, [] if labelled else numeric)
    return {} if step_s is None else dict.fromkeys(numeric, step_s)


def _commented_names(
    lines: Sequence[str], best: _Attempt, comment: str
) -> tuple[int | None, list[str]]:
    """Return the line and the names of a header that is written as a comment above the rows."""
    above = [n for n in range(best.place.first) if lines[n].strip()]
    if not above or not lines[above[-1]].lstrip().startswith(comment):
        return None, []
    bare = lines[above[-1]].lstrip().lstrip(comment).strip()
    names = split(bare, best.separator)
    if len(names) == best.place.width and not any(map(is_number, names)):
        return above[-1], names
    return None, []
