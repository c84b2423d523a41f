"""Restore a database from a backup file or an export folder: by one rename, or one transaction."""

import sqlite3
from contextlib import closing
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory

from autodb.errors import UnusableInput, no_such_file
from autodb.files.targets import LOGS, Progress, hidden, needs_folder, replace_by
from autodb.store import create_store, file_of, head, on_server
from autodb.store.copies import Copied, connect, copy_of, row_counts, settle, stored_schema_of
from autodb.store.exports import load_export
from autodb.store.moving import to_server
from autodb.wording import phrase


def restore(
    url: str, source: Path, *, replace: bool = False, progress: Progress | None = None
) -> Copied:
    """Make a backup file or an export folder the database, brought to this version's schema.

    Raises UnusableInput when ``source`` is neither, is damaged, or comes from a later version, when
    the database holds rows (without ``replace``), or when another program has it open.
    """
    if not source.exists():
        raise no_such_file(source)
    if on_server(url):
        with TemporaryDirectory() as folder:
            file = Path(folder) / "restored.sqlite3"
            copied = _made(source, file, progress)
            to_server(file, url, replace=replace, progress=progress)
        return copied
    target = file_of(url)
    needs_folder(target)
    with hidden(target, progress) as partial:
        _may_be_replaced(target, replace=replace)
        copied = _made(source, partial, progress)
        settle(partial)
        _put_in_place(partial, target)
    return copied


def _made(source: Path, file: Path, progress: Progress | None) -> Copied:
    """Make a database file of a backup or an export, and bring it to this version's schema."""
    if source.is_dir():
        copied = load_export(source, file, progress=progress)
    else:
        copied = copy_of(source, file, progress)
    if progress:
        progress(f"schema {copied.schema} to {head()}")
    create_store(f"sqlite:///{file}")
    return copied


def _may_be_replaced(target: Path, *, replace: bool) -> None:
    """Raise UnusableInput when the file at ``target`` may not be replaced by a restored one."""
    if not target.exists():
        for beside in (target.with_name(f"{target.name}{end}") for end in ("-wal", "-journal")):
            if beside.exists():
                raise UnusableInput(
                    phrase("{beside}: lies there without its database; move it away", beside=beside)
                )
        return
    try:
        with closing(connect(target)) as old:
            held = row_counts(old)
            if held:
                stored_schema_of(old, target)
    except sqlite3.DatabaseError as error:
        if replace:
            return  # what cannot be read is set aside, not lost
        raise UnusableInput(
            phrase(
                "{target}: is there and cannot be read as a database ({error}); move it aside "
                "with --replace, or use another --db",
                target=target,
                error=error,
            )
        ) from None
    if any(held.values()) and not replace:
        raise UnusableInput(
            phrase(
                "{target}: holds {values} rows; use another --db or --replace",
                target=target,
                values=sum(held.values()),
            )
        )


def _put_in_place(partial: Path, target: Path) -> None:
    """Give ``partial`` the name of the database, which nobody else may have open."""
    if target.exists():
        try:
            with closing(connect(target)) as old:
                # What the write-ahead log holds goes into the old file, so that no log is left
                # behind that SQLite would take for the new one's
                old.execute("PRAGMA journal_mode=DELETE")
                old.execute("BEGIN EXCLUSIVE")
                replace_by(partial, target, in_use=True)
        except sqlite3.OperationalError as error:
            if "locked" in str(error):
                raise UnusableInput(
                    phrase(
                        "{target}: another program has it open ({error}); close that program",
                        target=target,
                        error=error,
                    )
                ) from None
            raise UnusableInput(
                phrase("{target}: cannot be replaced ({error})", target=target, error=error)
            ) from None
        except sqlite3.DatabaseError:
            _set_aside(target)
            replace_by(partial, target, in_use=True)
    else:
        replace_by(partial, target, in_use=True)


def _set_aside(target: Path) -> None:
    """Rename a file that is no database any more, with its logs: nothing is thrown away."""
    names = (f"{target.name}.damaged{number or ''}" for number in count())
    aside = next(n for n in names if not target.with_name(n).exists())
    for end in (*LOGS, ""):
        part = target.with_name(f"{target.name}{end}")
        if part.exists():
            part.replace(target.with_name(f"{aside}{end}"))
