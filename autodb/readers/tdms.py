"""TDMS: a group's channels of one length and rate share a time base.

A waveform's increment gives the column `t` where none is recorded, counted from the start of the
file's earliest waveform, so that the bases of one file stay aligned. A group that was written in
several runs has a start for each. Where the last segment was not finished, the rows count that all
channels of a time base have.
"""

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from autodb.files.text import TextSection
from autodb.readers._base import ColumnSet, Numbers, damaged, library, undamaged
from autodb.readers._sliced import Cells, sliced

TIME = "t"


@dataclass(frozen=True)
class _Clock:
    """What channels of one time base share; ``step_s`` is 0 where no rate is stated.

    ``later``: of each run but the first, the row it begins with, and its start in s.
    """

    group: str
    rows: int
    step_s: float
    start_s: float
    later: tuple[tuple[int, float], ...] = ()

    def times_s(self, rows: range) -> Numbers:
        """Return the times of rows, s."""
        number = np.array(rows)
        times = self.start_s + self.step_s * number
        for begin, start_s in self.later:
            on = number >= begin
            times[on] = start_s + self.step_s * (number[on] - begin)
        return np.asarray(times, dtype=np.float64)

    def __str__(self) -> str:
        rate = f"{1 / self.step_s:g} Hz" if self.step_s else "no clock"
        return f"{self.group}, {rate}, {self.rows} rows from {self.start_s:g} s"


def open_file(path: Path, _: TextSection) -> tuple[ColumnSet, ...]:
    """Open a TDMS file by its metadata."""
    nptdms = library(path, "nptdms")
    grouped, units, cut_off = undamaged(path, "TDMS", lambda: _read_groups(nptdms, path))
    groups = Counter(clock.group for clock in grouped)
    bases = (
        _base(
            nptdms,
            path,
            clock,
            {name: units[clock.group, name] for name in names},
            _label(clock, groups),
        )
        for clock, names in grouped.items()
    )
    said = "cut off, rows that not all channels have are left out" if cut_off else ""
    return tuple(replace(base, layout=said) for base in bases)


@contextmanager
def _opened(nptdms: Any, path: Path) -> Iterator[Any]:
    with path.open("rb") as stream, nptdms.TdmsFile.open(stream) as file:
        yield file


def _read_groups(
    nptdms: Any, path: Path
) -> tuple[dict[_Clock, list[str]], dict[tuple[str, str], str], bool]:
    """Return the channels' names by clock, their units by group and name, and whether the file ends
    within a segment.
    """
    with _opened(nptdms, path) as file:
        units = {
            (str(channel.group_name), str(channel.name)): str(
                channel.properties.get("unit_string", "")
            )
            for group in file.groups()
            for channel in group.channels()
        }
        grouped = _grouped(file, _starts(nptdms, path))
        cut_off = bool(file.file_status.incomplete_final_segment)
        if cut_off and not any(clock.rows for clock in grouped):
            raise damaged(path, "TDMS", "it is cut off: no row is whole")
        return {clock: names for clock, names in grouped.items() if clock.rows}, units, cut_off


_Starts = dict[str, list[tuple[int, Any]]]
"""By path of a channel the rows at which its waveform starts, and when."""


def _starts(nptdms: Any, path: Path) -> _Starts:
    """Return every start of every waveform: the file's properties hold the last only."""
    found: _Starts = {}

    class Reader(nptdms.reader.TdmsReader):  # type: ignore[misc]
        """Reads metadata, and notes what each segment states."""

        before: dict[str, int]

        def _update_object_properties(self, properties: Any) -> None:
            for name, stated in (properties or {}).items():
                for key, value in stated:
                    if key == "wf_start_time":
                        start = (self.before.get(name, 0), value.as_datetime64("us"))
                        found.setdefault(name, []).append(start)
            super()._update_object_properties(properties)
            self.before = {name: one.num_values for name, one in self.object_metadata.items()}

    with path.open("rb") as stream:
        reader = Reader(stream)
        reader.before = {}
        reader.read_metadata()
    return found


def _grouped(file: Any, starts: _Starts) -> dict[_Clock, list[str]]:
    channels = [channel for group in file.groups() for channel in group.channels()]
    first = min((start for some in starts.values() for _, start in some), default=None)
    grouped: dict[_Clock, list[str]] = {}
    whole: dict[_Clock, int] = {}
    for channel in channels:
        rows = len(channel) + _lacking(file, channel.path)
        if rows:
            clock = _clock(channel, rows, starts.get(channel.path, []), first)
            grouped.setdefault(clock, []).append(str(channel.name))
            whole[clock] = min(whole.get(clock, rows), len(channel))
    return {
        replace(clock, rows=min(whole[one] for one in whole if _alike(one, clock))): names
        for clock, names in _joined(grouped).items()
    }


def _lacking(file: Any, path: str) -> int:
    """Return how many values of a channel the last segment should have had and has not."""
    found = (file.file_status.channel_statuses or {}).get(path)
    if found is None or not file.file_status.incomplete_final_segment:
        return 0
    return int(found.expected_length - found.read_length)


def _alike(one: _Clock, other: _Clock) -> bool:
    return (one.group, one.rows) == (other.group, other.rows)


def _joined(grouped: dict[_Clock, list[str]]) -> dict[_Clock, list[str]]:
    """Let channels without a clock share the only one of their group and length."""
    joined = {clock: list(names) for clock, names in grouped.items()}
    clocked: dict[tuple[str, int], list[_Clock]] = {}
    for clock in grouped:
        if clock.step_s:
            clocked.setdefault((clock.group, clock.rows), []).append(clock)
    for clock, names in grouped.items():
        alike = clocked.get((clock.group, clock.rows), [])
        if not clock.step_s and len(alike) == 1:
            joined[alike[0]] += names
            del joined[clock]
    return joined


def _clock(channel: Any, rows: int, starts: list[tuple[int, Any]], first: Any) -> _Clock:
    properties = channel.properties
    step_s = float(properties.get("wf_increment", 0.0))
    if not step_s > 0:
        return _Clock(channel.group_name, rows, 0.0, 0.0)
    offset_s = float(properties.get("wf_start_offset", 0.0))
    begins = [
        (row, offset_s + float((start - first) / np.timedelta64(1, "s"))) for row, start in starts
    ]
    runs = begins[:1] or [(0, offset_s)]
    for row, start_s in begins[1:]:
        begun, since_s = runs[-1]
        restated = start_s == since_s
        goes_on = abs(since_s + step_s * (row - begun) - start_s) < step_s
        if not restated and not goes_on:
            runs.append((row, start_s))
    return _Clock(channel.group_name, rows, step_s, runs[0][1], tuple(runs[1:]))


def _label(clock: _Clock, groups: Counter[str]) -> str:
    if groups.total() == 1:
        return ""
    return clock.group if groups[clock.group] == 1 else str(clock)


def _base(nptdms: Any, path: Path, clock: _Clock, units: dict[str, str], label: str) -> ColumnSet:
    made = clock.step_s > 0 and TIME not in units

    @contextmanager
    def opened() -> Iterator[Cells]:
        with _opened(nptdms, path) as file:
            group = file[clock.group]

            def cells(name: str, rows: range) -> Any:
                if made and name == TIME:
                    return clock.times_s(rows)
                return group[name][rows.start : rows.stop]

            yield cells

    columns = (TIME, *units) if made else tuple(units)
    return ColumnSet(label, columns, sliced(path, "TDMS", rows=clock.rows, opened=opened), units)
