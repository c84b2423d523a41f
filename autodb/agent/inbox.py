"""A machine's inbox: recordings that lie in a folder enter the database and are kept beside it.

A file is first linked into ``kept/YEAR-MONTH`` of the inbox, then its import and what became of it
are one transaction, then it leaves the inbox: killed between any two of them, the next look finds
the file, knows it by its checksum and goes on. What cannot be read stays where it is, with the
reason, until it or its side file changes.
"""

import errno
import os
import shutil
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.importing import Imported, Kept, import_file, whole_file
from autodb.agent.machines import find_machine
from autodb.errors import SetAside, UnusableInput
from autodb.files.checksums import checksum
from autodb.files.targets import hidden, replace_by
from autodb.sidefile import read_sidefile
from autodb.store import Store, models

KEPT = "kept"
BESIDE = (".toml", ".sha256")
"""Endings of files that go with a recording and are none."""
UNFINISHED = (".part", ".partial", ".tmp", ".crdownload", ".filepart")
SETTLED_S = 2.0
"""How long a file's size and time must stay before it counts as written. Chosen."""
NOT_WRITABLE = (errno.EROFS, errno.EACCES, errno.EPERM)
ASKED_AT_ONCE = 500
Progress = Callable[[str], None]


@dataclass(frozen=True)
class Inbox:
    """A folder that recordings come into; ``columns``: their side file, in place of their own.

    ``settled_s``: how long a file must stay as it is before it is read.
    """

    folder: Path
    columns: Path | None = None
    settled_s: float = SETTLED_S

    def take_in(self, store: Store, machine: str, progress: Progress = lambda _: None) -> list[str]:
        """Import what lies in the inbox, the oldest first by what its side file says, then by name.

        What became of each file is kept for the next pass to report. Returns what else is to be
        said. Raises UnusableInput where the inbox is no folder or the machine is not known.
        """
        if not self.folder.is_dir():
            raise UnusableInput(f"{self.folder}: no such folder; one that is there would work")
        found = stamps(self.folder)
        with store.reading() as session:
            new = _new(session, find_machine(session, machine).id, found)
        settled, growing = _settled(new, self.settled_s)
        notes = [f"{path.name}: still being written; the next pass takes it" for path in growing]
        for number, path in enumerate(sorted(settled, key=_order), start=1):
            progress(f"importing {number} of {len(settled)}: {path.name}")
            notes += _Arrival(store, machine, self, path).take()
        return list(dict.fromkeys(notes))


def stamps(inbox: Path) -> dict[Path, str]:
    """Return the files of an inbox that may be recordings, with sizes and times to know them by."""
    found = {}
    for folder, folders, names in os.walk(inbox):
        folders[:] = [one for one in folders if one != KEPT and not one.startswith(".")]
        for name in names:
            path = Path(folder) / name
            ending = path.suffix.lower()
            if not name.startswith(".") and ending not in (*BESIDE, *UNFINISHED):
                stamp = _stamp(path)
                if stamp is not None:
                    found[path] = stamp
    return found


def _stamp(path: Path) -> str | None:
    """Return sizes and times of a file and of those beside it; None: it is gone."""
    try:
        known = [(one.name, one.stat()) for one in (path, *_beside(path))]
    except FileNotFoundError:
        return None
    return "; ".join(f"{name} {one.st_size} {one.st_mtime_ns}" for name, one in known)


def _beside(path: Path) -> list[Path]:
    """Return the side file and the checksum file of a recording that are there."""
    names = (path.with_suffix(".toml"), *_checksum_files(path))
    return [one for one in names if one.is_file()]


def _checksum_files(path: Path) -> tuple[Path, ...]:
    return path.with_name(f"{path.name}.sha256"), path.with_suffix(".sha256")


def _new(session: Session, machine_id: int, found: Mapping[Path, str]) -> dict[Path, str]:
    """Return the files that were not looked at as they are: refused, or read where they must stay.

    An imported one that is still there was not taken out of the inbox: it was killed before.
    """
    paths = {str(path.absolute()): path for path in found}
    new = dict(found)
    for begin in range(0, len(paths), ASKED_AT_ONCE):
        some = list(paths)[begin : begin + ASKED_AT_ONCE]
        rows = session.execute(
            select(models.InboxFile.path, models.InboxFile.stamp, models.Recording.path)
            .outerjoin(models.Recording, models.Recording.id == models.InboxFile.recording_id)
            .where(models.InboxFile.machine_id == machine_id, models.InboxFile.path.in_(some))
        )
        for path, stamp, lies_at in rows:
            stays = lies_at is None or Path(lies_at) == Path(path).resolve()
            if stays and stamp == found[paths[path]]:
                new.pop(paths[path], None)
    return new


def _settled(new: Mapping[Path, str], settled_s: float) -> tuple[list[Path], list[Path]]:
    """Return the files that stay as they are, and those that are being written.

    One whose last change is not a while ago, by a clock that may be wrong, is looked at twice.
    """
    now = time.time()
    fresh = {
        path
        for path in new
        if path.exists() and not settled_s <= now - path.stat().st_mtime and settled_s > 0
    }
    if fresh:
        time.sleep(settled_s)
    growing = {path for path in fresh if _stamp(path) != new[path]}
    return [path for path in new if path not in growing], sorted(growing)


