"""Bits that flip in the database of a shop: of its file, and of a log that was left beside it."""

import os
import shutil
import signal
from functools import cache
from pathlib import Path

from autodb.proofs.runs.keeping.commands_run import shop
from autodb.proofs.runs.keeping.flips import Whole
from autodb.proofs.runs.keeping.flips_summary import IN_FILE, IN_LOG, Flipped
from autodb.proofs.runs.keeping.forked import finished, needs_forks
from autodb.proofs.runs.keeping.writing_commands import OTHER, URL
from autodb.store import models, open_store

SEED = 11
"""Fixed before anything was flipped; each run has its own below it."""
COMMITS = 12
"""In the log. Chosen: some, each of a few pages."""


def run_flips(seed: int) -> list[Flipped]:
    """Flip a bit of the file and one of the log; raises UnusableInput where nothing can be forked.

    The log is of a program that was killed: a fork is.
    """
    needs_forks()
    whole, left, folder = _bench()
    draw = 1000 * SEED + seed
    return [
        Flipped.of(IN_FILE, whole.flip(folder, draw)),
        Flipped.of(IN_LOG, left.flip_of_log(folder, draw)),
    ]


@cache
def _bench() -> tuple[Whole, Whole, Path]:
    """Return a shop's database, the same as a killed program left it, and a folder to work in."""
    home = shop(large=False).parent / "flips"
    shutil.copytree(shop(large=False), home / "left")
    whole = Whole.of(home / "left" / "autodb.sqlite3", home)
    assert finished(home / "left", _commit_and_die) == -signal.SIGKILL
    return whole, Whole.of(home / "left" / "autodb.sqlite3", home), home


def _commit_and_die() -> None:
    """Commit again and again and be killed, so that the log is still there."""
    store = open_store(URL)
    for number in range(COMMITS):
        with store.writing() as session:
            session.add(models.Machine(name=f"{OTHER}-{number}", rotary_order=[]))
    os.kill(os.getpid(), signal.SIGKILL)
