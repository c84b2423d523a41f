"""How each kind of database is opened, begun and locked.

SQLite takes one writer at a time. PostgreSQL takes one for each machine, by advisory locks that end
with the transaction:

    writing of one machine      shared lock on ALL, then the machine's own
    writing of anything else    exclusive lock on ALL: as SQLite does
    what all machines share     CATALOGUE on top, when something is added to it
    who did what                AUDIT last, when an entry is added to the log

They are always taken in this order, so that no two wait for each other. A machine's ids are given
out under its lock: of one machine, a larger id was kept later, which passes of the refresh rely on.
A writer reads what is committed at each statement (after it had to wait for a lock, a snapshot
from before would lack what the other wrote); a reader sees one state.
"""

import sqlite3
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, Protocol, TypeVar

from sqlalchemy import Connection, Engine, bindparam, create_engine, event, func, select
from sqlalchemy.engine import URL, ExceptionContext
from sqlalchemy.exc import DBAPIError
from sqlalchemy.orm import Session
from sqlalchemy.pool import ConnectionPoolEntry

from autodb.errors import UnusableInput
from autodb.files.targets import naming_file
from autodb.store import rowsums
from autodb.store.urls import POSTGRESQL, SQLITE, parsed
from autodb.wording import phrase

LOCKED_MS = 150_000
"""How long another program's write is waited for. Chosen: a backup of gigabytes is done by then."""
ALL, CATALOGUE, AUDIT = 0x6175746F6462, 0x6175746F6463, 0x6175746F6464
"""Keys of the locks on everything, on what all machines share, and on the audit log. Chosen:
'autodb' in ASCII."""
CONNECT_S = 10
"""How long a server is waited for that does not answer."""
BACK_S, AGAIN_S = 60.0, 0.5
"""How long a server is waited for that went away, and how often it is asked. Chosen: a restart."""
WRITES, MACHINE = "autodb_writes", "autodb_machine"
AWAY = ("57P01", "57P02", "57P03", "08")
"""What SQLSTATEs begin with that say that the server went away or starts (PostgreSQL, app. A)."""
AGAIN = ("40001", "40P01")
"""SQLSTATEs of transactions that the server gave up for another's sake."""


Done = TypeVar("Done")
NO_ROOM_TO_SHARE = ("SQLITE_IOERR_SHMSIZE", "SQLITE_IOERR_SHMMAP", "SQLITE_IOERR_SHMOPEN")
"""What SQLite says where it cannot make the file by which those who have a log open share it."""


def open_sqlite(*where: Any, **how: Any) -> sqlite3.Connection:
    """Return a connection to an SQLite file, which may be read where its disk is full.

    There it is alone: the index of the log is kept in memory, and others wait until it is closed.
    """
    connection = rowsums.register(sqlite3.connect(*where, **how))
    try:
        connection.execute("PRAGMA schema_version").fetchone()
    except sqlite3.DatabaseError as error:  # of any other, whoever uses the connection is told
        if getattr(error, "sqlite_errorname", None) in NO_ROOM_TO_SHARE:
            connection.close()
            connection = rowsums.register(sqlite3.connect(*where, **how))
            connection.execute("PRAGMA locking_mode=EXCLUSIVE")
    return connection


def is_alone(connection: Any) -> bool:
    """Say whether a driver's connection keeps all others out for as long as it is there."""
    if not isinstance(connection, sqlite3.Connection):
        return False
    return bool(connection.execute("PRAGMA locking_mode").fetchone()[0] == "exclusive")


class Backend(Protocol):
    """A kind of database."""

    @property
    def reading(self) -> Mapping[str, Any]:
        """Execution options of who only reads."""

    def made(self, url: URL, *, foreign_keys: bool) -> Engine:
        """Return a new engine."""

    def state(self, driver: Any) -> str:
        """Return what differs once anything is committed, asked over one driver's connection."""


@dataclass(frozen=True)
class _SQLite:
    reading: Mapping[str, Any]

    def made(self, url: URL, *, foreign_keys: bool) -> Engine:
        """Return a new engine."""
        engine = create_engine(url)
        event.listen(engine, "do_connect", self._do_connect)
        event.listen(engine, "checkin", self._on_checkin)
        event.listen(engine, "connect", partial(self._on_connect, foreign_keys))
        event.listen(engine, "begin", self._on_begin)
        event.listen(engine, "handle_error", partial(self._on_error, Path(str(url.database))))
        return engine

    @staticmethod
    def _do_connect(_dialect: object, _record: object, at: Any, how: Any) -> sqlite3.Connection:
        return open_sqlite(*at, timeout=LOCKED_MS / 1000.0, **how)

    @staticmethod
    def _on_checkin(connection: Any, record: ConnectionPoolEntry) -> None:
        """Let others in, where the one that is given back keeps them out."""
        if connection is not None and is_alone(connection):
            record.invalidate()

    @staticmethod
    def _on_error(path: Path, context: ExceptionContext) -> None:
        """Have errors name the file: of a full disk, it says which."""
        naming_file(context.original_exception, path)

    @staticmethod
    def _on_connect(foreign_keys: bool, connection: Any, _record: object) -> None:
        connection.isolation_level = None  # the driver begins nothing by itself: DDL transactional
        cursor = connection.cursor()
        cursor.execute(f"PRAGMA foreign_keys={'ON' if foreign_keys else 'OFF'}")
        cursor.execute(f"PRAGMA busy_timeout={LOCKED_MS}")
        cursor.close()

    @staticmethod
    def _on_begin(connection: Connection) -> None:
        """Begin; who only reads changes nothing, not even how the file keeps its log."""
        if connection.get_execution_options().get(WRITES, False):
            connection.exec_driver_sql("PRAGMA journal_mode=WAL")
            connection.exec_driver_sql("BEGIN IMMEDIATE")
        else:
            connection.exec_driver_sql("BEGIN")

    def state(self, driver: Any) -> str:
        """Return the number of commits by other connections that this one has seen."""
        return str(driver.execute("PRAGMA data_version").fetchone()[0])


