"""The layout of a file that a known program wrote, by its preset."""

import re
from collections.abc import Sequence
from functools import partial

from autodb.readers.text.cells import is_number, is_unit, split
from autodb.readers.text.layout import TextLayout, column_names
from autodb.readers.text.presets import PRESETS, Preset

_BEFORE_NAMES = ("", "***End_of_Header***", "BlockNumber")
"""First cells of the line before that of the names, with which presets end what is above."""


def by_preset(lines: Sequence[str]) -> TextLayout | None:
    """Return the layout of a file of a known program; None where none wrote it."""
    text = "\n".join(lines)
    for preset in PRESETS:
        begins = preset.begins.match(text)
        if begins:
            return _layout(preset, [split(line, begins["separator"]) for line in lines], begins)
    return None


def _layout(preset: Preset, rows: list[list[str]], begins: re.Match[str]) -> TextLayout | None:
    header = _header(preset, rows)
    if header is None:
        return None
    names = rows[header]
    remarks = len(names) - 1 if names[-1] == preset.remarks else len(names)
    while names and not names[-1] and not remarks < len(names):  # a separator at the end of lines
        names, remarks = names[:-1], remarks - 1
    decimal = "," if _has_commas(rows[header + 1 :]) else "."
    number = partial(is_number, decimal=decimal)
    first = next(
        (n for n in range(header + 1, len(rows)) if _is_row(rows[n][:remarks], number)), None
    )
    if first is None or not _named(names, rows[first:], remarks):
        return None
    said = {row[0]: row for row in rows[:first] if row}
    times = tuple(place for place, name in enumerate(names) if name == preset.time)
    steps = _steps(said.get(preset.steps, []), decimal)
    units = _units(preset, said.get(preset.units, [])) | dict.fromkeys(times, preset.time_unit)
    return TextLayout(
        column_names(["t" if place in times else name for place, name in enumerate(names)]),
        first=first,
        header=header,
        separator=begins["separator"],
        decimal=decimal,
        short_rows=True,
        units=units,
        times=times,
        steps_s=steps if all(not row[0] for row in rows[first : first + 2]) else {},
        title=preset.title,
    )


def _named(names: list[str], rows: list[list[str]], remarks: int) -> bool:
    """Say whether the fullest row has a cell for each name, but for remarks that are left out."""
    return max(map(len, rows)) in (len(names), len(names) + 1, remarks)


def _header(preset: Preset, rows: list[list[str]]) -> int | None:
    for line in range(1, len(rows)):
        before = rows[line - 1]
        if rows[line][:1] == [preset.names] and (not before or before[0] in _BEFORE_NAMES):
            return line
    return None


def _has_commas(rows: list[list[str]]) -> bool:
    """Say whether rows that begin with no text have numbers with commas."""
    of_numbers = [row for row in rows if row and (not row[0] or is_number(row[0], ","))]
    return any("," in cell and is_number(cell, ",") for row in of_numbers for cell in row)


def _is_row(cells: list[str], number: partial[bool]) -> bool:
    known = [cell for cell in cells if cell]
    return bool(known) and all(map(number, known))


def _steps(row: list[str], decimal: str) -> dict[int, float]:
    return {
        place: float(cell.replace(",", "."))
        for place, cell in enumerate(row)
        if is_number(cell, decimal)
    }


def _units(preset: Preset, row: list[str]) -> dict[int, str]:
    found = {}
    for place, cell in enumerate(row):
        within = preset.unit_cell.fullmatch(cell)
        unit = within["unit"] if within else ""
        if is_unit(unit) or is_unit(unit.lower()):
            found[place] = unit if is_unit(unit) else unit.lower()
    return found
