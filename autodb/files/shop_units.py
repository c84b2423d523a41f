"""Units of a shop that works in inches, in place of ours, on pages and in forms."""

from collections.abc import Mapping
from functools import cache

from autodb.files.units import conversion
from autodb.wording import ShopUnit, presentation

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


def shown_system() -> str:
    """Return the system of units that the reader has."""
    return INCH if presentation().units else SI
