"""Errors that input or surroundings are to blame for, in one line each."""

import errno
import os
import sqlite3
from pathlib import Path

from autodb.errors import UnusableInput, behind_name
from autodb.wording import msgid, phrase

NO_ROOM = (errno.ENOSPC, errno.EDQUOT)
"""Of a full disk, and of a share of it that is used up."""
DOCTOR = msgid("run 'autodb doctor'")
SYSTEM = {
    errno.ENOENT: msgid("No such file or directory"),
    errno.EACCES: msgid("Permission denied"),
    errno.EPERM: msgid("Operation not permitted"),
    errno.EROFS: msgid("Read-only file system"),
    errno.EISDIR: msgid("Is a directory"),
    errno.ENOTDIR: msgid("Not a directory"),
    errno.EEXIST: msgid("File exists"),
    errno.ENAMETOOLONG: msgid("File name too long"),
}
"""What the system says of a file, in its own words (POSIX, strerror)."""


def excuse(error: Exception) -> str | None:
    """Return the line for an error that input or surroundings are to blame for, else None."""
    if isinstance(error, UnusableInput):
        return str(error)
    if is_full(error):
        return full_under(getattr(getattr(error, "orig", error), "filename", None))
    if isinstance(error, OSError):
        said = (
            phrase(SYSTEM[error.errno]) if error.errno in SYSTEM else str(error.strerror or error)
        )
        return behind_name(error.filename, said) if error.filename else said
    return _of_the_database(error)


def system_words(error: OSError) -> str:
    """Return what the system says of a file, for the reader."""
    if error.errno in SYSTEM:
        return phrase(SYSTEM[error.errno])
    return str(error.strerror or error)


def is_full(error: BaseException) -> bool:
    """Say whether an error of the system, or of an SQLite file, is that of a full disk."""
    cause = getattr(error, "orig", error)
    if isinstance(cause, sqlite3.Error):
        return getattr(cause, "sqlite_errorname", None) == "SQLITE_FULL"
    return isinstance(cause, OSError) and cause.errno in NO_ROOM


def full_under(name: str | bytes | None) -> str:
    """Return the line for a full disk that a file, or a folder, of this name lies on."""
    if not name:
        return phrase("disk full; make room on the disk")
    place = Path(os.fsdecode(name)).absolute()
    folder = place if place.is_dir() else place.parent
    return phrase("disk full under {folder}; make room on the disk", folder=folder)


def _of_the_database(error: Exception) -> str | None:
    """Return the line for what the database cannot do: locked, read-only, damaged, away."""
    cause = getattr(error, "orig", error)
    if type(cause).__module__.startswith("psycopg"):
        said = str(cause).splitlines()[0]
        return phrase(
            "the database: {said}; {cause}",
            said=said,
            cause=_of_a_server(str(getattr(cause, "sqlstate", None))),
        )
    if not type(cause).__module__.startswith("sqlite3"):
        return None
    works = {
        "locked": phrase("wait until the other program that writes to it is done"),
        "readonly": phrase("give write permission, or use another database"),
    }
    known = next((text for word, text in works.items() if word in str(cause)), None)
    return phrase("the database: {said}; {cause}", said=cause, cause=known or phrase(DOCTOR))


def _of_a_server(state: str) -> str:
    """Return the remedy after an error of a server, by its SQLSTATE (PostgreSQL, app. A)."""
    works = {
        "None": phrase("try again when the server answers"),
        "08": phrase("try again when the server answers"),
        "57P": phrase("try again when the server answers"),
        "40": phrase("nothing was changed, try again"),
        "55P03": phrase("wait until the other program that writes to it is done"),
        "25006": phrase("use a database that can be written to"),
        "42501": phrase("use a database role that may do that"),
        "53100": phrase("make room on the server's disk"),
    }
    known = next((text for begin, text in works.items() if state.startswith(begin)), None)
    return known or phrase(DOCTOR)
