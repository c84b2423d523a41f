"""Machine files (TOML): axes, what carries what, limits, motors, gears, and the control's habits.

Everything that is not known is left out. Values are always in the unit of their name; ``units`` and
``diameter`` say how the control's own programs and logs are to be read.
"""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, PositiveInt, model_validator

from autodb.errors import near_words
from autodb.files.channels import LINEAR_AXES, ROTARY_AXES
from autodb.files.dynamometer import DynamometerSection
from autodb.files.toml import Finite, NotNegative, Positive, ReferenceValue, Section, read_toml
from autodb.wording import localized, phrase

SPINDLE = "spindle"
AXES = (*LINEAR_AXES, *ROTARY_AXES, SPINDLE)

Dialect = Literal[
    "fanuc", "siemens", "heidenhain", "haas", "mazak", "okuma", "linuxcnc", "other"
]  # fmt: skip
Counterweight = Literal["none", "weight", "gas", "hydraulic", "spring"]


Curve = Annotated[tuple[tuple[Positive, Positive], ...], Field(min_length=2)]
"""Pairs of a speed, rpm, rising, and what a motor gives there."""


class Position(Section):
    """Positions of linear axes in their travel."""

    x_mm: Finite | None = None
    y_mm: Finite | None = None
    z_mm: Finite | None = None


class Body(Section):
    """Jaws or a tailstock: where z is when the tool tip touches its face, and how wide it is."""

    z_mm: Finite
    diameter_mm: Positive | None = None


class Clamping(Section):
    """What is clamped today: where the program's zero, the jaws and the tailstock are.

    NC programs alone are made from it; it changes with every job, so the database does not keep it.
    Positions are those of the axes in their travel (a lathe's X as a radius), with the tool tip at
    the place that is named.

    ``zero``: axes with the tool tip at the program's zero (a bar's face on the spindle's axis, the
    middle of a block's top). ``retract``: axes where nothing is in the way. ``clearance_mm``: how
    near rapids come to the stock, and anything to jaws and tailstock.
    """

    tool: PositiveInt = Field(le=99)
    spindle: Literal["M3", "M4"]
    clearance_mm: Positive
    max_speed_rpm: Positive | None = None
    zero: Position
    retract: Position
    jaws: Body
    tailstock: Body | None = None


class AxisLimits(Section):
    """What an axis may carry and where it may go; a rotary axis or spindle has torque and rpm.

    ``torque_curve`` (N·m) and ``power_curve`` (W) of a spindle's motor over the spindle's speed: a
    share ``efficiency`` of them reaches the spindle; ``torque_N_m`` and ``power_W`` hold there.
    """

    force_N: Positive | None = None
    torque_N_m: Positive | None = None
    power_W: Positive | None = None
    torque_curve: Curve | None = None
    power_curve: Curve | None = None
    efficiency: Annotated[float, Field(gt=0, le=1, allow_inf_nan=False)] | None = None
    speed_mm_min: Positive | None = None
    speed_rpm: Positive | None = None
    travel_low_mm: Finite | None = None
    travel_high_mm: Finite | None = None

    @model_validator(mode="after")
    def _travel(self) -> "AxisLimits":
        low, high = self.travel_low_mm, self.travel_high_mm
        if low is not None and high is not None and low >= high:
            raise ValueError(
                phrase(
                    "travel_low_mm {low} is not below travel_high_mm {high}",
                    low=localized(f"{low:g}"),
                    high=localized(f"{high:g}"),
                )
            )
        return self

    @model_validator(mode="after")
    def _curves(self) -> "AxisLimits":
        curves = {"torque_curve": self.torque_curve, "power_curve": self.power_curve}
        for name, curve in curves.items():
            rpm = [speed for speed, _ in curve or ()]
            if rpm != sorted(set(rpm)):
                raise ValueError(
                    phrase("{name}: state [rpm, value] with speeds that rise", name=name)
                )
        if self.efficiency is not None and not any(curves.values()):
            raise ValueError(phrase("efficiency goes with torque_curve or power_curve; state one"))
        return self


class AxisFile(Section):
    """One axis of a machine.

    ``carries``: the tool or the work. ``current_sign`` multiplies the signed current.
    ``carried_by``: the axis it rides on (left out: the bed); ``moved_mass_kg``: all that it moves.
    ``vertical``: where its positive direction points on an axis that bears weight.
    ``gear_ratio``: motor revolutions a revolution of the screw, table or spindle.
    """

    carries: Literal["tool", "work"] = "tool"
    current_sign: Literal[-1, 1] = 1
    carried_by: str | None = None
    moved_mass_kg: Positive | None = None
    vertical: Literal["up", "down"] | None = None
    brake: bool | None = None
    counterweight: Counterweight | None = None
    counterweight_force_N: Positive | None = None
    rated_A: Positive | None = None
    screw_pitch_mm: Positive | None = None
    gear_ratio: Positive | None = None
    limits: AxisLimits = AxisLimits()
    torque_constant_N_m_A: ReferenceValue | None = None

    @model_validator(mode="after")
    def _counterweight_with_force(self) -> "AxisFile":
        if self.counterweight_force_N is not None and self.counterweight in (None, "none"):
            raise ValueError(
                phrase(
                    'counterweight_force_N needs a counterweight; state counterweight = "weight", '
                    "or leave out the force"
                )
            )
        return self


