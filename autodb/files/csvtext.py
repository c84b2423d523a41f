"""Tables as CSV text that no spreadsheet takes for more than text, and how such text is taken back.

A spreadsheet calculates a cell that begins like a formula, and what it calculates may start
programs or send data away. Names come from files of others, so a cell of text that begins so gets
an apostrophe before it (OWASP, "CSV Injection"), and one that has that already another.
"""

import csv
import io
import re
from collections.abc import Iterable, Sequence

FORMULA = "=+-@\t\r\n＝＋－＠"
"""What a formula begins with, in some language (OWASP)."""
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?|-?(inf|nan)", re.IGNORECASE | re.ASCII)
_BEGINS = re.compile(rf"'*[{re.escape(FORMULA)}]")


def rows_as_csv(rows: Iterable[Sequence[str]]) -> str:
    """Return rows of cells as CSV text; a line break stays within its cell's quotes."""
    return "".join(_line(row) for row in rows)


def neutral(cell: str) -> str:
    """Return a cell such that no spreadsheet calculates it; numbers stay as they are.

    >>> neutral("=1+1"), neutral("-3.5"), neutral("C45"), neutral("'=1+1")
    ("'=1+1", '-3.5', 'C45', "''=1+1")
    """
    begins = _BEGINS.match(cell) and not _NUMBER.fullmatch(cell)
    return f"'{cell}" if begins else cell


def restored(cell: str) -> str:
    """Return what a cell was before it was made neutral.

    >>> restored("'=1+1"), restored("''=1+1"), restored("'quoted'")
    ('=1+1', "'=1+1", "'quoted'")
    """
    return cell[1:] if cell.startswith("'") and _BEGINS.match(cell) else cell


def _line(row: Sequence[str]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\r\n").writerow([neutral(cell) for cell in row])
    return text.getvalue().removesuffix("\r\n") + "\n"  # the writer quotes what ends its lines
