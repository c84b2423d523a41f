"""Whether a database changed: a mark of its state, equal only while all committed rows are."""

import secrets
import threading

from sqlalchemy.engine.interfaces import DBAPIConnection

from autodb.store import Store
from autodb.store.engines import backend_of, is_alone

BETWEEN = "-"


class Watched:
    """Marks the states of a database, over one connection that is held.

    A file that another took the place of, as a restored backup does, is opened again, and so is a
    connection that was lost. One that would keep all others out is not held: marks of two then
    always differ.
    """

    def __init__(self, store: Store) -> None:
        self._store = store
        self._lock = threading.Lock()
        self._held: DBAPIConnection | None = None
        self._file: tuple[int, int] | None = None
        self._began = ""

    def mark(self) -> str:
        """Return the mark of the state that who reads from now on sees, or of one before it."""
        lost = self._store.engine.dialect.loaded_dbapi.Error
        with self._lock:
            file = self._is()
            if self._held is not None and file == self._file:
                try:
                    return self._asked(self._held)
                except lost:
                    self._held = None
            try:
                return self._asked(self._hold(file))
            finally:
                if self._held is not None and is_alone(self._held):
                    self._let_go()

    def close(self) -> None:
        """Give the connection back."""
        with self._lock:
            self._let_go()

    def _let_go(self) -> None:
        if self._held is not None:
            self._held.close()
            self._held = None

    def _asked(self, held: DBAPIConnection) -> str:
        return f"{self._began}{BETWEEN}{backend_of(self._store.engine).state(held)}"

    def _is(self) -> tuple[int, int] | None:
        """Return which file the database is; None on a server."""
        if self._store.path is None:
            return None
        found = self._store.path.stat()
        return found.st_dev, found.st_ino

    def _hold(self, file: tuple[int, int] | None) -> DBAPIConnection:
        self._let_go()
        self._store.engine.dispose()  # connections to the file before
        taken = self._store.engine.raw_connection()
        held = taken.dbapi_connection
        assert held is not None
        taken.detach()
        self._held, self._file = held, file
        self._began = secrets.token_hex(4)  # counts of two connections do not compare
        return held


def opening(mark: str) -> str:
    """Return which opening of the database a mark is of; only within one, rows keep their ids."""
    return mark.partition(BETWEEN)[0]
