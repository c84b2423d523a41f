"""Several files at once: their cuts as one table, and what becomes of those that are set aside."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from autodb.errors import SetAside, UnusableInput
from autodb.files.side import StatedColumns
from autodb.records import source as records
from autodb.records.plausible import refuse_doubtful
from autodb.records.summary import summary_of
from autodb.records.tables import EDGE, CutTable, edge_codes
from autodb.sensing.ranges.recorded import raw
from autodb.sensing.ranges.validity import with_stated
from autodb.wording import listed, phrase

Array = NDArray[np.float64]
Done = TypeVar("Done")
Tell = Callable[[str], None]


def each_used(files: Sequence[Path], work: Callable[[Path], Done], *, tell: Tell) -> list[Done]:
    """Do ``work`` on every file and return what it gave; a cut that is set aside is told.

    Raises what ``work`` raises of one file alone, and UnusableInput when none of several is left.
    """
    done = []
    for file in files:
        try:
            done.append(work(file))
        except SetAside as error:
            if len(files) == 1:
                raise
            tell(f"excluded: {error}")
    if not done:
        raise UnusableInput(
            phrase("none of the {n} cuts can be used; all are excluded", n=len(files))
        )
    return done


def cuts_of_files(files: Sequence[Path], *, columns: StatedColumns, tell: Tell) -> CutTable:
    """Return the cuts of cut tables, and of raw recordings of one cut each, as one table.

    Cuts of several files are numbered in the order given. What is left out of a cut's averages, and
    cuts that are set aside, are told. Raises UnusableInput.
    """
    tables = each_used(files, lambda file: _cuts_of(file, columns, tell), tell=tell)
    return tables[0] if len(files) == 1 else _joined(tables)


def _cuts_of(path: Path, columns: StatedColumns, tell: Tell) -> CutTable:
    found = records.read(path, columns=columns)
    refuse_doubtful(path, summary_of(found), found.side)
    if isinstance(found, CutTable):
        return with_stated(found)
    if not raw.has_phase_currents(found.channels):
        raise UnusableInput(
            phrase(
                "{file}: no column 'cut' and no phase currents; calibrate needs a table of "
                "cuts, or raw recordings of one cut each",
                file=path,
            )
        )
    cut = raw.cut_of_recording(found)
    for note in cut.notes:
        tell(f"{path}: {note}")
    return with_stated(cut.table)


def _joined(tables: Sequence[CutTable]) -> CutTable:
    """Return tables below each other: NaN and empty text where one lacks a column.

    Raises UnusableInput where a channel's unit is not the same everywhere.
    """
    names = list(dict.fromkeys(name for table in tables for name in table.channels))
    for name in names:
        units = {table.unit(name) for table in tables if name in table}
        if len(units) > 1:
            raise UnusableInput(
                phrase(
                    "{file}: {name} is in {names} in different files; use one unit in all of them",
                    file=tables[0].path,
                    name=name,
                    names=listed(sorted(units), phrase(" and ")),
                )
            )
    channels = {
        name: np.concatenate([table.channels.get(name, _unknown(table)) for table in tables])
        for name in names
    }
    texts = {
        name: [text for table in tables for text in table.texts.get(name) or _labels(table, name)]
        for name in dict.fromkeys(name for table in tables for name in table.texts)
    }
    channels["cut"] = np.arange(1.0, 1.0 + sum(len(table) for table in tables))
    if EDGE in texts:
        channels[EDGE] = edge_codes(texts[EDGE])
    units_of = {name: unit for table in tables for name, unit in table.units.items()}
    path = Path(f"{tables[0].path} and {len(tables) - 1} more")
    return replace(tables[0], path=path, channels=channels, texts=texts, units=units_of)


def _unknown(table: CutTable) -> Array:
    return np.full(len(table), np.nan)


def _labels(table: CutTable, name: str) -> list[str]:
    """Return a text column that a table lacks: its numbers where it has such, else empty."""
    numbers = table.channels.get(name)
    return [""] * len(table) if numbers is None else [f"{value:g}" for value in numbers]
