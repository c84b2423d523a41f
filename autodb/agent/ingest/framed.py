"""A table in memory on its way into the database: it is kept as a file, from which it is read."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pyarrow as pa
from pyarrow import parquet
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.ingest.arrival import named_by
from autodb.agent.ingest.importing import Imported, KeepAt, TakeBack, import_file, whole_file
from autodb.errors import UnusableInput
from autodb.files.checksums import checksum
from autodb.files.side import SideFile
from autodb.files.targets import hidden, replace_by
from autodb.store import Store, models
from autodb.wording import phrase

FOLDER = "recordings"
"""Where tables are kept: beside the database's file."""
UNNAMED = "frame"
"""What the file of a table is called, with the beginning of its checksum, that has no name."""


@dataclass(frozen=True)
class KeptTable:
    """The file of a table, and the path under which it counts as having come in."""

    path: Path
    came_as: Path


@contextmanager
def kept_table(
    store: Store, table: pa.Table, *, name: str | None = None, folder: Path | None = None
) -> Iterator[KeptTable]:
    """Give the file of a table; it stays where a recording of the database lies there in the end.

    A table of the same ``name`` with other rows is a file beside the first one. ``folder``: where
    it is kept; None: beside the database's file. Raises UnusableInput, naming the table.
    """
    called = _checked(name)
    inside = folder or _beside(store)
    inside.mkdir(parents=True, exist_ok=True)
    target = inside / f"{called}.parquet"
    with hidden(target) as part:
        parquet.write_table(table, part)
        sha256 = checksum(part)
        if name is None or (target.exists() and checksum(target) != sha256):
            target = named_by(target, sha256)
        if not target.exists():
            replace_by(part, target)
        try:
            yield KeptTable(target, target if name is None else inside / f"{called}.parquet")
        except UnusableInput as error:
            raise type(error)(str(error).replace(str(target), called)) from None
        finally:
            if not _is_kept(store, target):
                target.unlink(missing_ok=True)


def import_table(
    store: Store, table: pa.Table, *, machine: str, side: SideFile, name: str | None = None,
    folder: Path | None = None, instead: TakeBack | None = None,
) -> Imported:  # fmt: skip
    """Import a table in memory as ``import_file`` imports a file; raises what that raises."""
    with kept_table(store, table, name=name, folder=folder) as kept:

        def also(session: Session, one: Imported) -> None:
            lies_at(session, one.recording_id, kept.path)

        keep = KeepAt(kept.path, also, kept.came_as)
        return import_file(
            store, kept.path, machine=machine, columns=side, kept=keep, instead=instead
        )


def lies_at(session: Session, recording: int, path: Path) -> None:
    """Have a recording lie at a path, where it has no other whole file."""
    row = session.get_one(models.StoredRecording, recording)
    if whole_file(row, but=(path.resolve(),)) is None:
        row.path, row.dropped_at = str(path.resolve()), None


def _checked(name: str | None) -> str:
    """Return what a file is called; raises UnusableInput for a name that is none of a file."""
    if name is None:
        return UNNAMED
    if not name.strip() or Path(name).name != name or name.startswith("."):
        raise UnusableInput(
            phrase("name '{name}': is no name of a file; use one such as 'week-1'", name=name)
        )
    return name


def _beside(store: Store) -> Path:
    if store.path is None:
        raise UnusableInput(
            phrase("a database on a server has no folder; say in which one to keep tables")
        )
    return store.path.resolve().parent / FOLDER


def _is_kept(store: Store, path: Path) -> bool:
    with store.reading() as session:
        lies = models.StoredRecording.path == str(path.resolve())
        return session.scalar(select(models.StoredRecording.id).where(lies).limit(1)) is not None
