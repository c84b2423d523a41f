"""A recording file with its side file: its time bases, read whole or streamed in blocks."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from autodb import readers
from autodb.errors import UnusableInput, near_words, together
from autodb.files.side import SideFile, StatedColumns, read_sidefile
from autodb.records.convert import Conversion, specs
from autodb.records.tables import (
    EDGE,
    Array,
    CutTable,
    Recording,
    check_cuts,
    edge_codes,
    gap,
)
from autodb.records.timed import on_even_rows
from autodb.timing.dates import is_date
from autodb.wording import listed, phrase
from autodb.wording.kept import said_again

FEWEST_ROWS = 3
SHOWN = 12
"""Columns that are listed before the rest is only counted."""


@dataclass(frozen=True)
class ChannelSet:
    """One time base of a file, or its table of cuts, with the channels that it holds."""

    base: readers.ColumnSet
    conversion: Conversion

    @property
    def name(self) -> str:
        """Its name in the file; empty where the file has no other."""
        return self.base.name

    @property
    def holds_cuts(self) -> bool:
        """Whether a row is a cut; otherwise a row is a moment."""
        return "cut" in self.conversion.specs

    @property
    def has_key(self) -> bool:
        """Whether it has `t` or `cut`, without which nothing can be read of it."""
        return self.holds_cuts or "t" in self.conversion.specs

    @property
    def ignored(self) -> tuple[str, ...]:
        """Columns that are no channel."""
        taken = {spec.column for spec in self.conversion.specs.values()}
        return tuple(name for name in self.base.columns if name not in taken)

    def blocks(self) -> Iterator[tuple[dict[str, Array], dict[str, list[str]]]]:
        """Yield channels in our units, and text columns, block by block.

        Raises UnusableInput naming column and row. Memory is that of one block.
        """
        begun = False
        try:
            for block in self._blocks(self.conversion):
                begun = True
                yield block
        except UnusableInput:
            if begun or not self._is_dated():
                raise
            yield from self._blocks(replace(self.conversion, dated=True))

    def _is_dated(self) -> bool:
        """Say whether stamps are written as dates, by the first of them."""
        column = self.conversion.stamps
        if column is None:
            return False
        first = next(iter(self.base.blocks((), (column,))))[column].tolist()
        return is_date(next((str(text) for text in first if text), ""))

    def _blocks(
        self, conversion: Conversion
    ) -> Iterator[tuple[dict[str, Array], dict[str, list[str]]]]:
        rows = conversion.start()
        if not conversion.numbers and not conversion.labels:  # only rows are counted
            for block in self.base.blocks((), self.base.columns[:1]):
                yield conversion.channels(block, rows), {}
            return
        for block in self.base.blocks(conversion.numbers, conversion.labels):
            yield conversion.channels(block, rows), conversion.texts(block)

    def read(self, *, like: Recording | None = None) -> Recording | CutTable:
        """Read it whole; a recording as even rows, ``like`` one with the same stamps.

        Raises UnusableInput with file, column and row.
        """
        parts = list(self.blocks())
        channels = {n: np.concatenate([part[0][n] for part in parts]) for n in parts[0][0]}
        texts = {n: [text for part in parts for text in part[1][n]] for n in parts[0][1]}
        if EDGE in texts:
            channels[EDGE] = _edges(texts)
        return (
            self._cuts(channels, texts)
            if self.holds_cuts
            else on_even_rows(self._series(channels, texts), like=like)
        )

    def _cuts(self, channels: dict[str, Array], texts: dict[str, list[str]]) -> CutTable:
        path, conversion = self.conversion.path, self.conversion
        check_cuts(path, channels["cut"])
        return CutTable(
            path, channels, texts, conversion.units, conversion.side, ignored=self.ignored
        )

    def _series(self, channels: dict[str, Array], texts: dict[str, list[str]]) -> Recording:
        path, conversion = self.conversion.path, self.conversion
        bad = {name: gap(path, name, values) for name, values in channels.items()}
        unusable = {name: message for name, message in bad.items() if message and name != "t"}
        rows = len(channels["t"])
        if rows < FEWEST_ROWS:
            raise UnusableInput(
                phrase(
                    "{file}: {rows} rows are too few for a recording; record at least "
                    "{fewest_rows}",
                    file=path,
                    rows=rows,
                    fewest_rows=FEWEST_ROWS,
                )
            )
        usable = {name: values for name, values in channels.items() if name not in unusable}
        return Recording(
            path, usable, texts, conversion.units, conversion.side, unusable, self.ignored
        )


def _edges(texts: dict[str, list[str]]) -> Array:
    """Return edges as numbers: their own where all are numbers, otherwise in order of first use."""
    try:
        numbers = np.array([float(text) if text else np.nan for text in texts[EDGE]])
    except ValueError:
        return edge_codes(texts[EDGE])
    del texts[EDGE]
    return numbers


@dataclass(frozen=True)
class RecordingSource:
    """A file, its side file, and the time bases in it."""

    path: Path
    side: SideFile
    bases: tuple[ChannelSet, ...]

    @property
    def remarks(self) -> tuple[str, ...]:
        """How the file is written, where that was found out, and which columns are not read."""
        layouts = dict.fromkeys(base.base.layout for base in self.bases if base.base.layout)
        ignored = [column for base in self.bases for column in base.ignored]
        names = ", ".join(ignored[:SHOWN])
        if len(ignored) > SHOWN:
            names = phrase("{what} and {count} more", what=names, count=len(ignored) - SHOWN)
        unread = phrase("not read, no channel names it: {names}", names=names)
        return (
            *(phrase("read as: {layout}", layout=said_again(layout)) for layout in layouts),
            *([unread] if ignored else []),
        )

    def choose(self, group: str | None = None) -> ChannelSet:
        """Return the time base called ``group``, or the only one that can be read.

        Raises UnusableInput naming the time bases there are, or a near column.
        """
        if group is not None:
            return self._called(group)
        usable = self.usable()
        if len(usable) > 1:
            raise UnusableInput(
                phrase(
                    "{file}: several time bases: {listed}; read one of them with --group NAME",
                    file=self.path,
                    listed=self._listed(usable),
                )
            )
        return usable[0]

    def usable(self) -> list[ChannelSet]:
        """Return the time bases with `t` or `cut`; raises UnusableInput when there is none."""
        found = [base for base in self.bases if base.has_key and len(base.conversion.specs) > 1]
        if not found and any(base.has_key for base in self.bases):
            ignored = [column for base in self.bases for column in base.ignored]
            like = get_close_matches("x.current", ignored, n=1)
            there = near_words("x.current", ignored) if ignored else ""
            example = phrase(', such as "x.current" = "{like}"', like=like[0]) if like else there
            raise UnusableInput(
                phrase(
                    "{file}: no channel beside its time or cut number; name its columns in a side "
                    "file under [channels]{example}",
                    file=self.path,
                    example=example,
                )
            )
        if not found:
            columns = [column for base in self.bases for column in base.base.columns]
            raise UnusableInput(
                phrase(
                    "{file}: neither a column 't' (time, s) nor 'cut'{hint}; have 'autodb look "
                    "FILE --write' propose a side file, or name the column in one: [channels] "
                    '"t" = "NAME OF THE COLUMN", or the step of even rows: "t" = {{row_in = "*", '
                    "step_s = SECONDS}}",
                    file=self.path,
                    hint=near_words("t", columns),
                )
            )
        return found

    def _called(self, group: str) -> ChannelSet:
        found = next((base for base in self.bases if base.name == group), None)
        if found is None:
            if len(self.bases) == 1:
                raise UnusableInput(
                    phrase(
                        "{file}: no group '{group}'; the file has one time base; leave out --group",
                        file=self.path,
                        group=group,
                    )
                )
            names = [base.name for base in self.bases]
            raise UnusableInput(
                phrase(
                    "{file}: no group '{group}'{hint}",
                    file=self.path,
                    group=group,
                    hint=near_words(group, names),
                )
            )
        if not found.has_key:
            raise UnusableInput(
                phrase(
                    "{file}: group '{group}' has neither a column 't' (time, s) nor 'cut'{hint}",
                    file=self.path,
                    group=group,
                    hint=near_words("t", found.base.columns),
                )
            )
        return found

    @staticmethod
    def _listed(bases: Sequence[ChannelSet]) -> str:
        return "; ".join(f"'{b.name}' ({', '.join(sorted(b.conversion.specs))})" for b in bases)


def open_source(path: Path, *, columns: StatedColumns = None) -> RecordingSource:
    """Open a recording or cut table with its side file (beside it, or ``columns``).

    Raises UnusableInput for a file or side file that cannot be used.
    """
    if path.is_dir():
        raise UnusableInput(phrase("{file}: is a folder; give a file in it", file=path))
    readers.reader_of(path)
    if isinstance(columns, SideFile):
        return open_as_stored(path, columns)
    beside = path.with_suffix(".toml")
    side_path = columns or (beside if beside.is_file() else None)
    side = read_sidefile(side_path) if side_path else SideFile()
    return assembled_source(path, readers.open_bases(path, side.csv), side)


def open_as_stored(path: Path, side: SideFile) -> RecordingSource:
    """Open a recording or cut table with the side file that is known of it, whatever lies beside.

    Raises UnusableInput for a file that cannot be used.
    """
    return assembled_source(path, readers.open_bases(path, side.csv), side)


def assembled_source(
    path: Path, opened: Sequence[readers.ColumnSet], side: SideFile
) -> RecordingSource:
    """Return what time bases and a side file are; raises UnusableInput with all their problems."""
    everywhere = [column for base in opened for column in base.columns]
    wanted = dict.fromkeys(str(s.column or s.row_in) for s in side.channels.values())
    there = {*everywhere, "*"}
    problems: list[str] = [
        phrase("no column '{w}'{hint}", w=w, hint=near_words(w, everywhere))
        for w in wanted
        if w not in there
    ]
    layouts = dict.fromkeys(base.layout for base in opened if base.layout)
    if problems and layouts:
        read_as = phrase("the file is read as: {what}", what=listed(map(said_again, layouts), "; "))
        problems[-1] = listed([problems[-1], read_as], "; ")
    bases = tuple(
        ChannelSet(base, Conversion(path, specs(base.columns, side), side, base.units))
        for base in opened
    )
    problems += [problem for base in bases for problem in base.conversion.problems]
    if problems:
        raise together(path, problems)
    return RecordingSource(path, side, bases)


def read(
    path: Path,
    *,
    columns: StatedColumns = None,
    group: str | None = None,
    like: Recording | None = None,
) -> Recording | CutTable:
    """Read a recording or a cut table with its side file (beside it, or ``columns``).

    ``group`` picks a time base of a file that has several; ``like`` is a recording whose time
    counts for a file with the same stamps. Raises UnusableInput with file, column and row.
    """
    return open_source(path, columns=columns).choose(group).read(like=like)
