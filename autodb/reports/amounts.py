"""Numbers and quantities of reports as text, in the units and with the marks of who reads them."""

import math

from autodb.wording import localized, phrase, shop_amount


def number(value: float, *, like: float | None = None) -> str:
    """Return ``value`` with three significant digits, or with the decimals that ``like`` has then.

    >>> number(1234.0), number(0.42), number(-0.0031), number(0.004, like=0.42)
    ('1230', '0.420', '−0.00310', '0.004')
    """
    if not math.isfinite(value):
        return phrase("not known")
    if not like:
        value = like = float(f"{value:.2e}")
    if value == 0.0 == like:
        return "0"
    exponent = _exponent(value or like)
    if like == value and not -4 <= exponent < 7:
        text = f"{value / 10.0**exponent:.2f} × 10{_raised(exponent)}"
    else:
        text = f"{value:.{max(0, 2 - _exponent(like))}f}"
    return localized(text.replace("-", "−"))


def _exponent(value: float) -> int:
    return math.floor(math.log10(abs(float(f"{value:.2e}"))))


def _raised(exponent: int) -> str:
    return str(exponent).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def quantity(value: float, unit: str) -> str:
    """Return number and unit; a bare number where the unit is 1.

    >>> quantity(0.42, "A"), quantity(1.1, "1")
    ('0.420\\xa0A', '1.10')
    """
    value, unit = shop_amount(value, unit)
    return number(value) + suffix(unit)


def suffix(unit: str) -> str:
    """Return the unit as it follows a number; nothing for the unit 1."""
    return "" if unit in ("", "1") else f"\u00a0{unit}"


def span(low: float, high: float, unit: str) -> str:
    """Return an interval: as many decimals as its larger end needs, or its width where narrow.

    >>> span(0.4, 0.44, "A"), span(14.19, 14.21, "s")
    ('0.400 to 0.440\\xa0A', '14.19 to 14.21\\xa0s')
    """
    (low, _), (high, unit) = shop_amount(low, unit), shop_amount(high, unit)
    like = _shown_digits(max(abs(low), abs(high)), 100.0 * (high - low))
    ends = phrase("{low} to {high}", low=number(low, like=like), high=number(high, like=like))
    return f"{ends}{suffix(unit)}"


def plus_minus(value: float, half_width: float, unit: str) -> str:
    """Return a value and its half width with the same decimals.

    >>> plus_minus(2051.0, 65.0, "N"), plus_minus(2051.0, 0.4, "N")
    ('2051 ± 65\\xa0N', '2051.00 ± 0.40\\xa0N')
    """
    (value, _), (half_width, unit) = shop_amount(value, unit), shop_amount(half_width, unit)
    like = _shown_digits(abs(value), 10.0 * half_width)
    return f"{number(value, like=like)} ± {number(half_width, like=like)}{suffix(unit)}"


def _shown_digits(largest: float, width: float) -> float | None:
    """What decides the decimals of a pair; None (each by itself) where it is tiny or huge."""
    if not (math.isfinite(largest) and 1e-4 <= largest < 1e7):
        return None
    return min(largest, width) if width > 0.0 else largest
