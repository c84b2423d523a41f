"""A database and its machines; every call opens and closes it, so that threads may share one."""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from autodb.agent.rows.machines import add_machine, machines_at_work, the_machine
from autodb.errors import NotThere
from autodb.files.machine import LATHE, MachineFile, read_machine_file
from autodb.files.toml import checked
from autodb.library.machine import ShopMachine
from autodb.store import create_store, database_url, opened_database, shown_url, whole_url


@dataclass(frozen=True, repr=False)
class Database:
    """A database by its URL. It holds nothing open: threads share it, processes pickle it."""

    url: str

    def machines(self) -> list[str]:
        """Return the names of the machines that are at work."""
        with opened_database(self.url) as store, store.reading() as session:
            return machines_at_work(session)

    def machine(self, name: str | None = None) -> ShopMachine:
        """Return a machine that is there; without a name, the only one.

        Raises UnusableInput naming the machines that there are.
        """
        with opened_database(self.url) as store, store.reading() as session:
            return ShopMachine(self.url, the_machine(session, name))

    def add_machine(
        self, name: str, file: str | os.PathLike[str] | Mapping[str, Any] | None = None
    ) -> ShopMachine:
        """Add a machine and return it; one that is there already and says the same is returned.

        ``file``: its machine file, or what that says; without it, a lathe with x, z and spindle.
        Raises UnusableInput where it is there and differs.
        """
        with opened_database(self.url) as store:
            add_machine(store, name, _said(file))
        return ShopMachine(self.url, name)

    def __repr__(self) -> str:
        return f"Database({shown_url(self.url)!r})"


def _said(file: str | os.PathLike[str] | Mapping[str, Any] | None) -> MachineFile:
    if file is None:
        return LATHE
    if isinstance(file, Mapping):
        return checked(file, MachineFile, where="machine")
    return read_machine_file(Path(file))


def open_database(
    database: str | os.PathLike[str] | None = None, *, create: bool = False
) -> Database:
    """Return a database: of a file by its path, or of any by its URL.

    Without it, the one that AUTODB_DB names, or autodb.sqlite3 in the working folder. ``create``:
    it is made where there is none, and one of an earlier version is brought to this version's.

    Raises UnusableInput where there is none, or it is none of ours.

    >>> import autodb
    >>> db = autodb.open("shop.sqlite3", create=True)
    >>> db.add_machine("lathe-1")
    ShopMachine('lathe-1')
    >>> db.machines()
    ['lathe-1']
    >>> autodb.open("other.sqlite3")
    Traceback (most recent call last):
    autodb.errors.NotThere: sqlite:///other.sqlite3: no database there; ...
    """
    url = database_url(None if database is None else os.fspath(database))
    if create:
        create_store(url)
    try:
        with opened_database(url):
            return Database(whole_url(url))
    except NotThere as error:
        raise NotThere(f"{error}, or open it with create=True") from None
