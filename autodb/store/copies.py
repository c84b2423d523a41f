"""Copies of a database: taken while it is in use, and checked."""

import sqlite3
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from autodb.errors import UnusableInput, no_such_file
from autodb.files.excuses import full_under, is_full
from autodb.files.targets import Progress, sync
from autodb.store import head, revisions, rowsums
from autodb.store.engines import open_sqlite
from autodb.store.schemas import schema_faults
from autodb.wording import phrase

PAGES_A_STEP = 2048
WAIT_S = 5.0


@dataclass(frozen=True)
class Copied:
    """Rows by table, and the schema that the source had."""

    rows: dict[str, int]
    schema: str

    @property
    def total(self) -> int:
        """Number of rows in all tables."""
        return sum(self.rows.values())


def same_folder(a: Path, b: Path) -> bool:
    """Say whether two files lie in one folder."""
    return a.parent.resolve() == b.parent.resolve()


def row_counts(connection: sqlite3.Connection) -> dict[str, int]:
    """Return the number of rows of every table but the migrations' own and the checksums."""
    return {
        name: connection.execute(f'SELECT COUNT(*) FROM "{name}"').fetchone()[0]
        for name in rowsums.tables_of(connection)
    }


def copy_of(source: Path, partial: Path, progress: Progress | None) -> Copied:
    """Copy one state of ``source``, and check that the copy is sound and holds as many rows."""
    if not source.is_file():
        raise no_such_file(source)
    try:
        with closing(connect(source)) as live, closing(connect(partial)) as copy:
            live.execute("BEGIN")  # all that follows sees this state, whatever others write
            schema = stored_schema_of(live, source)
            before = row_counts(live)
            live.backup(copy, pages=PAGES_A_STEP, progress=_said(progress))
            live.execute("ROLLBACK")
            _check(copy, source, schema, before)
    except rowsums.UNREADABLE as error:
        if is_full(error):
            raise UnusableInput(full_under(str(partial))) from None
        raise UnusableInput(
            phrase("{source}: cannot be copied as a database ({error})", source=source, error=error)
        ) from None
    return Copied(before, schema)


def _said(progress: Progress | None) -> Callable[[int, int, int], None]:
    def say(_status: int, remaining: int, total: int) -> None:
        if progress:
            progress(f"page {total - remaining} of {total}")

    return say


def stored_schema_of(connection: sqlite3.Connection, path: Path) -> str:
    """Return the schema of a database; raises UnusableInput when it is none that we know."""
    names = {row[0] for row in connection.execute("SELECT name FROM sqlite_master")}
    row = None
    if "alembic_version" in names:
        row = connection.execute("SELECT version_num FROM alembic_version").fetchone()
    if row is None:
        raise UnusableInput(
            phrase("{file}: no autodb database; use a file that 'autodb backup' wrote", file=path)
        )
    if row[0] not in revisions():
        raise UnusableInput(
            phrase(
                "{file}: schema {row} is not known to this version, which knows up to {value}; "
                "install a newer autodb",
                file=path,
                row=row[0],
                value=head(),
            )
        )
    return str(row[0])


def _check(copy: sqlite3.Connection, source: Path, schema: str, before: dict[str, int]) -> None:
    """Raise UnusableInput where a copy is not sound, holds what is not ours, or other values."""
    strange = schema_faults(copy, schema)
    if strange:
        raise UnusableInput(
            phrase(
                "{source}: {strange}; use an earlier backup or an export",
                source=source,
                strange=strange[0],
            )
        )
    faults = [row[0] for row in copy.execute("PRAGMA integrity_check") if row[0] != "ok"]
    faults += [f"rows of '{row[0]}' point to no row" for row in copy.execute(
        "PRAGMA foreign_key_check")]  # fmt: skip
    if row_counts(copy) != before:
        faults.append("the copy holds another number of rows")
    if faults:
        raise UnusableInput(
            phrase(
                "{source}: damaged ({faults}); run 'autodb doctor'", source=source, faults=faults[0]
            )
        )
    altered = rowsums.altered(copy)
    if altered:
        raise UnusableInput(
            phrase(
                "{source}: damaged ({altered} changed after they were written); restore an "
                "earlier backup with 'autodb restore'",
                source=source,
                altered=altered[0],
            )
        )


def connect(path: Path) -> sqlite3.Connection:
    """Open a database file as it is, without changing how it keeps its log."""
    return open_sqlite(path, isolation_level=None, timeout=WAIT_S)


def settle(path: Path) -> None:
    """Make a database one file without a write-ahead log, written to the disk."""
    with closing(connect(path)) as connection:
        connection.execute("PRAGMA journal_mode=DELETE")
    sync(path)
