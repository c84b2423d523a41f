"""A recording over time and a table of cuts: named channels in our units, and where they came from.

A file with a column `cut` is a cut table (one row a cut); any other needs `t` and is a recording
over time.
"""

import hashlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from autodb.channels import TEXT_COLUMNS, is_channel, unit_of
from autodb.errors import UnusableInput, near
from autodb.readers import Columns, read_columns
from autodb.sidefile import Column, SideFile, read_sidefile
from autodb.units import RAW, factor

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]
EDGE = "tool.edge"
LARGEST = 1e15
"""Numbers beyond this are damage, not a measurement in any of our units."""
_KIND_TO_IQ = {"iq": 1.0, "rms": 2**0.5, "peak": 1.0}  # amplitude of the torque-producing current


@dataclass(frozen=True)
class _Table:
    """Named channels of one length; ``units`` overrides the unit of the name (only `raw` does).

    ``ignored``: columns of the file that are no channel. ``unusable``: channels of a recording that
    hold no finite number somewhere, and where; using one raises. In a cut table NaN stands for what
    is not known of that cut.
    """

    path: Path
    channels: dict[str, Array]
    texts: dict[str, list[str]] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)
    side: SideFile = field(default_factory=SideFile)
    unusable: dict[str, str] = field(default_factory=dict)
    ignored: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(next(iter(self.channels.values())))

    def __contains__(self, name: object) -> bool:
        return name in self.channels

    def __getitem__(self, name: str) -> Array:
        """Return channel ``name``; raises UnusableInput naming near ones, or the unusable row."""
        if name in self.unusable:
            raise UnusableInput(self.unusable[name])
        if name not in self.channels:
            raise UnusableInput(f"{self.path}: no channel '{name}'{self.near(name)}")
        return self.channels[name]

    def get(self, name: str) -> Array | None:
        """Return channel ``name`` or None where it was not recorded."""
        return self[name] if name in self.channels or name in self.unusable else None

    def near(self, name: str) -> str:
        """Return a hint at columns of the file, read or ignored, that look like ``name``."""
        return near(name, [*self.channels, *self.ignored])

    def unit(self, name: str) -> str:
        """Return the unit of channel ``name`` (`raw` for uncalibrated counts)."""
        return self.units.get(name) or unit_of(name) or "1"

    def sha256(self) -> str:
        """Return the checksum of the file as it lies on disk."""
        return hashlib.sha256(self.path.read_bytes()).hexdigest()

    def to_pandas(self) -> "pd.DataFrame":
        """Return a pandas table of all columns, for notebooks."""
        import pandas as pd

        return pd.DataFrame({**self.channels, **self.texts})


@dataclass(frozen=True)
class Recording(_Table):
    """Channels over strictly increasing time ``t`` [s]."""

    @property
    def t_s(self) -> Array:
        """Time, shape (n,), s."""
        return self.channels["t"]

    @property
    def rate_hz(self) -> float:
        """Samples per second: the inverse of the median step."""
        return float(1.0 / np.median(np.diff(self.t_s)))


@dataclass(frozen=True)
class CutTable(_Table):
    """One row a cut, numbered by ``cut``."""

    @property
    def cut(self) -> Array:
        """Cut numbers, shape (n,)."""
        return self.channels["cut"]


def read(path: Path, *, columns: Path | None = None) -> Recording | CutTable:
    """Read a recording or a cut table with its side file (beside it, or ``columns``).

    Raises UnusableInput with file, column and row.
    """
    beside = path.with_suffix(".toml")
    side_path = columns or (beside if beside.is_file() else None)
    raw = read_columns(path)
    side = read_sidefile(side_path) if side_path else SideFile()
    channels: dict[str, Array] = {}
    texts: dict[str, list[str]] = {}
    units: dict[str, str] = {}
    for name, spec in _specs(raw, side).items():
        values = _source(path, raw, spec)
        if name in TEXT_COLUMNS:
            texts[name] = [str(v) for v in values]
        elif name == EDGE and values.dtype.kind not in "fiu":
            texts[name] = [str(v) for v in values]
            channels[name] = edge_codes(texts[name])
        else:
            channels[name] = _convert(path, name, values, spec, side)
            if spec.unit == RAW:
                units[name] = RAW
    taken = {spec.column for spec in _specs(raw, side).values()}
    ignored = tuple(name for name in raw if name not in taken)
    if "cut" in channels:
        table: Recording | CutTable = CutTable(path, channels, texts, units, side, ignored=ignored)
    else:
        bad = {name: _not_finite(path, name, values) for name, values in channels.items()}
        unusable = {name: message for name, message in bad.items() if message}
        usable = {name: values for name, values in channels.items() if name not in unusable}
        table = Recording(path, usable, texts, units, side, unusable, ignored)
    _check(table)
    return table


