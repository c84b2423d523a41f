"""Job files (TOML): the cuts, or the turning program, that a planner wants forces for."""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import ConfigDict, Field, PositiveInt, model_validator
from pydantic.config import JsonDict

from autodb.files.job_cut import Across, Coordinate, Diameter, EndDiameter, JobCut, Rpm
from autodb.files.part import BarSection
from autodb.files.toml import Finite, NotNegative, Section, read_toml
from autodb.wording import phrase


def is_none(value: object) -> bool:
    """Return whether a key was left out: of two that exclude each other, one is written."""
    return value is None


def _either(*keys: str) -> JsonDict:
    """Return what a schema says of a section that has exactly one of some keys."""
    return {"oneOf": [{"required": [key]} for key in keys]}


OTHERS = "other"
"""Of a program's tools, what those are that are not named."""


_NEEDS = {"grooving": "width_mm", "drill": "diameter_mm", "end_mill": "diameter_mm"}


class ProgramTool(Section):
    """A tool of a program: what it does, and what of its shape decides its engaged edge.

    ``edge_mm``: the longest depth it cuts; ``kappa_deg``: its entering angle; ``width_mm`` of a
    blade, whose programmed ``corner`` is that towards the chuck or that away from it;
    ``diameter_mm`` of a drill or a mill, which has ``teeth``, ``corner_radius_mm``, ``helix_deg``;
    ``offset_mm``: how far beside a contour in G41 and G42 its centre goes, left out: its radius.
    """

    kind: Literal["outside", "boring", "grooving", "threading", "drill", "end_mill"] = "outside"
    edge_mm: Across | None = None
    kappa_deg: Annotated[float, Field(gt=0, lt=180, allow_inf_nan=False)] | None = None
    width_mm: Across | None = None
    corner: Literal["chuck", "away"] = "chuck"
    diameter_mm: Diameter | None = None
    teeth: PositiveInt | None = None
    corner_radius_mm: NotNegative | None = None
    helix_deg: Finite | None = None
    offset_mm: NotNegative | None = Field(default=None, exclude_if=is_none)

    @model_validator(mode="after")
    def _what_its_kind_needs(self) -> "ProgramTool":
        needs = _NEEDS.get(self.kind)
        if needs is not None and getattr(self, needs) is None:
            raise ValueError(
                phrase("a tool of kind '{kind}' needs {needs}", kind=self.kind, needs=needs)
            )
        return self


class ContourCycle(Section):
    """What a call of Sinumerik's CYCLE952 does, as its mask shows it: in the program it is digits.

    ``cut``: its passes go along the axis, towards the chuck, or across, towards the axis;
    ``passes``: it roughs, finishes or both; ``allowance``: those of X and Z count (UX, UZ), or that
    of the contour (U). Outside or inside is as its tool is.
    """

    cut: Literal["along", "across"]
    passes: Literal["roughing", "finishing", "both"]
    allowance: Literal["axes", "contour"] | None = Field(default=None, exclude_if=is_none)


