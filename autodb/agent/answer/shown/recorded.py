"""What was recorded, to be looked at: over time with its cut marked, or cut by cut."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.agent.ingest.as_imported import as_imported
from autodb.agent.rows.recordings import cuts_as_table
from autodb.errors import UnusableInput
from autodb.files.channels import unit_of
from autodb.records.tables import Recording
from autodb.sensing.ranges.recorded.raw import cut_stretch
from autodb.store import models

Array = NDArray[np.float64]

MOST = 8
"""Channels that are shown. Chosen: more would not be told apart."""
FIRST = (r"force\.", r"torque", r"spindle\.(current|power)", r".*\.current", r".\.drive_", r".*")
"""Which channels are shown first, by their names."""


@dataclass(frozen=True)
class RecordedCourse:
    """Channels (n,) of a recording over ``x``, time in s or the number of a cut, with their units.

    ``cuts``: from when to when cuts last, s; ``others``: channels that there is no room for.
    """

    over_time: bool
    x: Array
    channels: dict[str, Array]
    units: dict[str, str]
    cuts: tuple[tuple[float, float], ...]
    others: tuple[str, ...]


def course_of(row: models.StoredRecording) -> RecordedCourse:
    """Return what is shown of a stored recording; of a table of cuts what the database has of them.

    Raises UnusableInput where the file of a recording over time is not as it was imported.
    """
    if row.kind == "cuts":
        return _cut_by_cut(row)
    read = as_imported(row)
    if not isinstance(read, Recording):
        return _cut_by_cut(row)
    every = {name: values for name, values in read.channels.items() if name != "t"}
    cuts = _stretches(read) if row.cuts else ()
    return _course(True, read.t_s, every, read.units, cuts)


def _cut_by_cut(row: models.StoredRecording) -> RecordedCourse:
    table = cuts_as_table(row.cuts, path=Path(row.path))
    measured = set().union(*(cut.measured for cut in row.cuts)) if row.cuts else set()
    every = {name: table[name] for name in sorted(measured)}
    number = table.get("cut")
    x = np.zeros(0) if number is None else number
    return _course(False, x, every, table.units, ())


def _course(
    over_time: bool,
    x: Array,
    every: dict[str, Array],
    units: dict[str, str],
    cuts: tuple[tuple[float, float], ...],
) -> RecordedCourse:
    shown = _first(name for name, values in every.items() if np.isfinite(values).any())
    return RecordedCourse(
        over_time=over_time,
        x=x,
        channels={name: every[name] for name in shown[:MOST]},
        units={name: units.get(name) or unit_of(name) or "1" for name in shown[:MOST]},
        cuts=cuts,
        others=tuple(shown[MOST:]),
    )


def _first(names: Iterable[str]) -> list[str]:
    """Return names in the order in which they are shown."""

    def place(name: str) -> tuple[int, str]:
        return next(k for k, pattern in enumerate(FIRST) if re.match(pattern, name)), name

    return sorted(names, key=place)


def _stretches(recording: Recording) -> tuple[tuple[float, float], ...]:
    """Return when the cut of a recording lasts, by loads or forces; none: they do not show."""
    try:
        return (cut_stretch(recording),)
    except UnusableInput:
        return ()
