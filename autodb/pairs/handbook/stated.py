"""What a source says of a material, as its file states it: every value with bounds and source.

A file has one of four sections, after what was found to read: `[shear]`, the five numbers of the
thin-shear-zone law; `[linear_edge]`, its chip and edge coefficients; `[table]`, specific forces
over feed; `[kienzle]`, which may also stand beside `[shear]`. Bounds are taken as those of 95 %.
Specific forces hold at `rake_deg`; where the source does not say a rake, they are taken for those
at 0.
"""

from statistics import median
from typing import Annotated, ClassVar

from pydantic import Field, model_validator

from autodb.files.toml import Finite, Positive, Section


class StatedValue(Section):
    """A value with 95 % bounds; what was read, whom it cites, how sure it is, and since when.

    ``read``: several values that were read, of which it is the median and they the extremes.
    """

    value: Finite
    lower: Finite
    upper: Finite
    read: tuple[Finite, ...] = ()
    unit: str
    source: str = Field(min_length=1)
    citation: str = Field(min_length=1)
    status: str = Field(min_length=1)
    date: str = Field(pattern=r"^\d{4}-\d\d-\d\d$")

    @model_validator(mode="after")
    def _in_order(self) -> "StatedValue":
        if not self.lower < self.value < self.upper:
            raise ValueError(f"value {self.value:g} must lie between lower and upper")
        return self

    @model_validator(mode="after")
    def _of_what_was_read(self) -> "StatedValue":
        if self.read and (self.value, self.lower, self.upper) != (
            median(self.read), min(self.read), max(self.read),
        ):  # fmt: skip
            raise ValueError("value, lower and upper are to be the median and extremes of read")
        return self


class Size(StatedValue):
    """A value that is above 0, and its bounds with it."""

    lower: Positive


class StatedColumn(Section):
    """Values of a table's row, each above 0 and with its bounds."""

    value: tuple[Positive, ...] = Field(min_length=2)
    lower: tuple[Positive, ...]
    upper: tuple[Positive, ...]
    unit: str
    source: str = Field(min_length=1)
    citation: str = Field(min_length=1)
    status: str = Field(min_length=1)
    date: str = Field(pattern=r"^\d{4}-\d\d-\d\d$")

    @model_validator(mode="after")
    def _in_order(self) -> "StatedColumn":
        if not len(self.lower) == len(self.value) == len(self.upper):
            raise ValueError("value, lower and upper must be as many")
        for low, value, high in zip(self.lower, self.value, self.upper, strict=True):
            if not low < value < high:
                raise ValueError(f"value {value:g} must lie between lower and upper")
        return self


class _InUnits(Section):
    """A section whose values have one unit each."""

    UNITS: ClassVar[dict[str, str]]

    @model_validator(mode="after")
    def _in_its_units(self) -> "_InUnits":
        for name, unit in self.UNITS.items():
            stated = getattr(self, name).unit
            if stated != unit:
                raise ValueError(f"{name}.unit is '{stated}'; use '{unit}'")
        return self


class Shear(_InUnits):
    """The five numbers of the law along lines in the normal rake γ, °, at chips of h mm.

    Friction angle β = β_0 + β_1 γ, chip ratio r = (r_0 + r_1 γ) h^(a_0 + a_1 γ).
    """

    UNITS: ClassVar[dict[str, str]] = {
        "shear_stress": "MPa", "friction_angle": "deg", "friction_angle_rake": "deg/deg",
        "chip_ratio": "1", "chip_ratio_rake": "1/deg", "chip_ratio_thickness": "1",
        "chip_ratio_thickness_rake": "1/deg", "K_te": "N/mm", "K_re": "N/mm",
    }  # fmt: skip

    shear_stress: Size
    friction_angle: Size
    friction_angle_rake: StatedValue
    chip_ratio: Size
    chip_ratio_rake: StatedValue
    chip_ratio_thickness: StatedValue
    chip_ratio_thickness_rake: StatedValue
    K_te: Size
    K_re: Size

    @property
    def read(self) -> tuple[StatedValue, ...]:
        """The values in their order."""
        return tuple(getattr(self, name) for name in self.UNITS)


class LinearEdge(_InUnits):
    """Tangential force per width K_tc h + K_te and thrust K_rc h + K_re of an orthogonal edge."""

    UNITS: ClassVar[dict[str, str]] = {
        "K_tc": "N/mm²",
        "K_te": "N/mm",
        "K_rc": "N/mm²",
        "K_re": "N/mm",
    }

    K_tc: Size
    K_te: Size
    K_rc: Size
    K_re: Size
    rake_deg: Finite = 0.0


class ForceTable(_InUnits):
    """Specific tangential forces over feed, of a straight edge at an entering angle."""

    UNITS: ClassVar[dict[str, str]] = {"specific_force": "N/mm²"}

    entering_deg: Annotated[float, Field(strict=True, gt=0, le=90)]
    feed_mm: tuple[Positive, ...]
    specific_force: StatedColumn
    rake_deg: Finite = 0.0

    @model_validator(mode="after")
    def _as_many(self) -> "ForceTable":
        if len(self.feed_mm) != len(self.specific_force.value):
            raise ValueError("feed_mm and specific_force.value must be as many")
        if list(self.feed_mm) != sorted(set(self.feed_mm)):
            raise ValueError("feed_mm must grow")
        return self


class Kienzle(_InUnits):
    """k_c = k_c1.1 h^-m_c."""

    UNITS: ClassVar[dict[str, str]] = {"k_c11": "N/mm²", "m_c": "1"}

    k_c11: Size
    m_c: StatedValue
    rake_deg: Finite = 0.0


class Alias(Section):
    """Another name of the material, and where it was read to be one."""

    name: str = Field(min_length=1)
    source: str = Field(min_length=1)


class StatedMaterial(Section):
    """Conventional values of a work material, from one source."""

    name: str = Field(min_length=1)
    note: str = ""
    alias: tuple[Alias, ...] = ()
    shear: Shear | None = None
    linear_edge: LinearEdge | None = None
    table: ForceTable | None = None
    kienzle: Kienzle | None = None

    @model_validator(mode="after")
    def _one_kind(self) -> "StatedMaterial":
        both = self.shear is not None and self.kienzle is not None
        if len(self.kinds) != (2 if both else 1):
            raise ValueError(
                "give one of [shear], [linear_edge], [table] and [kienzle], or [shear] with "
                "[kienzle]"
            )
        return self

    @property
    def kinds(self) -> tuple[Shear | LinearEdge | ForceTable | Kienzle, ...]:
        """The sections that are there."""
        all_ = (self.shear, self.linear_edge, self.table, self.kienzle)
        return tuple(kind for kind in all_ if kind is not None)

    @property
    def names(self) -> tuple[str, ...]:
        """Its name and the other names that it has."""
        return (self.name, *(alias.name for alias in self.alias))
