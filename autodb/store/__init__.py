"""The database: one file or server, opened only at the schema this version knows.

SQLite with foreign keys and write-ahead log. Every change is one transaction: a process killed in
the middle leaves the database as it was before.
"""

import os
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, Engine, create_engine, event, inspect
from sqlalchemy.engine import URL, make_url
from sqlalchemy.exc import ArgumentError, DatabaseError
from sqlalchemy.orm import Session

from autodb.assets import kit
from autodb.errors import UnusableInput

DEFAULT_URL = "sqlite:///autodb.sqlite3"
LOCKED_MS = 150_000
"""How long another program's write is waited for. Chosen: a backup of gigabytes is done by then."""


def database_url(given: str | None) -> str:
    """Return the URL in use: the given one, else AUTODB_DB, else a file in the working folder."""
    return given or os.environ.get("AUTODB_DB") or DEFAULT_URL


class Store:
    """An open database."""

    def __init__(self, engine: Engine) -> None:
        self.engine = engine

    @contextmanager
    def reading(self) -> Iterator[Session]:
        """Give a session that sees one state of the database and writes nothing."""
        with self.engine.connect() as connection, Session(connection) as session:
            yield session
            session.rollback()

    @contextmanager
    def writing(self) -> Iterator[Session]:
        """Give a session whose changes are committed together at the end, or not at all."""
        options = {"autodb_writes": True}
        with (
            self.engine.connect().execution_options(**options) as connection,
            Session(connection) as session,
        ):
            yield session
            session.commit()

    def close(self) -> None:
        """Give back the file."""
        self.engine.dispose()


def open_store(url: str, *, any_schema: bool = False) -> Store:
    """Open an existing database at the schema of this version, or at any.

    Raises UnusableInput when there is none, it is no database, or its schema is another.
    """
    engine = _engine(url)
    if _missing_file(url):
        raise UnusableInput(f"{url}: no database there; 'autodb init' makes one")
    found = _revision(engine, url)
    if found is None:
        raise UnusableInput(f"{url}: no autodb database; 'autodb init' makes one")
    if found != head() and not any_schema:
        works = "'autodb init' brings it there" if found in revisions() else "a newer autodb works"
        raise UnusableInput(f"{url}: schema {found}, this version needs {head()}; {works}")
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
    file_of(url)
    engine = _engine(url)
    try:
        found = _revision(engine, url)
        if found is None and inspect(engine).get_table_names():
            raise UnusableInput(f"{url}: holds another program's tables; a new file would work")
        if found is not None and found not in revisions():
            raise UnusableInput(
                f"{url}: schema {found} is not known to this version, which knows up to {head()}; "
                "a newer autodb would work"
            )
    finally:
        engine.dispose()
    if found != head():
        migrate(url, head())
    return Created(found, head())


def migrate(url: str, revision: str) -> None:
    """Bring a database up or down to a schema revision, in one transaction.

    Going down forgets what the lower schema cannot hold. Raises UnusableInput when a row would
    lose the row that it points to.
    """
    from alembic import command

    engine = _engine(url, foreign_keys=False)  # changing a table copies it; see schema/migrations
    found = _revision(engine, url)
    known = ["base", *revisions()]
    down = found is not None and known.index(revision) < known.index(found)
    move = command.downgrade if down else command.upgrade
    try:
        with engine.connect().execution_options(autodb_writes=True) as connection:
            move(_alembic(connection), revision)
            lost = connection.exec_driver_sql("PRAGMA foreign_key_check").all()
            if lost:
                raise UnusableInput(f"{url}: table '{lost[0][0]}' has rows that point to no row; "
                                    "a backup would work: 'autodb restore'")  # fmt: skip
            connection.commit()
    finally:
        engine.dispose()


def file_of(url: str) -> Path:
    """Return the file of a database, there or not.

    Raises UnusableInput when the URL is none of SQLite, or means a database in memory.
    """
    database = _parsed(url).database
    if database in (None, "", ":memory:"):
        raise UnusableInput(f"{url}: a database in memory keeps nothing; {DEFAULT_URL} would work")
    path = Path(str(database))
    return path.resolve() if path.is_symlink() else path


def _parsed(url: str) -> URL:
    try:
        parsed = make_url(url)
    except ArgumentError:
        raise UnusableInput(f"'{url}' is no database URL; {DEFAULT_URL} would work") from None
    if parsed.get_backend_name() != "sqlite":
        raise UnusableInput(f"'{url}': only SQLite is supported; {DEFAULT_URL} would work")
    return parsed


def _engine(url: str, *, foreign_keys: bool = True) -> Engine:
    """Return the engine of a database, made once: what opens it every minute must not grow.

    Mappers keep the statements that they compiled for each engine; a disposed one opens again.
    """
    parsed = _parsed(url)
    database = parsed.database
    if database and database != ":memory:":
        parsed = parsed.set(database=str(Path(database).absolute()))
    return _made_once(parsed, foreign_keys)


@lru_cache(maxsize=16)
def _made_once(url: URL, foreign_keys: bool) -> Engine:
    engine = create_engine(url)
    event.listen(engine, "connect", partial(_on_connect, foreign_keys))
    event.listen(engine, "begin", _on_begin)
    return engine


def _on_connect(foreign_keys: bool, connection: Any, _record: object) -> None:
    connection.isolation_level = None  # the driver begins nothing by itself: DDL is transactional
    cursor = connection.cursor()
    cursor.execute(f"PRAGMA foreign_keys={'ON' if foreign_keys else 'OFF'}")
    cursor.execute(f"PRAGMA busy_timeout={LOCKED_MS}")
    cursor.close()


def _on_begin(connection: Connection) -> None:
    """Begin; who only reads changes nothing, not even how the file keeps its log."""
    if connection.get_execution_options().get("autodb_writes", False):
        connection.exec_driver_sql("PRAGMA journal_mode=WAL")
        connection.exec_driver_sql("BEGIN IMMEDIATE")
    else:
        connection.exec_driver_sql("BEGIN")


def _missing_file(url: str) -> bool:
    database = make_url(url).database
    return bool(database) and database != ":memory:" and not Path(str(database)).exists()


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


def _revision(engine: Engine, url: str) -> str | None:
    try:
        if not inspect(engine).has_table("alembic_version"):
            return None
        with engine.connect() as connection:
            row = connection.exec_driver_sql("SELECT version_num FROM alembic_version").first()
        return str(row[0]) if row else None
    except (sqlite3.Error, DatabaseError) as error:
        reason = getattr(error, "orig", error)
        raise UnusableInput(
            f"{url}: cannot be opened as a database ({reason}); a SQLite file in a folder that "
            "may be written would work"
        ) from None
