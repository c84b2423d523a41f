"""The database: one file or server, opened only at the schema this version knows.

SQLite with foreign keys and write-ahead log, or PostgreSQL. Every change is one transaction: a
process killed in the middle leaves the database as it was before.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from sqlalchemy import Engine, inspect
from sqlalchemy.orm import Session

from autodb.errors import NotThere, UnusableInput
from autodb.store import rowsums
from autodb.store.engines import (
    MACHINE,
    WRITES,
    backend_of,
    engine_of,
    lock_audit,
    lock_catalogue,
    retried,
)
from autodb.store.schemas import (
    head,
    make_in,
    migrate,
    none_of,
    pointing_nowhere,
    revision_of,
    revisions,
    schema_faults,
    trigger_faults,
)
from autodb.store.urls import (
    DEFAULT_URL,
    SQLITE,
    database_url,
    file_of,
    on_server,
    shown_url,
    whole_url,
)
from autodb.wording import phrase

__all__ = [
    "DEFAULT_URL",
    "Also",
    "Created",
    "Store",
    "create_store",
    "database_url",
    "file_of",
    "head",
    "lock_audit",
    "lock_catalogue",
    "migrate",
    "nothing_else",
    "on_server",
    "open_store",
    "opened_database",
    "pointing_nowhere",
    "retried",
    "revisions",
    "shown_url",
    "whole_url",
]


Also = Callable[[Session, int], None]
"""What else is written in the transaction that writes a row, by its number."""


def nothing_else(_session: Session, _number: int) -> None:
    """Write nothing beside a row."""


class Store:
    """An open database."""

    def __init__(self, engine: Engine) -> None:
        self.engine = engine

    @cached_property
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
    named = shown_url(url)
    if not on_server(url) and not file_of(url).exists():
        raise NotThere(
            phrase("{named}: no database there; make one with 'autodb init'", named=named)
        )
    try:
        _check_schema(engine, url, any_schema=any_schema)
    except UnusableInput:
        engine.dispose()  # a connection keeps what it read of the schema
        raise
    return Store(engine)


@contextmanager
def opened_database(url: str) -> Iterator[Store]:
    """Open a database as ``open_store`` does, and close it again."""
    store = open_store(url)
    try:
        yield store
    finally:
        store.close()


def _check_schema(engine: Engine, url: str, *, any_schema: bool) -> None:
    """Raise UnusableInput where a database has none of ours, or another than this version's."""
    named = shown_url(url)
    found = revision_of(engine, url)
    if found is None:
        raise UnusableInput(
            phrase("{named}: no autodb database; make one with 'autodb init'", named=named)
        )
    if found != head() and not any_schema:
        works = "run 'autodb init'" if found in revisions() else "install a newer autodb"
        raise UnusableInput(
            phrase(
                "{named}: schema {found}, this version needs {value}; {works}",
                named=named,
                found=found,
                value=head(),
                works=works,
            )
        )
    if not (any_schema or on_server(url)):
        _runs_nothing_else(engine, named)


def _runs_nothing_else(engine: Engine, named: str) -> None:
    """Raise UnusableInput where a write would run what is not ours, or keep no checksum."""
    with engine.connect() as connection:
        strange = trigger_faults(rowsums.driver_of(connection))
    if strange:
        raise UnusableInput(
            phrase(
                "{named}: {strange}; restore a backup or an export with 'autodb restore'",
                named=named,
                strange=strange[0],
            )
        )


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
    engine, named = engine_of(url), shown_url(url)
    try:
        found = revision_of(engine, url)
        if found is None and inspect(engine).get_table_names():
            new = "database" if on_server(url) else "file"
            raise UnusableInput(
                phrase(
                    "{named}: holds another program's tables; use a new {new}", named=named, new=new
                )
            )
        if found is not None and found not in revisions():
            raise UnusableInput(
                phrase(
                    "{named}: schema {found} is not known to this version, which knows up to "
                    "{value}; install a newer autodb",
                    named=named,
                    found=found,
                    value=head(),
                )
            )
    finally:
        engine.dispose()
    if found is None:
        _make(url)
    elif found != head():
        _holds_its_schema(engine, url, found)
        migrate(url, head())
    return Created(found, head())


def _holds_its_schema(engine: Engine, url: str, revision: str) -> None:
    """Raise UnusableInput where a file of an earlier version is not what that version made."""
    if on_server(url):
        return
    with engine.connect() as connection:
        strange = schema_faults(rowsums.driver_of(connection), revision)
    engine.dispose()
    none_of(strange, url)


def _make(url: str) -> None:
    """Make the tables that this version's models state, in one transaction."""
    engine = engine_of(url)
    try:
        with engine.connect().execution_options(**{WRITES: True}) as connection:
            if not inspect(connection).has_table("alembic_version"):  # another did it meanwhile
                make_in(connection)
            connection.commit()
    finally:
        engine.dispose()
