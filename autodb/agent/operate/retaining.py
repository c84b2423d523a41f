"""How long recordings are kept: compressed after a while, later not at all; what was derived stays.

Only files that an inbox moved into its ``kept`` are touched. A table of text (CSV) becomes Parquet
with checksums, read back and compared before the original goes; binary files are left as they are.
Age counts from one import to the newest: a machine that stands still keeps everything. What is
dropped goes into a trash first (autodb.agent.operate.trash).
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from pyarrow import parquet
from sqlalchemy import ColumnElement, select
from sqlalchemy.orm import Session

from autodb import readers
from autodb.agent.ingest.entries import KEPT
from autodb.agent.ingest.importing import files_of
from autodb.agent.ingest.kept import kept_folders
from autodb.agent.operate import trash
from autodb.agent.rows.machines import find_machine
from autodb.errors import UnusableInput
from autodb.files.checksums import checksum
from autodb.files.side import SideFile
from autodb.files.targets import hidden, replace_by
from autodb.records.source import RecordingSource, open_as_stored
from autodb.store import Store, models

COMPRESSED = ".csv"
"""Ending of files that become Parquet."""
Progress = Callable[[str], None]
_Recording = models.StoredRecording


@dataclass
class Retained:
    """How many recordings were compressed, from and to how many bytes, and how many dropped;
    ``left``: what to say of those that could not be.
    """

    compressed: int = 0
    bytes_before: int = 0
    bytes_after: int = 0
    dropped: int = 0
    left: list[str] = field(default_factory=list)

    def lines(self) -> list[str]:
        """Return it in words, a line each."""
        said = []
        if self.compressed:
            sizes = f"{self.bytes_before / 1e6:.3g} to {self.bytes_after / 1e6:.3g} MB"
            said.append(f"{self.compressed} recordings compressed, {sizes}")
        if self.dropped:
            where = f"into {KEPT}/{trash.TRASH}"
            said.append(f"{self.dropped} recordings dropped, {where}; what was derived stays")
        return said + self.left


def retain(store: Store, machine: str, *, progress: Progress = lambda _: None) -> Retained:
    """Compress and drop the recordings of a machine that its file's [retention] says are old."""
    done = Retained()
    with store.reading() as session:
        owner = find_machine(session, machine)
        days = owner.compress_after_days, owner.drop_after_days
        newest = _newest(session, owner.id)
        if newest is None or days == (None, None):
            return done
        _finish(session, owner.id)
        there, plain = _Recording.dropped_at.is_(None), _Recording.stored_path.is_(None)
        old = _due(session, owner.id, newest, days[0], there & plain)
        gone = _due(session, owner.id, newest, days[1], there)
        why_not = trash.jumped(session, owner.id) if gone else None
        for folder in kept_folders(session, owner.id):
            trash.empty_trash(session, owner.id, folder)
    if why_not is not None:
        done.left.append(why_not)
        gone = []
    for number, one in enumerate(gone, start=1):
        progress(f"dropping {number} of {len(gone)}")
        _drop(store, machine, one)
    done.dropped = len(gone)
    due = [one for one in old if one not in set(gone)]
    for number, one in enumerate(due, start=1):
        progress(f"compressing {number} of {len(due)}")
        _compress(store, machine, one, done)
    return done


def _newest(session: Session, machine_id: int) -> datetime | None:
    said = session.scalar(
        select(_Recording.imported_at)
        .where(_Recording.machine_id == machine_id)
        .order_by(_Recording.id.desc())
        .limit(1)
    )
    return None if said is None else datetime.fromisoformat(said)


def _due(
    session: Session,
    machine_id: int,
    newest: datetime,
    days: float | None,
    lacks: ColumnElement[bool],
) -> list[int]:
    """Return the recordings that an inbox keeps, by id, that came in long before the newest."""
    if days is None:
        return []
    before = (newest - timedelta(days=days)).isoformat(timespec="seconds")
    rows = session.execute(
        select(_Recording.id, _Recording.path, _Recording.delivered_as)
        .where(
            _Recording.machine_id == machine_id, lacks, _Recording.imported_at < before,
        )
        .order_by(_Recording.id)
    )  # fmt: skip
    return [number for number, path, came_as in rows if came_as not in (None, path)]


