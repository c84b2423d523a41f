"""Tool bits of FreeCAD's CAM workbench (`.fctb`, JSON).

A bit has a shape and parameters, quantities with their unit as text. Read are those that decide
forces of end mills, drills and inserts; a bit says neither rake nor helix, and flutes only where
its maker entered them. Source of the names: the bits that FreeCAD ships (`src/Mod/CAM/Tools/Bit`).
"""

import re
from pathlib import Path
from typing import Any

from pydantic_core import from_json

from autodb.errors import UnusableInput
from autodb.wording import phrase

SUFFIX = ".fctb"
_BIT_UNITS = {
    "": 1.0, "mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4, '"': 25.4, "°": 1.0, "deg": 1.0,
}  # fmt: skip
"""Millimetres or degrees a unit; a number without one is in these."""
_BIT_KINDS = {
    "endmill": "end_mill", "ballend": "end_mill", "bullnose": "end_mill", "torus": "end_mill",
    "drill": "drill", "isoshape": "turning_insert", "isoshapec": "turning_insert",
    "isoshaped": "turning_insert", "isoshapes": "turning_insert", "isoshapet": "turning_insert",
}  # fmt: skip
"""Kind of tool by a bit's shape, without case and what is no letter."""
_ROUNDED = ("bullnose", "torus")
"""Shapes whose corner radius is a parameter; an older name of FreeCAD among them."""
_BIT_PARAMETERS = {
    "end_mill": {
        "Diameter": "diameter_mm", "CornerRadius": "corner_radius_mm",
        "TorusRadius": "corner_radius_mm", "Flutes": "teeth",
    },
    "drill": {"Diameter": "diameter_mm", "TipAngle": "point_angle_deg", "Flutes": "teeth"},
    "turning_insert": {"TipRadius": "nose_radius_mm", "TipAngle": "included_deg"},
}  # fmt: skip
_BIT_INCLUDED = {"isoshapec": 80.0, "isoshaped": 55.0, "isoshapes": 90.0, "isoshapet": 60.0}
"""Angle between an insert's edges by its shape (ISO 1832)."""
_QUANTITY = re.compile(r"\s*([-+]?\d+(?:[.,]\d+)?(?:[eE][-+]?\d+)?)(?:/(\d+))?\s*(\S*)\s*")
"""A number, what it is parted by (1/4 in), and a unit."""


def said_in_bit(path: Path, name: str | None = None) -> dict[str, Any]:
    """Return what a bit's file says as a tool file would; raises UnusableInput with the key.

    A bit has the name that the shop gave it, so that ``name`` changes nothing.
    """
    del name
    try:
        bit = from_json(path.read_bytes())
    except ValueError as error:
        raise UnusableInput(
            phrase("{file}: is no JSON ({error}); save the bit again", file=path, error=error)
        ) from None
    if not isinstance(bit, dict) or not isinstance(bit.get("parameter"), dict):
        raise UnusableInput(
            phrase("{file}: parameter: missing; use a bit that FreeCAD has saved", file=path)
        )
    shape = str(bit.get("shape-type") or Path(str(bit.get("shape", ""))).stem)
    plain = "".join(c for c in shape.lower() if c.isalpha())
    if plain not in _BIT_KINDS:
        raise UnusableInput(
            phrase(
                "{file}: shape '{shape}' is no tool whose forces are known; use an end mill, a "
                "ball end, a bull nose, a drill or an ISO insert",
                file=path,
                shape=shape,
            )
        )
    kind = _BIT_KINDS[plain]
    stated = {**bit["parameter"], **(bit.get("attribute") or {})}
    found = {
        ours: _quantity(path, name, stated[name])
        for name, ours in _BIT_PARAMETERS[kind].items()
        if name in stated
    }
    if kind == "end_mill" and plain not in _ROUNDED:
        found["corner_radius_mm"] = 0.5 * found.get("diameter_mm", 0.0) * (plain == "ballend")
    if plain in _BIT_INCLUDED:
        found["included_deg"] = _BIT_INCLUDED[plain]
    if found.get("teeth") == 0:
        del found["teeth"]  # FreeCAD's way to say that nobody counted them
    return {"name": str(bit.get("name") or path.stem), "kind": kind, "geometry": found}


def _quantity(path: Path, name: str, value: object) -> float:
    """Return a quantity in millimetres or degrees."""
    read = _QUANTITY.fullmatch(str(value))
    if read is None or read[3].lower() not in _BIT_UNITS or not float(read[2] or 1):
        raise UnusableInput(
            phrase(
                "{file}: parameter.{name}: '{value}' is no quantity; use one such as '6 mm'",
                file=path,
                name=name,
                value=value,
            )
        )
    return float(read[1].replace(",", ".")) / float(read[2] or 1) * _BIT_UNITS[read[3].lower()]
