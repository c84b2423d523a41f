"""A server's database as one SQLite file, and back: all rows, as they are stored.

A backup of a server is a file that `autodb restore` puts in place anywhere; a machine's file moves
to a server the same way. Rows are read from one state, and written in one transaction.
"""

from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

from sqlalchemy import JSON, Connection, Select, Table, Text, cast, func, select
from sqlalchemy.exc import DBAPIError

from autodb.errors import UnusableInput
from autodb.files.targets import Progress
from autodb.store import create_store, head, models, open_store, shown_url
from autodb.store.copies import Copied, connect
from autodb.wording import phrase

ROWS_A_STEP = 10_000


def as_stored(table: Table) -> Select[Any]:
    """Return what asks for a table's rows as they are stored, in order of their keys.

    JSON is its text.
    """
    columns = (
        cast(c, Text).label(c.name) if isinstance(c.type, JSON) else c for c in table.columns
    )
    return select(*columns).order_by(*table.primary_key.columns)


def in_steps(connection: Connection, query: Select[Any]) -> Iterator[Sequence[Any]]:
    """Return the rows of a query in steps that fit in memory."""
    streamed = connection.execution_options(stream_results=True, yield_per=ROWS_A_STEP)
    yield from streamed.execute(query).partitions()


def to_file(url: str, target: Path, progress: Progress | None) -> Copied:
    """Copy a server's database into a new SQLite file at the same schema.

    Raises UnusableInput where it is not of this version's schema.
    """
    create_store(f"sqlite:///{target}")
    store, rows = open_store(url), {}
    try:
        with (
            store.reading() as session,
            closing(connect(target)) as file,
        ):
            file.execute("BEGIN")
            for table in models.Base.metadata.sorted_tables:
                if progress:
                    progress(f"table {table.name}")
                names = ", ".join(f'"{column.name}"' for column in table.columns)
                places = ", ".join("?" for _ in table.columns)
                into = f'INSERT INTO "{table.name}" ({names}) VALUES ({places})'
                rows[table.name] = 0
                for some in in_steps(session.connection(), as_stored(table)):
                    file.executemany(into, [tuple(row) for row in some])
                    rows[table.name] += len(some)
            file.execute("COMMIT")
    finally:
        store.close()
    return Copied(rows, head())


def to_server(source: Path, url: str, *, replace: bool, progress: Progress | None) -> None:
    """Put all rows of an SQLite file of this version's schema into a server's database.

    What is there is replaced, with ``replace``, in the same transaction. Raises UnusableInput when
    it holds rows (without), or the server does not take one of the file's.
    """
    create_store(url)
    file, server = open_store(f"sqlite:///{source}"), open_store(url)
    try:
        with file.reading() as old, server.writing() as new:
            held = _rows_of(new.connection())
            if held and not replace:
                raise UnusableInput(
                    phrase(
                        "{url}: holds {held} rows; use another database or --replace",
                        url=shown_url(url),
                        held=held,
                    )
                )
            tables = models.Base.metadata.sorted_tables
            every = ", ".join(f'"{table.name}"' for table in tables)
            new.connection().exec_driver_sql(f"TRUNCATE {every}")
            for table in tables:
                if progress:
                    progress(f"table {table.name}")
                _fill(old.connection(), new.connection(), table)
    except DBAPIError as error:
        if (getattr(error.orig, "sqlstate", None) or "").startswith("22"):
            reason = str(error.orig).splitlines()[0]
            raise UnusableInput(
                phrase(
                    "{source}: the server does not take a value ({reason})",
                    source=source,
                    reason=reason,
                )
            ) from None
        raise
    finally:
        file.close()
        server.close()


def _rows_of(connection: Connection) -> int:
    counts = (
        connection.scalar(select(func.count()).select_from(table)) or 0
        for table in models.Base.metadata.sorted_tables
    )
    return sum(counts)


def _fill(old: Connection, new: Connection, table: Table) -> None:
    """Copy a table's rows, and let the server number new ones behind them."""
    names = ", ".join(f'"{column.name}"' for column in table.columns)
    driver: Any = new.connection.driver_connection
    with (
        driver.cursor() as cursor,
        cursor.copy(f'COPY "{table.name}" ({names}) FROM STDIN') as copy,
    ):
        for some in in_steps(old, as_stored(table)):
            for row in some:
                copy.write_row(tuple(row))
    if "id" in table.columns:
        last = new.scalar(select(func.max(table.c.id)))
        of_ids = func.pg_get_serial_sequence(table.name, "id")
        new.execute(select(func.setval(of_ids, last or 1, last is not None)))
