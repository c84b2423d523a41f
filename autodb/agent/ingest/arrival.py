"""One file of an inbox on its way into the database: once, by what it is and not by its name.

It is opened and held, following no link; linked under a hidden name into ``kept/YEAR-MONTH`` of the
inbox, which is checked to be the file that is held; read there; and its import and what became of
it are one transaction, in which it is seen that nobody has written to it meanwhile. Only then does
it leave the inbox, if it is still the one that lies there. Killed between any two of these, the
next look finds the file, knows it by its checksum and goes on. What cannot be read stays where it
is, with the reason, until it or its side file changes.
"""

import errno
import os
import secrets
import shutil
import time
from dataclasses import dataclass
from pathlib import Path

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.ingest.entries import (
    KEPT,
    checksum_files,
    files_beside,
    inbox_entries,
    open_held,
    stamp,
)
from autodb.agent.ingest.importing import Imported, KeepAt, import_file, whole_file
from autodb.agent.rows.machines import find_machine
from autodb.errors import SetAside, UnusableInput
from autodb.files.checksums import checksum
from autodb.files.targets import hidden, sync
from autodb.store import Store, models

NOT_WRITABLE = (errno.EROFS, errno.EACCES, errno.EPERM)
NOT_READABLE = (errno.EACCES, errno.EPERM, errno.ELOOP, errno.ENXIO, errno.EIO, errno.ENODEV)
"""What is wrong with one entry, and not with the inbox or the disk."""


class _Written(Exception):  # noqa: N818 - the file's state, not a program error
    """Somebody writes to the file, or put another one in its place."""


@dataclass(frozen=True)
class _Held:
    """A file that is held open: its stamp, and its size and time when it was opened."""

    file: int
    stamp: str
    size: int
    mtime_ns: int

    def check(self) -> None:
        """Raise _Written where the file is not as it was."""
        now = os.fstat(self.file)
        if (now.st_size, now.st_mtime_ns) != (self.size, self.mtime_ns):
            raise _Written

    def is_at(self, path: Path) -> bool:
        """Say whether the file lies at a path, itself and not by a link."""
        return os.path.samestat(path.lstat(), os.fstat(self.file))


@dataclass(frozen=True)
class Desk:
    """Where files of a machine come in: its database, its inbox, a side file of all of them."""

    store: Store
    machine: str
    inbox: Path
    columns: Path | None = None


