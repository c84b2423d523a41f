"""Backups by date in a folder: one when it is due, the oldest away, and a restore of the newest.

A backup is due once the newest is as old as their distance, less a tenth: a timer that comes a
little early skips none. Older ones go only after the new one has been proven.
"""

import re
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from enum import StrEnum
from pathlib import Path
from tempfile import TemporaryDirectory

from autodb.errors import UnusableInput
from autodb.files.targets import Progress, expect_folder, one_writer
from autodb.store.backups import backup
from autodb.store.copies import Copied
from autodb.store.restoring import restore
from autodb.wording import phrase

NAME = re.compile(r"autodb-(\d{8}T\d{6})Z\.sqlite3")
STAMP = "%Y%m%dT%H%M%S"
LOCKED = "autodb"
"""What is locked in a folder while one makes a backup there and takes the oldest away."""
EARLY = 0.1
"""Share of their distance by which a backup may be early. Chosen: a day's may be two hours."""


class Every(StrEnum):
    """How far backups are apart."""

    HOUR = "hour"
    DAY = "day"
    WEEK = "week"

    @property
    def apart(self) -> timedelta:
        """Time between two."""
        return {
            Every.HOUR: timedelta(hours=1),
            Every.DAY: timedelta(days=1),
            Every.WEEK: timedelta(weeks=1),
        }[self]


@dataclass(frozen=True)
class Dated:
    """A backup in a folder of them, and when it was begun."""

    path: Path
    at: datetime


@dataclass(frozen=True)
class Rotated:
    """What was done: the copy that was made, if one was due, and what went and what is there."""

    copied: Copied | None
    removed: tuple[Path, ...]
    there: tuple[Dated, ...]


@dataclass(frozen=True)
class RestoreDrill:
    """The newest backup, how old it is, and what a restore of it held."""

    newest: Dated
    age: timedelta
    restored: Copied


def dated(folder: Path) -> list[Dated]:
    """Return the backups of a folder by their names, oldest first; other files are not looked at.

    Raises UnusableInput where there is no such folder.
    """
    expect_folder(folder)
    found = ((path, NAME.fullmatch(path.name)) for path in sorted(folder.iterdir()))
    return [
        Dated(path, datetime.strptime(match[1], STAMP).replace(tzinfo=UTC))
        for path, match in found
        if match
    ]


def rotate(
    url: str,
    folder: Path,
    *,
    keep: int | None,
    every: Every | None,
    now: datetime,
    progress: Progress | None = None,
) -> Rotated:
    """Back a database up into a folder where one is due, and then remove all but the newest.

    ``keep``: how many stay, the new one among them; None: all. ``every``: None: one is always due.
    Raises UnusableInput as a backup does; then nothing is removed.
    """
    dated(folder)  # where there is none, nothing is locked in it
    with one_writer(folder / LOCKED, progress):
        _sweep(folder, progress)
        before = dated(folder)
        if every is not None and before and not _is_due(before[-1], every, now):
            gone = _beyond(before, keep)  # a killed one may have left them
            return Rotated(None, gone, tuple(one for one in before if one.path not in gone))
        new = Dated(folder / f"autodb-{now.strftime(STAMP)}Z.sqlite3", now)
        copied = backup(url, new.path, progress=progress)
        gone = _beyond(before, None if keep is None else keep - 1)
        return Rotated(copied, gone, (*before[len(gone) :], new))


def _sweep(folder: Path, progress: Progress | None) -> None:
    """Take away what killed ones left: no other has the same date, and would."""
    hidden = (path.name for path in folder.iterdir() if path.name.startswith("."))
    for name in {found[0] for one in hidden if (found := NAME.search(one))}:
        with one_writer(folder / name, progress):
            pass


def _beyond(there: list[Dated], keep: int | None) -> tuple[Path, ...]:
    """Remove the oldest of backups but ``keep``, or none; return those that went."""
    gone = [] if keep is None else there[: max(0, len(there) - keep)]
    for old in gone:
        old.path.unlink(missing_ok=True)
    return tuple(old.path for old in gone)


def _is_due(newest: Dated, every: Every, now: datetime) -> bool:
    """Say whether a backup is due; one from the future was made by a clock that was wrong."""
    age = now - newest.at
    return age < timedelta() or age >= every.apart * (1.0 - EARLY)


def drill(folder: Path, *, now: datetime, progress: Progress | None = None) -> RestoreDrill:
    """Restore the newest backup of a folder into a temporary one, as a real restore would.

    Raises UnusableInput where there is none, or it cannot be restored.
    """
    there = dated(folder)
    if not there:
        raise UnusableInput(
            phrase(
                "{folder}: no backup there; make one with 'autodb backup {folder} --keep 7 "
                "--every day'",
                folder=folder,
            )
        )
    with TemporaryDirectory() as aside:
        url = f"sqlite:///{Path(aside) / 'restored.sqlite3'}"
        restored = restore(url, there[-1].path, progress=progress)
    return RestoreDrill(there[-1], now - there[-1].at, restored)


def age_words(age: timedelta) -> str:
    """Return an age in words.

    >>> age_words(timedelta(hours=30))
    '30 h'
    """
    minutes = round(age / timedelta(minutes=1))
    if minutes < 120:
        return phrase("{count} min", count=minutes)
    if minutes < 72 * 60:
        return phrase("{count} h", count=minutes // 60)
    return phrase("{count} days", count=minutes // (24 * 60))