class JobProgram(Section):
    """A program in place of cuts, and the stock that it meets: a lathe's, or a mill's block.

    ``file``: in a job file relative to it. The stock is a bar, ``stock_diameter_mm``, with its face
    at ``stock_face_mm`` (0), or ``stock``: pairs of z (rising to the face, a z twice is a shoulder)
    and diameter, mm; behind the first the stock goes on; or ``block_mm``: lowest and
    highest x, y and z of a block, and the program is a mill's. ``units`` and ``diameter``: how the
    program is read where it does not say; left out: as the machine file says. ``feeds``: what those
    of a lathe's count until the program says it, left out: a revolution, of LinuxCNC a minute.
    ``speed_rpm``: what the spindle turns at until the program says a speed. ``block_skip``: what
    stands behind a / is left out. ``last_line``: the program as if it ended behind that line.
    ``left_out``: subprograms that are missing and cut nothing. ``angles``: of a mill's rotary
    axes, degrees: what is cut where they stand so is predicted, others stand at 0. ``plane``: the
    line that tilts the plane of which what is cut is predicted, 0: upright. ``centres``: whether
    I, J and K of arcs are ways from their start or places. ``sha256``: of the program's file;
    another one is refused. ``control``: for which it is written, left out: as its words tell.
    ``bore_diameter_mm``: of a hole that the stock has. ``tools``: what tools are, by what the
    program calls them (``0303``, or ``3``), ``other`` of all others. ``cycle952``: what calls of
    that cycle do, by their lines.
    """

    model_config = ConfigDict(json_schema_extra=_either("stock_diameter_mm", "stock", "block_mm"))

    file: str
    stock_diameter_mm: Diameter | None = Field(default=None, exclude_if=is_none)
    stock_face_mm: Coordinate | None = None
    stock: tuple[tuple[Coordinate, EndDiameter], ...] | None = Field(
        default=None, exclude_if=is_none
    )
    block_mm: (
        tuple[Coordinate, Coordinate, Coordinate, Coordinate, Coordinate, Coordinate] | None
    ) = Field(default=None, exclude_if=is_none)
    units: Literal["mm", "inch"] | None = None
    diameter: bool | None = None
    feeds: Literal["minute", "revolution"] | None = Field(default=None, exclude_if=is_none)
    speed_rpm: Rpm | None = Field(default=None, exclude_if=is_none)
    block_skip: bool | None = Field(default=None, exclude_if=is_none)
    last_line: Annotated[int, Field(ge=1)] | None = Field(default=None, exclude_if=is_none)
    left_out: tuple[Annotated[str, Field(min_length=1)], ...] = Field(
        default=(), exclude_if=lambda names: not names
    )
    angles: dict[Annotated[str, Field(pattern="^[ABC]$")], Finite] | None = Field(
        default=None, exclude_if=is_none
    )
    plane: Annotated[int, Field(ge=0)] | None = Field(default=None, exclude_if=is_none)
    centres: Literal["start", "places"] | None = Field(default=None, exclude_if=is_none)
    sha256: str | None = None
    control: Literal["fanuc-a", "fanuc-b", "fanuc-c", "linuxcnc", "okuma", "sinumerik"] | None = (
        Field(default=None, exclude_if=is_none)
    )
    bore_diameter_mm: Diameter | None = Field(default=None, exclude_if=is_none)
    tools: dict[str, ProgramTool] = Field(default_factory=dict, exclude_if=lambda tools: not tools)
    cycle952: dict[Annotated[str, Field(pattern="^[1-9][0-9]*$")], ContourCycle] = Field(
        default_factory=dict, exclude_if=lambda calls: not calls
    )

    @model_validator(mode="after")
    def _one_stock(self) -> "JobProgram":
        given = [self.stock_diameter_mm, self.stock, self.block_mm]
        if sum(one is not None for one in given) != 1:
            raise ValueError(
                phrase(
                    "give one of stock_diameter_mm (a bar), stock, or block_mm of a mill, and no "
                    "other"
                )
            )
        if self.block_mm is not None and self.cycle952:
            raise ValueError(phrase("cycle952 goes with a lathe's stock, and block_mm is a mill's"))
        if self.block_mm is not None and self.feeds is not None:
            raise ValueError(
                phrase("feeds goes with a lathe's stock; a mill's count a minute until G95")
            )
        if self.block_mm is None and self.angles is not None:
            raise ValueError(phrase("angles goes with block_mm, the block of a mill"))
        if self.block_mm is None and self.plane is not None:
            raise ValueError(phrase("plane goes with block_mm, the block of a mill"))
        if self.block_mm is not None:
            x0, x1, y0, y1, z0, z1 = self.block_mm
            if x0 >= x1 or y0 >= y1 or z0 >= z1:
                raise ValueError(
                    phrase("block_mm: state [x_low, x_high, y_low, y_high, z_low, z_high]")
                )
        if self.stock is None:
            return self
        if self.stock_face_mm is not None:
            raise ValueError(
                phrase("stock_face_mm goes with stock_diameter_mm; stock says where it ends")
            )
        z_mm = [z for z, _ in self.stock]
        if z_mm != sorted(z_mm) or len(set(z_mm)) < 2:
            raise ValueError(
                phrase("stock: state [z_mm, diameter_mm] at two places or more, with z rising")
            )
        return self


SomeText = Annotated[str, Field(min_length=1)]


class Job(Section):
    """A job: material, tool, and its cuts in order or the program that makes them.

    ``lot``: of the material, such as a bar or a heat number; what was learnt of that lot alone then
    counts. ``bar``: the work, and ``shank``: the tool, as round bars that bend.
    """

    model_config = ConfigDict(
        json_schema_extra=_either("cut", "program"),
        defer_build=False,  # a route's body: what reads it is made with the route
    )

    name: str
    material: SomeText
    tool: SomeText
    lot: str | None = Field(default=None, exclude_if=is_none)
    bar: BarSection | None = Field(default=None, exclude_if=is_none)
    shank: BarSection | None = Field(default=None, exclude_if=is_none)
    cut: tuple[JobCut, ...] = Field(default=(), min_length=1, exclude_if=lambda cut: not cut)
    program: JobProgram | None = Field(default=None, exclude_if=is_none)

    @model_validator(mode="after")
    def _cuts_or_a_program(self) -> "Job":
        if bool(self.cut) == (self.program is not None):
            raise ValueError(phrase("give either [[cut]] or [program], and only one of them"))
        return self


def read_job(path: Path) -> Job:
    """Read and check a job file; a program's file is then relative to the working folder.

    Raises UnusableInput with file and key.
    """
    job = read_toml(path, Job, made_by="'autodb demo' writes one, demo-out/job.toml")
    if job.program is None:
        return job
    program = job.program.model_copy(update={"file": str(path.parent / job.program.file)})
    return job.model_copy(update={"program": program})
