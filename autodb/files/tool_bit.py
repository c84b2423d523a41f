"""Tool bits of FreeCAD's CAM workbench (`.fctb`, JSON) as tools: end mills, drills and inserts.

A bit has a shape and parameters, quantities with their unit as text. Read are those that decide
forces; a bit says neither rake nor helix, and flutes only where its maker entered them. Source of
the names: the bits that FreeCAD ships (`src/Mod/CAM/Tools/Bit`).
"""

import re
from pathlib import Path
from typing import Any

from pydantic_core import from_json

from autodb.errors import UnusableInput

UNITS = {"": 1.0, "mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4, '"': 25.4, "°": 1.0, "deg": 1.0}
"""Millimetres or degrees a unit; a number without one is in these."""
KINDS = {
    "endmill": "end_mill", "ballend": "end_mill", "bullnose": "end_mill", "drill": "drill",
    "isoshapec": "turning_insert", "isoshaped": "turning_insert", "isoshapes": "turning_insert",
    "isoshapet": "turning_insert",
}  # fmt: skip
"""Kind of tool by a bit's shape, without case and what is no letter."""
PARAMETERS = {
    "end_mill": {"Diameter": "diameter_mm", "CornerRadius": "corner_radius_mm", "Flutes": "teeth"},
    "drill": {"Diameter": "diameter_mm", "TipAngle": "point_angle_deg", "Flutes": "teeth"},
    "turning_insert": {"TipRadius": "nose_radius_mm"},
}  # fmt: skip
_QUANTITY = re.compile(r"\s*([-+]?\d+(?:[.,]\d+)?(?:[eE][-+]?\d+)?)\s*(\S*)\s*")


def tool_of_bit(path: Path) -> dict[str, Any]:
    """Return what a bit's file says as a tool file would; raises UnusableInput with the key."""
    try:
        bit = from_json(path.read_bytes())
    except ValueError as error:
        raise UnusableInput(f"{path}: is no JSON ({error}); save the bit again") from None
    if not isinstance(bit, dict) or not isinstance(bit.get("parameter"), dict):
        raise UnusableInput(f"{path}: parameter: missing; use a bit that FreeCAD has saved")
    shape = str(bit.get("shape-type") or Path(str(bit.get("shape", ""))).stem)
    plain = "".join(c for c in shape.lower() if c.isalpha())
    if plain not in KINDS:
        raise UnusableInput(
            f"{path}: shape '{shape}' is no tool whose forces are known; use an end mill, a ball "
            "end, a bull nose, a drill or an ISO insert"
        )
    kind = KINDS[plain]
    stated = {**bit["parameter"], **(bit.get("attribute") or {})}
    found = {
        ours: _number(path, name, stated[name])
        for name, ours in PARAMETERS[kind].items()
        if name in stated
    }
    if kind == "end_mill" and plain != "bullnose":
        found["corner_radius_mm"] = 0.5 * found.get("diameter_mm", 0.0) * (plain == "ballend")
    if found.get("teeth") == 0:
        del found["teeth"]  # FreeCAD's way to say that nobody counted them
    return {"name": str(bit.get("name") or path.stem), "kind": kind, "geometry": found}


def _number(path: Path, name: str, value: object) -> float:
    """Return a quantity in millimetres or degrees."""
    read = _QUANTITY.fullmatch(str(value))
    if read is None or read[2].lower() not in UNITS:
        raise UnusableInput(
            f"{path}: parameter.{name}: '{value}' is no quantity; use one such as '6 mm'"
        )
    return float(read[1].replace(",", ".")) * UNITS[read[2].lower()]
