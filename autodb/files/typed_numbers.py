"""Numbers as people type them: with a decimal point or a decimal comma, whatever their locale."""

import re

from autodb.errors import UnusableInput

_GROUPED = re.compile(r"[-+]?[1-9]\d{0,2},\d{3}")
"""A comma that may stand for a thousand as well."""


def typed_number(name: str, text: str) -> float:
    """Return the number that someone typed; raises UnusableInput, which calls it ``name``.

    A comma is a decimal comma, where it cannot part thousands.

    >>> typed_number("feed_mm_rev", "0,25"), typed_number("depth_mm", "2.5")
    (0.25, 2.5)
    """
    plain = text.strip().replace("−", "-")
    commas = plain.count(",")
    if _GROUPED.fullmatch(plain):
        point, whole = plain.replace(",", "."), plain.replace(",", "")
        raise UnusableInput(f"{name}: '{text}' may be {point} or {whole}; type one of them")
    if commas > 1 or (commas and "." in plain):
        raise UnusableInput(
            f"{name}: '{text}' has more than a decimal sign; type it without signs between "
            "thousands, such as 1234.5"
        )
    try:
        return float(plain.replace(",", ".").replace("_", "?"))
    except ValueError:
        raise UnusableInput(
            f"{name}: '{text}' is not a number; send a number such as 2.5"
        ) from None
