"""Files and folders that are replaced: one writer each, whole or not at all, proven when done.

Who writes a target holds its lock, writes under a hidden name of its own beside it, and gives that
the target's name once it is whole and on the disk; then what lies there is read back and compared.
Killed at any moment, the target is what it was before or what it is to become. What a killed writer
left, its lock included, the next one of that target takes away.
"""

import os
import re
import secrets
import shutil
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from autodb.errors import UnusableInput
from autodb.wording import localized, phrase

LOGS = ("-wal", "-shm", "-journal")
"""Endings of what SQLite keeps beside a database."""
BUSY_S = 600.0
"""How long a writer waits for another of the same target. Chosen: a backup of gigabytes."""
SOON_S = 0.5
"""Waiting, s, without a message."""
TOKEN = r"[0-9a-f]{16}"
Progress = Callable[[str], None]


def needs_folder(target: Path) -> None:
    """Raise UnusableInput when the folder that ``target`` is to lie in is not there."""
    expect_folder(target.parent)


def expect_folder(folder: Path) -> None:
    """Raise UnusableInput where ``folder`` is not there, or is a file."""
    if folder.is_dir():
        return
    if folder.exists():
        raise UnusableInput(phrase("{folder}: is a file; name a folder", folder=folder))
    raise UnusableInput(
        phrase("{folder}: no such folder; create it or name another", folder=folder)
    )


def check_target(path: Path, *, suffix: str, option: str) -> None:
    """Raise UnusableInput where a file could not be written to ``path``."""
    if path.suffix != suffix:
        raise UnusableInput(
            phrase(
                "{option}: {file} does not end in {suffix}; write FILE{suffix}",
                option=option,
                file=path,
                suffix=suffix,
            )
        )
    if path.is_dir():
        raise UnusableInput(
            phrase(
                "{file}: is a folder; {option} needs the name of a file", file=path, option=option
            )
        )
    needs_folder(path)


def write_text(target: Path, text: str) -> None:
    """Write a file whole or not at all; an earlier one of that name is replaced."""
    with hidden(target) as part:
        part.write_text(text, encoding="utf-8")
        replace_by(part, target)


@contextmanager
def hidden(target: Path, progress: Progress | None = None) -> Iterator[Path]:
    """Give a new hidden name beside ``target``, with its ending, for one writer at a time.

    What is left under it in the end is removed. Raises UnusableInput where another goes on writing.
    """
    with one_writer(target, progress):
        path = target.with_name(f".{secrets.token_hex(8)}.partial.{target.name}")
        try:
            yield path
        except (OSError, sqlite3.Error) as error:
            naming_file(error, target)
            raise
        finally:
            for end in ("", *LOGS):
                _remove(path.with_name(f"{path.name}{end}"))


def naming_file(error: BaseException, place: Path) -> None:
    """Have an error that names no file name one: by a handle, nothing says which it was."""
    if getattr(error, "filename", None) is None:
        error.filename = str(place)  # type: ignore[attr-defined]


def replace_by(part: Path, target: Path, *, in_use: bool = False) -> None:
    """Put a finished file, or folder, in the place of ``target``.

    On the disk when this returns, and what lies there is what was written; of one that others write
    to as soon as it lies there, ``in_use``, it is the same file.
    """
    written = _content(part)
    same = part.stat()
    for path in (*(part / name for name in written), part):
        sync(path)
    if part.is_dir() and target.exists():
        _swap(part, target)
    else:
        part.replace(target)
    sync(target.parent)
    there = os.path.samestat(target.stat(), same) if in_use else _content(target) == written
    if not there:
        raise UnusableInput(
            phrase(
                "{target}: what is on the disk differs from what was written; use another disk",
                target=target,
            )
        )


def sync(path: Path) -> None:
    """Have a file or folder written to the disk, and read from there the next time."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
        if hasattr(os, "posix_fadvise"):
            os.posix_fadvise(handle, 0, 0, os.POSIX_FADV_DONTNEED)
    finally:
        os.close(handle)


def _content(path: Path) -> dict[str, str]:
    """Return the checksum of each file, by its place below ``path``; of folders, none."""
    from autodb.files.checksums import checksum

    if not path.is_dir():
        return {"": checksum(path)}
    below = sorted(path.rglob("*"))
    return {str(p.relative_to(path)): "" if p.is_dir() else checksum(p) for p in below}


def _swap(part: Path, folder: Path) -> None:
    """Put a folder in another's place, which is away only between two renames."""
    old = part.with_name(part.name.replace("partial", "old", 1))
    folder.rename(old)
    try:
        part.rename(folder)
    except BaseException:
        old.rename(folder)
        raise
    shutil.rmtree(old)


@contextmanager
def one_writer(target: Path, progress: Progress | None) -> Iterator[None]:
    """Hold the lock of a target, beside which nothing lies that a killed writer left.

    Raises UnusableInput where another goes on writing.
    """
    from filelock import FileLock, Timeout

    lock = FileLock(target.with_name(f".{target.name}.lock"))
    try:
        try:
            lock.acquire(timeout=SOON_S)
        except Timeout:
            if progress:
                progress(f"waiting for another that writes {target.name}")
            lock.acquire(timeout=BUSY_S)
    except Timeout:
        raise UnusableInput(
            phrase(
                "{target}: another program has been writing it for {busy} s; wait until it has "
                "ended",
                target=target,
                busy=localized(f"{BUSY_S:.0f}"),
            )
        ) from None
    try:
        _sweep(target)
        yield
    finally:
        # those who wait see that theirs is not the file of that name any more, and lock the next
        Path(lock.lock_file).unlink(missing_ok=True)
        lock.release()


def _sweep(target: Path) -> None:
    """Take away what killed writers left; a folder that one had moved away lies there again."""
    ours = re.compile(rf"\.{TOKEN}\.(old|partial)\.{re.escape(target.name)}(?:{'|'.join(LOGS)})?")
    for path in target.parent.iterdir():
        if found := ours.fullmatch(path.name):
            if found[1] == "old" and not target.exists():
                path.rename(target)
            else:
                _remove(path)


def _remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)
