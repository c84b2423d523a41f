"""Cells of a line of text: numbers in one or the other way of writing, units, and the rest."""

import csv
import re
from functools import cache

from autodb.errors import UnusableInput
from autodb.files.channels import OUR_UNITS
from autodb.files.units import conversion

UNKNOWN = frozenset(
    ("", "#N/A", "#N/A N/A", "#NA", "-1.#IND", "-1.#QNAN", "-NaN", "-nan", "1.#IND", "1.#QNAN")
) | frozenset(("N/A", "NA", "NULL", "NaN", "n/a", "nan", "null"))
"""Texts that stand for a number that is not known: what Arrow takes as such."""
_POINT = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|[+-]?(inf|infinity)", re.IGNORECASE)
_COMMA = re.compile(r"[+-]?(\d+,?\d*|,\d+)([eE][+-]?\d+)?")
_GROUPS = re.compile(r"[+-]?\d{1,3}(?:([.,'’\u00a0\u202f ])\d{3})(?:\1\d{3})*(?:([.,])\d+)?")
_IN_BRACKETS = re.compile(r"^\s*(?P<name>.*?)\s*[\[(](?P<unit>[^\[\]()]*)[\])]\s*$")
_BEHIND = re.compile(r"^\s*(?P<name>\S.*?)\s+(?:/|in)\s+(?P<unit>\S+)\s*$")
"""As DIN 1313 and 461 have it: `Kraft / N`, `Kraft in N`."""
_QUOTED = re.compile(r'(?m)(?:^|(?<=[,;\t|]))"(?:[^"]|""){1,200}"(?=[,;\t|]|\r?$)')
"""A cell between quotes; a longer one is a quote that was left open. Chosen."""
SPACE = " "
"""As a separator: one or several spaces or tabs."""


def split(line: str, separator: str) -> list[str]:
    """Return the cells of a line without the spaces around them; quotes hold one together."""
    if separator == SPACE and '"' not in line:
        return line.split()
    try:
        text = SPACE.join(line.split()) if separator == SPACE else line
        return [cell.strip() for cell in next(csv.reader([text], delimiter=separator), [])]
    except csv.Error:
        return [cell.strip() for cell in line.split(separator)]


def on_one_line(text: str) -> str:
    r"""Return a text in which cells between quotes go over one line each.

    >>> on_one_line('1,"2\n",3\n4,"5",6" pipe\n')
    '1,"2",3\n4,"5",6" pipe\n'
    """
    return _QUOTED.sub(lambda found: f'"{" ".join(found[0][1:-1].splitlines())}"', text)


def is_number(cell: str, decimal: str = ".", thousands: str = "") -> bool:
    """Say whether a cell is a number with this decimal mark.

    >>> is_number("-1.5e3"), is_number("0,32"), is_number("0,32", ",")
    (True, False, True)
    """
    plain = cell.replace(thousands, "") if thousands else cell
    return (_COMMA if decimal == "," else _POINT).fullmatch(plain) is not None


def thousands_marks(cell: str) -> tuple[str, str] | None:
    """Return thousands separator and decimal mark of a number that shows both, or groups twice.

    One mark before three digits alone may be either: none is returned.

    >>> thousands_marks("1.234,5"), thousands_marks("1'234'567"), thousands_marks("1.234")
    (('.', ','), ("'", ''), None)
    """
    found = _GROUPS.fullmatch(cell)
    if found is None or found[1] == found[2]:
        return None
    if found[2] is None and cell.count(found[1]) < 2:
        return None
    return found[1], found[2] or ""


@cache
def is_unit(text: str) -> bool:
    """Say whether a text is a unit that one of our channels may be logged in.

    >>> is_unit("mm/s"), is_unit("kN"), is_unit("Force")
    (True, True, False)
    """
    if not text or len(text) > 12 or is_number(text):
        return False
    for ours in OUR_UNITS:
        try:
            conversion(text, to=ours, where="")
        except UnusableInput:
            continue
        return True
    return False


def unit_within(name: str) -> str:
    """Return the unit that a column's name ends with; empty where it has none of ours.

    >>> unit_within("Fx [kN]"), unit_within("Zeit / s"), unit_within("load (left)")
    ('kN', 's', '')
    """
    return name_and_unit(name)[1]


def name_and_unit(name: str) -> tuple[str, str]:
    """Return a column's name, and the unit of ours that stands behind it, or nothing.

    >>> name_and_unit("force.x [kN]"), name_and_unit("Kraft in N"), name_and_unit("load (left)")
    (('force.x', 'kN'), ('Kraft', 'N'), ('load (left)', ''))
    """
    found = _IN_BRACKETS.match(name) or _BEHIND.match(name)
    unit = found["unit"].strip() if found else ""
    return (found["name"], unit) if found and is_unit(unit) else (name, "")


def bare_unit(cell: str) -> str:
    """Return a cell of a row of units without brackets around it.

    >>> bare_unit("(ms)"), bare_unit("[N]"), bare_unit("mm/s")
    ('ms', 'N', 'mm/s')
    """
    return cell.strip().strip("[]()").strip()
