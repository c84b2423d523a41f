"""Tool files (TOML): kind and geometry, under our own names or under ISO 13399 property codes.

Source of the codes: the property symbols of ISO 13399 as the MTConnect standard and public tool
catalogues print them. Symbols for rake and inclination are not among those that could be checked,
so these angles have our own names only.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, PositiveInt, ValidationError, model_validator

from autodb.errors import UnusableInput, near
from autodb.files.toml import Finite, Positive, Section, read_toml

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
                hint = near(symbol, known)
                raise ValueError(f"iso13399.{symbol}: no code of ours for {self.kind}{hint}")
            ours = known[symbol][self.kind]
            try:
                Geometry.model_validate({ours: int(value) if ours == "teeth" else value})
            except ValidationError as error:
                from autodb.wording.mistakes import mistake_words

                said = mistake_words(error.errors()[0])
                raise ValueError(f"iso13399.{symbol}: {said}") from None
            own = getattr(self.geometry, ours)
            if own is not None and own != value:
                raise ValueError(f"iso13399.{symbol} = {value:g} but geometry.{ours} = {own:g}")
        return self


BIT = ".fctb"
"""Suffix of a tool bit of FreeCAD."""


def read_tool(path: Path) -> ToolFile:
    """Read a tool file, or a tool bit of FreeCAD; raises UnusableInput with file and key."""
    if path.suffix.lower() != BIT:
        return read_toml(path, ToolFile)
    from autodb.files.tool_bit import tool_of_bit  # few shops have them

    try:
        said = tool_of_bit(path)
        return ToolFile.model_validate(said)
    except OSError as error:
        raise UnusableInput(f"{path}: {error.strerror}; name a file that is there") from None
    except ValidationError as error:
        from autodb.wording.mistakes import mistake_words

        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise UnusableInput(f"{path}: {where}: {mistake_words(first)}") from None


def geometry_of(tool: ToolFile) -> Geometry:
    """Return a tool's geometry under our names, ISO 13399 values included."""
    values = tool.geometry.model_dump(exclude_none=True)
    for code in ISO_13399:
        if code.symbol in tool.iso13399:
            values[code.ours[tool.kind]] = tool.iso13399[code.symbol]
    return Geometry.model_validate(values)
