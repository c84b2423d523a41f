"""Single bits of a database that flip by themselves: in its file, or in the log beside it.

Each flip is judged by what can be read: where any value differs from before, or the file can no
longer be read, it counts, and must be found by `doctor` and by `backup`. A log is there while a
program has the database open, and after one was killed; of that, what is lost is whole commits.
"""

import random
import secrets
import sqlite3
from contextlib import closing
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from autodb.agent.operate.doctor import examine
from autodb.errors import UnusableInput
from autodb.files.excuses import excuse
from autodb.files.targets import LOGS
from autodb.store.backups import backup

HEADER = {2: 12, 5: 12, 10: 8, 13: 8}
"""Length of a page's header by its first byte: inner and leaf pages of indices and of tables."""
FILE_HEADER = 100
LOG = "-wal"
Content = dict[str, list[str]] | str


@dataclass(frozen=True)
class Flip:
    """One flipped bit: whether anything read differs by it, and who found it."""

    byte: int
    bit: int
    counts: bool
    by_doctor: bool
    by_backup: bool


@dataclass(frozen=True)
class Whole:
    """A database before anything flips: its bytes, those of its log, and all that it holds."""

    held: bytes
    log: bytes
    content: Content

    @classmethod
    def of(cls, path: Path, folder: Path) -> "Whole":
        """Read a database, which must be sound, and its log, if it has one; in copies."""
        held, log = path.read_bytes(), b""
        beside = path.with_name(f"{path.name}{LOG}")
        if beside.exists():
            log = beside.read_bytes()
        copy = _written(folder / "sound.sqlite3", held, log)
        content = read_rows(copy)
        assert not any(_found(copy, folder))
        _removed(copy)
        return cls(held, log, content)

    @cached_property
    def _used(self) -> list[int]:
        return used(self.held)

    def flip(self, folder: Path, seed: int) -> Flip:
        """Flip a bit of the used bytes of the file, and judge it."""
        draw = random.Random(seed)
        byte, bit = draw.choice(self._used), draw.randrange(8)
        return self._judged(folder, byte, bit, flipped(self.held, byte, bit), self.log)

    def flip_of_log(self, folder: Path, seed: int) -> Flip:
        """Flip a bit of the log, and judge it."""
        draw = random.Random(seed)
        byte, bit = draw.randrange(len(self.log)), draw.randrange(8)
        return self._judged(folder, byte, bit, self.held, flipped(self.log, byte, bit))

    def _judged(self, folder: Path, byte: int, bit: int, held: bytes, log: bytes) -> Flip:
        copy = folder / f"flipped-{secrets.token_hex(8)}.sqlite3"  # no connection has it open
        found = _found(_written(copy, held, log), folder)
        flip = Flip(byte, bit, read_rows(copy) != self.content, *found)
        _removed(copy)
        return flip


def flipped(whole: bytes, byte: int, bit: int) -> bytes:
    """Return bytes with one bit the other way."""
    made = bytearray(whole)
    made[byte] ^= 1 << bit
    return bytes(made)


def _written(path: Path, held: bytes, log: bytes) -> Path:
    path.write_bytes(held)
    if log:
        path.with_name(f"{path.name}{LOG}").write_bytes(log)
    return path


def _removed(path: Path) -> None:
    for end in ("", *LOGS):
        path.with_name(f"{path.name}{end}").unlink(missing_ok=True)


def used(whole: bytes) -> list[int]:
    """Return the places of all bytes of a database but those between a page's cells: its header,
    those of pages, where cells lie, cells, and pages that long values go on in.
    """
    size = int.from_bytes(whole[16:18], "big")
    places: list[int] = []
    for page in range(0, len(whole), size):
        at = page + (FILE_HEADER if page == 0 else 0)
        end, first = page, page  # of a page that a value goes on in: all of it
        if header := HEADER.get(whole[at]):
            n = int.from_bytes(whole[at + 3 : at + 5], "big")
            end = at + header + 2 * n
            pointers = whole[at + header : end]
            starts = (int.from_bytes(pointers[2 * k : 2 * k + 2], "big") for k in range(n))
            first = page + min(starts, default=size)
        places += [*range(page, end), *range(first, page + size)]
    return places


def read_rows(path: Path) -> Content:
    """Return every row of every table as text, types included; an error's name where it cannot."""
    try:
        with closing(sqlite3.connect(path)) as file:
            file.text_factory = lambda text: ("text", text)
            names = file.execute("SELECT name FROM sqlite_master WHERE type = 'table'").fetchall()
            return {
                repr(name): sorted(map(repr, file.execute(f'SELECT * FROM "{name[1].decode()}"')))
                for (name,) in names
            }
    except (sqlite3.Error, UnicodeDecodeError) as error:
        return type(error).__name__


def _found(path: Path, folder: Path) -> tuple[bool, bool]:
    """Say whether the doctor finds something wrong with a database, and whether a backup does."""
    return _found_by_doctor(path), _found_by_backup(path, folder / "copy.sqlite3")


def _found_by_doctor(path: Path) -> bool:
    try:
        findings = examine(f"sqlite:///{path}", progress=lambda _: None)
    except Exception as error:
        if excuse(error) is None:
            raise
        return True
    return not all(finding.outcome.passed for finding in findings)


def _found_by_backup(path: Path, target: Path) -> bool:
    try:
        backup(f"sqlite:///{path}", target, replace=True)
    except UnusableInput:
        return True
    return False
