"""Checksums of the rows of an SQLite file: a value that changed by itself is found.

SQLite checks how its pages hang together, and not what their cells hold. So each table's rows,
GROUP of them by their key, have a row in `row_checksum`: how many they are, and the exclusive or of
their digests. Triggers keep it in the same statement that changes a row, whoever makes it, and take
out what the row was to be, not what lies there: a value that has changed by itself never comes
right again by a later write. A connection that does not know the digest cannot write.

A server has checksums of its own pages, and no such table.
"""

import sqlite3
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from hashlib import blake2b
from struct import pack
from typing import Any

from sqlalchemy import BigInteger, Column, Connection, Integer, MetaData, String, Table

from autodb.store.urls import SQLITE

BITS = 8
GROUP = 2**BITS
"""Keys a group. Chosen: a checksum is a hundredth of what it covers, and names few rows."""
DIGEST = "autodb_row"
"""What SQL calls the digest of a row."""
SUMS = Table(
    "row_checksum",
    MetaData(),
    Column("of_table", String, primary_key=True),
    Column("part", Integer, primary_key=True, autoincrement=False),
    Column("rows", Integer, nullable=False),
    Column("digest", BigInteger, nullable=False),
    sqlite_with_rowid=False,
)
"""``part``: the first column of the key by GROUP; ``digest``: 64 bits, signed."""
UNCOUNTED = ("alembic_version", SUMS.name)

UNREADABLE = (sqlite3.DatabaseError, UnicodeDecodeError)
"""What is raised where a file is damaged; its driver cannot even read some of SQLite's messages."""
Sums = dict[tuple[str, int], tuple[int, int]]
"""Rows and digest, by table and part."""


class _Text(bytes):
    """Text as it is stored, of whatever bytes."""


@dataclass(frozen=True)
class TableColumns:
    """A table's columns in the order of their names, and the first one of its key."""

    names: tuple[str, ...]
    key: str


def row_digest(*values: object) -> int:
    """Return the digest of a row's values, in 64 bits, signed: of type and value of each.

    Floats count by their 8 bytes, text by its UTF-8.
    """
    parts = [CANONICAL[type(value)](value) for value in values]
    return int.from_bytes(blake2b(b"".join(parts), digest_size=8).digest(), "little", signed=True)


def _text(value: bytes) -> bytes:
    return b"t%d:%b" % (len(value), value)


CANONICAL: Mapping[type, Callable[[Any], bytes]] = {
    float: lambda value: pack("<cd", b"f", value + 0.0),  # SQLite keeps no minus zero
    int: lambda value: b"i%d;" % value,
    str: lambda value: _text(value.encode()),
    _Text: _text,
    bytes: lambda value: b"b%d:%b" % (len(value), value),
    type(None): lambda _: b"n",
}
"""The bytes of a value of each type that SQLite has."""


def register(connection: sqlite3.Connection) -> sqlite3.Connection:
    """Let a connection write to a database with checksums; return it."""
    connection.create_function(DIGEST, -1, row_digest, deterministic=True)
    connection.execute("PRAGMA recursive_triggers=ON")  # rows that REPLACE removes count too
    return connection


def triggers(tables: Mapping[str, TableColumns]) -> dict[str, str]:
    """Return the triggers that keep the checksums of tables: SQL by name."""
    made = {}
    for table, columns in tables.items():
        added, removed = _count(table, columns, "NEW", 1), _count(table, columns, "OLD", -1)
        for event, body in (("INSERT", added), ("UPDATE", removed + added), ("DELETE", removed)):
            name = f"{SUMS.name}_{table}_{event.lower()}"
            made[name] = f'CREATE TRIGGER {name} AFTER {event} ON "{table}" BEGIN {body}END'
    return made


def _count(table: str, columns: TableColumns, row: str, by: int) -> str:
    """Return the statement that counts a row in or out; its digest is its own inverse."""
    values = ", ".join(f'{row}."{name}"' for name in columns.names)
    return (
        f"INSERT INTO {SUMS.name} (of_table, part, rows, digest) "
        f"VALUES ('{table}', {row}.\"{columns.key}\" >> {BITS}, {by}, {DIGEST}({values})) "
        f"ON CONFLICT (of_table, part) DO UPDATE SET rows = rows + {by}, "
        "digest = (digest | excluded.digest) & ~(digest & excluded.digest); "
    )


