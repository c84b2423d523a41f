"""Recordings of a SINUMERIK Edge (JSON): every signal in every cycle of the interpolator.

A header says the signals, in their order, and the cycle; the payload has rows of values, some at a
time. The counter of the cycles is the time, so that cycles that are missing leave a gap. Events
between the rows (blocks of the program, signals of low frequency) are not read.
"""

import json
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.files.text import TextSection
from autodb.readers._base import (
    BLOCK_ROWS,
    Columns,
    ColumnSet,
    as_label,
    as_number,
    undamaged,
)
from autodb.wording import phrase

KIND = "SINUMERIK Edge"
TIME, COUNTER = "t", "CYCLE"
HEADER, PAYLOAD, ROWS = '"Header"', '"Payload"', "HFData"
CHUNK = 1 << 20
"""Characters that are read at a time, at least."""
_BEFORE_A_VALUE = " \t\r\n,:["

Cells = NDArray[Any]


@dataclass(frozen=True)
class _Header:
    """Where each signal is in a row, which is the counter, and the interpolator's cycle, s."""

    place: dict[str, int]
    counter: str | None
    cycle_s: float


def open_file(path: Path, stated: TextSection) -> tuple[ColumnSet, ...]:
    """Open a recording by its header."""
    del stated
    header = undamaged(path, KIND, lambda: _header(path))

    def blocks(numbers: Sequence[str], labels: Sequence[str]) -> Iterator[Columns]:
        first, row = None, 0
        for cells in _blocks(path, width=len(header.place)):
            counted = row + np.arange(len(cells), dtype=np.float64)
            if header.counter is not None:
                at = header.place[header.counter]
                counted = as_number(str(path), header.counter, cells[:, at], row)
            first = counted[0] if first is None else first
            found = {name: cells[:, at] for name, at in header.place.items()}
            found[TIME] = header.cycle_s * (counted - first)
            columns: Columns = {n: as_number(str(path), n, found[n], row) for n in numbers}
            columns |= {n: as_label(found[n]) for n in labels}
            row += len(cells)
            yield columns

    return (ColumnSet("", (TIME, *header.place), blocks, layout=KIND),)


def _header(path: Path) -> _Header:
    """Return what the header says; raises UnusableInput for JSON that is no such recording."""
    with path.open(encoding="utf-8") as file:
        begun = file.read(CHUNK)
        while HEADER in begun and PAYLOAD not in begun and (more := file.read(CHUNK)):
            begun += more
    said: Any = {}
    if HEADER in begun and PAYLOAD in begun:
        after = begun.partition(HEADER)[2].lstrip(_BEFORE_A_VALUE)
        said = json.JSONDecoder().raw_decode(after)[0]
    said = said if isinstance(said, dict) else {}
    signals, cycle_ms = said.get("SignalListHFData"), said.get("CycleTimeMs")
    if not signals or not cycle_ms:
        raise UnusableInput(
            phrase(
                "{file}: JSON, but no recording of a SINUMERIK Edge; export it as CSV, a "
                "column a channel",
                file=path,
            )
        )
    addresses = [one["Address"] for one in signals]
    names = [f"{one['Name']} {one['Axis']}".strip() for one in signals]
    times = Counter(names)
    place = {
        name if times[name] == 1 else f"{name} {address}": at
        for at, (name, address) in enumerate(zip(names, addresses, strict=True))
    }
    counter = [*place][addresses.index(COUNTER)] if COUNTER in addresses else None
    return _Header(place, counter, float(cycle_ms) / 1000.0)


def _blocks(path: Path, *, width: int) -> Iterator[Cells]:
    """Yield cells (n, width) of rows, so that memory stays that of a block."""
    parts, some = _parts(path, width), []
    while (rows := undamaged(path, KIND, lambda: next(parts, None))) is not None:
        some += rows
        if len(some) >= BLOCK_ROWS // 8:
            yield np.array(some, dtype=object)
            some = []
    if some:
        yield np.array(some, dtype=object)


def _parts(path: Path, width: int) -> Iterator[list[list[Any]]]:
    """Yield the rows of each part of the payload; raises ValueError where the file ends within one,
    or a row has other than ``width`` values.
    """
    decoder = json.JSONDecoder()
    with path.open(encoding="utf-8") as file:
        text = ""
        while PAYLOAD not in text:
            text += file.read(CHUNK)
        text = text.partition(PAYLOAD)[2]
        while not (text := text.lstrip(_BEFORE_A_VALUE)).startswith("]"):
            try:
                part, end = decoder.raw_decode(text)
            except json.JSONDecodeError:
                more = file.read(max(CHUNK, len(text)))
                if not more:
                    raise
                text += more
            else:
                text = text[end:]
                rows = part.get(ROWS, [])
                if any(len(row) != width for row in rows):
                    raise ValueError(f"a row of other than {width} values")
                yield rows
