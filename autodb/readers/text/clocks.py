"""Several columns of time in one text table, each of the columns behind it.

A scope or a logger with a fast and a slow group writes them side by side; the shorter one ends
early. Which columns these are is told by what they do: clocks that run at different rates.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput, near_words
from autodb.files.text import TextSection
from autodb.readers.text.cells import UNKNOWN, is_number, split
from autodb.readers.text.layout import TextLayout
from autodb.wording import phrase

Array = NDArray[np.float64]

_NAMED = re.compile(
    r"(t|ts|(?i:time|zeit|temps|tempo|tiempo|timestamp|zeitstempel))(?![A-Za-zÄÖÜäöüß])"
)
"""How a column of time begins; `T` is a temperature."""
FEWEST = 8
"""Rows that a clock is known by. Chosen."""
EVEN = 0.02
"""By what share of one the steps of a clock that ticks evenly may differ. Chosen: stamps in whole
milliseconds of 50 Hz and slower."""
SAME = 1e-3
IN_UNITS = (1.0, 60.0, 3600.0, 86_400.0, 1e3, 1e6, 1e9)
"""By how many times one clock may run faster than another and still be it, in another unit."""


def with_clocks(
    path: Path, layout: TextLayout, lines: Sequence[str], stated: TextSection
) -> TextLayout:
    """Return a layout with the places of its columns of time, where it has several.

    All of them get the name of the first, so that one line of a side file names them. Raises
    UnusableInput for one that is stated and not there.
    """
    if layout.times or layout.steps_s or layout.header is None:
        return layout
    if stated.times is not None:
        places = tuple(_place(path, layout, name) for name in stated.times)
    elif layout.names.count(layout.names[0]) > 1:
        return layout
    else:
        places = _found(layout, lines)
    if len(places) < 2:
        return layout
    first, clocks = layout.names[places[0]], tuple(layout.names[place] for place in places)
    names = tuple(first if k in places else name for k, name in enumerate(layout.names))
    return replace(layout, names=names, times=places, clocks=clocks, short_rows=True)


def _place(path: Path, layout: TextLayout, name: str) -> int:
    if name not in layout.names:
        raise UnusableInput(
            phrase(
                "{file}: [csv] times: no column '{name}'{hint}",
                file=path,
                name=name,
                hint=near_words(name, layout.names),
            )
        )
    return layout.names.index(name)


def _found(layout: TextLayout, lines: Sequence[str]) -> tuple[int, ...]:
    """Return the places of columns of time that are clocks of their own."""
    named = [k for k, name in enumerate(layout.names) if _NAMED.match(name)]
    if len(named) < 2 or named[0] > 1:
        return ()
    rows = [split(line, layout.separator) for line in lines[layout.first :] if line.strip()]
    ends = [*named[1:], len(layout.names)]
    clocks = {k: _ticks(layout, rows, k) for k in named}
    if any(end - k < 2 for k, end in zip(named, ends, strict=True)) or len(clocks[named[0]]) == 0:
        return ()
    first = clocks[named[0]]
    units = [layout.units.get(k, "") for k in named]
    others = [
        k
        for k, end, unit in zip(named[1:], ends[1:], units[1:], strict=True)
        if len(clocks[k])
        and (
            _ends_early(rows, range(k, end), len(clocks[k]), len(first))
            or _runs_otherwise(first, clocks[k], alike=bool(unit) and unit == units[0])
        )
    ]
    return (named[0], *others) if len(others) == len(named) - 1 else ()


def _ticks(layout: TextLayout, rows: Sequence[list[str]], place: int) -> Array:
    """Return the stamps of a column up to where it ends; none where it is no clock."""
    number = partial(is_number, decimal=layout.decimal, thousands=layout.thousands)
    cells = [row[place] if place < len(row) else "" for row in rows[:-1] or rows]
    known = next((k for k, cell in enumerate(cells) if cell in UNKNOWN), len(cells))
    if known < FEWEST or not all(map(number, cells[:known])):
        return np.zeros(0)
    if any(cell not in UNKNOWN for cell in cells[known:]):
        return np.zeros(0)
    stamps = np.array([float(one) for one in _plain(layout, cells[:known])])
    return stamps if np.all(np.diff(stamps) > 0) else np.zeros(0)


def _plain(layout: TextLayout, cells: Sequence[str]) -> Iterator[str]:
    for cell in cells:
        bare = cell.replace(layout.thousands, "") if layout.thousands else cell
        yield bare.replace(layout.decimal, ".")


def _ends_early(rows: Sequence[list[str]], places: range, known: int, first: int) -> bool:
    """Say whether all of a clock's columns end with it, and the first clock goes on."""
    rest = rows[known : len(rows) - 1]
    return known < first and not any(
        row[k] not in UNKNOWN for row in rest for k in places if k < len(row)
    )


def _runs_otherwise(first: Array, other: Array, *, alike: bool) -> bool:
    """Say whether two even clocks run at rates that no unit explains; ``alike``: in one unit."""
    steps, others = np.diff(first), np.diff(other)
    if not (_is_even(steps) and _is_even(others)):
        return False
    times = float(np.mean(others) / np.mean(steps))
    factor = max(times, 1.0 / times)
    return not any(
        abs(factor / unit - 1.0) < SAME for unit in (IN_UNITS[:1] if alike else IN_UNITS)
    )


def _is_even(steps: Array) -> bool:
    return bool(np.max(np.abs(steps / np.median(steps) - 1.0)) < EVEN)
