"""Tools: kind and geometry of a tool file (TOML), of a tool bit of FreeCAD, or of a code in a name.

A tool file has our own names or ISO 13399 property codes. Source of these: the property symbols of
ISO 13399 as the MTConnect standard and public tool catalogues print them. Symbols for rake and
inclination are not among those that could be checked, so these angles have our own names only.

A tool bit of FreeCAD's CAM workbench (`.fctb`, JSON) has a shape and parameters, quantities with
their unit as text. Read are those that decide forces of end mills, drills and inserts; a bit says
neither rake nor helix, and flutes only where its maker entered them. Source of the names: the bits
that FreeCAD ships (`src/Mod/CAM/Tools/Bit`).

Codes in names are those of inserts (ISO 1832, and the inch sizes of ANSI B212.4), external holders
(ISO 5608), boring bars (ISO 6261) and holders with a polygonal shank (prefix C3 to C10, ISO 26623).
Neither rake nor edge preparation is in a code: they stay assumed. Angles as these standards define
the letters.
"""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, PositiveInt, ValidationError, model_validator
from pydantic_core import from_json

from autodb.errors import UnusableInput, behind_name, near_words
from autodb.files.toml import Finite, Positive, Section, read_toml
from autodb.wording import localized, phrase

ToolKind = Literal["turning_insert", "end_mill", "drill"]
Angle = Annotated[float, Field(gt=0, lt=180, allow_inf_nan=False)]


@dataclass(frozen=True)
class Code:
    """An ISO 13399 property: its symbol, its name in the standard, our name by kind of tool."""

    symbol: str
    meaning: str
    unit: str
    ours: dict[str, str]


_ROTATING = ("end_mill", "drill")
ISO_13399 = (
    Code("DC", "cutting diameter", "mm", dict.fromkeys(_ROTATING, "diameter_mm")),
    Code("ZEFP", "peripheral effective cutting edge count", "1", {"end_mill": "teeth"}),
    Code("NOF", "flute count", "1", {"drill": "teeth"}),
    Code("FHA", "flute helix angle", "deg", dict.fromkeys(_ROTATING, "helix_deg")),
    Code(
        "RE", "corner radius", "mm",
        {"turning_insert": "nose_radius_mm", "end_mill": "corner_radius_mm"},
    ),
    Code("KAPR", "tool cutting edge angle", "deg", {"turning_insert": "kappa_deg"}),
    Code("SIG", "point angle", "deg", {"drill": "point_angle_deg"}),
)  # fmt: skip


class Geometry(Section):
    """Geometry that is known.

    ``kappa_deg``: entering angle; ``rake_deg``: normal rake, ``inclination_deg``: both of the
    insert in its holder; ``teeth``: edges that cut (flutes of a drill).
    """

    diameter_mm: Positive | None = None
    teeth: PositiveInt | None = None
    helix_deg: Finite | None = None
    corner_radius_mm: Annotated[float, Field(ge=0, allow_inf_nan=False)] | None = None
    point_angle_deg: Angle | None = None
    nose_radius_mm: Annotated[float, Field(ge=0, allow_inf_nan=False)] | None = None
    kappa_deg: Angle | None = None
    rake_deg: Finite | None = None
    inclination_deg: Finite | None = None


class ToolFile(Section):
    """One tool; ``iso13399``: values in mm and degrees by property symbol."""

    name: str = Field(min_length=1)
    kind: ToolKind
    geometry: Geometry = Geometry()
    iso13399: dict[str, Finite] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _codes(self) -> "ToolFile":
        known = {code.symbol: code.ours for code in ISO_13399 if self.kind in code.ours}
        for symbol, value in self.iso13399.items():
            if symbol not in known:
                hint = near_words(symbol, known)
                raise ValueError(
                    phrase(
                        "iso13399.{symbol}: no code of ours for {kind}{hint}",
                        symbol=symbol,
                        kind=self.kind,
                        hint=hint,
                    )
                )
            ours = known[symbol][self.kind]
            try:
                Geometry.model_validate({ours: int(value) if ours == "teeth" else value})
            except ValidationError as error:
                from autodb.wording.mistakes import mistake_words

                said = mistake_words(error.errors()[0])
                raise ValueError(behind_name(f"iso13399.{symbol}", said)) from None
            own = getattr(self.geometry, ours)
            if own is not None and own != value:
                raise ValueError(
                    phrase(
                        "iso13399.{symbol} = {value} but geometry.{ours} = {own}",
                        symbol=symbol,
                        value=localized(f"{value:g}"),
                        ours=ours,
                        own=localized(f"{own:g}"),
                    )
                )
        return self