def _order(path: Path) -> tuple[str, str]:
    """Return by what files are imported in turn: when they began, as far as known; their name."""
    beside = path.with_suffix(".toml")
    try:
        start = read_sidefile(beside).recording.start if beside.is_file() else None
    except UnusableInput:
        start = None
    return start or "", str(path)


class _Arrival:
    """One file of an inbox on its way into the database."""

    def __init__(self, store: Store, machine: str, inbox: Inbox, path: Path) -> None:
        self._store, self._machine, self._columns = store, machine, inbox.columns
        self._folder, self._path = inbox.folder.absolute(), path.absolute()
        self._notes: list[str] = []

    def take(self) -> list[str]:
        """Import the file, or keep why not; return what else is to be said."""
        try:
            stamp, sha256 = _stamp(self._path), checksum(self._path)
            if stamp is not None:
                try:
                    self._import(stamp, sha256)
                except (UnusableInput, SetAside) as error:
                    self._refuse(stamp, sha256, str(error).removeprefix(f"{self._path}: "))
        except FileNotFoundError:  # another agent took it
            pass
        return self._notes

    def _import(self, stamp: str, sha256: str) -> None:
        for said in _checksum_files(self._path):
            if said.is_file():
                _refuse_damaged(self._path, sha256, said)
        target = self._put(sha256)
        lies: list[Path] = []

        def also(session: Session, one: Imported) -> None:
            lies.append(self._lie(session, one, target))
            _note(
                session, self._row(session, sha256), "imported", stamp, recording=one.recording_id
            )

        kept = Kept(target, also)
        try:
            import_file(
                self._store, self._path, machine=self._machine, columns=self._columns, kept=kept
            )
        except BaseException:
            if target != self._path and not self._is_kept(target):
                target.unlink(missing_ok=True)
            raise
        if target != self._path:
            self._leave(target, kept_there=lies[-1] == target)

    def _put(self, sha256: str) -> Path:
        """Link or copy the file to where it is kept; return where, or its own path."""
        folder = self._folder / KEPT / time.strftime("%Y-%m", time.gmtime())
        folder /= self._path.parent.relative_to(self._folder)
        target = folder / self._path.name
        if target.exists() and checksum(target) != sha256:
            target = folder / f"{self._path.stem}-{sha256[:8]}{self._path.suffix}"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            if not target.exists():
                _link(self._path, target)
        except OSError as error:
            if error.errno not in NOT_WRITABLE:
                raise
            why = error.strerror
            self._notes.append(f"{self._folder}: cannot be written ({why}); its files stay in it")
            return self._path
        return target

    def _lie(self, session: Session, one: Imported, target: Path) -> Path:
        """Return where the recording lies; at ``target`` where it has no other whole file."""
        row = session.get_one(models.Recording, one.recording_id)
        other = whole_file(row, but=(self._path.resolve(), target.resolve()))
        if other is not None:
            return other
        row.path, row.dropped_at = str(target.resolve()), None
        return target

    def _is_kept(self, target: Path) -> bool:
        """Say whether a recording lies there."""
        with self._store.reading() as session:
            query = select(models.Recording.id).where(
                models.Recording.path == str(target.resolve())
            )
            return session.scalar(query.limit(1)) is not None

    def _leave(self, target: Path, *, kept_there: bool) -> None:
        """Take the file out of the inbox, as its recording lies elsewhere, and what is beside it.

        The file first: alone it could not be read, and would not be known by its checksum.
        """
        if not kept_there:
            target.unlink(missing_ok=True)
        alone = [one for one in stamps(self._path.parent) if one.stem == self._path.stem]
        beside = _beside(self._path)
        for other in beside if kept_there else ():
            ending = other.name.removeprefix(self._path.stem)
            shutil.copyfile(other, target.with_name(f"{target.stem}{ending}"))
        self._path.unlink(missing_ok=True)
        for other in beside if len(alone) == 1 else ():
            other.unlink(missing_ok=True)

    def _refuse(self, stamp: str, sha256: str, reason: str) -> None:
        with self._store.writing(self._machine) as session:
            _note(session, self._row(session, sha256), "refused", stamp, reason=reason)

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


def _note(
    session: Session,
    row: models.InboxFile,
    status: str,
    stamp: str,
    *,
    reason: str | None = None,
    recording: int | None = None,
) -> None:
    """Keep what became of a file; the next pass reports it."""
    row.status, row.reason, row.stamp = status, reason, stamp
    row.recording_id, row.refresh_pass_id, row.seen_at = recording, None, models.now()
    session.flush()


def _refuse_damaged(path: Path, sha256: str, said: Path) -> None:
    """Raise UnusableInput where a file is not what a checksum file beside it says."""
    wanted = said.read_text(encoding="utf-8", errors="replace").split()[:1]
    if not wanted or wanted[0].lower() != sha256:
        raise UnusableInput(f"{path}: not what {said.name} says; delivered again it would work")


def _link(path: Path, target: Path) -> None:
    """Make a file lie at ``target`` too, whole or not at all."""
    try:
        os.link(path, target)
    except OSError:  # another disk, or one without links
        with hidden(target) as part:
            shutil.copyfile(path, part)
            replace_by(part, target)