@dataclass(frozen=True)
class _PostgreSQL:
    reading: Mapping[str, Any]

    def made(self, url: URL, *, foreign_keys: bool) -> Engine:
        """Return a new engine; raises UnusableInput where the extra is not installed."""
        del foreign_keys  # changing a table copies nothing here: they may stay on
        try:
            engine = create_engine(
                url, pool_pre_ping=True, connect_args={"connect_timeout": CONNECT_S}
            )
        except ImportError:
            raise UnusableInput(
                phrase("PostgreSQL needs the extra 'postgres'; run pip install 'autodb[postgres]'")
            ) from None
        event.listen(engine, "begin", self._on_begin)
        return engine

    @staticmethod
    def _on_begin(connection: Connection) -> None:
        options = connection.get_execution_options()
        if not options.get(WRITES, False):
            return
        connection.exec_driver_sql(f"SET LOCAL lock_timeout = {LOCKED_MS}")
        machine = options.get(MACHINE)
        if machine is None:
            connection.execute(select(func.pg_advisory_xact_lock(ALL)))
            return
        connection.execute(select(func.pg_advisory_xact_lock_shared(ALL)))
        own = func.hashtextextended(bindparam("machine", machine), ALL)
        connection.execute(select(func.pg_advisory_xact_lock(own)))

    def state(self, driver: Any) -> str:
        """Return which transactions a statement would see now."""
        driver.autocommit = True
        return str(driver.execute("SELECT pg_current_snapshot()::text").fetchone()[0])


BACKENDS: Mapping[str, Backend] = {
    SQLITE: _SQLite({}),
    POSTGRESQL: _PostgreSQL({"isolation_level": "REPEATABLE READ", "postgresql_readonly": True}),
}


def backend_of(engine: Engine) -> Backend:
    """Return what kind of database an engine opens."""
    return BACKENDS[engine.dialect.name]


def engine_of(url: str, *, foreign_keys: bool = True) -> Engine:
    """Return the engine of a database, made once: what opens it every minute must not grow.

    Mappers keep the statements that they compiled for each engine; a disposed one opens again.
    Raises UnusableInput where the URL is of no database that we use, or its extra is not installed.
    """
    found = parsed(url)
    database = found.database
    if found.get_backend_name() == SQLITE and database and database != ":memory:":
        found = found.set(database=str(Path(database).absolute()))
    return _made_once(found, foreign_keys)


@lru_cache(maxsize=16)
def _made_once(url: URL, foreign_keys: bool) -> Engine:
    return BACKENDS[url.get_backend_name()].made(url, foreign_keys=foreign_keys)


def lock_catalogue(session: Session) -> None:
    """Let no other add to what all machines share (materials, tools, pairs) until this commits."""
    if session.get_bind().dialect.name == POSTGRESQL:
        session.execute(select(func.pg_advisory_xact_lock(CATALOGUE)))


def lock_audit(session: Session) -> None:
    """Let no other add to the audit log until this commits."""
    if session.get_bind().dialect.name == POSTGRESQL:
        session.execute(select(func.pg_advisory_xact_lock(AUDIT)))


def retried(work: Callable[[], Done], tell: Callable[[str], None] = lambda _: None) -> Done:
    """Do work that may be done again; where the server goes away meanwhile, once it is back.

    Raises the server's error where it stays away.
    """
    until = time.monotonic() + BACK_S
    while True:
        try:
            return work()
        except DBAPIError as error:
            if not is_away(error) or time.monotonic() > until:
                raise
        tell("the database's server went away; trying again")
        time.sleep(AGAIN_S)


def is_away(error: Exception) -> bool:
    """Say whether a server went away, starts, or gave a transaction up: it may be tried again."""
    if not isinstance(error, DBAPIError) or type(error.orig).__module__.startswith("sqlite3"):
        return False
    state = getattr(error.orig, "sqlstate", None)
    if state is None:  # of a connection that is lost, or was never made
        return error.connection_invalidated or type(error.orig).__name__ == "OperationalError"
    return str(state).startswith((*AWAY, *AGAIN))
