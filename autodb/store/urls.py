"""Where a database is: the URL in use, what it may be, and how it is named in messages."""

import os
from pathlib import Path, PureWindowsPath

from sqlalchemy.engine import URL, make_url
from sqlalchemy.exc import ArgumentError

from autodb.errors import UnusableInput
from autodb.wording import phrase

DEFAULT_URL = "sqlite:///autodb.sqlite3"
SERVER_URL = "postgresql://USER@HOST/DATABASE"
"""What the URL of a database on a server looks like."""
SQLITE, POSTGRESQL = "sqlite", "postgresql"
DRIVERS = ("postgresql", "postgresql+psycopg")


def database_url(given: str | None) -> str:
    """Return the URL in use: the given one, else AUTODB_DB, else a file in the working folder.

    The path of a file stands for its URL.
    """
    said = given or os.environ.get("AUTODB_DB") or DEFAULT_URL
    is_path = ":" not in said or PureWindowsPath(said).drive
    return f"{SQLITE}:///{said}" if is_path else said


def parsed(url: str) -> URL:
    """Return the parts of a URL; raises UnusableInput where it is of no database that we use."""
    works = f"use {DEFAULT_URL} or {SERVER_URL}"
    try:
        found = make_url(url)
    except (ArgumentError, ValueError):
        raise UnusableInput(
            phrase("'{url}' is no database URL; {works}", url=url, works=works)
        ) from None
    if found.drivername in DRIVERS:
        if not found.database:
            raise UnusableInput(
                phrase(
                    "{url}: names no database; use {server_url}",
                    url=shown_url(url),
                    server_url=SERVER_URL,
                )
            )
        return found.set(drivername="postgresql+psycopg")
    if found.get_backend_name() != SQLITE:
        raise UnusableInput(
            phrase(
                "'{url}': only SQLite and PostgreSQL are supported; {works}",
                url=shown_url(url),
                works=works,
            )
        )
    return found


def whole_url(url: str) -> str:
    """Return a URL that means the same from every working folder."""
    if on_server(url):
        return url
    return str(make_url(url).set(database=str(file_of(url).resolve())))


def shown_url(url: str) -> str:
    """Return a URL as messages may name it: without its password."""
    found = make_url(url)
    return url if found.password is None else found.render_as_string(hide_password=True)


def on_server(url: str) -> bool:
    """Say whether a database is on a server, and no file."""
    return parsed(url).get_backend_name() == POSTGRESQL


def file_of(url: str) -> Path:
    """Return the file of a database, there or not.

    Raises UnusableInput when the URL is none of a file, or means a database in memory.
    """
    if on_server(url):
        raise UnusableInput(
            phrase(
                "{url}: is on a server, not in a file; use {default_url}",
                url=shown_url(url),
                default_url=DEFAULT_URL,
            )
        )
    database = parsed(url).database
    if database in (None, "", ":memory:"):
        raise UnusableInput(
            phrase(
                "{url}: a database in memory keeps nothing; use {default_url}",
                url=url,
                default_url=DEFAULT_URL,
            )
        )
    path = Path(str(database))
    return path.resolve() if path.is_symlink() else path
