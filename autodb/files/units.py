"""Foreign units become ours at the edge; inside, a float is in the unit of its name.

On pages and in forms a shop may have units of its own in place of ours.
"""

import re
from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING

from autodb.errors import UnusableInput
from autodb.wording import Presentation, ShopUnit, phrase, presentation

if TYPE_CHECKING:
    from pint import UnitRegistry

RAW = "raw"


@cache
def _registry() -> "UnitRegistry[float]":
    from pint import UnitRegistry

    return UnitRegistry()


_OWN: dict[str, dict[str, float]] = {
    "rpm": {
        **dict.fromkeys(("1/min", "min^-1", "min-1", "rev/min", "r/min", "U/min", "RPM"), 1.0),
        **dict.fromkeys(("tr/min", "giri/min"), 1.0),
        **dict.fromkeys(("1/s", "s^-1", "Hz", "rev/s", "r/s", "U/s", "rps"), 60.0),
    },
    "mm": {
        **dict.fromkeys(("mm/rev", "mm/U", "mm/tooth", "mm/r", "mm/tr", "mm/giro", "mm/z"), 1.0),
        **dict.fromkeys(("in/rev", "ipr", "in/tooth"), 25.4),
    },
    "mm/rev": {"in/rev": 25.4},
    "mm/tooth": {"in/tooth": 25.4},
    "deg": dict.fromkeys(("rev", "U"), 360.0),
    "N/mm²": {"N/mm2": 1.0, "daN/mm2": 10.0, "kN/mm2": 1000.0},
    "N·m": dict.fromkeys(("Nm", "N m", "N-m", "N.m"), 1.0),
    "1": {"1": 1.0, "-": 1.0, "": 1.0},
}
"""Names of the shop that a library of units reads otherwise, or not at all, by our unit."""


_PLAIN = {"·": "*", "²": "**2", "³": "**3", "°C": "degC", "°": "deg"}
"""What the library of units reads in place of what we write, one after another."""


def _plain(unit: str) -> str:
    for sign, plain in _PLAIN.items():
        unit = unit.replace(sign, plain)
    return unit


@cache
def is_any_unit(text: str) -> bool:
    """Say whether a text is a unit of anything, ours or not.

    >>> is_any_unit("mV"), is_any_unit("U/min"), is_any_unit("Kraft")
    (True, True, False)
    """
    if any(text in own for own in _OWN.values()):
        return bool(text)
    try:
        _registry().Unit(_plain(text))
    except Exception:  # pint's parser fails on nonsense in any way, assertions included
        return False
    return True


def conversion(unit: str, *, to: str, where: str) -> tuple[float, float]:
    """Return scale and offset: a value v in ``unit`` is scale · v + offset in ``to``.

    Raises UnusableInput, naming ``where``, for an unknown unit or one of another dimension.

    >>> conversion("m", to="mm", where="doc")
    (1000.0, 0.0)
    >>> conversion("Hz", to="rpm", where="doc")
    (60.0, 0.0)
    """
    from pint.errors import DimensionalityError

    if unit in (RAW, to):
        return 1.0, 0.0
    if unit in _OWN.get(to, {}):
        return _OWN[to][unit], 0.0
    try:
        quantity, target = _registry().Quantity, _plain(to)
        zero = float(quantity(0.0, _plain(unit)).to(target).magnitude)
        one = float(quantity(1.0, _plain(unit)).to(target).magnitude)
    except DimensionalityError:
        raise UnusableInput(
            phrase(
                "{where}: unit '{unit}' cannot become {to}; use {to} or a unit of the same kind",
                where=where,
                unit=unit,
                to=to,
            )
        ) from None
    except Exception:  # pint's parser fails on nonsense in any way, assertions included
        raise UnusableInput(
            phrase("{where}: unknown unit '{unit}'; use {to}", where=where, unit=unit, to=to)
        ) from None
    return one - zero, zero


# Units of a shop that works in inches

SI, INCH = "si", "inch"
_INCH = {
    "N": "lbf", "N·m": "ft·lbf", "W": "hp", "mm": "in", "µm": "in", "mm/rev": "in/rev",
    "mm/tooth": "in/tooth", "mm/min": "in/min", "mm/s": "in/s", "mm/s²": "in/s²", "m/min": "ft/min",
    "N/mm": "lbf/in", "N/mm²": "ksi", "N/mm^2": "ksi", "cm³": "in³", "cm³/min": "in³/min",
    "N/A": "lbf/A", "N·m/A": "ft·lbf/A",
}  # fmt: skip
"""Units of the shop by ours; turns, angles, times, currents, energies and temperatures stay."""
SYSTEMS = {SI: "mm, N", INCH: "inch, lbf"}
"""Systems of units, each by what stands for it."""


@cache
def shop_units(system: str) -> Mapping[str, ShopUnit]:
    """Return what a shop of a system has in place of our units.

    >>> shop_units("si"), round(1.0 / shop_units("inch")["N"].factor, 10)
    ({}, 4.4482216153)
    """
    if system != INCH:
        return {}
    return {
        ours: ShopUnit(name, 1.0 / conversion(name, to=ours, where=name)[0])
        for ours, name in _INCH.items()
    }


def presentation_of(language: str, system: str) -> Presentation:
    """Return for whom something is said: in a language, by its code, and a system of units."""
    return Presentation(language, shop_units(system))


def shown_system() -> str:
    """Return the system of units that the reader has."""
    return INCH if presentation().units else SI


_GROUPED = {
    ".": re.compile(r"[-+]?[1-9]\d{0,2},\d{3}"), ",": re.compile(r"[-+]?[1-9]\d{0,2}\.\d{3}")
}  # fmt: skip
"""By the decimal mark: the other sign that may stand for a thousand as well."""


def typed_number(name: str, text: str, mark: str = ".") -> float:
    """Return the number that someone typed; raises UnusableInput, which calls it ``name``.

    A comma is a decimal comma, and a point a decimal point, where it cannot part thousands; the
    ``mark`` of who typed it never does.

    >>> typed_number("feed_mm_rev", "0,25"), typed_number("depth_mm", "2.5")
    (0.25, 2.5)
    >>> typed_number("length_mm", "1,125", mark=",")
    1.125
    """
    plain = text.strip().replace("−", "-")
    if _GROUPED[mark].fullmatch(plain):
        raise UnusableInput(
            phrase(
                "{name}: '{text}' may be {point} or {whole}; type one of them",
                name=name,
                text=text,
                point=plain.replace(",", ".").replace(".", mark),
                whole=plain.replace(",", "").replace(".", ""),
            )
        )
    if plain.count(",") > 1 or ("," in plain and "." in plain):
        raise UnusableInput(
            phrase(
                "{name}: '{text}' has more than a decimal sign; type it without signs between "
                "thousands, such as {example}",
                name=name,
                text=text,
                example=f"1234{mark}5",
            )
        )
    try:
        return float(plain.replace(",", ".").replace("_", "?"))
    except ValueError:
        raise UnusableInput(
            phrase(
                "{name}: '{text}' is not a number; send a number such as {example}",
                name=name,
                text=text,
                example=f"2{mark}5",
            )
        ) from None
