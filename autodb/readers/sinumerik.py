"""Traces of a SINUMERIK control (XML): each signal at an interval of its own.

A record has the signals that changed; between, each is what it was. Signals of one interval, frame
and beginning are a time base. A frame is what was recorded without a pause.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from autodb.errors import UnusableInput
from autodb.files.text import TextSection
from autodb.readers._base import Columns, ColumnSet, Numbers, as_label, undamaged
from autodb.wording import phrase

KIND = "SINUMERIK trace"
TIME = "t"
ROOT, FRAME, SIGNAL, RECORD = "traceSession", "dataFrame", "dataSignal", "rec"
_AXIS = re.compile(r"\[[^\[\]]*\]$")
_BITS = re.compile(r" \(\d+ bit\)$")


@dataclass(frozen=True)
class _Traced:
    """A signal: its frame, what it is called in records and here, its interval and its points."""

    frame: int
    key: str
    name: str
    interval_s: float
    points: int


@dataclass(frozen=True)
class _Grid:
    """The instants of a time base: of one frame, from ``start_s`` on, every ``interval_s``."""

    frame: int
    start_s: float
    interval_s: float
    rows: int


def open_file(path: Path, stated: TextSection) -> tuple[ColumnSet, ...]:
    """Open a trace by its signals and their first and last records."""
    del stated
    found = undamaged(path, KIND, lambda: _grids(path))
    several = len(found) > 1
    frames = len({grid.frame for grid in found}) > 1
    return tuple(
        _base(path, grid, signals, _called(grid, frames=frames) if several else "")
        for grid, signals in found.items()
    )


def _called(grid: _Grid, *, frames: bool) -> str:
    rate = f"{grid.interval_s * 1000:g} ms"
    return f"frame {grid.frame}, {rate}" if frames else rate


def _base(path: Path, grid: _Grid, signals: Sequence[_Traced], name: str) -> ColumnSet:
    keys = {signal.name: signal.key for signal in signals}

    def blocks(numbers: Sequence[str], labels: Sequence[str]) -> Iterator[Columns]:
        wanted = {keys[one] for one in (*numbers, *labels) if one != TIME}
        read = undamaged(path, KIND, lambda: _held(path, grid, wanted))
        t_s = grid.start_s + grid.interval_s * np.arange(grid.rows)
        columns: Columns = {n: np.asarray(t_s if n == TIME else read[keys[n]]) for n in numbers}
        columns |= {n: as_label(t_s if n == TIME else read[keys[n]]) for n in labels}
        yield columns

    return ColumnSet(name, (TIME, *keys), blocks, layout=KIND)


def _elements(path: Path) -> Iterator[tuple[int, ElementTree.Element]]:
    """Yield signals and records with the number of their frame; memory stays that of one of them.

    Raises UnusableInput for XML that is no trace.
    """
    frame = 0
    parents: list[ElementTree.Element] = []
    for event, one in ElementTree.iterparse(path, events=("start", "end")):
        if event == "start":
            if not parents and one.tag != ROOT:
                raise UnusableInput(
                    phrase(
                        "{file}: XML, but no trace of a SINUMERIK control; export it as CSV, a "
                        "column a channel",
                        file=path,
                    )
                )
            frame += one.tag == FRAME
            parents.append(one)
            continue
        parents.pop()
        if one.tag in (SIGNAL, RECORD):
            yield frame, one
        if parents:
            parents[-1].remove(one)


def _grids(path: Path) -> dict[_Grid, list[_Traced]]:
    """Return the signals of each time base."""
    signals: list[_Traced] = []
    first: dict[tuple[int, str], float] = {}
    last: dict[int, float] = {}
    for frame, one in _elements(path):
        if one.tag == SIGNAL:
            signals.append(_signal(frame, one, signals))
            continue
        instant_s = float(one.attrib["time"])
        last[frame] = max(instant_s, last.get(frame, instant_s))
        for key in one.attrib:
            first.setdefault((frame, key), instant_s)
    made: dict[_Grid, list[_Traced]] = {}
    for signal in signals:
        start_s = first.get((signal.frame, signal.key))
        if start_s is not None and signal.interval_s > 0:
            rows = int((last[signal.frame] - start_s) / signal.interval_s + 1.5)
            grid = _Grid(signal.frame, start_s, signal.interval_s, min(rows, signal.points))
            made.setdefault(grid, []).append(signal)
    return {grid: signals for grid, signals in made.items() if grid.rows > 0}


def _signal(frame: int, one: ElementTree.Element, before: Sequence[_Traced]) -> _Traced:
    """Return a signal, called by what it is and the axis that it is of."""
    said = one.attrib
    axis = _AXIS.search(said.get("name", ""))
    called = _BITS.sub("", said.get("description") or said.get("name", "")).rstrip(".")
    name = f"{called} {axis[0]}" if axis else called
    if any((other.frame, other.name) == (frame, name) for other in before):
        name = f"{name} {said['id']}"
    return _Traced(frame, said["id"], name, float(said["interval"]), int(said["datapointCount"]))


def _held(path: Path, grid: _Grid, keys: set[str]) -> dict[str, Numbers]:
    """Return signals on the rows of a time base, each as it was said last."""
    found = {key: np.full(grid.rows, np.nan) for key in keys}
    for frame, one in _elements(path):
        if one.tag != RECORD or frame != grid.frame:
            continue
        row = round((float(one.attrib["time"]) - grid.start_s) / grid.interval_s)
        if 0 <= row < grid.rows:
            for key in keys & one.attrib.keys():
                found[key][row] = float(one.attrib[key])
    return {key: _filled(values) for key, values in found.items()}


def _filled(values: Numbers) -> Numbers:
    """Return values with each that was not said as the last before it."""
    known = np.where(np.isfinite(values), np.arange(len(values)), 0)
    return np.asarray(values[np.maximum.accumulate(known)], dtype=np.float64)
