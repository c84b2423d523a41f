"""A recording that somebody sent: it enters the database and stays where it was put.

It was put into a folder of its own, in which nothing else is. Its import, where it lies and who
sent it are one transaction: killed at any moment, the database has the file or does not, and
``recording_came_in`` says which.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.ingest.framed import lies_at
from autodb.agent.ingest.importing import (
    Imported,
    KeepAt,
    import_file,
    time_sentences,
)
from autodb.agent.operate.access import Access, noting
from autodb.agent.rows.recordings import counted_cuts
from autodb.errors import UnusableInput
from autodb.files.side import SideFile
from autodb.files.toml import read_toml
from autodb.store import Store, models


@dataclass(frozen=True)
class Sent:
    """A recording that was sent, its side file beside it; by whom, and of which machine.

    ``came_as``: the path that it counts as having come in under, so that one that has grown is
    known again by its name.
    """

    path: Path
    machine: str
    came_as: Path
    by: Access


def take_in_sent(store: Store, sent: Sent, progress: Callable[[str], None]) -> Imported:
    """Import a recording that was sent; raises UnusableInput, and nothing is written then."""
    path = sent.path.resolve()
    _refuse_other_files(path.with_suffix(".toml"))

    def also(session: Session, one: Imported) -> None:
        lies_at(session, one.recording_id, path)
        said = {"machine": sent.machine, "file": path.name, "already_there": one.already_there}
        noting(sent.by, "recording imported", "recording", **said)(session, one.recording_id)

    kept = KeepAt(path, also, sent.came_as)
    return import_file(store, path, machine=sent.machine, progress=progress, kept=kept)


def _refuse_other_files(side: Path) -> None:
    """Raise UnusableInput where a side file names a file that was not sent with it."""
    if side.is_file() and read_toml(side, SideFile).tool.file is not None:
        raise UnusableInput(
            f"{side}: tool.file: only the recording and this file were sent; state the tool's "
            "own keys under [tool]"
        )


def recording_came_in(store: Store, path: Path) -> Imported | None:
    """Return what came in with the file that lies there; None: no recording lies there."""
    with store.reading() as session:
        lies_there = models.StoredRecording.path == str(path.resolve())
        row = session.scalar(select(models.StoredRecording).where(lies_there).limit(1))
        if row is None:
            return None
        return Imported(
            row.id,
            row.kind,
            row.rows,
            len(counted_cuts(row)),
            already_there=False,
            timing=time_sentences(row),
        )
