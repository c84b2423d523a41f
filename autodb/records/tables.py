"""A recording over time and a table of cuts: named channels in our units, and where they came from.

A table with a column `cut` is a cut table (one row a cut); any other needs `t` and is a recording
over time.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput, near_words
from autodb.files.channels import unit_of
from autodb.files.side import SideFile
from autodb.timing import Timing, examined
from autodb.wording import localized, phrase
from autodb.wording.kept import said_again

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]
EDGE = "tool.edge"


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
            raise UnusableInput(
                phrase(
                    "{file}: no channel '{name}'{near}",
                    file=self.path,
                    name=name,
                    near=self.near(name),
                )
            )
        return self.channels[name]

    def get(self, name: str) -> Array | None:
        """Return channel ``name`` or None where it was not recorded."""
        return self[name] if name in self.channels or name in self.unusable else None

    def near(self, name: str) -> str:
        """Return a hint at columns of the file, read or ignored, that look like ``name``."""
        return near_words(name, [*self.channels, *self.ignored])

    def unit(self, name: str) -> str:
        """Return the unit of channel ``name`` (`raw` for uncalibrated counts)."""
        return self.units.get(name) or unit_of(name) or "1"

    def to_pandas(self) -> "pd.DataFrame":
        """Return a pandas table of all columns, for notebooks."""
        import pandas as pd

        return pd.DataFrame({**self.channels, **self.texts})


@dataclass(frozen=True)
class Recording(_Table):
    """Channels over time ``t`` [s], in pieces of even rows.

    ``examined_as``: what its stamps were found to be, by whoever read it; None: they have to be
    even as they are. ``as_written`` (N,) each: the channels at the rows of the file, where those
    are not its even rows.
    """

    examined_as: Timing | None = None
    as_written: Mapping[str, Array] | None = None

    @property
    def t_s(self) -> Array:
        """Time, shape (n,), s; even within each piece."""
        return self.channels["t"]

    @cached_property
    def timing(self) -> Timing:
        """What its time is.

        Raises UnusableInput where its stamps are not even and nobody has laid its rows out.
        """
        if self.examined_as is not None:
            return self.examined_as
        found = examined(self.t_s, {}, where=str(self.path))
        if found.layout is not None:
            raise UnusableInput(
                phrase(
                    "{file}: column 't' is not even ({found}); lay its rows out with "
                    "autodb.records.timed.on_even_rows",
                    file=self.path,
                    found=found,
                )
            )
        return found

    @property
    def written(self) -> Mapping[str, Array]:
        """Its channels at the rows of the file, (N,) each, with the stamps as written."""
        return self.channels if self.as_written is None else self.as_written

    @property
    def pieces(self) -> tuple[slice, ...]:
        """Its runs of even rows, in time."""
        return self.timing.pieces

    @property
    def rate_hz(self) -> float:
        """Rows per second of a recording in one piece.

        Raises UnusableInput where it is in several.
        """
        if len(self.pieces) > 1:
            raise UnusableInput(
                phrase(
                    "{file}: column 't': {timing}; this needs even rows without a gap: give one "
                    "piece as a file of its own ({parted})",
                    file=self.path,
                    timing=said_again(str(self.timing)),
                    parted=self.timing.parted(self.t_s),
                )
            )
        return self.timing.rate_hz


@dataclass(frozen=True)
class CutTable(_Table):
    """One row a cut, numbered by ``cut``."""

    @property
    def cut(self) -> Array:
        """Cut numbers, shape (n,)."""
        return self.channels["cut"]


def edge_codes(labels: Iterable[str]) -> Array:
    """Return a number for each edge label, in the order in which the edges first cut."""
    names = list(labels)
    order = {label: i for i, label in enumerate(dict.fromkeys(names))}
    return np.array([order[label] for label in names], dtype=np.float64)


def gap(path: Path, name: str, values: Array) -> str:
    """Return the line that says where a channel holds no finite number, or nothing."""
    rows = np.flatnonzero(~np.isfinite(values))
    if not rows.size:
        return ""
    such = "" if rows.size == 1 else f" ({rows.size} such rows)"
    return (
        f"{path}: {name}, row {rows[0] + 1}: no finite number{such}; use a recording without gaps"
    )


def check_cuts(path: Path, cut: Array) -> None:
    """Raise UnusableInput where a cut has no number or the number of another."""
    message = gap(path, "cut", cut)
    if message:
        raise UnusableInput(message)
    numbers, first = np.unique(cut, return_index=True)
    if len(numbers) < len(cut):
        row = min(set(range(len(cut))) - set(first.tolist()))
        raise UnusableInput(
            phrase(
                "{file}: row {row}: cut {cut} stands twice; write one row per cut, or rename "
                "that column if rows are moments in time",
                file=path,
                row=row + 1,
                cut=localized(f"{cut[row]:g}"),
            )
        )
