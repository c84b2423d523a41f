"""A machine's inbox: recordings that lie in a folder enter the database and are kept beside it.

What a look finds is taken one by one (``arrival``); an entry that nothing can be read of
costs itself alone. What lies in ``kept`` and is not in the database, or has grown there, is taken
in too: after an older backup was restored, and of a logger that goes on where it had paused.
"""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.ingest.arrival import Arrival, Desk, back
from autodb.agent.ingest.entries import KEPT, inbox_entries, stamp
from autodb.agent.ingest.kept import Unread, parted, unread
from autodb.agent.rows.machines import find_machine, working_machine
from autodb.errors import UnusableInput
from autodb.files.side import read_sidefile
from autodb.files.targets import expect_folder
from autodb.store import Store, models

SETTLED_S = 2.0
"""How long a file's size and time must stay before it counts as written. Chosen."""
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
        expect_folder(self.folder)
        found = inbox_entries(self.folder)
        for path, name in found.leaving.items():
            back(path, name)
            found.files.update({} if (seen := stamp(name)) is None else {name: seen})
        with store.reading() as session:
            new = _new(session, working_machine(session, machine).id, found.files)
        desk = Desk(store, machine, self.folder, self.columns)
        settled, growing = _settled(new, self.settled_s)
        notes = [f"{path.name}: still being written; the next pass takes it" for path in growing]
        for number, path in enumerate(sorted(settled, key=_order), start=1):
            progress(f"importing {number} of {len(settled)}: {path.name}")
            notes += Arrival(desk, path).take()
        notes += self._read_on(desk, progress)
        return list(dict.fromkeys([*found.odd, *notes]))

    def _read_on(self, desk: Desk, progress: Progress) -> list[str]:
        """Take in what lies in ``kept`` and is not in the database as it is."""
        with desk.store.reading() as session:
            machine_id = find_machine(session, desk.machine).id
            found = {one.path: one for one in unread(session, machine_id, self.folder / KEPT)}
        settled, growing = _settled({p: one.stamp for p, one in found.items()}, self.settled_s)
        notes = [f"{path.name}: still being written; the next pass takes it" for path in growing]
        for path in settled:
            progress(f"reading on: {path.name}")
            notes += _taken_on(desk, found[path])
        return notes


def _taken_on(desk: Desk, one: Unread) -> list[str]:
    try:
        path = one.path if one.grown is None else parted(one.path, one.grown)
    except UnusableInput as error:
        return [str(error)]
    return Arrival(desk, path, one.came_as).take()


def _new(session: Session, machine_id: int, found: Mapping[Path, str]) -> dict[Path, str]:
    """Return the files that were not looked at as they are: refused, or read where they must stay.

    An imported one that is still there was not taken out of the inbox: it was killed before.
    """
    paths = {str(path.absolute()): path for path in found}
    new = dict(found)
    for begin in range(0, len(paths), ASKED_AT_ONCE):
        some = list(paths)[begin : begin + ASKED_AT_ONCE]
        rows = session.execute(
            select(models.InboxFile.path, models.InboxFile.stamp, models.StoredRecording.path)
            .outerjoin(
                models.StoredRecording, models.StoredRecording.id == models.InboxFile.recording_id
            )
            .where(models.InboxFile.machine_id == machine_id, models.InboxFile.path.in_(some))
        )
        for path, seen, lies_at in rows:
            stays = lies_at is None or Path(lies_at) == Path(path).resolve()
            if stays and seen == found[paths[path]]:
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
    growing = {path for path in fresh if stamp(path) != new[path]}
    return [path for path in new if path not in growing], sorted(growing)


def _order(path: Path) -> tuple[str, str]:
    """Return by what files are imported in turn: when they began, as far as known; their name."""
    beside = path.with_suffix(".toml")
    try:
        start = read_sidefile(beside).recording.start if beside.is_file() else None
    except UnusableInput:
        start = None
    return start or "", str(path)
