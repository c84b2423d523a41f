"""Agent files (TOML): where a running machine is read, what its items mean, and when it cuts."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, model_validator

from autodb.errors import near
from autodb.files.channels import is_channel
from autodb.files.side import FileColumn, ToolSection
from autodb.files.toml import Finite, NotNegative, Positive, Section, read_toml

CHANNELS = ("x.position", "x.current", "x.current.u", "spindle.current", "spindle.speed", "force.x")
COLUMN = ("scale", "unit", "sign", "diameter", "kind", "rated_A", "clips")
"""What an item says of itself that the side file of a recording says of a column."""


class ChannelItem(Section):
    """An item of the machine that a channel is recorded from; the rest as in a side file."""

    item: str
    scale: Finite = 1.0
    unit: str | None = None
    sign: Literal[-1, 1] = 1
    diameter: bool = False
    kind: Literal["iq", "rms", "peak", "percent"] | None = None
    rated_A: Positive | None = None
    clips: bool = False

    def column(self, name: str) -> FileColumn:
        """Return what the side file says of the column that a recording has under ``name``."""
        return FileColumn(column=name, **{key: getattr(self, key) for key in COLUMN})


class StatedItem(Section):
    """An item that states something of a cut: a number times ``scale``, or a text."""

    item: str
    scale: Finite = 1.0


class Condition(Section):
    """What an item must say while it cuts: more or less than a number, or just this."""

    item: str
    above: Finite | None = None
    below: Finite | None = None
    is_: str | Finite | bool | None = Field(default=None, alias="is")

    @model_validator(mode="after")
    def _something(self) -> "Condition":
        if self.above is None and self.below is None and self.is_ is None:
            raise ValueError(f"'{self.item}' needs 'above', 'below' or 'is'")
        return self

    def holds(self, value: float | str | None) -> bool:
        """Say whether a value is what it must be; what is not known is not."""
        if value is None:
            return False
        if self.is_ is not None:
            return _same(value, self.is_)
        number = _number(value)
        if number is None:
            return False
        over = self.above is None or number > self.above
        return over and (self.below is None or number < self.below)


def _same(value: float | str, wanted: str | float | bool) -> bool:
    if isinstance(value, str) and isinstance(wanted, str):
        return value.strip().casefold() == wanted.strip().casefold()
    number = _number(value)
    return number is not None and number == _number(wanted)


def _number(value: float | str | bool) -> float | None:
    try:
        return float(value)
    except ValueError:
        return {"true": 1.0, "false": 0.0}.get(str(value).strip().casefold())


Item = Annotated[
    ChannelItem,
    BeforeValidator(
        lambda value: {"item": value} if isinstance(value, str) else value,
        json_schema_input_type=ChannelItem | str,
    ),
]
"""An item, or just its name where the unit is ours already."""
Number = StatedItem | Finite
Text = StatedItem | str


class SourceSection(Section):
    """Where the machine is read.

    ``sample_ms`` and ``publish_ms``: how often an OPC UA server looks and sends, or an MTConnect
    agent sends. ``password_env``: the variable of the environment that holds the password;
    ``security``: "Policy,Mode,certificate,key" as OPC UA names them. ``device``: of an MTConnect
    agent with several.
    """

    protocol: Literal["opcua", "mtconnect"]
    url: str
    sample_ms: NotNegative = 0.0
    publish_ms: Positive = 200.0
    user: str | None = None
    password_env: str | None = None
    security: str | None = None
    device: str | None = None


class AgentCutSection(Section):
    """When it cuts, and what is known of a cut: as in a side file, or told by items.

    ``while``: all of them hold. A pause shorter than ``pause_s`` belongs to the cut, a cut shorter
    than ``least_s`` is none, one longer than ``longest_s`` is recorded in parts. ``before_s`` and
    ``after_s`` are recorded with it. ``feed_mm_min`` becomes a feed per revolution or tooth.
    """

    while_: Annotated[tuple[Condition, ...], Field(min_length=1, alias="while")]
    before_s: NotNegative = 2.0
    after_s: NotNegative = 2.0
    pause_s: NotNegative = 0.3
    least_s: NotNegative = 0.5
    longest_s: Positive = 300.0
    name: Text | None = None
    block: Number | None = None
    operation: Text | None = None
    depth_mm: Number | None = None
    width_mm: Number | None = None
    feed_mm_tooth: Number | None = None
    feed_mm_rev: Number | None = None
    feed_mm_min: Number | None = None
    speed_rpm: Number | None = None
    feed_direction_deg: Number | None = None
    work_diameter_mm: Number | None = None


class WorkSection(Section):
    """What is on the machine, for [recording] of the side files: stated, or told by items."""

    job: Text | None = None
    program: Text | None = None
    kind: Text | None = None
    work: Text | None = None
    coolant: Text | None = None
    gear_range: Text | None = None
    sensor: Text | None = None
    calibration: Text | None = None


class AgentFile(Section):
    """A whole agent file.

    ``inbox`` and tool files lie relative to the agent file. ``tool_number`` tells which of
    ``tools`` cuts; without it ``tool`` does.
    """

    machine: str
    inbox: str = "inbox"
    rate_hz: Positive
    source: SourceSection
    channels: Annotated[dict[str, Item], Field(min_length=1)]
    cut: AgentCutSection
    recording: WorkSection = WorkSection()
    tool: ToolSection = ToolSection()
    tool_number: StatedItem | None = None
    tools: dict[str, ToolSection] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _channel_names(self) -> "AgentFile":
        for name in self.channels:
            if not is_channel(name) or name == "t":
                raise ValueError(f"[channels] '{name}' is not a channel name{near(name, CHANNELS)}")
        return self

    @model_validator(mode="after")
    def _tools(self) -> "AgentFile":
        if bool(self.tools) != (self.tool_number is not None):
            raise ValueError("tool_number and [tools.NUMBER] go together")
        return self

    def said(self) -> dict[str, StatedItem]:
        """Return what items tell of a cut, by section and key: 'cut.depth_mm', 'tool.number'."""
        found = dict(_told("cut", self.cut)) | dict(_told("recording", self.recording))
        if self.tool_number is not None:
            found["tool.number"] = self.tool_number
        return found

    def items(self) -> list[str]:
        """Return every item that is read, each once."""
        named = [one.item for one in self.channels.values()]
        named += [one.item for one in self.cut.while_]
        named += [one.item for one in self.said().values()]
        return list(dict.fromkeys(named))


def _told(section: str, values: Section) -> Iterator[tuple[str, StatedItem]]:
    for key in type(values).model_fields:
        value = getattr(values, key)
        if isinstance(value, StatedItem):
            yield f"{section}.{key}", value


def read_agentfile(path: Path) -> AgentFile:
    """Read and check an agent file; raises UnusableInput with the file and the key."""
    return read_toml(path, AgentFile)