def _finish(session: Session, machine_id: int) -> None:
    """Take away what a kill left of the recordings that were compressed and dropped last."""
    own = _Recording.machine_id == machine_id, _Recording.delivered_as != _Recording.path
    last = select(_Recording).where(*own).order_by(_Recording.id.desc()).limit(1)
    stored = session.scalar(last.where(_Recording.stored_path.is_not(None)))
    if stored is not None and stored.stored_path != stored.path and len(files_of(stored)) > 1:
        Path(stored.path).unlink()
    dropped = session.scalar(last.where(_Recording.dropped_at.is_not(None)))
    for path in files_of(dropped) if dropped is not None else ():
        trash.throw(path)


def _compress(store: Store, machine: str, recording: int, done: Retained) -> None:
    """Put a compressed copy in a recording's place; the original goes once that is known."""
    with store.reading() as session:
        row = session.get_one(_Recording, recording)
        path, sha256, side = Path(row.path), row.sha256, SideFile.model_validate(row.side)
    if not path.is_file() or checksum(path) != sha256:
        done.left.append(f"{path}: not as it was imported; it is not compressed")
        return
    if path.suffix.lower() != COMPRESSED:
        _keep(store, machine, recording, path, sha256)
        return
    target = path.with_name(f"{path.name}.parquet")
    try:
        with hidden(target) as part:
            _write(path, side, part)
            _compare(open_as_stored(path, side), open_as_stored(part, side))
            replace_by(part, target)
    except UnusableInput as error:
        done.left.append(f"{path}: not compressed: {error}")
        _keep(store, machine, recording, path, sha256)
        return
    _keep(store, machine, recording, target, checksum(target))
    done.compressed += 1
    done.bytes_before += path.stat().st_size
    done.bytes_after += target.stat().st_size
    path.unlink()


def _keep(store: Store, machine: str, recording: int, path: Path, sha256: str) -> None:
    with store.writing(machine) as session:
        row = session.get_one(_Recording, recording)
        row.stored_path, row.stored_sha256 = str(path), sha256
        row.stored_bytes = path.stat().st_size


def _write(path: Path, side: SideFile, target: Path) -> None:
    """Write all columns of a file with one time base as Parquet: numbers as float64, else text."""
    source = open_as_stored(path, side)
    base, *others = readers.open_bases(path, side.csv)
    if others:
        raise UnusableInput("it has several time bases")
    labels = set(source.bases[0].conversion.labels)
    labels |= {name for name in base.columns if name not in labels and not _is_number(base, name)}
    numbers = [name for name in base.columns if name not in labels]
    schema = pa.schema(
        [
            pa.field(
                name,
                pa.string() if name in labels else pa.float64(),
                metadata={"unit": base.units[name]} if name in base.units else None,
            )
            for name in base.columns
        ]
    )
    options: dict[str, Any] = {"compression": "zstd", "write_page_checksum": True}
    with parquet.ParquetWriter(target, schema, **options) as writer:
        for block in base.blocks(numbers, sorted(labels)):
            writer.write_table(pa.table({name: block[name] for name in base.columns}, schema))


def _is_number(base: readers.ColumnSet, name: str) -> bool:
    try:
        for _ in base.blocks([name], []):
            pass
    except UnusableInput:
        return False
    return True


def _compare(before: RecordingSource, after: RecordingSource) -> None:
    """Raise UnusableInput where what is read of a copy is not what is read of the original."""
    old, new = (_whole(source) for source in (before, after))
    for name, values in old.items():
        same = name in new and len(new[name]) == len(values)
        numeric = values.dtype.kind == "f"
        if not same or not np.array_equal(values, new[name], equal_nan=numeric):
            raise UnusableInput(f"column '{name}' reads otherwise")


def _whole(source: RecordingSource) -> dict[str, np.ndarray[Any, np.dtype[Any]]]:
    blocks = list(source.bases[0].blocks())
    read: dict[str, list[Any]] = {}
    for channels, texts in blocks:
        for name, values in (*channels.items(), *texts.items()):
            read.setdefault(name, []).append(np.asarray(values))
    return {name: np.concatenate(parts) for name, parts in read.items()}


def _drop(store: Store, machine: str, recording: int) -> None:
    """Have no file of a recording any more."""
    with store.writing(machine) as session:
        row = session.get_one(_Recording, recording)
        files = list(files_of(row))
        row.dropped_at = models.now()
    for path in files:
        trash.throw(path)
