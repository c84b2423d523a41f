"""What stands beside the numbers of a table: labels before them, a period above, remarks below."""

import re
from collections.abc import Callable, Sequence
from itertools import pairwise

from autodb.readers.text.cells import UNKNOWN
from autodb.readers.text.rows import Cells, TablePlace, find_table

FEWEST_ABOVE = 3
"""Rows that a table has above remarks at the least; more than there are remarks. Chosen."""
_PERIOD = re.compile(
    r"sampl\w*[ _]*(?P<what>period|interval|time|step|rate|frequency)\W*(?:is)?\W*"
    r"(?P<number>\d+(?:[.,]\d+)?)\s*(?P<unit>[a-zµ]+)",
    re.IGNORECASE,
)
_SECONDS = {"nsec": 1e-9, "ns": 1e-9, "usec": 1e-6, "us": 1e-6, "µs": 1e-6, "msec": 1e-3}
_SECONDS |= {"ms": 1e-3, "sec": 1.0, "s": 1.0}
_HERTZ = {"hz": 1.0, "khz": 1e3}


def labels_before(rows: Sequence[Cells], width: int, number: Callable[[str], bool]) -> list[str]:
    """Return what stands before the numbers of each column on every row, empty where nothing does.

    >>> labels_before([["pos", "1.5"], ["pos", "1.7"]], 2, str.isdigit)
    ['', '']
    >>> labels_before([["pos", "15"], ["pos", "17"]], 2, str.isdigit)
    ['', 'pos']
    """
    kept = [row for row in rows if len(row) == width]
    found = [""] * width
    for place in range(1, width):
        texts = {row[place - 1] for row in kept}
        if len(kept) > 1 and len(texts) == 1 and all(number(row[place]) for row in kept):
            (text,) = texts
            found[place] = "" if number(text) or text in UNKNOWN else text
    return found


def stated_step_s(
    above: Sequence[str], rows: Sequence[Cells], numeric: Sequence[int]
) -> float | None:
    """Return the step of time that lines above a table state, s; None where none does.

    Nor where a column of numbers rises on every row, which is then its time.
    """
    found = next((said for line in above if (said := _PERIOD.search(line))), None)
    if found is None or any(_rises([row[place] for row in rows]) for place in numeric):
        return None
    value, unit = float(found["number"].replace(",", ".")), found["unit"].lower()
    if not value > 0:
        return None
    if found["what"].lower() in ("rate", "frequency"):
        return 1.0 / (value * _HERTZ[unit]) if unit in _HERTZ else None
    return value * _SECONDS[unit] if unit in _SECONDS else None


def _rises(cells: Sequence[str]) -> bool:
    try:
        values = [float(cell.replace(",", ".")) for cell in cells if cell not in UNKNOWN]
    except ValueError:
        return False
    return len(values) > 1 and all(later > earlier for earlier, later in pairwise(values))


def lines_of_table(rows: Sequence[Cells], width: int, first: int = 0) -> int:
    """Return how many lines there are above remarks below a table that begins in line ``first``.

    Remarks fill half the cells at the most and begin with no digit: a row that is cut off is none.

    >>> table = [["1", "2"], ["3", "4"], ["5", "6"]]
    >>> lines_of_table([*table, [], ["made by night"]], 2), lines_of_table([*table, ["7"]], 2)
    (3, 4)
    """
    last = len(rows)
    while last > 0 and 2 * sum(map(bool, rows[last - 1])) <= width and not _numbers(rows[last - 1]):
        last -= 1
    return last if last - first >= max(FEWEST_ABOVE, len(rows) - last) else len(rows)


def table_above_remarks(rows: Sequence[Cells], number: Callable[[str], bool]) -> TablePlace | None:
    """Return where a table begins, with or without remarks below it."""
    ends = lines_of_table(rows, max(map(len, rows), default=0))
    place = find_table(rows[:ends], number)
    if place is None or lines_of_table(rows, place.width, place.first) > ends:
        return find_table(rows, number)
    return place


def _numbers(row: Cells) -> bool:
    return any(cell[:1].isdigit() or cell[:1] in ("+", "-", ".") for cell in row if cell)
