"""Side files (TOML): foreign column names and units, and what was on the machine."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, PositiveInt, model_validator

from autodb.errors import UnusableInput, behind_name, near_words
from autodb.files.channels import is_channel
from autodb.files.dynamometer import DynamometerSection, PublicationSection
from autodb.files.text import TextSection
from autodb.files.toml import Finite, Positive, Section, checked, read_toml
from autodb.files.tool import ToolKind, geometry_of, read_tool
from autodb.wording import listed, phrase

Operation = Literal[
    "slot", "side-up", "side-down", "ramp", "pocket", "turn", "face", "taper", "contour", "drill"
]


class FileColumn(Section):
    """Where a channel comes from: a column of the file, or a count of rows.

    ``row_in`` counts rows within each value of that column (``"*"``: within the file), times
    ``step_s``. ``sign``: 1 states that it is right as it is. ``clips``: the machine itself limits
    this channel; a plateau at its extreme is true.
    """

    column: str | None = None
    row_in: str | None = None
    step_s: Positive = 1.0
    scale: Finite = 1.0
    unit: str | None = None
    sign: Literal[-1, 1] | None = None
    diameter: bool = False
    kind: Literal["iq", "rms", "peak", "percent"] | None = None
    rated_A: Positive | None = None
    clips: bool = False


def _as_table(value: object) -> object:
    return {"column": value} if isinstance(value, str) else value


Named = Annotated[FileColumn, BeforeValidator(_as_table, json_schema_input_type=FileColumn | str)]
"""A column, or just its name where the unit is ours already."""


class RecordingSection(Section):
    """Where and when it was recorded, and what ran: a ``job``, or its ``program``.

    ``lot``: of the work material.
    """

    machine: str | None = None
    job: str | None = None
    program: str | None = None
    kind: str | None = None
    work: str | None = None
    lot: str | None = None
    start: str | None = None
    coolant: str | None = None
    gear_range: str | None = None
    sensor: str | None = None
    calibration: str | None = None
    spindle_state: Literal["cold", "warm"] | None = None
    diameter: bool = False


class ToolSection(Section):
    """The tool in use: a cutter's diameter, teeth, helix, or an insert's angles.

    ``file``: a tool file, relative to the side file, that says the same or more.
    """

    name: str | None = None
    file: str | None = None
    kind: ToolKind | None = None
    diameter_mm: Positive | None = None
    teeth: PositiveInt | None = None
    helix_deg: Finite | None = None
    nose_radius_mm: Finite | None = None
    kappa_deg: Finite | None = None
    rake_deg: Finite | None = None
    inclination_deg: Finite | None = None
    included_deg: Finite | None = None
    corner_radius_mm: Finite | None = None
    point_angle_deg: Finite | None = None


class CutSection(Section):
    """The one cut of a recording over time; ``name`` or ``block``: which of its job's cuts."""

    name: str | None = None
    block: PositiveInt | None = None
    operation: Operation | None = None
    depth_mm: Positive | None = None
    width_mm: Positive | None = None
    feed_mm_tooth: Positive | None = None
    feed_mm_rev: Positive | None = None
    speed_rpm: Positive | None = None
    feed_direction_deg: Finite | None = None
    work_diameter_mm: Positive | None = None


class ValuesSection(Section):
    """What texts of the file mean: operations, materials and tools by the file's own words."""

    operation: dict[str, Operation] = Field(default_factory=dict)
    material: dict[str, str] = Field(default_factory=dict)
    tool: dict[str, str] = Field(default_factory=dict)

    def of(self, channel: str) -> Mapping[str, str]:
        """Return what texts of a channel mean, by what the file says."""
        means: dict[str, Mapping[str, str]] = {
            "operation": self.operation,
            "work.material": self.material,
            "tool": self.tool,
        }
        return means.get(channel, {})


class SideFile(Section):
    """A whole side file; every part is optional.

    ``csv``: how a text table is written, where that is not to be detected. ``source``: where forces
    were taken from that nobody measured here.
    """

    csv: TextSection = TextSection()
    channels: dict[str, Named] = Field(default_factory=dict)
    values: ValuesSection = ValuesSection()
    recording: RecordingSection = RecordingSection()
    tool: ToolSection = ToolSection()
    cut: CutSection = CutSection()
    dynamometer: DynamometerSection | None = None
    source: PublicationSection | None = None

    @model_validator(mode="after")
    def _channels(self) -> "SideFile":
        faults = {name: _fault(name, spec) for name, spec in self.channels.items()}
        said = [
            behind_name(f"[channels] '{name}'", fault, " ")
            for name, fault in faults.items()
            if fault
        ]
        if said:
            raise ValueError(listed(said, "; "))
        return self

    @model_validator(mode="after")
    def _one_statement_of_forces(self) -> "SideFile":
        if self.source is not None and self.dynamometer is not None:
            raise ValueError(
                phrase(
                    "[source] and [dynamometer] both say where the forces are from; state [source] "
                    "for a publication's forces, [dynamometer] for your own"
                )
            )
        return self


StatedColumns = Path | SideFile | None
"""A side file on the disk or as it is; None: the one beside the recording, where there is one."""


def stated_side(said: Mapping[str, Any], *, where: str) -> SideFile:
    """Return a side file of what a program says: all of it, or its channels alone.

    Raises UnusableInput as ``read_sidefile`` does.
    """
    whole = said.keys() <= SideFile.model_fields.keys()
    return checked(said if whole else {"channels": said}, SideFile, where=where)


MADE_BY = "'autodb look FILE --write' writes a first one beside a recording"


def read_sidefile(path: Path) -> SideFile:
    """Read and check a side file.

    Raises UnusableInput with the file, the key and names that would have worked.
    """
    return _with_tool_file(path, read_toml(path, SideFile, made_by=MADE_BY))


def _with_tool_file(path: Path, side: SideFile) -> SideFile:
    """Return a side file whose [tool] also says what its tool file says."""
    if side.tool.file is None:
        return side
    tool = read_tool(path.parent / side.tool.file, side.tool.name)
    known = geometry_of(tool).model_dump(exclude_none=True)
    known |= {"name": tool.name, "kind": tool.kind}
    said = side.tool.model_dump(exclude_none=True)
    for key, value in said.items():
        if known.get(key, value) != value:
            raise UnusableInput(
                phrase(
                    "{file}: [tool] {key} = {value}, but {file_2} says {known}",
                    file=path,
                    key=key,
                    value=value,
                    file_2=side.tool.file,
                    known=known[key],
                )
            )
    return side.model_copy(update={"tool": ToolSection.model_validate({**known, **said})})


def _fault(name: str, spec: FileColumn) -> str:
    """Return what is wrong with a channel, or nothing."""
    if not is_channel(name):
        known = ["x.position", "x.current", "x.drive_force", "spindle.current", "force.x", "t"]
        hint = near_words(
            name, [*known, "force.z", "z.current", "z.current.range", "z.position", "cut"]
        )
        return phrase("is not a channel name{hint}", hint=hint)
    if (spec.column is None) == (spec.row_in is None):
        return phrase("needs either column or row_in")
    if spec.scale == 0:
        return phrase("has scale 0, which makes every value 0; use another scale")
    if spec.kind == "percent" and spec.rated_A is None:
        return phrase("of kind percent needs rated_A")
    return ""
