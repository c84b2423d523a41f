"""The schema: its revisions, how a new database is made, and one brought to another revision.

A database may consist of the tables, indices and triggers of its schema and nothing else: a trigger
or view that somebody else put into a file runs with the rights of who writes to it next.
"""

import sqlite3
from collections.abc import Mapping
from contextlib import closing
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from sqlalchemy import (
    Column,
    Connection,
    Engine,
    MetaData,
    PrimaryKeyConstraint,
    String,
    Table,
    create_engine,
    inspect,
)
from sqlalchemy.exc import DatabaseError

from autodb.assets import kit
from autodb.errors import UnusableInput
from autodb.files.excuses import full_under, is_full
from autodb.store import rowsums
from autodb.store.engines import WRITES, engine_of
from autodb.store.urls import SQLITE, on_server, shown_url
from autodb.wording import phrase

Objects = dict[tuple[str, str], str | tuple[str, ...] | None]
"""What makes each thing of a schema, by kind and name; None: SQLite makes it for a table."""
STATISTICS = (("table", "sqlite_stat1"), ("table", "sqlite_stat4"))
"""What SQLite's ANALYZE leaves: numbers that only its planner reads."""
RUNS = ("trigger", "view")
"""Kinds that do something by themselves, or instead of what they are taken for."""


def make_in(connection: Connection) -> None:
    """Make the tables and triggers of this version: those that all migrations make, sooner."""
    from autodb.store import models

    stamp = Table(
        "alembic_version",
        MetaData(),
        Column("version_num", String(32), nullable=False),
        PrimaryKeyConstraint("version_num", name="alembic_version_pkc"),
    )
    models.Base.metadata.create_all(connection, checkfirst=False)  # nothing is there: callers ask
    if connection.dialect.name == SQLITE:
        rowsums.SUMS.create(connection, checkfirst=False)
    rowsums.lay(connection)
    stamp.create(connection, checkfirst=False)
    connection.execute(stamp.insert().values(version_num=head()))


def migrate(url: str, revision: str) -> None:
    """Bring a database up or down to a schema revision, in one transaction.

    Going down forgets what the lower schema cannot hold. Checksums of rows are taken anew, of
    what was found to be as it was written. Raises UnusableInput when a row is not, or would lose
    the row that it points to.
    """
    from alembic import command

    engine = engine_of(url, foreign_keys=False)  # changing a table copies it; see schema/migrations
    found = revision_of(engine, url)
    known = ["base", *revisions()]
    down = found is not None and known.index(revision) < known.index(found)
    move = command.downgrade if down else command.upgrade
    try:
        with engine.connect().execution_options(**{WRITES: True}) as connection:
            connection.begin()
            if not on_server(url):
                none_of(rowsums.altered(rowsums.driver_of(connection)), url)
            rowsums.lift(connection)
            move(_alembic(connection), revision)
            rowsums.lay(connection)
            if not on_server(url):
                none_of(pointing_nowhere(connection), url)
            connection.commit()
    finally:
        engine.dispose()


def none_of(faults: list[str], url: str) -> None:
    """Raise UnusableInput with the first of what is wrong with a database, if anything is."""
    if faults:
        raise UnusableInput(
            phrase("{url}: {what}; restore a backup with 'autodb restore'", url=url, what=faults[0])
        )


def _alembic(connection: Connection | None) -> Any:
    from alembic.config import Config

    config = Config()
    config.set_main_option("script_location", str(kit("schema") / "migrations"))
    config.attributes["connection"] = connection
    return config


def revisions() -> list[str]:
    """Return all revisions, oldest first, read off the file names (Alembic takes 0.2 s)."""
    names = sorted((kit("schema") / "migrations" / "versions").glob("[0-9]*.py"))
    return [name.name.split("_", 1)[0] for name in names]


def head() -> str:
    """Return the revision that this version works with."""
    return revisions()[-1]


def pointing_nowhere(connection: Connection) -> list[str]:
    """Return the rows of an SQLite file that point to a row which is not there, in words."""
    found = connection.exec_driver_sql("PRAGMA foreign_key_check").all()
    return [f"{row[0]} {row[1]} points to no {row[2]}" for row in found]


