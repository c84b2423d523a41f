"""Columns of a file become channels in our units, block by block."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from autodb.channels import TEXT_COLUMNS, is_channel, unit_of
from autodb.errors import UnusableInput
from autodb.readers import Columns
from autodb.records.tables import EDGE, Array
from autodb.sidefile import Column, SideFile
from autodb.units import RAW, factor

LARGEST = 1e15
"""Numbers beyond this are damage, not a measurement in any of our units."""
_KIND_TO_IQ = {"iq": 1.0, "rms": 2**0.5, "peak": 1.0}  # amplitude of the torque-producing current
_ROW = "*"
_DIAMETER_CHANNELS = ("x.position", "x.velocity", "x.acceleration")


def specs(columns: tuple[str, ...], side: SideFile) -> dict[str, Column]:
    """Return the channels that ``columns`` hold: under our own names, overridden by the side file.

    A channel that the side file takes from a column that is not among them is left out.
    """
    own = {name: Column(column=name) for name in columns if is_channel(name)}
    return {
        name: spec
        for name, spec in {**own, **side.channels}.items()
        if spec.row_in == _ROW or (spec.column or spec.row_in) in columns
    }


@dataclass(frozen=True)
class Conversion:
    """How the columns of one time base become channels."""

    path: Path
    specs: dict[str, Column]
    side: SideFile

    @property
    def units(self) -> dict[str, str]:
        """Channels that keep another unit than their name's: uncalibrated counts."""
        return {name: RAW for name, spec in self.specs.items() if spec.unit == RAW}

    @property
    def labels(self) -> list[str]:
        """Columns to read as text: texts, edges, and those within whose values rows are counted."""
        texts = {s.column for n, s in self.specs.items() if n in TEXT_COLUMNS or n == EDGE}
        counted = {s.row_in for s in self.specs.values() if s.row_in != _ROW}
        return sorted(c for c in texts | counted if c)

    @property
    def numbers(self) -> list[str]:
        """Columns to read as numbers."""
        found = {s.column for n, s in self.specs.items() if n not in (*TEXT_COLUMNS, EDGE)}
        return sorted(c for c in found if c and c not in self.labels)

    def start(self) -> "Rows":
        """Return a counter of rows to convert blocks in their order."""
        return Rows(0, {})

    def texts(self, block: Columns) -> dict[str, list[str]]:
        """Return the text columns of a block; the edge's label is one."""
        return {
            name: [str(v) for v in block[str(spec.column)].tolist()]
            for name, spec in self.specs.items()
            if name in TEXT_COLUMNS or (name == EDGE and spec.column)
        }

    def channels(self, block: Columns, rows: "Rows") -> dict[str, Array]:
        """Return the numeric channels of a block, in our units; ``rows`` counts on.

        Raises UnusableInput naming column and row.
        """
        n = len(next(iter(block.values()))) if block else 0
        found = {}
        for name, spec in self.specs.items():
            if spec.row_in is not None:
                found[name] = rows.count(name, spec, block, n) * spec.step_s
            elif name not in TEXT_COLUMNS and name != EDGE:
                found[name] = self._numbers(block, str(spec.column), rows.before)
            else:
                continue
            scale = self._scale(name, spec)
            found[name] = found[name] if scale == 1.0 else found[name] * scale
        rows.before += n
        return found

    def _numbers(self, block: Columns, column: str, before: int) -> Array:
        numbers = np.asarray(block[column], dtype=np.float64)
        huge = np.flatnonzero(np.abs(numbers) > LARGEST)
        if huge.size:
            row = before + int(huge[0]) + 1
            raise UnusableInput(
                f"{self.path}: column '{column}', row {row}: {numbers[huge[0]]:g} is no measurement"
            )
        return numbers

    def _scale(self, name: str, spec: Column) -> float:
        """Return what a channel's numbers are multiplied by."""
        where = f"{self.path}: column '{spec.column or spec.row_in}'"
        scale = spec.scale * spec.sign * _KIND_TO_IQ.get(spec.kind or "iq", 1.0)
        if spec.kind == "percent" and spec.rated_A is not None:
            scale *= spec.rated_A / 100.0
        elif spec.unit is not None:
            scale *= factor(spec.unit, to=unit_of(name) or "1", where=where)
        if spec.diameter or (self.side.recording.diameter and name in _DIAMETER_CHANNELS):
            scale *= 0.5
        return scale


@dataclass
class Rows:
    """How many rows came before a block, in all and of each value of a column."""

    before: int
    seen: dict[tuple[str, str], int]

    def count(self, name: str, spec: Column, block: Columns, n: int) -> Array:
        """Return the number of each row within the file, or within its value of a column."""
        if spec.row_in == _ROW:
            return np.arange(self.before, self.before + n, dtype=np.float64)
        counted = np.empty(n)
        for i, value in enumerate(block[str(spec.row_in)].tolist()):
            key = (name, str(value))
            counted[i] = self.seen.get(key, 0)
            self.seen[key] = self.seen.get(key, 0) + 1
        return counted