class Gear(Section):
    """One gear range of the spindle; above ``base_speed_rpm`` its power is constant."""

    name: str
    low_rpm: Annotated[float, Field(ge=0, allow_inf_nan=False)] = 0.0
    high_rpm: Positive
    base_speed_rpm: Positive | None = None

    @model_validator(mode="after")
    def _in_order(self) -> "Gear":
        if self.low_rpm >= self.high_rpm:
            raise ValueError(
                phrase(
                    "low_rpm {low} is not below high_rpm {high}",
                    low=localized(f"{self.low_rpm:g}"),
                    high=localized(f"{self.high_rpm:g}"),
                )
            )
        return self


class SpindleFile(Section):
    """Speeds of the spindle: constant torque up to the base speed, constant power above."""

    base_speed_rpm: Positive | None = None
    max_speed_rpm: Positive | None = None
    gear: tuple[Gear, ...] = ()


class Retention(Section):
    """How long an inbox keeps recordings, days from one import to the newest; left out: always."""

    compress_after_days: NotNegative | None = None
    drop_after_days: NotNegative | None = None

    @model_validator(mode="after")
    def _in_turn(self) -> "Retention":
        first, last = self.compress_after_days, self.drop_after_days
        if first is not None and last is not None and last < first:
            raise ValueError(
                phrase(
                    "drop_after_days is less than compress_after_days; use a larger drop_after_days"
                )
            )
        return self


Shares = Literal["nothing", "parameters", "recordings"]


class MachineFile(Section):
    """A machine. ``rotary_order``: the rotary axes from the one on the bed to the outermost.

    ``shares``: what other machines may know of it: None: its parameters, and no more.
    ``dynamometer``: the one of recordings whose side files state none. ``setup``: what is clamped
    today; NC programs are made from it, the database does not keep it.
    """

    dialect: Dialect | None = None
    units: Literal["mm", "inch"] | None = None
    diameter: bool | None = None
    rotary_order: tuple[str, ...] | None = None
    shares: Shares | None = None
    spindle: SpindleFile = SpindleFile()
    retention: Retention = Retention()
    dynamometer: DynamometerSection | None = None
    setup: Clamping | None = None
    axes: dict[str, AxisFile] = Field(json_schema_extra={"minProperties": 1})

    @model_validator(mode="after")
    def _names(self) -> "MachineFile":
        if not self.axes:
            raise ValueError(phrase("a machine needs axes; add [axes.z] to its file"))
        for name, axis in self.axes.items():
            if name not in AXES:
                raise ValueError(
                    phrase(
                        "axes.{name}: no axis has this name{hint}",
                        name=name,
                        hint=near_words(name, AXES),
                    )
                )
            if axis.carried_by is not None and axis.carried_by not in self.axes:
                hint = near_words(axis.carried_by, self.axes)
                raise ValueError(
                    phrase(
                        "axes.{name}.carried_by: no axis '{carried_by}'{hint}",
                        name=name,
                        carried_by=axis.carried_by,
                        hint=hint,
                    )
                )
        for name in self.rotary_order or ():
            if name not in self.axes or name not in ROTARY_AXES:
                raise ValueError(
                    phrase("rotary_order: '{name}' is no rotary axis of this file", name=name)
                )
        names = [gear.name for gear in self.spindle.gear]
        if len(set(names)) < len(names):
            raise ValueError(phrase("spindle.gear: two gear ranges have the same name"))
        return self

    @model_validator(mode="after")
    def _chain_ends_at_the_bed(self) -> "MachineFile":
        for start in self.axes:
            seen = [start]
            while (below := self.axes[seen[-1]].carried_by) is not None:
                if below in seen:
                    raise ValueError(
                        phrase(
                            "axes.{start}.carried_by: axes carry each other in a ring", start=start
                        )
                    )
                seen.append(below)
        return self


LATHE = MachineFile(
    axes={"x": AxisFile(), "z": AxisFile(), "spindle": AxisFile(carries="work")},
)
"""What `machine add NAME` takes without a file: a two-axis lathe."""


MADE_BY = "a first one holds a line each of [axes.x], [axes.z] and [axes.spindle]"


def read_machine_file(path: Path) -> MachineFile:
    """Read a machine file; raises UnusableInput with file and key."""
    return read_toml(path, MachineFile, made_by=MADE_BY)


def lasting_part(file: MachineFile) -> MachineFile:
    """Return what stays true of a machine when the next job is clamped: all but its setup."""
    return file.model_copy(update={"setup": None})


def flat(file: MachineFile) -> dict[str, str]:
    """Return what a machine file states as text by key, such as ``axes.x.limits.force_N``."""
    return _flat("", file.model_dump(exclude_none=True))


def _flat(prefix: str, value: object) -> dict[str, str]:
    if isinstance(value, dict):
        parts = [_flat(f"{prefix}.{key}" if prefix else key, part) for key, part in value.items()]
        return {key: text for part in parts for key, text in part.items()}
    if isinstance(value, tuple) and value and isinstance(value[0], dict):
        return _flat(prefix, {part.pop("name"): part for part in value})
    if isinstance(value, tuple):
        return {prefix: ", ".join(map(str, value))} if value else {}
    if isinstance(value, bool):
        return {prefix: str(value).lower()}
    return {prefix: str(value).removesuffix(".0")}
