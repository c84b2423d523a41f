"""What lies in a folder and in its databases, summed up: are two the same but for the clock?

What carries a clock, or is drawn at random, is learnt and not listed: columns of tables, and lines
of text, in which two undisturbed runs differ are left out of every comparison.
"""

import hashlib
import re
import sqlite3
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import pyarrow.parquet as pq

from autodb.files.checksums import checksum
from autodb.files.targets import LOGS
from autodb.store import rowsums
from autodb.store.copies import connect

DATABASE = ".sqlite3"
DATES = re.compile(r"\d{8}T\d{6}Z|(?<=kept/)\d{4}-\d{2}")
"""Times in the names of dated backups, and of the folders that an inbox keeps files in."""
NEW_EACH_TIME = (rowsums.SUMS.name,)
"""Checksums cover clocks too; whether they are right is asked by itself."""
Rows = Iterator[Sequence[object]]
Masks = Mapping[str, frozenset[str]]
"""By the name of a file: which of its parts, as `table.column` or a line's number, are left out."""
State = Mapping[str, str]
"""By the name of a file, and of a table in it: a digest of what it holds, or of its bytes."""


@dataclass(frozen=True)
class Part:
    """A table of a file, or its text as one row of its lines."""

    name: str
    columns: tuple[str, ...]
    rows: Rows


def files_in(folder: Path) -> dict[str, Path]:
    """Return all files of a folder by their names from there, without their dates."""
    found: dict[str, Path] = {}
    for path in sorted(folder.rglob("*")):
        if not path.is_dir():
            name = DATES.sub("DATE", str(path.relative_to(folder)))
            while name in found:
                name += "+"
            found[name] = path
    return found


def folder_state(folder: Path, masks: Masks, of: Callable[[str], bool] = lambda _: True) -> State:
    """Return the state of a folder's files, or of those of some names.

    Of files without a mask, which are no database, it is their checksums.
    """
    files = {name: path for name, path in files_in(folder).items() if of(name)}
    in_parts = {name: p for name, p in files.items() if name.rstrip("+") in masks or is_database(p)}
    # a database that is opened may take its log away: those files come first
    state = {name: checksum(path) for name, path in files.items() if name not in in_parts}
    for name, path in in_parts.items():
        mask = masks.get(name.rstrip("+"), frozenset())
        state |= {_called(name, part): _digest(part, mask) for part in _parts(path)}
    return state


def is_database(path: Path) -> bool:
    """Say whether a file is a database in sight; one that is hidden is only there or not."""
    return path.suffix == DATABASE and not path.name.startswith(".")


def _called(name: str, part: Part) -> str:
    return f"{name}: {part.name}" if part.name else name


def masks_of(one: Path, other: Path) -> dict[str, frozenset[str]]:
    """Return where two folders differ that ought to be the same, by file."""
    both = files_in(one), files_in(other)
    masks = {}
    for name in both[0].keys() & both[1].keys():
        a, b = both[0][name], both[1][name]
        if is_database(a) or checksum(a) != checksum(b):
            sums = _by_column(a), _by_column(b)
            masks[name] = frozenset(
                column
                for column in sums[0].keys() | sums[1].keys()
                if sums[0].get(column) != sums[1].get(column)
            )
    return masks


def faults_of(folder: Path, checked_in: Path) -> list[str]:
    """Return which databases of a folder are not sound, checked in copies in another folder."""
    faults = []
    for name, path in files_in(folder).items():
        if is_database(path):
            copy = _copied(path, checked_in)
            try:
                faults += [f"{name}: {one}" for one in _faults_of_file(copy)]
            except rowsums.UNREADABLE as error:
                faults.append(f"{name}: {error}")
    return faults


def _copied(path: Path, checked_in: Path) -> Path:
    """Copy a database with its log: opened where it lies, it would be put in order."""
    copy = checked_in / "checked.sqlite3"
    for end in ("", *LOGS):
        copy.with_name(f"{copy.name}{end}").unlink(missing_ok=True)
    for end in ("", "-wal", "-journal"):
        source = path.with_name(f"{path.name}{end}")
        if source.exists():
            copy.with_name(f"{copy.name}{end}").write_bytes(source.read_bytes())
    return copy


def _faults_of_file(path: Path) -> list[str]:
    with closing(connect(path)) as file:
        faults = [str(row[0]) for row in file.execute("PRAGMA integrity_check") if row[0] != "ok"]
        faults += [f"{row[0]} points to no row" for row in file.execute("PRAGMA foreign_key_check")]
        return faults + rowsums.altered(file)


def _parts(path: Path) -> Iterator[Part]:
    if path.suffix == DATABASE:
        yield from _tables(path)
    elif path.suffix == ".parquet":
        table = pq.read_table(path)
        yield Part("", tuple(table.schema.names), zip(*table.to_pydict().values(), strict=True))
    else:
        lines = path.read_text("utf-8", errors="surrogateescape").split("\n")
        yield Part("", tuple(f"line {k + 1}" for k in range(len(lines))), iter([lines]))


def _tables(path: Path) -> Iterator[Part]:
    with closing(sqlite3.connect(path)) as file:
        for (name,) in file.execute(
            "SELECT name FROM sqlite_master WHERE type = 'table'"
        ).fetchall():
            if name not in NEW_EACH_TIME and not name.startswith("sqlite_"):
                rows = file.execute(f'SELECT * FROM "{name}"')
                yield Part(name, tuple(column[0] for column in rows.description), rows)


def _digest(part: Part, mask: frozenset[str]) -> str:
    """Return the rows of a part, in whatever order, without what is left out; counted."""
    seen = [k for k, name in enumerate(part.columns) if f"{part.name}.{name}" not in mask]
    n = total = 0
    for row in part.rows:
        n, total = n + 1, total + _number([row[k] for k in seen])
    return f"{n} rows, {len(part.columns)} columns, {total:x}"


def _by_column(path: Path) -> dict[str, Counter[str]]:
    """Return the values of each column, counted: order says nothing."""
    found: dict[str, Counter[str]] = {}
    for part in _parts(path):
        counts: list[Counter[str]] = [Counter() for _ in part.columns]
        for row in part.rows:
            for count, value in zip(counts, row, strict=True):
                count[
                    hashlib.blake2b(
                        repr(value).encode("utf-8", "surrogateescape"), digest_size=8
                    ).hexdigest()
                ] += 1
        found |= {f"{part.name}.{c}": n for c, n in zip(part.columns, counts, strict=True)}
    return found


def _number(values: list[object]) -> int:
    text = repr(values).encode("utf-8", "surrogateescape")
    return int.from_bytes(hashlib.blake2b(text, digest_size=8).digest(), "little")
