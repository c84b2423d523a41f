"""The recording of a cut, as files that an inbox takes: Parquet, side file and checksum."""

from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import tomli_w
from pyarrow import parquet
from pydantic import ValidationError

from autodb.errors import UnusableInput
from autodb.files.checksums import checksum
from autodb.files.side import CutSection, RecordingSection, SideFile, ToolSection
from autodb.files.targets import hidden, replace_by, write_text
from autodb.files.tool import geometry_of, read_tool
from autodb.live.agentfile import AgentFile, StatedItem
from autodb.live.batch import Value
from autodb.live.segmenter import LiveCut
from autodb.wording.mistakes import mistake_words

PER_TURN = ("turn", "face", "taper", "contour", "drill")
"""Operations whose feed is per revolution; of the others it is per tooth."""


def name_of(cut: LiveCut) -> str:
    """Return what the files of a cut are called: by when it was recorded, UTC."""
    start = datetime.fromtimestamp(cut.start_s, UTC)
    return f"cut-{start:%Y%m%dT%H%M%S}.{start.microsecond:06d}Z"


def write(cut: LiveCut, plan: AgentFile, *, beside: Path, inbox: Path) -> tuple[Path, list[str]]:
    """Write the recording of a cut into an inbox; the same cut gives the same files again.

    ``beside``: the folder that tool files lie relative to. What would begin to be read is written
    last. Returns the recording, and what of the cut could not be stated. Raises OSError.
    """
    inbox.mkdir(parents=True, exist_ok=True)
    side, notes = side_of(cut, plan, beside)
    target = inbox / f"{name_of(cut)}.parquet"
    known = {
        name: column for name, column in cut.columns.items() if bool(np.any(np.isfinite(column)))
    }
    notes += [f"{name}: never known while it was cut" for name in cut.columns if name not in known]
    notes += [
        f"{name}: comes every {step_s:.3g} s, its rows repeat it at {plan.rate_hz:g} Hz"
        for name, step_s in cut.seldom.items()
        if name in known
    ]
    with hidden(target) as part:
        table = {"t": cut.t} | known
        parquet.write_table(pa.table(table), part, compression="zstd")
        said = side.model_dump(mode="json", exclude_defaults=True)
        said["channels"] = {name: said["channels"][name] for name in known}
        write_text(target.with_suffix(".toml"), tomli_w.dumps(_plain(said)))
        write_text(target.with_name(f"{target.name}.sha256"), f"{checksum(part)}  {target.name}\n")
        replace_by(part, target)
    return target, notes


def side_of(cut: LiveCut, plan: AgentFile, beside: Path) -> tuple[SideFile, list[str]]:
    """Return the side file of a cut, and what could not be stated of it."""
    notes: list[str] = []
    told = {key: _said(value, cut.said.get(key)) for key, value in plan.said().items()}
    start = datetime.fromtimestamp(cut.start_s, UTC).isoformat(timespec="microseconds")
    tool = _tool(plan, told.get("tool.number"), beside, notes)
    work = _as_texts(_stated(plan.recording, "recording", told), RecordingSection)
    work |= {"machine": plan.machine, "start": start}
    conditions = _feeds(_as_texts(_stated(plan.cut, "cut", told), CutSection), tool)
    side = SideFile(
        channels={name: one.column(name) for name, one in plan.channels.items()},
        recording=_checked(RecordingSection, work, "recording", notes),
        tool=tool,
        cut=_checked(CutSection, conditions, "cut", notes),
    )
    return side, notes


def _said(told: StatedItem, value: Value) -> Value:
    """Return what an item told, a number by its scale."""
    if value is None:
        return None
    try:
        return float(value) * told.scale
    except ValueError:
        return str(value)


def _stated(section: Any, prefix: str, told: dict[str, Value]) -> dict[str, Value]:
    """Return what a section states: what it says itself, and what items told in its place."""
    found: dict[str, Value] = {}
    for key in type(section).model_fields:
        value = getattr(section, key)
        if isinstance(value, StatedItem):
            value = told[f"{prefix}.{key}"]
        if isinstance(value, float | str):
            found[key] = value
    return found


def _as_texts(stated: dict[str, Value], section: Any) -> dict[str, Value]:
    """Return what is stated with numbers as texts where a section has texts: program 1234."""
    texts = {name for name, field in section.model_fields.items() if field.annotation == str | None}
    return {
        key: f"{value:g}" if key in texts and isinstance(value, float) else value
        for key, value in stated.items()
    }


def _feeds(stated: dict[str, Value], tool: ToolSection) -> dict[str, Value]:
    """Return conditions with a feed per minute as one per revolution, or tooth."""
    known = {key: value for key, value in stated.items() if key in CutSection.model_fields}
    feed, speed = stated.get("feed_mm_min"), stated.get("speed_rpm")
    if isinstance(feed, float) and isinstance(speed, float) and speed > 0.0:
        if stated.get("operation") in PER_TURN:
            known.setdefault("feed_mm_rev", feed / speed)
        elif tool.teeth is not None:
            known.setdefault("feed_mm_tooth", feed / speed / tool.teeth)
    return known


def _tool(plan: AgentFile, number: Value, beside: Path, notes: list[str]) -> ToolSection:
    """Return the tool in use, with what its tool file says."""
    tool = plan.tool
    if plan.tool_number is not None:
        key = (
            "unknown" if number is None else f"{number:g}" if isinstance(number, float) else number
        )
        if key not in plan.tools:
            notes.append(f"tool {key}: no [tools.{key}]")
            return ToolSection()
        tool = plan.tools[key]
    try:
        return with_file(tool, beside)
    except UnusableInput as error:
        notes.append(str(error))
        return tool.model_copy(update={"file": None})


def with_file(tool: ToolSection, beside: Path) -> ToolSection:
    """Return a tool with what its tool file says; raises UnusableInput."""
    if tool.file is None:
        return tool
    read = read_tool(beside / tool.file, tool.name)
    known = geometry_of(read).model_dump(exclude_none=True)
    known |= {"name": read.name, "kind": read.kind}
    said = tool.model_dump(exclude_none=True, exclude={"file"})
    return ToolSection.model_validate(known | said)


def _checked(section: Any, values: dict[str, Value], name: str, notes: list[str]) -> Any:
    """Return a section of what can be stated in it; the rest is noted."""
    left = {key: value for key, value in values.items() if value is not None}
    notes += [f"[{name}] {key}: not known" for key in values if key not in left]
    while True:
        try:
            return section.model_validate(left)
        except ValidationError as error:
            key = str(error.errors()[0]["loc"][0])
            notes.append(f"[{name}] {key} = {left.pop(key)!r}: {mistake_words(error.errors()[0])}")


def _plain(value: Any) -> Any:
    """Return what TOML can hold: without None."""
    if isinstance(value, dict):
        return {key: _plain(one) for key, one in value.items() if one is not None}
    return value