def _not_finite(path: Path, name: str, values: Array) -> str:
    """Return where a channel holds no finite number, or nothing."""
    rows = np.flatnonzero(~np.isfinite(values))
    if not rows.size:
        return ""
    return (
        f"{path}: {name}, row {rows[0] + 1}: no finite number ({rows.size} such rows); "
        "a recording without gaps would work"
    )


def edge_codes(labels: list[str]) -> Array:
    """Return a number for each edge label, in the order in which the edges first cut."""
    order = {label: i for i, label in enumerate(dict.fromkeys(labels))}
    return np.array([order[label] for label in labels], dtype=np.float64)


def _specs(raw: Columns, side: SideFile) -> dict[str, Column]:
    """Return what to read: columns under our own names, overridden by the side file."""
    own = {name: Column(column=name) for name in raw if is_channel(name)}
    return {**own, **side.channels}


def _source(path: Path, raw: Columns, spec: Column) -> NDArray[np.generic]:
    name = spec.column or spec.row_in
    if spec.row_in == "*":
        return np.arange(len(next(iter(raw.values())))) * spec.step_s
    if name not in raw:
        raise UnusableInput(f"{path}: no column '{name}'{near(str(name), raw)}")
    if spec.row_in is None:
        return raw[name]
    count: dict[object, int] = {}
    rows = np.empty(len(raw[name]))
    for i, group in enumerate(raw[name].tolist()):
        rows[i] = count.get(group, 0)
        count[group] = count.get(group, 0) + 1
    return rows * spec.step_s


def _convert(
    path: Path, name: str, values: NDArray[np.generic], spec: Column, side: SideFile
) -> Array:
    where = f"{path}: column '{spec.column or spec.row_in}'"
    if values.dtype.kind not in "fiu":
        row = _first_text(values)
        raise UnusableInput(f"{where}, row {row + 1}: '{values[row]}' is not a number")
    numbers = np.asarray(values, dtype=np.float64)
    huge = np.flatnonzero(np.abs(numbers) > LARGEST)
    if huge.size:
        raise UnusableInput(f"{where}, row {huge[0] + 1}: {numbers[huge[0]]:g} is no measurement")
    scale = spec.scale * spec.sign * _KIND_TO_IQ.get(spec.kind or "iq", 1.0)
    if spec.kind == "percent" and spec.rated_A is not None:
        scale *= spec.rated_A / 100.0
    elif spec.unit is not None:
        scale *= factor(spec.unit, to=unit_of(name) or "1", where=where)
    motion = name in ("x.position", "x.velocity", "x.acceleration")
    if spec.diameter or (side.recording.diameter and motion):
        scale *= 0.5
    return numbers if scale == 1.0 else numbers * scale


def _first_text(values: NDArray[np.generic]) -> int:
    for i, value in enumerate(values):
        try:
            float(str(value))
        except ValueError:
            return i
    return 0


def _check(table: Recording | CutTable) -> None:
    if isinstance(table, CutTable):
        message = _not_finite(table.path, "cut", table.cut)
        if message:
            raise UnusableInput(message)
        numbers, first = np.unique(table.cut, return_index=True)
        if len(numbers) < len(table):
            row = min(set(range(len(table))) - set(first.tolist()))
            raise UnusableInput(f"{table.path}: row {row + 1}: cut {table.cut[row]:g} stands twice")
        return
    if "t" not in table.channels:
        if "t" in table.unusable:
            raise UnusableInput(table.unusable["t"])
        hint = table.near("t") if table.channels or table.ignored else ""
        raise UnusableInput(f"{table.path}: neither a column 't' (time, s) nor 'cut'{hint}")
    step = np.flatnonzero(np.diff(table.t_s) <= 0)
    if step.size:
        row = int(step[0]) + 2
        raise UnusableInput(
            f"{table.path}: column 't', row {row}: time does not increase; "
            "rows in the order of strictly increasing time would work"
        )
    if len(table) < 3:
        raise UnusableInput(f"{table.path}: {len(table)} rows are too few for a recording")
