"""What an inbox keeps, held against the database: recordings that it does not know as they are."""

import hashlib
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.ingest.arrival import named_by
from autodb.agent.ingest.entries import KEPT, files_beside, inbox_entries, open_held, size_by_stamp
from autodb.errors import UnusableInput
from autodb.files.checksums import checksum
from autodb.files.targets import hidden, replace_by
from autodb.store import models
from autodb.wording import phrase

COPIED = ".parquet"
"""Ending that the compressed copy of a recording has after its name."""
BLOCK_BYTES = 1 << 20


@dataclass(frozen=True)
class Grown:
    """What of a file is in the database: its first bytes, with their checksum."""

    size: int
    sha256: str


@dataclass(frozen=True)
class Unread:
    """A file that is kept and not in the database as it is; ``grown``: from what."""

    path: Path
    stamp: str
    came_as: Path
    grown: Grown | None = None


@dataclass(frozen=True)
class _Known:
    """A recording's file: the path that it came in by, and its size then, as far as it is known."""

    came_as: str
    sha256: str
    size: int | None


def every_unread(session: Session) -> dict[str, list[Unread]]:
    """Return what inboxes keep and the database has not as it is, by machine."""
    found: dict[str, list[Unread]] = {}
    for machine in session.scalars(select(models.Machine).order_by(models.Machine.id)):
        for folder in kept_folders(session, machine.id):
            found.setdefault(machine.name, []).extend(unread(session, machine.id, folder))
    return {name: some for name, some in found.items() if some}


def kept_folders(session: Session, machine_id: int) -> list[Path]:
    """Return the folders in which a machine's inboxes keep recordings."""
    paths = session.scalars(
        select(models.StoredRecording.path).where(
            models.StoredRecording.machine_id == machine_id,
            models.StoredRecording.delivered_as != models.StoredRecording.path,
        )
    )
    above = [folder for path in paths for folder in Path(path).parents if folder.name == KEPT]
    return list(dict.fromkeys(above))


def unread(session: Session, machine_id: int, folder: Path) -> list[Unread]:
    """Return the recordings in a ``kept`` that a machine has not, or that have grown since.

    Neither are refused ones, as long as they stay as they are, nor copies of ones that are known.
    """
    files = {path.resolve(): seen for path, seen in inbox_entries(folder).files.items()}
    known, refused = _known(session, machine_id), _refused(session, machine_id)
    return [
        one
        for path, seen in sorted(files.items())
        if refused.get(str(path)) != seen
        for one in _looked_at(path, seen, known, folder.resolve())
    ]


def _known(session: Session, machine_id: int) -> dict[str, _Known]:
    rows = session.execute(
        select(
            models.StoredRecording.path,
            models.StoredRecording.stored_path,
            models.StoredRecording.delivered_as,
            models.StoredRecording.sha256,
            models.InboxFile.stamp,
        )
        .outerjoin(models.InboxFile, models.InboxFile.recording_id == models.StoredRecording.id)
        .where(models.StoredRecording.machine_id == machine_id)
    )
    found = {}
    for path, stored, came_as, sha256, seen in rows:
        size = None if seen is None else size_by_stamp(seen)
        found[path] = _Known(came_as or path, sha256, size)
        if stored is not None and stored != path:
            found[stored] = _Known(came_as or path, sha256, None)
    return found


def _refused(session: Session, machine_id: int) -> dict[str, str | None]:
    query = select(models.InboxFile).where(
        models.InboxFile.machine_id == machine_id, models.InboxFile.status == "refused"
    )
    return {row.path: row.stamp for row in session.scalars(query)}


def _looked_at(path: Path, seen: str, known: dict[str, _Known], kept: Path) -> Iterator[Unread]:
    one, size = known.get(str(path)), size_by_stamp(seen)
    if one is None:
        whole = path.with_suffix("")
        if path.suffix != COPIED or not (str(whole) in known or whole.exists()):
            yield Unread(path, seen, _came_as(path, kept))
    elif one.size is not None and size > one.size:
        yield Unread(path, seen, Path(one.came_as), Grown(one.size, one.sha256))


def _came_as(path: Path, kept: Path) -> Path:
    """Return what a kept file was called in the inbox: there its month is not in its path."""
    return kept.parent / Path(*path.relative_to(kept).parts[1:])


def parted(path: Path, grown: Grown) -> Path:
    """Have a kept file that has grown lie under a name of its own; return that.

    Under the one that it had lies what it was again, and a logger that still writes to it goes on
    in the other. Raises UnusableInput where it does not begin with what it was.
    """
    with open_held(path) as file, hidden(path) as part, part.open("xb") as was:
        begins = hashlib.sha256()
        for block in _blocks(file, grown.size):
            begins.update(block)
            was.write(block)
        was.close()
        if begins.hexdigest() != grown.sha256:
            raise UnusableInput(
                phrase(
                    "{file}: its beginning differs from what was imported; put the imported file "
                    "back",
                    file=path,
                )
            )
        new = named_by(path, checksum(path))
        if not new.exists():
            os.link(path, new)
        for other in files_beside(path):
            ending = other.name.removeprefix(path.stem)
            new.with_name(f"{new.stem}{ending}").write_bytes(other.read_bytes())
        replace_by(part, path)
    return new


def _blocks(file: int, size: int) -> Iterator[bytes]:
    """Return the first bytes of an open file."""
    at = 0
    while at < size:
        block = os.pread(file, min(BLOCK_BYTES, size - at), at)
        if not block:
            return
        at += len(block)
        yield block
