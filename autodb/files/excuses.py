"""Errors that input or surroundings are to blame for, in one line each."""

import errno
import os
import sqlite3
from pathlib import Path

from autodb.errors import UnusableInput

NO_ROOM = (errno.ENOSPC, errno.EDQUOT)
"""Of a full disk, and of a share of it that is used up."""
DOCTOR = "run 'autodb doctor'"


def excuse(error: Exception) -> str | None:
    """Return the line for an error that input or surroundings are to blame for, else None."""
    if isinstance(error, UnusableInput):
        return str(error)
    if is_full(error):
        return full_under(getattr(getattr(error, "orig", error), "filename", None))
    if isinstance(error, OSError):
        where = f"{error.filename}: " if error.filename else ""
        return f"{where}{error.strerror or error}"
    return _of_the_database(error)


def is_full(error: BaseException) -> bool:
    """Say whether an error of the system, or of an SQLite file, is that of a full disk."""
    cause = getattr(error, "orig", error)
    if isinstance(cause, sqlite3.Error):
        return getattr(cause, "sqlite_errorname", None) == "SQLITE_FULL"
    return isinstance(cause, OSError) and cause.errno in NO_ROOM


def full_under(name: str | bytes | None) -> str:
    """Return the line for a full disk that a file, or a folder, of this name lies on."""
    if not name:
        return "disk full; make room on the disk"
    place = Path(os.fsdecode(name)).absolute()
    return f"disk full under {place if place.is_dir() else place.parent}; make room on the disk"


def _of_the_database(error: Exception) -> str | None:
    """Return the line for what the database cannot do: locked, read-only, damaged, away."""
    cause = getattr(error, "orig", error)
    if type(cause).__module__.startswith("psycopg"):
        said = str(cause).splitlines()[0]
        return f"the database: {said}; {_of_a_server(str(getattr(cause, 'sqlstate', None)))}"
    if not type(cause).__module__.startswith("sqlite3"):
        return None
    works = {
        "locked": "wait until the other program that writes to it is done",
        "readonly": "give write permission, or use another database",
    }
    known = next((text for word, text in works.items() if word in str(cause)), None)
    return f"the database: {cause}; {known or DOCTOR}"


def _of_a_server(state: str) -> str:
    """Return the remedy after an error of a server, by its SQLSTATE (PostgreSQL, app. A)."""
    works = {
        "None": "try again when the server answers",
        "08": "try again when the server answers",
        "57P": "try again when the server answers",
        "40": "nothing was changed, try again",
        "55P03": "wait until the other program that writes to it is done",
        "25006": "use a database that can be written to",
        "42501": "use a database role that may do that",
        "53100": "make room on the server's disk",
    }
    known = next((text for begin, text in works.items() if state.startswith(begin)), None)
    return known or DOCTOR
