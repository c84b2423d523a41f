"""MDF (ASAM MDF 3 and 4): each channel group is a time base; its master is the column `t`."""

from collections import Counter
from collections.abc import Container, Iterator
from contextlib import closing, contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from autodb.files.text import TextSection
from autodb.readers._base import ColumnSet, library
from autodb.readers._child import isolated, isolated_value
from autodb.readers._sliced import Cells, sliced

TIME = "t"


@dataclass(frozen=True)
class _Group:
    """A channel group: its number and name, rows, and index and unit of each channel."""

    number: int
    name: str
    rows: int
    channels: dict[str, int]
    units: dict[str, str]


def open_file(path: Path, _: TextSection) -> tuple[ColumnSet, ...]:
    """Open an MF4 file by its channel groups."""
    asammdf = library(path, "asammdf")
    found = isolated_value(path, "MF4", lambda: _read_groups(asammdf, path))
    groups = [_Group(**group) for group in found]
    times = Counter(group.name for group in groups)
    return tuple(_base(asammdf, path, group, _label(group, times)) for group in groups)


@contextmanager
def _opened(asammdf: Any, path: Path) -> Iterator[Any]:
    """Open an MF4 file as a stream: given a path, asammdf would map all of it into memory."""
    with path.open("rb") as stream, closing(asammdf.MDF(stream)) as mdf:
        yield mdf


def _read_groups(asammdf: Any, path: Path) -> list[dict[str, Any]]:
    with _opened(asammdf, path) as file:
        return [asdict(group) for group in _groups(file)]


def _groups(file: Any) -> list[_Group]:
    found = []
    for number, group in enumerate(file.groups):
        alike: Counter[str] = Counter()
        rows = int(group.channel_group.cycles_nr)
        master = file.masters_db.get(number)
        channels = {} if master is None else {TIME: master}
        for index, channel in enumerate(group.channels):
            if index != master:
                channels[_unused(str(channel.name), channels, alike)] = index
        units = {name: str(group.channels[index].unit or "") for name, index in channels.items()}
        if rows and channels:
            found.append(_Group(number, _name(group.channel_group), rows, channels, units))
    return found


def _unused(name: str, taken: Container[str], alike: Counter[str]) -> str:
    """Return ``name``, numbered where a channel of the group has it already.

    ``alike`` counts how often each name was given, so that none is tried again.
    """
    unused = name
    while unused in taken:
        alike[name] += 1
        unused = f"{name} ({alike[name] + 1})"
    return unused


def _name(group: Any) -> str:
    """Return the acquisition's name, or the first line of its comment."""
    named = getattr(group, "acq_name", "")  # MDF 4 alone has it
    text = str(named or group.comment or "").strip()
    return "" if text.startswith("<") else (text.splitlines() or [""])[0]


def _label(group: _Group, times: Counter[str]) -> str:
    """Return what a group is called; ``times``: how many are called so, by name."""
    if times.total() == 1:
        return ""
    alone = times[group.name] == 1
    return group.name if group.name and alone else f"{group.name or 'group'} {group.number}"


def _base(asammdf: Any, path: Path, group: _Group, label: str) -> ColumnSet:
    @contextmanager
    def opened() -> Iterator[Cells]:
        with _opened(asammdf, path) as file:
            yield lambda name, rows: _cells(file, group, name, rows)

    blocks = sliced(path, "MF4", rows=group.rows, opened=opened)
    return ColumnSet(label, tuple(group.channels), isolated(path, "MF4", blocks), group.units)


def _cells(file: Any, group: _Group, name: str, rows: range) -> Any:
    """Return cells of a channel in its physical unit; invalid ones as NaN."""
    samples, invalid = file.get(
        group=group.number,
        index=group.channels[name],
        record_offset=rows.start,
        record_count=len(rows),
        samples_only=True,
        ignore_invalidation_bits=True,
    )
    values = np.asarray(samples)
    if values.dtype.kind == "S":
        return np.char.decode(values, "utf-8", "replace")
    if invalid is not None and values.dtype.kind in "fiu":
        return np.where(np.asarray(invalid), np.nan, values)
    return values
