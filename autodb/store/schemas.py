"""The schema: its revisions, how a new database is made, and one brought to another revision."""

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

from autodb.assets import kit
from autodb.errors import UnusableInput
from autodb.files.excuses import full_under, is_full
from autodb.store import rowsums
from autodb.store.engines import WRITES, engine_of
from autodb.store.urls import SQLITE, on_server, shown_url


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
        raise UnusableInput(f"{url}: {faults[0]}; restore a backup with 'autodb restore'")


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
            "name an existing database on a server that answers"
            if on_server(url)
            else "use a SQLite file in a folder that can be written to"
        )
        raise UnusableInput(
            f"{shown_url(url)}: cannot be opened as a database ({reason}); {works}"
        ) from None
