"""The database: one file or server, opened only at the schema this version knows.

SQLite with foreign keys and write-ahead log, or PostgreSQL. Every change is one transaction: a
process killed in the middle leaves the database as it was before.
"""

import sqlite3
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sqlalchemy import (
    Column,
    Connection,
    Engine,
    MetaData,
    PrimaryKeyConstraint,
    String,
    Table,
    inspect,
)
from sqlalchemy.exc import DatabaseError
from sqlalchemy.orm import Session

from autodb.assets import kit
from autodb.errors import UnusableInput
from autodb.store.engines import (
    MACHINE,
    WRITES,
    backend_of,
    engine_of,
    lasting,
    lock_audit,
    lock_catalogue,
)
from autodb.store.urls import DEFAULT_URL, SQLITE, database_url, file_of, on_server, shown

__all__ = [
    "DEFAULT_URL",
    "Also",
    "Created",
    "Store",
    "create_store",
    "database_url",
    "file_of",
    "head",
    "lasting",
    "lock_audit",
    "lock_catalogue",
    "migrate",
    "nothing_else",
    "on_server",
    "open_store",
    "pointing_nowhere",
    "revisions",
    "shown",
]


Also = Callable[[Session, int], None]
"""What else is written in the transaction that writes a row, by its number."""


def nothing_else(_session: Session, _number: int) -> None:
    """Write nothing beside a row."""


class Store:
    """An open database."""

    def __init__(self, engine: Engine) -> None:
        self.engine = engine

    @property
    def path(self) -> Path | None:
        """Return the database's file; None on a server."""
        name = self.engine.url.database
        return Path(name) if self.engine.dialect.name == SQLITE and name else None

    @contextmanager
    def reading(self) -> Iterator[Session]:
        """Give a session that sees one state of the database and writes nothing."""
        options = backend_of(self.engine).reading
        with (
            self.engine.connect().execution_options(**options) as connection,
            Session(connection) as session,
        ):
            yield session
            session.rollback()

    @contextmanager
    def writing(self, machine: str | None = None) -> Iterator[Session]:
        """Give a session whose changes are committed together at the end, or not at all.

        ``machine``: the only one whose rows are changed; a server then lets others write those of
        other machines meanwhile. None: nobody else writes.
        """
        options = {WRITES: True, MACHINE: machine}
        with (
            self.engine.connect().execution_options(**options) as connection,
            Session(connection) as session,
        ):
            yield session
            session.commit()

    def close(self) -> None:
        """Give back the file, or the connections to a server."""
        self.engine.dispose()


def open_store(url: str, *, any_schema: bool = False) -> Store:
    """Open an existing database at the schema of this version, or at any.

    Raises UnusableInput when there is none, it is no database, or its schema is another.
    """
    engine = engine_of(url)
    named = shown(url)
    if not on_server(url) and not file_of(url).exists():
        raise UnusableInput(f"{named}: no database there; 'autodb init' makes one")
    found = _revision(engine, url)
    if found is None:
        raise UnusableInput(f"{named}: no autodb database; 'autodb init' makes one")
    if found != head() and not any_schema:
        works = "'autodb init' brings it there" if found in revisions() else "a newer autodb works"
        raise UnusableInput(f"{named}: schema {found}, this version needs {head()}; {works}")
    return Store(engine)


@dataclass(frozen=True)
class Created:
    """From which schema (None: there was no database) to which; the same: nothing changed."""

    was: str | None
    now: str

    @property
    def changed(self) -> bool:
        """Whether the database was made or its schema changed."""
        return self.was != self.now


def create_store(url: str) -> Created:
    """Create the database or bring it to this version's schema.

    Raises UnusableInput when it is no database of ours, or one of a later version.
    """
    if not on_server(url):
        file_of(url)
    engine, named = engine_of(url), shown(url)
    try:
        found = _revision(engine, url)
        if found is None and inspect(engine).get_table_names():
            new = "database" if on_server(url) else "file"
            raise UnusableInput(f"{named}: holds another program's tables; a new {new} would work")
        if found is not None and found not in revisions():
            raise UnusableInput(
                f"{named}: schema {found} is not known to this version, which knows up to "
                f"{head()}; a newer autodb would work"
            )
    finally:
        engine.dispose()
    if found is None:
        _make(url)
    elif found != head():
        migrate(url, head())
    return Created(found, head())


def _make(url: str) -> None:
    """Make the tables that this version's models state, in one transaction.

    They are those that all migrations make, sooner.
    """
    from autodb.store import models

    engine = engine_of(url)
    stamp = Table(
        "alembic_version",
        MetaData(),
        Column("version_num", String(32), nullable=False),
        PrimaryKeyConstraint("version_num", name="alembic_version_pkc"),
    )
    try:
        with engine.connect().execution_options(**{WRITES: True}) as connection:
            if not inspect(connection).has_table(stamp.name):  # another did it meanwhile
                models.Base.metadata.create_all(connection)
                stamp.create(connection)
                connection.execute(stamp.insert().values(version_num=head()))
            connection.commit()
    finally:
        engine.dispose()


def migrate(url: str, revision: str) -> None:
    """Bring a database up or down to a schema revision, in one transaction.

    Going down forgets what the lower schema cannot hold. Raises UnusableInput when a row would
    lose the row that it points to.
    """
    from alembic import command

    engine = engine_of(url, foreign_keys=False)  # changing a table copies it; see schema/migrations
    found = _revision(engine, url)
    known = ["base", *revisions()]
    down = found is not None and known.index(revision) < known.index(found)
    move = command.downgrade if down else command.upgrade
    try:
        with engine.connect().execution_options(**{WRITES: True}) as connection:
            move(_alembic(connection), revision)
            lost = () if on_server(url) else pointing_nowhere(connection)
            if lost:
                raise UnusableInput(f"{url}: {lost[0]}; a backup would work: 'autodb restore'")
            connection.commit()
    finally:
        engine.dispose()


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


def _revision(engine: Engine, url: str) -> str | None:
    try:
        if not inspect(engine).has_table("alembic_version"):
            return None
        with engine.connect() as connection:
            row = connection.exec_driver_sql("SELECT version_num FROM alembic_version").first()
        return str(row[0]) if row else None
    except (sqlite3.Error, DatabaseError) as error:
        reason = " ".join(str(getattr(error, "orig", error)).split())
        works = (
            "a database that is there, on a server that answers, would work"
            if on_server(url)
            else "a SQLite file in a folder that may be written would work"
        )
        raise UnusableInput(
            f"{shown(url)}: cannot be opened as a database ({reason}); {works}"
        ) from None
