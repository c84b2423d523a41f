"""What lies in a folder that recordings come into: files, and entries that nothing is read of."""

import os
import re
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from autodb.errors import UnusableInput

KEPT = "kept"
BESIDE = (".toml", ".sha256")
"""Endings of files that go with a recording and are none."""
UNFINISHED = (".part", ".partial", ".tmp", ".crdownload", ".filepart")
LEAVING = re.compile(r"\.[0-9a-f]{16}\.leaving\.(.+)")
"""Name of a file that is just taken out of an inbox."""
KINDS = (
    (stat.S_ISLNK, "a link; deliver the file that it leads to"),
    (stat.S_ISFIFO, "a pipe; deliver a file"),
    (stat.S_ISSOCK, "a socket; deliver a file"),
    (lambda mode: stat.S_ISCHR(mode) or stat.S_ISBLK(mode), "a device; deliver a file"),
)


@dataclass
class Entries:
    """Files by path, with sizes and times to know them by; what is to be said of other entries;
    files, by path, that somebody who was killed was taking out, with the names that they had.
    """

    files: dict[Path, str] = field(default_factory=dict)
    odd: list[str] = field(default_factory=list)
    leaving: dict[Path, Path] = field(default_factory=dict)


def inbox_entries(inbox: Path) -> Entries:
    """Look into a folder and those in it, but for what is hidden or kept there already."""
    found = Entries()

    def unreadable(error: OSError) -> None:
        found.odd.append(f"{_shown(error.filename)}: cannot be looked into ({error.strerror})")

    for folder, folders, names in os.walk(inbox, onerror=unreadable):
        folders[:] = [one for one in folders if one != KEPT and not one.startswith(".")]
        linked = [one for one in folders if (Path(folder) / one).is_symlink()]
        for name in (*names, *linked):
            _sort(Path(folder) / name, found)
    return found


def _sort(path: Path, found: Entries) -> None:
    if match := LEAVING.fullmatch(path.name):
        found.leaving[path] = path.with_name(match[1])
    elif not path.name.startswith(".") and path.suffix.lower() not in (*BESIDE, *UNFINISHED):
        try:
            why = _why_not(path)
            seen = stamp(path) if why is None else None
        except OSError as error:
            why, seen = f"cannot be looked at ({error.strerror})", None
        if why is not None:
            found.odd.append(f"{_shown(path.name)}: {why}")
        elif seen is not None:
            found.files[path] = seen


def _why_not(path: Path) -> str | None:
    """Return why nothing can be read of an entry, by its name and kind; None: it may be read."""
    if not path.name.isprintable():
        return "a name that is not text or holds a line break; rename it"
    try:
        mode = path.lstat().st_mode
    except FileNotFoundError:
        return None
    return next((words for is_kind, words in KINDS if is_kind(mode)), None)


def _shown(name: str) -> str:
    """Return a name as it can be printed on one line."""
    return name if name.isprintable() else ascii(name)


def stamp(path: Path) -> str | None:
    """Return sizes and times of a file and of those beside it; None: it is gone."""
    try:
        known = [(one.name, one.stat()) for one in (path, *files_beside(path))]
    except FileNotFoundError:
        return None
    return "; ".join(f"{name} {one.st_size} {one.st_mtime_ns}" for name, one in known)


def size_by_stamp(seen: str) -> int:
    """Return the size of the file itself that a stamp says, in bytes."""
    return int(seen.split("; ", maxsplit=1)[0].rsplit(" ", 2)[1])


def files_beside(path: Path) -> list[Path]:
    """Return the side file and the checksum file of a recording that are there."""
    names = (path.with_suffix(".toml"), *checksum_files(path))
    return [one for one in names if one.is_file()]


def checksum_files(path: Path) -> tuple[Path, ...]:
    """Return where a checksum of a file may lie."""
    return path.with_name(f"{path.name}.sha256"), path.with_suffix(".sha256")


@contextmanager
def open_held(path: Path) -> Iterator[int]:
    """Open a file to be read, following no link and waiting for nobody.

    Raises UnusableInput where it is no regular file.
    """
    file = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    try:
        if not stat.S_ISREG(os.fstat(file).st_mode):
            raise UnusableInput(f"{path}: not a regular file; deliver a recording")
        yield file
    finally:
        os.close(file)