class Arrival:
    """One file of an inbox on its way into the database.

    ``came_as``: the path that it came in under, of one that lies in ``kept`` already.
    """

    def __init__(self, desk: Desk, path: Path, came_as: Path | None = None) -> None:
        self._store, self._machine, self._columns = desk.store, desk.machine, desk.columns
        self._folder, self._path = desk.inbox.absolute(), path.absolute()
        self._came_as = came_as
        self._notes: list[str] = []

    def take(self) -> list[str]:
        """Import the file, or keep why not; return what else is to be said."""
        try:
            with open_held(self._path) as file:
                seen, now = stamp(self._path), os.fstat(file)
                if seen is not None:
                    self._taken(_Held(file, seen, now.st_size, now.st_mtime_ns))
        except FileNotFoundError:  # another agent took it
            pass
        except _Written:
            self._notes.append(f"{self._path.name}: still being written; the next pass takes it")
        except (UnusableInput, SetAside) as error:
            self._notes.append(str(error))
        except OSError as error:
            if error.errno not in NOT_READABLE:
                raise
            self._notes.append(f"{self._path.name}: cannot be read ({error.strerror}); it stays")
        return self._notes

    def _taken(self, one: _Held) -> None:
        target, sha256 = self._put(one)
        try:
            for said in checksum_files(self._path):
                if said.is_file():
                    _refuse_damaged(self._path, sha256, said)
            lies_at = self._import(one, target, sha256)
        except (UnusableInput, SetAside) as error:
            self._drop(target)
            one.check()
            self._refuse(one.stamp, sha256, _reason(error, self._path, target))
        except BaseException:
            self._drop(target)
            raise
        else:
            self._leave(one, target, lies_at)

    def _import(self, one: _Held, target: Path, sha256: str) -> Path:
        """Import the file; return where its recording lies from now on."""
        lies: list[Path] = []

        def also(session: Session, imported: Imported) -> None:
            one.check()
            lies.append(self._lie(session, imported, target))
            row = self._row(session, sha256)
            _note(session, row, "imported", one.stamp, recording=imported.recording_id)

        side = self._path.with_suffix(".toml")
        import_file(
            self._store,
            target,
            machine=self._machine,
            columns=self._columns or (side if side.is_file() else None),
            kept=KeepAt(target, also, self._came_as or self._path),
        )
        return lies[-1]

    def _put(self, one: _Held) -> tuple[Path, str]:
        """Have the file lie where it is kept; return where, and its checksum.

        In place where it is kept already, or the inbox cannot be written.
        """
        if self._came_as is not None:
            return self._path, checksum(self._path)
        folder = self._folder / KEPT / time.strftime("%Y-%m", time.gmtime())
        folder /= self._path.parent.relative_to(self._folder)
        try:
            folder.mkdir(parents=True, exist_ok=True)
            return self._put_into(folder, one)
        except OSError as error:
            if error.errno not in NOT_WRITABLE:
                raise
            why = error.strerror
            self._notes.append(f"{self._folder}: cannot be written ({why}); its files stay in it")
        sha256 = checksum(self._path)
        if not one.is_at(self._path):
            raise _Written
        return self._path, sha256

    def _put_into(self, folder: Path, one: _Held) -> tuple[Path, str]:
        target = folder / self._path.name
        with hidden(target) as part:
            self._link(one, part)
            sha256 = checksum(part)
            if target.exists() and checksum(target) != sha256:
                target = named_by(target, sha256)
            if not target.exists():
                sync(part)
                part.rename(target)
                sync(folder)
        return target, sha256

    def _link(self, one: _Held, part: Path) -> None:
        """Make the file that is held lie at ``part``."""
        try:
            os.link(self._path, part, follow_symlinks=False)
        except FileNotFoundError:
            raise
        except OSError:  # another disk, one without links, or another user's file
            with os.fdopen(os.dup(one.file), "rb") as file, part.open("xb") as copy:
                file.seek(0)
                shutil.copyfileobj(file, copy)
            one.check()
        else:
            if not one.is_at(part):
                raise _Written

    def _lie(self, session: Session, imported: Imported, target: Path) -> Path:
        """Return where the recording lies; at ``target`` where it has no other whole file."""
        row = session.get_one(models.StoredRecording, imported.recording_id)
        other = whole_file(row, but=(self._path.resolve(), target.resolve()))
        if other is not None:
            return other
        row.path, row.dropped_at = str(target.resolve()), None
        return target

    def _drop(self, target: Path) -> None:
        """Take away what was put for an import that was not made."""
        if target != self._path and not self._is_kept(target):
            target.unlink(missing_ok=True)

    def _is_kept(self, target: Path) -> bool:
        """Say whether a recording lies there."""
        with self._store.reading() as session:
            query = select(models.StoredRecording.id).where(
                models.StoredRecording.path == str(target.resolve())
            )
            return session.scalar(query.limit(1)) is not None

    def _leave(self, one: _Held, target: Path, lies_at: Path) -> None:
        """Take the file out of the inbox, as its recording lies elsewhere, and what is beside it.

        The file first: alone it could not be read, and would not be known by its checksum.
        """
        kept_there = lies_at == target
        if not kept_there:
            target.unlink(missing_ok=True)
        if target == self._path:
            return
        files = inbox_entries(self._path.parent).files
        alone = [path for path in files if path.stem == self._path.stem]
        others = files_beside(self._path)
        for other in others if kept_there else ():
            ending = other.name.removeprefix(self._path.stem)
            shutil.copyfile(other, target.with_name(f"{target.stem}{ending}"))
        if self._away(one) and len(alone) == 1:
            for other in others:
                other.unlink(missing_ok=True)

    def _away(self, one: _Held) -> bool:
        """Take the file that was read away, and no other that has come to lie in its place."""
        leaving = self._path.with_name(f".{secrets.token_hex(8)}.leaving.{self._path.name}")
        try:
            self._path.rename(leaving)
        except FileNotFoundError:
            return True
        except PermissionError as error:
            self._notes.append(f"{self._path.name}: imported, and stays ({error.strerror})")
            return False
        same = one.is_at(leaving) and os.fstat(one.file).st_size == one.size
        if same:
            leaving.unlink(missing_ok=True)
        else:
            back(leaving, self._path)
        return same

    def _refuse(self, seen: str, sha256: str, reason: str) -> None:
        with self._store.writing(self._machine) as session:
            _note(session, self._row(session, sha256), "refused", seen, reason=reason)

    def _row(self, session: Session, sha256: str) -> models.InboxFile:
        machine_id = find_machine(session, self._machine).id
        row = session.scalar(
            select(models.InboxFile).where(
                models.InboxFile.machine_id == machine_id,
                models.InboxFile.path == str(self._path),
                models.InboxFile.sha256 == sha256,
            )
        )
        if row is None:
            row = models.InboxFile(machine_id=machine_id, path=str(self._path), sha256=sha256)
            session.add(row)
        return row


def named_by(target: Path, sha256: str) -> Path:
    """Return the name of a file beside others of its name: with the checksum's beginning."""
    return target.with_name(f"{target.stem}-{sha256[:8]}{target.suffix}")


def back(leaving: Path, path: Path) -> None:
    """Give a file its name back; another one where a newer file has that."""
    token = leaving.name.split(".")[1]
    for name in (path, path.with_name(f"{path.stem}-{token}{path.suffix}")):
        try:
            os.link(leaving, name, follow_symlinks=False)
        except FileExistsError:
            continue
        except FileNotFoundError:  # another agent did
            return
        except OSError:  # a disk without links
            leaving.rename(name)
            return
        leaving.unlink(missing_ok=True)
        return


def _reason(error: Exception, *paths: Path) -> str:
    """Return why a file was refused, without its path."""
    said = str(error)
    for path in paths:
        said = said.removeprefix(f"{path}: ")
    return said


def _note(
    session: Session,
    row: models.InboxFile,
    status: str,
    seen: str,
    *,
    reason: str | None = None,
    recording: int | None = None,
) -> None:
    """Keep what became of a file; the next pass reports it."""
    row.status, row.reason, row.stamp = status, reason, seen
    row.recording_id, row.refresh_pass_id, row.seen_at = recording, None, models.now()
    session.flush()


def _refuse_damaged(path: Path, sha256: str, said: Path) -> None:
    """Raise UnusableInput where a file is not what a checksum file beside it says."""
    wanted = said.read_text(encoding="utf-8", errors="replace").split()[:1]
    if not wanted or wanted[0].lower() != sha256:
        raise UnusableInput(f"{path}: does not agree with {said.name}; deliver it again")
