"""What a person chooses of a file's columns and of how it is written, put into its side file."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from autodb.errors import UnusableInput
from autodb.files.side import SideFile, stated_side
from autodb.files.text import TextSection
from autodb.files.toml import checked
from autodb.records.convert import specs
from autodb.wording import listed, phrase

ROWS = "*"
"""In the place of a column: rows are counted."""
_KEPT = ("scale", "kind", "rated_A", "diameter", "clips")


@dataclass(frozen=True)
class ColumnChoice:
    """A column's channel (empty: none), in a unit (empty: that of the file, or ours).

    ``turned``: its sign is the other way round. Of time of counted rows the unit is the step in s.
    """

    column: str
    channel: str = ""
    unit: str = ""
    turned: bool = False


@dataclass(frozen=True)
class SideChoices:
    """Choices of columns; of keys of `[csv]`, empty: to be found out; operations by the texts."""

    columns: tuple[ColumnChoice, ...] = ()
    text: dict[str, str] = field(default_factory=dict)
    operations: dict[str, str] = field(default_factory=dict)


def chosen_now(columns: Iterable[str], side: SideFile) -> dict[str, ColumnChoice]:
    """Return what a side file, and names alone, say of columns and of rows that are counted."""
    found: dict[str, ColumnChoice] = {}
    for channel, spec in specs(tuple(columns), side).items():
        column = spec.column or (ROWS if spec.row_in == ROWS else "")
        unit = f"{spec.step_s:g}" if column == ROWS and channel == "t" else spec.unit or ""
        if column:
            found.setdefault(column, ColumnChoice(column, channel, unit, spec.sign == -1))
    return found


def with_choices(side: SideFile, chosen: SideChoices) -> tuple[SideFile, bool]:
    """Return a side file with what was chosen, and whether its columns are to be proposed anew.

    They are where the file is to be read otherwise than before. What a side file says beside these
    choices stays. Raises UnusableInput with all that cannot be.
    """
    text = _text(side.csv, chosen.text)
    if text != side.csv:
        return side.model_copy(update={"csv": text}), True
    said = side.model_dump(mode="json", exclude_defaults=True)
    said["channels"] = _channels(side, chosen.columns, said.get("channels", {}))
    means = said.setdefault("values", {}).setdefault("operation", {})
    for word, operation in chosen.operations.items():
        means.pop(word, None)
        if operation:
            means[word] = operation
    return stated_side(said, where="your choices"), False


def _text(now: TextSection, chosen: Mapping[str, str]) -> TextSection:
    said = now.model_dump(mode="json", exclude_defaults=True)
    said = {key: value for key, value in said.items() if key not in chosen}
    said |= {key: value for key, value in chosen.items() if value}
    return checked(said, TextSection, where="how the file is written")


def _channels(
    side: SideFile, chosen: Sequence[ColumnChoice], channels: dict[str, Any]
) -> dict[str, Any]:
    """Return the channels of a side file with choices that differ from what it says."""
    now = chosen_now([one.column for one in chosen], side)
    _refuse_shared(chosen)
    changed = [one for one in chosen if one != now.get(one.column, ColumnChoice(one.column))]
    before = {
        one.column: channels.pop(now[one.column].channel, {})
        for one in changed
        if one.column in now
    }
    made = {
        one.channel: _stated(one, before.get(one.column, {}), now.get(one.column))
        for one in changed
        if one.channel
    }
    return channels | made


def _refuse_shared(chosen: Sequence[ColumnChoice]) -> None:
    """Raise UnusableInput where columns are to be one channel."""
    columns: dict[str, list[str]] = {}
    for one in chosen:
        if one.channel:
            columns.setdefault(one.channel, []).append(f"'{one.column}'")
    twice = [f"{' and '.join(c)} are both {name}" for name, c in columns.items() if len(c) > 1]
    if twice:
        raise UnusableInput(phrase("{names}; take one of them for it", names=listed(twice, "; ")))


def _stated(
    one: ColumnChoice, before: Mapping[str, Any], now: ColumnChoice | None
) -> dict[str, Any]:
    if one.column == ROWS:
        return {"row_in": ROWS} | ({"step_s": _step_s(one.unit)} if one.channel == "t" else {})
    same = now is not None and now.channel == one.channel
    said = {key: before[key] for key in _KEPT if same and key in before} | {"column": one.column}
    if one.unit:
        said["unit"] = one.unit
    if one.turned:
        said["sign"] = -1
    return said


def _step_s(text: str) -> float:
    try:
        return float(text.replace(",", "."))
    except ValueError:
        raise UnusableInput(
            phrase(
                "the step of counted rows: '{text}' is no number; type seconds, such as 0.004",
                text=text,
            )
        ) from None
