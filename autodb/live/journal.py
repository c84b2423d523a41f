"""What a machine said, on the disk before anything is made of it.

A folder of numbered files, a line of JSON each batch; a line more for each cut whose recording is
written. Killed anywhere, the lines that are whole tell again what was said, and from where the
source is to go on; a file whose values nobody needs any more is removed.
"""

import errno
import json
import os
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from autodb.live.batch import Batch, Position, Value, from_row

FILE_BYTES = 4_000_000
"""From how many on a new file is begun. Chosen: half a minute of fourteen items at 250 Hz."""
SYNCED_S = 1.0
"""How much a power failure may take, s: an MTConnect agent says it again, most servers do not."""

Latest = Callable[[], dict[str, tuple[float, Value]]]


@dataclass(frozen=True)
class Said:
    """What a journal holds: newest values before its first batch, batches, and how far it got.

    ``done_s``: what was cut before is written; ``position``: from where the source goes on;
    ``damaged``: lines that could not be read.
    """

    latest: dict[str, tuple[float, Value]]
    batches: list[Batch]
    done_s: float | None
    position: Position | None
    damaged: int = 0

    def replayed(self) -> Iterator[Batch]:
        """Yield batches that say all of it again."""
        if self.latest:
            values = {item: ([instant], [value]) for item, (instant, value) in self.latest.items()}
            yield Batch(values, max(instant for instant, _ in self.latest.values()))
        yield from self.batches


@dataclass
class _File:
    path: Path
    upto_s: float = float("-inf")


@dataclass
class _Open:
    """The file that is written to: its handle, how long it is, and when the disk last had it."""

    handle: Any
    written: int = 0
    synced: float = field(default_factory=time.monotonic)


class Journal:
    """A folder that batches are appended to."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._files: list[_File] = []
        self._open: _Open | None = None
        self._done_s: float | None = None

    @property
    def begun(self) -> bool:
        """Whether anything was ever appended."""
        return bool(self._paths())

    def read(self) -> Said:
        """Read what is there; what is appended then goes into a new file.

        The end of a file that was cut off by a kill is passed over; a line in its middle that
        cannot be read, a gap.
        """
        self.close()
        latest: dict[str, tuple[float, Value]] = {}
        batches: list[Batch] = []
        done_s: float | None = None
        position: Position | None = None
        damaged, self._files = 0, []
        paths = self._paths()
        for number, path in enumerate(paths):
            lines = path.read_bytes().split(b"\n")
            file = _File(path)
            self._files.append(file)
            for line in lines[:-1]:
                row = _row(line)
                if row is None:
                    damaged += 1
                    batches.append(_gap(batches))
                elif "latest" in row:
                    if number == 0:
                        latest = {i: (at, value) for i, (at, value) in row["latest"].items()}
                    done_s = row["done_s"]
                elif "done_s" in row:
                    done_s = row["done_s"]
                else:
                    batch = from_row(row)
                    batches.append(batch)
                    position, file.upto_s = batch.position, batch.upto_s
        self._done_s = done_s
        return Said(latest, batches, done_s, position, damaged)

    def append(self, batch: Batch, latest: Latest) -> None:
        """Write a batch; ``latest`` tells the newest values before it. Raises OSError."""
        self._begin(latest)
        self._files[-1].upto_s = max(self._files[-1].upto_s, batch.upto_s)
        self._write(batch.as_row())

    def done(self, end_s: float, latest: Latest) -> None:
        """Keep that what was cut before an instant is written. Raises OSError."""
        self._begin(latest)
        self._done_s = end_s
        self._write({"done_s": end_s})

    def forget(self, before_s: float) -> None:
        """Remove files that say nothing of what was after an instant."""
        while len(self._files) > 1 and self._files[0].upto_s < before_s:
            self._files.pop(0).path.unlink(missing_ok=True)

    def clear(self) -> None:
        """Remove everything: no instant of it means anything any more."""
        self.close()
        for path in self._paths():
            path.unlink(missing_ok=True)
        self._files, self._done_s = [], None

    def close(self) -> None:
        """Close the file that is open."""
        if self._open is not None:
            self._open.handle.close()
            self._open = None

    def _paths(self) -> list[Path]:
        return sorted(self._folder.glob("[0-9]*.jsonl"))

    def _begin(self, latest: Latest) -> None:
        """Begin a file where none is open, or the open one is long enough."""
        if self._open is not None and self._open.written <= FILE_BYTES:
            return
        self.close()
        self._folder.mkdir(parents=True, exist_ok=True)
        numbers = [int(path.stem) for path in self._paths()]
        path = self._folder / f"{max(numbers, default=0) + 1:08d}.jsonl"
        self._open = _Open(path.open("ab", buffering=0))
        self._files.append(_File(path))
        self._write({"latest": latest(), "done_s": self._done_s})

    def _write(self, row: dict[str, Any]) -> None:
        """Write a line; of one that does not fit on the disk a part may stay, which is no line."""
        if self._open is None:
            raise ValueError("no file of the journal is open")
        line = json.dumps(row, separators=(",", ":")).encode() + b"\n"
        handle = self._open.handle
        try:
            if handle.write(line) < len(line):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(self._files[-1].path))
        except OSError:
            self.close()
            raise
        self._open.written += len(line)
        now = time.monotonic()
        if now - self._open.synced >= SYNCED_S:
            os.fsync(handle.fileno())
            self._open.synced = now


def _row(line: bytes) -> dict[str, Any] | None:
    try:
        row = json.loads(line)
    except ValueError:
        return None
    return row if isinstance(row, dict) else None


def _gap(batches: list[Batch]) -> Batch:
    """Return a batch that says only that something is missing here."""
    upto = batches[-1].upto_s if batches else float("-inf")
    position = batches[-1].position if batches else {}
    return Batch({}, upto, position, gap=True)
