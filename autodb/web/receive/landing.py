"""Where recordings land that are sent: each in a folder of its own, in which it may stay.

``MACHINE/YEAR-MONTH/NUMBER`` of one folder. Until it is decided whether it stays, its place is
noted below ``unfinished``; what a killed service left there is decided a day later.
"""

import contextlib
import secrets
import shutil
import time
from pathlib import Path

from autodb.agent.operate.receiving import recording_came_in
from autodb.agent.operate.scheduling import slug
from autodb.store import Store
from autodb.web.receive import accepted

UNFINISHED = "unfinished"
LEFT_S = 24 * 3600.0
"""How old a place is that nobody works at any more. Chosen."""


def place(folder: Path, machine: str) -> Path:
    """Make a new place for a recording of a machine, and note it as unfinished."""
    number, month = secrets.token_hex(8), time.strftime("%Y-%m", time.gmtime())
    made = folder / slug(machine) / month / number
    noted = folder / UNFINISHED / number
    noted.parent.mkdir(parents=True, exist_ok=True)
    noted.write_text(str(made.relative_to(folder)), encoding="utf-8")
    made.mkdir(parents=True)
    return made


def came_as(folder: Path, machine: str, name: str) -> Path:
    """Return the path that a recording counts as having come in under: known by its name."""
    return folder / slug(machine) / name


def give_up(folder: Path, made: Path) -> None:
    """Take a place away with what is in it."""
    shutil.rmtree(made, ignore_errors=True)
    _finish(folder, made.name)


def keep_place(folder: Path, made: Path, store: Store) -> None:
    """Keep a place where a recording of the database lies in it; otherwise take it away."""
    if any(recording_came_in(store, path) is not None for path in _files(made)):
        _finish(folder, made.name)
    else:
        give_up(folder, made)


def decide_left(folder: Path, store: Store) -> None:
    """Decide about places that a service left which was killed."""
    noted = folder / UNFINISHED
    for note in noted.iterdir() if noted.is_dir() else ():
        with contextlib.suppress(FileNotFoundError):
            if time.time() - note.stat().st_mtime > LEFT_S:
                made = folder / note.read_text(encoding="utf-8")
                if accepted.is_accepted(folder, made):
                    continue
                if made.name == note.name and made.resolve().is_relative_to(folder.resolve()):
                    keep_place(folder, made, store)


def _files(made: Path) -> list[Path]:
    return list(made.iterdir()) if made.is_dir() else []


def _finish(folder: Path, number: str) -> None:
    (folder / UNFINISHED / number).unlink(missing_ok=True)