def of_metadata(metadata: MetaData) -> dict[str, TableColumns]:
    """Return the columns of the tables that models state."""
    return {
        table.name: TableColumns(
            tuple(sorted(table.columns.keys())), next(iter(table.primary_key)).name
        )
        for table in metadata.sorted_tables
    }


def of_file(file: sqlite3.Connection) -> dict[str, TableColumns]:
    """Return the columns of the tables of a file whose rows have checksums; each has a key."""
    return {
        name: _columns(file.execute("SELECT name, pk FROM pragma_table_info(?)", (name,)))
        for name in tables_of(file)
    }


def tables_of(file: sqlite3.Connection) -> list[str]:
    """Return the tables of a file but those of migrations, checksums and SQLite itself."""
    names = file.execute("SELECT name FROM sqlite_master WHERE type = 'table' ORDER BY name")
    return [name for (name,) in names if name not in UNCOUNTED and not name.startswith("sqlite_")]


def _columns(rows: Iterable[tuple[str, int]]) -> TableColumns:
    keys = dict(rows)
    return TableColumns(
        tuple(sorted(keys)), next(name for name, place in keys.items() if place == 1)
    )


def driver_of(connection: Connection) -> sqlite3.Connection:
    """Return the SQLite connection below SQLAlchemy's."""
    found = connection.connection.driver_connection
    assert isinstance(found, sqlite3.Connection)
    return found


def is_kept(file: sqlite3.Connection) -> bool:
    """Say whether a file has checksums: those of schemas before 0010 have none."""
    asked = "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name = ?"
    return bool(file.execute(asked, (SUMS.name,)).fetchone()[0])


def lift(connection: Connection) -> None:
    """Take the triggers off, for tables that are about to change; on a server, nothing."""
    if connection.dialect.name == SQLITE:
        file = driver_of(connection)
        for name in triggers(of_file(file)):
            file.execute(f"DROP TRIGGER IF EXISTS {name}")


def lay(connection: Connection) -> None:
    """Take the checksums of all rows anew and put the triggers on, where there is their table."""
    if connection.dialect.name != SQLITE or not is_kept(file := driver_of(connection)):
        return
    file.execute(f"DELETE FROM {SUMS.name}")
    rows = ((*group, *what) for group, what in sums_of_rows(file).items())
    file.executemany(f"INSERT INTO {SUMS.name} VALUES (?, ?, ?, ?)", rows)
    for statement in triggers(of_file(file)).values():
        file.execute(statement)


def sums_of_rows(file: sqlite3.Connection) -> Sums:
    """Return what the checksums of all rows are, as they can be read now."""
    found: Sums = {}
    tables = of_file(file)
    with _raw(file):
        for table, columns in tables.items():
            names = ", ".join(f'"{name}"' for name in columns.names)
            asked = f'SELECT "{columns.key}" >> {BITS}, {names} FROM "{table}" NOT INDEXED'
            for part, *values in file.execute(asked):
                rows, digest = found.get((table, part), (0, 0))
                found[table, part] = rows + 1, digest ^ row_digest(*values)
    return found


@contextmanager
def _raw(file: sqlite3.Connection) -> Iterator[None]:
    """Read text as its bytes: some that changed by itself may be none."""
    before: Any = file.text_factory
    file.text_factory = _Text
    try:
        yield
    finally:
        file.text_factory = before


def altered(file: sqlite3.Connection) -> list[str]:
    """Return the groups of rows that are not what was written, in words; those of no checksum too.

    Of a file without checksums, none. Raises one of UNREADABLE where it cannot be read so far.
    """
    if not is_kept(file):
        return []
    kept = {
        (table, part): (rows, digest)
        for table, part, rows, digest in file.execute(f"SELECT * FROM {SUMS.name}")
        if rows or digest
    }
    found = sums_of_rows(file)
    keys = {name: columns.key for name, columns in of_file(file).items()}
    different = {
        group for group in kept.keys() | found.keys() if kept.get(group) != found.get(group)
    }
    return [_named(table, part, keys) for table, part in sorted(different, key=repr)]


def _named(table: str, part: object, keys: Mapping[str, str]) -> str:
    if table not in keys or not isinstance(part, int):
        return f"{SUMS.name}: a checksum of '{table}' {part!r}, which is no part of a table"
    first = part * GROUP
    return f"{table}, rows of {keys[table]} {max(first, 1)} to {first + GROUP - 1}"
