"""Columns of a file become channels in our units, block by block."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from autodb.errors import UnusableInput
from autodb.files.channels import TEXT_COLUMNS, is_channel, unit_of
from autodb.files.side import FileColumn, SideFile
from autodb.files.units import RAW, conversion
from autodb.readers import Columns
from autodb.readers.text.cells import name_and_unit
from autodb.records.tables import EDGE, Array
from autodb.timing.dates import seconds_of
from autodb.wording import localized, phrase

LARGEST = 1e15
"""Numbers beyond this are damage, not a measurement in any of our units."""
LARGEST_STAMP = 1e20
"""The same of stamps, which may be nanoseconds since 1970: their unit is looked at as a whole."""
_KIND_TO_IQ = {"iq": 1.0, "rms": 2**0.5, "peak": 1.0}  # amplitude of the torque-producing current
_ROW = "*"
_DIAMETER_CHANNELS = ("x.position", "x.velocity", "x.acceleration")


def specs(columns: tuple[str, ...], side: SideFile) -> dict[str, FileColumn]:
    """Return the channels that ``columns`` hold: under our own names, overridden by the side file.

    A channel that the side file takes from a column that is not among them is left out.
    """
    own = {called: FileColumn(column=name, unit=unit) for name, called, unit in _own(columns)}
    return {
        name: spec
        for name, spec in {**own, **side.channels}.items()
        if spec.row_in == _ROW or (spec.column or spec.row_in) in columns
    }


def _own(columns: tuple[str, ...]) -> Iterator[tuple[str, str, str | None]]:
    """Yield each column that is named as a channel, the channel, and a unit behind its name."""
    for name in columns:
        bare, unit = name_and_unit(name)
        if is_channel(name):
            yield name, name, None
        elif unit and is_channel(bare) and bare not in columns:
            yield name, bare, unit


@dataclass(frozen=True)
class Conversion:
    """How the columns of one time base become channels; ``dated``: `t` is written as dates."""

    path: Path
    specs: dict[str, FileColumn]
    side: SideFile
    file_units: dict[str, str] = field(default_factory=dict)
    dated: bool = False

    @property
    def units(self) -> dict[str, str]:
        """Channels that keep another unit than their name's: uncalibrated counts."""
        return {name: RAW for name, spec in self.specs.items() if spec.unit == RAW}

    @property
    def labels(self) -> list[str]:
        """Columns to read as text: texts, edges, dates, and those within whose values rows are
        counted.
        """
        texts = {s.column for n, s in self.specs.items() if n in TEXT_COLUMNS or n == EDGE}
        texts |= {self.stamps} if self.dated else set()
        counted = {s.row_in for s in self.specs.values() if s.row_in != _ROW}
        return sorted(c for c in texts | counted if c)

    @property
    def stamps(self) -> str | None:
        """The column of the stamps; None where rows are counted, or there is none."""
        spec = self.specs.get("t")
        return None if spec is None else spec.column

    @property
    def numbers(self) -> list[str]:
        """Columns to read as numbers."""
        found = {s.column for n, s in self.specs.items() if n not in (*TEXT_COLUMNS, EDGE)}
        return sorted(c for c in found if c and c not in self.labels)

    def start(self) -> "RowsBefore":
        """Return a counter of rows to convert blocks in their order."""
        return RowsBefore(0, {})

    def texts(self, block: Columns) -> dict[str, list[str]]:
        """Return the text columns of a block; the edge's label is one."""
        found = {}
        for name, spec in self.specs.items():
            if name in TEXT_COLUMNS or (name == EDGE and spec.column):
                means = self.side.values.of(name)
                texts = [str(v) for v in block[str(spec.column)].tolist()]
                found[name] = [means.get(text, text) for text in texts]
        return found

    @property
    def problems(self) -> list[str]:
        """What is wrong with the units of its channels, a line each without the file's name."""
        found = []
        for name, spec in self.specs.items():
            if name not in TEXT_COLUMNS and name != EDGE:
                try:
                    self._scale(name, spec)
                except UnusableInput as fault:
                    found.append(str(fault).removeprefix(f"{self.path}: "))
        return found

    def channels(self, block: Columns, rows: "RowsBefore") -> dict[str, Array]:
        """Return the numeric channels of a block, in our units; ``rows`` counts on.

        Raises UnusableInput naming column and row.
        """
        n = len(next(iter(block.values()))) if block else 0
        found = {}
        for name, spec in self.specs.items():
            if self.dated and name == "t":
                found[name] = self._moments(block, rows.before)
                continue
            if spec.row_in is not None:
                found[name] = rows.count(name, spec, block, n) * spec.step_s
            elif name not in TEXT_COLUMNS and name != EDGE:
                found[name] = np.asarray(block[str(spec.column)], dtype=np.float64)
            else:
                continue
            scale, offset = self._scale(name, spec)
            if (scale, offset) != (1.0, 0.0):
                found[name] = found[name] * scale + offset
            self._refuse_damage(name, spec, found[name], rows.before)
        rows.before += n
        return found

    def _moments(self, block: Columns, before: int) -> Array:
        """Return the stamps of a block, written as dates, in s; raises UnusableInput."""
        texts = [str(text) for text in block[str(self.stamps)].tolist()]
        found = seconds_of(texts)
        if found is not None:
            return found
        row = next(i for i, text in enumerate(texts) if text and seconds_of([text]) is None)
        raise UnusableInput(
            phrase(
                "{file}: column '{stamps}', row {row}: '{texts}' is no moment; write "
                "2026-11-26T10:00:00.125, or seconds",
                file=self.path,
                stamps=self.stamps,
                row=before + row + 1,
                texts=texts[row][:40],
            )
        )

    def _refuse_damage(self, name: str, spec: FileColumn, numbers: Array, before: int) -> None:
        most = LARGEST_STAMP if name == "t" else LARGEST
        if not len(numbers) or -most <= numbers.min() <= numbers.max() <= most:
            return  # no number is missing either, or none of these would hold
        huge = np.flatnonzero(np.isfinite(numbers) & (np.abs(numbers) > most))
        if huge.size:
            row, column = before + int(huge[0]) + 1, spec.column or name
            raise UnusableInput(
                phrase(
                    "{file}: column '{column}', row {row}: {numbers} is no measurement; leave the "
                    "cell empty",
                    file=self.path,
                    column=column,
                    row=row,
                    numbers=localized(f"{numbers[huge[0]]:g}"),
                )
            )

    def stated_unit(self, name: str) -> str | None:
        """Return the unit that the side file states for a channel, else the file itself.

        A scale without a unit goes from the numbers as they are to our unit.
        """
        spec = self.specs[name]
        said = self.file_units.get(spec.column or "") if spec.scale == 1.0 else None
        return spec.unit or said or None

    def is_stated(self, name: str) -> bool:
        """Say whether a channel's unit was stated, by name or as a scale; else it is assumed."""
        spec = self.specs.get(name)
        return spec is not None and (self.stated_unit(name) is not None or spec.scale != 1.0)

    def _scale(self, name: str, spec: FileColumn) -> tuple[float, float]:
        """Return what a channel's numbers are multiplied by, and what is then added."""
        where = f"{self.path}: column '{spec.column or spec.row_in}'"
        scale, offset = spec.scale * (spec.sign or 1) * _KIND_TO_IQ.get(spec.kind or "iq", 1.0), 0.0
        unit = self.stated_unit(name)
        if spec.kind == "percent" and spec.rated_A is not None:
            scale *= spec.rated_A / 100.0
        elif unit is not None:
            factor, offset = conversion(unit, to=unit_of(name) or "1", where=where)
            scale *= factor
        if spec.diameter or (self.side.recording.diameter and name in _DIAMETER_CHANNELS):
            scale *= 0.5
        return scale, offset


@dataclass
class RowsBefore:
    """How many rows came before a block, in all and of each value of a column."""

    before: int
    seen: dict[tuple[str, str], int]

    def count(self, name: str, spec: FileColumn, block: Columns, n: int) -> Array:
        """Return the number of each row within the file, or within its value of a column."""
        if spec.row_in == _ROW:
            return np.arange(self.before, self.before + n, dtype=np.float64)
        counted = np.empty(n)
        for i, value in enumerate(block[str(spec.row_in)].tolist()):
            key = (name, str(value))
            counted[i] = self.seen.get(key, 0)
            self.seen[key] = self.seen.get(key, 0) + 1
        return counted