def read_tool(path: Path) -> ToolFile:
    """Read a tool file, or a tool bit of FreeCAD; raises UnusableInput with file and key."""
    if path.suffix.lower() != _BIT:
        return read_toml(path, ToolFile)
    try:
        said = _said_in_bit(path)
        return ToolFile.model_validate(said)
    except OSError as error:
        raise UnusableInput(
            phrase(
                "{file}: {strerror}; name a file that is there", file=path, strerror=error.strerror
            )
        ) from None
    except ValidationError as error:
        from autodb.wording.mistakes import mistake_words

        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise UnusableInput(behind_name(path, behind_name(where, mistake_words(first)))) from None


def geometry_of(tool: ToolFile) -> Geometry:
    """Return a tool's geometry under our names, ISO 13399 values included."""
    values = tool.geometry.model_dump(exclude_none=True)
    for code in ISO_13399:
        if code.symbol in tool.iso13399:
            values[code.ours[tool.kind]] = tool.iso13399[code.symbol]
    return Geometry.model_validate(values)


_BIT = ".fctb"
_BIT_UNITS = {
    "": 1.0, "mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4, '"': 25.4, "°": 1.0, "deg": 1.0,
}  # fmt: skip
"""Millimetres or degrees a unit; a number without one is in these."""
_BIT_KINDS = {
    "endmill": "end_mill", "ballend": "end_mill", "bullnose": "end_mill", "drill": "drill",
    "isoshapec": "turning_insert", "isoshaped": "turning_insert", "isoshapes": "turning_insert",
    "isoshapet": "turning_insert",
}  # fmt: skip
"""Kind of tool by a bit's shape, without case and what is no letter."""
_BIT_PARAMETERS = {
    "end_mill": {"Diameter": "diameter_mm", "CornerRadius": "corner_radius_mm", "Flutes": "teeth"},
    "drill": {"Diameter": "diameter_mm", "TipAngle": "point_angle_deg", "Flutes": "teeth"},
    "turning_insert": {"TipRadius": "nose_radius_mm"},
}  # fmt: skip
_QUANTITY = re.compile(r"\s*([-+]?\d+(?:[.,]\d+)?(?:[eE][-+]?\d+)?)\s*(\S*)\s*")


def _said_in_bit(path: Path) -> dict[str, Any]:
    """Return what a bit's file says as a tool file would; raises UnusableInput with the key."""
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
    if kind == "end_mill" and plain != "bullnose":
        found["corner_radius_mm"] = 0.5 * found.get("diameter_mm", 0.0) * (plain == "ballend")
    if found.get("teeth") == 0:
        del found["teeth"]  # FreeCAD's way to say that nobody counted them
    return {"name": str(bit.get("name") or path.stem), "kind": kind, "geometry": found}


def _quantity(path: Path, name: str, value: object) -> float:
    """Return a quantity in millimetres or degrees."""
    read = _QUANTITY.fullmatch(str(value))
    if read is None or read[2].lower() not in _BIT_UNITS:
        raise UnusableInput(
            phrase(
                "{file}: parameter.{name}: '{value}' is no quantity; use one such as '6 mm'",
                file=path,
                name=name,
                value=value,
            )
        )
    return float(read[1].replace(",", ".")) * _BIT_UNITS[read[2].lower()]


