"""Property tables of tools by DIN 4000, as catalogues hand them out (`.xml`, `.csv`).

A property has a code that means something only within its table: part 82 is that of end mills,
part 81 that of drills, each with numbers for what they look like. Sources: the labels that a public
catalogue prints beside the codes of drills; of end mills, two public importers and one tool's data
in both this form and that of ISO 13399.
"""

import csv
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from autodb.errors import UnusableInput
from autodb.wording import phrase

SUFFIXES = (".xml", ".csv")
_NAMES = ("J22", "J23", "J21")
"""A product's name, its description, its order number."""


@dataclass(frozen=True)
class _Part:
    """A part of DIN 4000: the kind of tool, our name by code, what its pictures show."""

    kind: str
    ours: dict[str, str]
    pictures: frozenset[str]


_PARTS = {
    "DIN4000-81": _Part(
        "drill",
        {"A11": "diameter_mm", "D1": "teeth", "D3": "helix_deg", "E1": "point_angle_deg"},
        frozenset({"1"}),
    ),
    "DIN4000-82": _Part(
        "end_mill",
        {
            "A11": "diameter_mm", "A1": "diameter_mm", "F21": "teeth", "F4": "helix_deg",
            "G1": "corner_radius_mm",
        },
        frozenset({"1", "2", "6"}),
    ),
}  # fmt: skip
_BALL = ("DIN4000-82", "6")


def said_in_table(path: Path, name: str | None) -> dict[str, Any]:
    """Return what a property table says as a tool file would; raises UnusableInput.

    ``name``: that of the tool, and of several in a file the one to read.
    """
    tools = _xml(path) if path.suffix.lower() == ".xml" else _csv(path)
    if not tools:
        raise UnusableInput(
            phrase(
                "{file}: has no properties of DIN 4000 (NSM, BLD, A1, …); use a catalogue's "
                "export for DIN 4000, or a tool file (TOML)",
                file=path,
            )
        )
    said = _one_of(path, tools, name)
    return {"name": name or _called(said) or path.stem, **_geometry(path, said)}


def _geometry(path: Path, said: dict[str, str]) -> dict[str, Any]:
    """Return kind and geometry of one tool's properties."""
    table, picture = said.get("NSM", ""), said.get("BLD", "")
    part = _PARTS.get(table)
    if part is None or picture not in part.pictures:
        raise UnusableInput(
            phrase(
                "{file}: NSM {table}, BLD {picture}: no end mill or drill whose properties are "
                "known (DIN4000-82 with BLD 1, 2 or 6, DIN4000-81 with BLD 1); use its data by "
                "ISO 13399 (.p21)",
                file=path,
                table=table or "-",
                picture=picture or "-",
            )
        )
    found = {
        ours: _number(path, code, said[code]) for code, ours in part.ours.items() if said.get(code)
    }
    if (table, picture) == _BALL and "diameter_mm" in found:
        found["corner_radius_mm"] = 0.5 * found["diameter_mm"]
    return {"kind": part.kind, "geometry": found}


def _number(path: Path, code: str, value: str) -> float:
    """Return a property's number: some tables have decimal commas."""
    try:
        return float(value.replace(",", "."))
    except ValueError:
        raise UnusableInput(
            phrase(
                "{file}: {code} = '{value}' is no number; use a tool file (TOML)",
                file=path,
                code=code,
                value=value,
            )
        ) from None


def _called(said: dict[str, str]) -> str:
    return next((said[code] for code in _NAMES if said.get(code)), "")


def _one_of(path: Path, tools: list[dict[str, str]], name: str | None) -> dict[str, str]:
    """Return the properties of the tool of that name; of a single one whatever it is called."""
    if len(tools) == 1:
        return tools[0]
    found = [said for said in tools if name in [said.get(code) for code in _NAMES]]
    if len(found) != 1:
        raise UnusableInput(
            phrase(
                "{file}: has {n} tools; name one of them: {names}",
                file=path,
                n=len(tools),
                names=", ".join(_called(said) for said in tools[:6]),
            )
        )
    return found[0]


def _xml(path: Path) -> list[dict[str, str]]:
    """Return the properties of each tool of a DIN 4000-102 file, by code."""
    try:
        root = ET.fromstring(path.read_bytes())
    except ET.ParseError as error:
        raise UnusableInput(
            phrase("{file}: is no XML ({error}); export it again", file=path, error=error)
        ) from None
    tools = []
    for tool in root.iter("Tool"):
        pairs = [*tool.iter("Category-Data"), *tool.iter("Property-Data")]
        said = {
            (one.findtext("PropertyName") or "").strip(): (one.findtext("Value") or "").strip()
            for one in pairs
        }
        tools += [said] if said.get("NSM") else []
    return tools


def _csv(path: Path) -> list[dict[str, str]]:
    """Return the properties of each row of a table that has their codes for a head."""
    data = path.read_bytes()
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("cp1252", "replace")
    lines = text.splitlines()
    if not lines or "NSM" not in lines[0]:
        return []
    mark = ";" if ";" in lines[0] else ","
    try:
        rows = list(csv.DictReader(lines, delimiter=mark, restval=""))
    except csv.Error as error:
        raise UnusableInput(
            phrase("{file}: is no table ({error}); export it again", file=path, error=error)
        ) from None
    return [
        {code: value.strip() for code, value in row.items() if isinstance(value, str) and code}
        for row in rows
        if row.get("NSM")
    ]
