"""Single bits of a database file that flip by themselves, in the bytes of its cells.

Each flip is judged by what can be read: where any value differs from before, or the file can no
longer be read, it counts, and must be found by `doctor` and by `backup`.
"""

import random
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from autodb.agent.operate.doctor import examine
from autodb.errors import UnusableInput
from autodb.files.excuses import excuse
from autodb.store.backups import backup

HEADER = {2: 12, 5: 12, 10: 8, 13: 8}
"""Length of a page's header by its first byte: inner and leaf pages of indices and of tables."""
FIRST_PAGE_HEADER = 100


@dataclass(frozen=True)
class Flip:
    """One flipped bit: whether anything read differs by it, and who found it."""

    byte: int
    bit: int
    counts: bool
    by_doctor: bool
    by_backup: bool


def flips(path: Path, folder: Path, *, seed: int, n: int) -> Iterator[Flip]:
    """Flip ``n`` bits of the cells of a sound database, each in a copy in ``folder``."""
    whole = path.read_bytes()
    before = _read(path)
    assert not _found_by_doctor(path)
    assert not _found_by_backup(path, folder / "copy.sqlite3")
    used = cell_places(whole)
    draw = random.Random(seed)
    for number in range(n):
        byte, bit = draw.choice(used), draw.randrange(8)
        flipped = bytearray(whole)
        flipped[byte] ^= 1 << bit
        copy = folder / f"flipped-{number}.sqlite3"  # no connection knows it from before
        copy.write_bytes(flipped)
        found = _found_by_doctor(copy), _found_by_backup(copy, folder / "copy.sqlite3")
        yield Flip(byte, bit, _read(copy) != before, *found)
        copy.unlink()


def cell_places(whole: bytes) -> list[int]:
    """Return the places of the bytes of all cells, and of pages that long values go on in."""
    size = int.from_bytes(whole[16:18], "big")
    places: list[int] = []
    for page in range(0, len(whole), size):
        at = page + (FIRST_PAGE_HEADER if page == 0 else 0)
        first = 4  # of a page that a value goes on in: where it goes on next
        if header := HEADER.get(whole[at]):
            n = int.from_bytes(whole[at + 3 : at + 5], "big")
            pointers = whole[at + header : at + header + 2 * n]
            starts = (int.from_bytes(pointers[2 * k : 2 * k + 2], "big") for k in range(n))
            first = min(starts, default=size)
        places += range(page + first, page + size)
    return places


def _read(path: Path) -> dict[str, list[str]] | str:
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