_SHAPES_DEG = {
    "A": 85.0, "B": 82.0, "C": 80.0, "D": 55.0, "E": 75.0, "H": 120.0, "K": 55.0, "L": 90.0,
    "M": 86.0, "O": 135.0, "P": 108.0, "S": 90.0, "T": 60.0, "V": 35.0, "W": 80.0,
}  # fmt: skip
"""Angle between the edges of an insert by its first letter (ISO 1832). R is round: it has none."""
_STYLES_DEG = {
    "A": 90.0, "B": 75.0, "D": 45.0, "E": 60.0, "G": 90.0, "H": 107.5, "J": 93.0, "L": 95.0,
    "M": 50.0, "N": 63.0, "R": 75.0, "S": 45.0, "T": 60.0, "V": 72.5, "Y": 85.0,
}  # fmt: skip
"""Entering angle of a holder that feeds along the axis, by its style (ISO 5608). Styles C, F, K, U
and W cut with the end, so that their angle is that of facing: they tell none here."""
_BARS_DEG = {"F": 90.0, "K": 75.0, "Q": 107.5, "U": 93.0, "W": 60.0}
"""The same of the styles that cut with the end, on a bar or a round head: it feeds along its own
axis (ISO 6261)."""
_ROUND_MM = {"06": 6.35, "09": 9.525, "12": 12.7, "15": 15.875, "19": 19.05, "25": 25.4}
"""Diameter of a round insert by its size, where the code ends in 00; in M0 it is the size itself
(ISO 1832). Those of the type X (RCMX) have diameters in mm in either."""
_SHAPES = "".join(_SHAPES_DEG)
_LETTERS = rf"(?<![A-Z])([{_SHAPES}R])[A-GNOP][A-HJ-NU]([A-HJMNPQRTUWXZ])"
_INSERT = re.compile(_LETTERS + r"[\s_-]*(\d{2})[\s_-]*(?:\d{2}|T\d)[\s_-]*(\d{2}|M0)(?!\d)")
_INCHES = re.compile(
    rf"(?<![A-Z])([{_SHAPES}R])[A-GNOP][A-HJ-NU][A-HJMNPQRTUWXZ]?[\s_-]*"
    r"\d\(?[1-9](?:\.5)?\)?(\d(?:\.5)?)(?![\d.])"
)
"""Insert of ANSI B212.4: eighths of an inch across, sixteenths thick, sixty-fourths of nose."""
_HOLDER = re.compile(
    rf"(C(?:3|4|5|6|8|10)|[A-HJSX]\d{{2}}[A-Z]?)?([CDMPSW])([{_SHAPES}R])([A-Y])([A-GNOP])([RLN])"
    r"(?:\d{4,6}[A-Z]?)?(\d{2})?"
)
_INCH_MM = 25.4


def geometry_of_code(text: str) -> dict[str, float]:
    """Return what the codes in a tool's name tell, by names of a tool's geometry; often nothing.

    >>> geometry_of_code("CNMG 120408 in PCLNR 2525M12")
    {'included_deg': 80.0, 'nose_radius_mm': 0.8, 'kappa_deg': 95.0}
    """
    found: dict[str, float] = {}
    said, shape = text.upper(), ""
    insert = _INSERT.search(said) or _INCHES.search(said)
    if insert is not None:
        shape, found["nose_radius_mm"] = insert[1], _nose_mm(insert)
        said = said.replace(insert[0], " ")
    holder = _HOLDER.search(re.sub(r"[\s\-_./]", "", said))
    if holder is not None:
        shape = shape or holder[3]
        kappa = _STYLES_DEG.get(holder[4], _BARS_DEG.get(holder[4]) if holder[1] else None)
        found |= {} if kappa is None or holder[3] == "R" else {"kappa_deg": kappa}
    if shape in _SHAPES_DEG:
        found = {"included_deg": _SHAPES_DEG[shape], **found}
    return found


def _nose_mm(insert: re.Match[str]) -> float:
    """Return the nose radius that an insert's code says: of a round one half its diameter."""
    if insert.re is _INCHES:
        return float(insert[2]) * _INCH_MM / 64.0
    size, nose = insert[3], insert[4]
    if insert[1] != "R":
        return int(nose.replace("M", "")) / 10.0  # M0: sharp, as 00
    inches = nose != "M0" and insert[2] != "X"
    return 0.5 * (_ROUND_MM.get(size, float(size)) if inches else float(size))
