"""Tools: kind and geometry of a tool file (TOML), or of what a tool's maker or a CAM program says.

A tool file has our own names or ISO 13399 property codes. Source of these: the property symbols of
ISO 13399 as the MTConnect standard and public tool catalogues print them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, PositiveInt, ValidationError, model_validator

from autodb.errors import UnusableInput, behind_name, near_words
from autodb.files.toml import Finite, Positive, Section, read_toml
from autodb.files.tool_sources import bits, din4000, part21
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
    Code("EPSR", "insert included angle", "deg", {"turning_insert": "included_deg"}),
    Code("LAMS", "inclination angle", "deg", {"turning_insert": "inclination_deg"}),
    Code("SIG", "point angle", "deg", {"drill": "point_angle_deg"}),
)  # fmt: skip


class Geometry(Section):
    """Geometry that is known.

    ``kappa_deg``: entering angle; ``rake_deg``: normal rake, ``inclination_deg``: both of the
    insert in its holder; ``included_deg``: between its edges; ``teeth``: edges that cut (flutes of
    a drill).
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
    included_deg: Angle | None = None


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


_SAID_IN: dict[str, Callable[[Path, str | None], dict[str, Any]]] = {
    bits.SUFFIX: bits.said_in_bit,
    part21.SUFFIX: part21.said_in_file,
    part21.PACKAGE: part21.said_in_package,
    **dict.fromkeys(din4000.SUFFIXES, din4000.said_in_table),
}
"""What reads a file that is no tool file of ours, by the end of its name."""


def read_tool(path: Path, name: str | None = None) -> ToolFile:
    """Read a tool file, or what a tool's maker or a CAM program says of the tool.

    ``name``: what the shop calls it; a catalogue's data says what its maker does. Of several tools
    in a file it tells which. Raises UnusableInput with file and key.
    """
    said_in = _SAID_IN.get(path.suffix.lower())
    if said_in is None:
        return read_toml(path, ToolFile)
    try:
        return ToolFile.model_validate(said_in(path, name))
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
