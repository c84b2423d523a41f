"""Numbers, amounts and times as the reader writes them.

Digits are grouped in threes by a narrow space from five before the mark on, as ISO 80000-1 has it:
a point between them would be a decimal mark to who types the number into a form.
"""

import datetime
import re
from functools import cache

from autodb.wording.presentation import presentation
from autodb.wording.sentences import msgid, phrase

NARROW = "\u202f"
"""Between groups of digits."""
_WHOLE = re.compile(r"(?<![\d.])\d{5,}(?=\D|$)")
"""Digits before a decimal mark that are grouped."""
WHOLE_BELOW = 1e5
"""Chosen: who reads a force or a duration does not count a power of ten."""
NAMED_UNITS = frozenset(
    {
        msgid("rpm"), msgid("deg"), msgid("mm/rev"), msgid("mm/tooth"), msgid("in/rev"),
        msgid("in/tooth"),
    }
)  # fmt: skip
"""Units with a word in them, which a language has its own for."""


@cache
def decimal_mark(language: str) -> str:
    """Return the decimal mark of a language."""
    if language == "en":
        return "."
    from babel.numbers import get_decimal_symbol

    return get_decimal_symbol(language)


def localized(text: str) -> str:
    """Return a number, written with a decimal point, as the reader writes it."""
    language = presentation().language
    if language == "en":
        return text
    grouped = _WHOLE.sub(lambda found: f"{int(found[0]):_}".replace("_", NARROW), text)
    return grouped.replace(".", decimal_mark(language))


def significant(value: float, digits: int = 3) -> str:
    """Return a number with so many significant digits; below 100 000 without an exponent.

    >>> significant(812.4, 2), significant(1234.5), significant(0.05678)
    ('810', '1230', '0.0568')
    """
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e+" in text and abs(value) < WHOLE_BELOW else text


def shop_amount(value: float, unit: str) -> tuple[float, str]:
    """Return a value in one of our units in the shop's, and what that unit is called."""
    own = presentation().units.get(unit)
    shown, name = (value, unit) if own is None else (own.factor * value, own.name)
    return shown, phrase(name) if name in NAMED_UNITS else name


def amount_words(value: float, unit: str, form: str = "g") -> str:
    """Return a number in a form of Python's, and its unit, as the reader has them.

    >>> amount_words(600.0, "N", ".6g")
    '600 N'
    """
    shown, name = shop_amount(value, unit)
    return f"{localized(f'{shown:{form}}')} {name}"


def day(at: str) -> str:
    """Return the day and minute of a stored time, which is UTC; of a day alone the day.

    >>> day("2026-03-01T07:30:12+00:00"), day("2026-03-01")
    ('2026-03-01 07:30', '2026-03-01')
    """
    language = presentation().language
    date, minute = at[:10], at[11:16]
    if language != "en":
        from babel.dates import format_date

        date = format_date(datetime.date.fromisoformat(date), "dd.MM.yyyy", locale=language)
    return f"{date} {minute}".rstrip()
