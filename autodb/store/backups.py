"""Backups: one file that holds one state of a database, taken while others write to it."""

import sqlite3
from contextlib import closing
from pathlib import Path

from autodb.errors import UnusableInput
from autodb.files.targets import LOGS, Progress, hidden, needs_folder, replace_by
from autodb.store import file_of, on_server
from autodb.store.copies import Copied, connect, copy_of, same_folder, settle, stored_schema_of
from autodb.store.moving import to_file
from autodb.wording import phrase


def backup(
    url: str, target: Path, *, replace: bool = False, progress: Progress | None = None
) -> Copied:
    """Copy one state of a database into an SQLite file while others may be writing to it.

    Raises UnusableInput when there is no database, ``target`` is there (without ``replace``), or
    the copy is not sound.
    """
    source = None if on_server(url) else file_of(url)
    if source is not None and not source.is_file():
        raise UnusableInput(
            phrase("{url}: no database there; make one with 'autodb init'", url=url)
        )
    target = target.resolve() if target.is_symlink() else target
    needs_folder(target)
    with hidden(target, progress) as partial:
        _may_be_written(target, source, replace=replace)
        if source is None:
            copied = to_file(url, partial, progress)
        else:
            copied = copy_of(source, partial, progress)
        settle(partial)
        replace_by(partial, target)
    return copied


def _may_be_written(target: Path, source: Path | None, *, replace: bool) -> None:
    """Raise UnusableInput where a backup would take the place of anything but a backup."""
    logs = set() if source is None else {f"{source.name}{end}" for end in LOGS}
    if source is not None and target.name in logs and same_folder(target, source):
        raise UnusableInput(
            phrase(
                "{target}: is the name of the database's own log; use another name", target=target
            )
        )
    if not target.exists():
        return
    if not target.is_file() or (source is not None and target.samefile(source)):
        raise UnusableInput(
            phrase(
                "{target}: cannot be a backup file; use a new name, or a folder with --keep",
                target=target,
            )
        )
    if not replace:
        raise UnusableInput(
            phrase("{target}: is there already; use another name or --replace", target=target)
        )
    try:
        with closing(connect(target)) as old:
            stored_schema_of(old, target)
    except sqlite3.DatabaseError as error:
        raise UnusableInput(
            phrase(
                "{target}: is no backup, so it is not replaced ({error}); use a new name",
                target=target,
                error=error,
            )
        ) from None