def revision_of(engine: Engine, url: str) -> str | None:
    """Return the schema revision of a database; None where it has none of ours.

    Raises UnusableInput where it cannot be opened.
    """
    try:
        if not inspect(engine).has_table("alembic_version"):
            return None
        with engine.connect() as connection:
            row = connection.exec_driver_sql("SELECT version_num FROM alembic_version").first()
        return str(row[0]) if row else None
    except (*rowsums.UNREADABLE, DatabaseError) as error:
        if is_full(error):
            raise UnusableInput(full_under(str(engine.url.database))) from None
        reason = " ".join(str(getattr(error, "orig", error)).split())
        works = (
            phrase("name an existing database on a server that answers")
            if on_server(url)
            else phrase("use a SQLite file in a folder that can be written to")
        )
        raise UnusableInput(
            phrase(
                "{url}: cannot be opened as a database ({reason}); {works}",
                url=shown_url(url),
                reason=reason,
                works=works,
            )
        ) from None


def objects(file: sqlite3.Connection) -> Objects:
    """Return what a database consists of."""
    found = file.execute("SELECT type, name, sql FROM sqlite_master").fetchall()
    return {
        (kind, name): _plain(kind, sql)
        for kind, name, sql in found
        if (kind, name) not in STATISTICS
    }


def _plain(kind: str, sql: str | None) -> str | tuple[str, ...] | None:
    """Return SQL to compare: of a table, what it lists in any order; migrations add at the end."""
    if kind != "table" or sql is None:
        return sql
    told = " ".join(sql.replace('"', "").split())
    begin, end = told.find("("), told.rfind(")")
    parts = _parted(told[begin + 1 : end])
    return (told[:begin].strip(), told[end:], *sorted(part.strip() for part in parts))


def _parted(text: str) -> list[str]:
    """Split a list at its commas, but for those in brackets."""
    depth, parts = 0, [""]
    for letter in text:
        depth += (letter == "(") - (letter == ")")
        if letter == "," and not depth:
            parts.append("")
        else:
            parts[-1] += letter
    return parts


@cache
def expected_shape(revision: str) -> Objects:
    """Return what a database of a schema that this version knows consists of."""
    if revision == head():
        engine = create_engine("sqlite://")
        with engine.connect() as connection:
            rowsums.register(rowsums.driver_of(connection))
            make_in(connection)
            found = objects(rowsums.driver_of(connection))
        engine.dispose()
        return found
    with TemporaryDirectory() as folder:
        path = Path(folder) / "expected.sqlite3"
        migrate(f"sqlite:///{path}", revision)
        with closing(sqlite3.connect(path)) as file:
            return objects(file)


def schema_faults(file: sqlite3.Connection, revision: str) -> list[str]:
    """Return what a database has beyond its schema, lacks of it or has otherwise, in words."""
    return _differing(objects(file), expected_shape(revision))


def trigger_faults(file: sqlite3.Connection) -> list[str]:
    """Return what triggers and views a database of this version's schema has or lacks, in words.

    It is asked at each opening: before anything is written that they might run for.
    """
    from autodb.store import models

    known: Objects = {
        ("trigger", name): sql
        for name, sql in rowsums.triggers(rowsums.of_metadata(models.Base.metadata)).items()
    }
    found = file.execute(
        f"SELECT type, name, sql FROM sqlite_master WHERE type IN {RUNS}"
    ).fetchall()
    return _differing({(kind, name): sql for kind, name, sql in found}, known)


def _differing(found: Mapping[tuple[str, str], object], known: Objects) -> list[str]:
    both = found.keys() & known.keys()
    different = (found.keys() ^ known.keys()) | {one for one in both if found[one] != known[one]}
    return [_said(one, one in found, one in known) for one in sorted(different, key=_order)]


def _order(thing: tuple[str, str]) -> tuple[bool, str]:
    """Return by what things are listed: what runs by itself first."""
    return thing[0] not in RUNS, thing[1]


def _said(thing: tuple[str, str], found: bool, known: bool) -> str:
    how = "is not the schema's" if known and found else "is no part of autodb's schema"
    return f"{thing[0]} '{thing[1]}' {how if found else 'is missing'}"
