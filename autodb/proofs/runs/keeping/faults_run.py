"""A refresh from an inbox, killed at a random moment and run again: is anything lost, or twice?

The inbox holds two tables of cuts, a copy of one of them under another name, a recording over time
with its side file, and a file that must be refused. A forked child refreshes; SIGKILL ends it at a
moment drawn uniformly over the time of an undisturbed child (even seeds) or over what follows its
first write (odd seeds), so that the short time in which files move and rows are written is hit
often. Then the same refresh runs to its end, and every row of every table but the clock's, and
every file, is compared with what the undisturbed one left.
"""

import hashlib
import os
import re
import shutil
import signal
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from sqlalchemy import event, func, select

from autodb.agent.ingest.importing import import_file
from autodb.agent.ingest.inbox import Inbox
from autodb.agent.operate.refreshing import refresh
from autodb.agent.rows.machines import add_machine
from autodb.agent.sense.calibrating import calibrate_machine
from autodb.assets import kit
from autodb.errors import UnusableInput
from autodb.files.machine import LATHE
from autodb.proofs.runs.keeping.faults_summary import PHASES, Killed
from autodb.store import Store, create_store, models, open_store

MACHINE = "lathe-1"
CUTS = 5
"""Of each table: as many as a pair learns in a second."""
CLOCKS = {
    *("created_at", "imported_at", "started_at", "finished_at", "decided_at", "seen_at"),
    *("superseded_at", "dropped_at", "updated_at", "since"),
}
MONTH = re.compile(r"kept/\d{4}-\d{2}")
RECORDINGS = kit("sample_jobs") / "stepped_shaft" / "recordings"
Content = dict[str, list[tuple[str, ...]]]


@dataclass(frozen=True)
class State:
    """All rows of a database by table, but for the clock's time; all files with their checksums."""

    rows: Content
    files: dict[str, str]


def run_faults(seed: int) -> list[Killed]:
    """Kill one refresh and run it again; raises UnusableInput where no process can be forked."""
    if not hasattr(os, "fork"):
        raise UnusableInput("prove faults needs a system that can fork; use Linux or macOS")
    return [_bench().killed(seed)]


@cache
def _bench() -> "RefreshBench":
    return RefreshBench()


class RefreshBench:
    """A lathe before the refresh and after it, in a folder of its own."""

    def __init__(self) -> None:
        self._home = tempfile.TemporaryDirectory(prefix="autodb-faults-")
        self._base, self._work = (Path(self._home.name) / name for name in ("base", "work"))
        self._work.mkdir()
        prepare(self._work)
        shutil.copytree(self._work, self._base)
        self._to_write_s, self._took_s = self._undisturbed()
        self._after = state_of(self._work)

    def killed(self, seed: int) -> Killed:
        """Kill a refresh at the moment that a seed draws, look, run it again and compare."""
        self._reset()
        from_write = bool(seed % 2)
        most_s = self._took_s - self._to_write_s if from_write else self._took_s
        delay_s = float(np.random.default_rng([seed, 110]).uniform(0.0, most_s))
        lived_s = _kill(self._work, delay_s, from_write=from_write)
        phase, sound = _phase(self._work), is_sound(self._work)
        take(self._work)
        left = state_of(self._work)
        return Killed(
            tenth=min(9, int(10.0 * lived_s / self._took_s)),
            phase=phase,
            sound=sound,
            rows=left.rows == self._after.rows,
            files=left.files == self._after.files,
        )

    def _reset(self) -> None:
        shutil.rmtree(self._work)
        shutil.copytree(self._base, self._work)

    def _undisturbed(self) -> tuple[float, float]:
        """Refresh in a child; return the seconds to its first write, and in all."""
        times = []
        reads, child = _forked(self._work)
        for _ in range(2):
            os.read(reads, 1)
            times.append(time.perf_counter())
        os.close(reads)
        os.waitpid(child, 0)
        end = time.perf_counter()
        return times[1] - times[0], end - times[0]


def prepare(folder: Path) -> None:
    """Make the database of a calibrated lathe, and an inbox with what came in."""
    create_store(_url(folder))
    store = _opened(folder)
    add_machine(store, MACHINE, LATHE)
    standard = pd.read_csv(RECORDINGS / "standard-cuts.csv").drop(columns="tool")
    standard.to_csv(folder / "standard.csv", index=False)  # of no tool: nothing is learnt from it
    import_file(store, folder / "standard.csv", machine=MACHINE)
    calibrate_machine(store, MACHINE)
    refresh(store, MACHINE)
    _settled(store)
    inbox = folder / "in"
    inbox.mkdir()
    week = pd.read_csv(RECORDINGS / "shop-week-1.csv")
    for number in range(2):
        table = week.iloc[CUTS * number : CUTS * (number + 1)]
        table.to_csv(inbox / f"week-{number}.csv", index=False)
    shutil.copyfile(inbox / "week-0.csv", inbox / "again.csv")
    for ending in (".parquet", ".toml"):
        shutil.copyfile(RECORDINGS / f"standard-cut-raw{ending}", inbox / f"raw{ending}")
    (inbox / "broken.csv").write_text("cut,t\n1,2\n", encoding="utf-8")


def take(folder: Path) -> None:
    """Refresh from the inbox of a folder."""
    store = _opened(folder)
    try:
        refresh(store, MACHINE, inbox=Inbox(folder / "in", settled_s=0.0))
    finally:
        store.close()


def state_of(folder: Path) -> State:
    """Return what lies in a folder, and in its database."""
    store = _opened(folder)
    with store.reading() as session:
        rows = {
            table.name: sorted(
                tuple(
                    MONTH.sub("kept", repr(row[c])) for c in table.columns if c.name not in CLOCKS
                )
                for row in session.execute(select(table)).mappings()
            )
            for table in models.Base.metadata.sorted_tables
        }
    _settled(store)
    files = {
        MONTH.sub("kept", str(path.relative_to(folder))): hashlib.sha256(
            path.read_bytes()
        ).hexdigest()
        for path in sorted((folder / "in").rglob("*"))
        if path.is_file()
    }
    return State(rows, files)


def is_sound(folder: Path) -> bool:
    """Say whether SQLite finds the file whole and every foreign key leading somewhere."""
    store = _opened(folder)
    with store.engine.connect() as connection:
        whole = connection.exec_driver_sql("PRAGMA integrity_check").scalar() == "ok"
        led = connection.exec_driver_sql("PRAGMA foreign_key_check").all() == []
    store.close()
    return whole and led


def _phase(folder: Path) -> str:
    """Return how far a killed refresh had come, by what it left in the database."""
    store = _opened(folder)
    with store.reading() as session:
        files = session.scalar(select(func.count()).select_from(models.InboxFile)) or 0
        passes = session.scalar(select(func.count()).select_from(models.RefreshPass)) or 0
    store.close()
    if passes > 1:
        return PHASES[3]
    came_in = len([one for one in (folder / "in").iterdir() if one.is_file()])
    if not files:
        return PHASES[0]
    return PHASES[1] if came_in > 1 else PHASES[2]


def _kill(folder: Path, delay_s: float, *, from_write: bool) -> float:
    """Fork a refresh and kill it after a delay; return how long it had run, s."""
    reads, child = _forked(folder)
    os.read(reads, 1)
    start = time.perf_counter()
    if from_write:
        os.read(reads, 1)
    time.sleep(delay_s)
    os.kill(child, signal.SIGKILL)
    lived_s = time.perf_counter() - start
    os.close(reads)
    os.waitpid(child, 0)
    return lived_s


def _forked(folder: Path) -> tuple[int, int]:
    """Fork a refresh; return where a byte each says that it begins and first writes, and its id."""
    reads, writes = os.pipe()
    child = os.fork()
    if child:
        os.close(writes)
        return reads, child
    try:
        store = _opened(folder)
        os.write(writes, b"s")
        _on_first_write(store, lambda: os.write(writes, b"w"))
        refresh(store, MACHINE, inbox=Inbox(folder / "in", settled_s=0.0))
        store.close()
    finally:
        os._exit(0)


def _on_first_write(store: Store, call: Callable[[], object]) -> None:
    seen: list[bool] = []

    def before(_c: Any, _k: Any, statement: str, *_: Any) -> None:
        if statement.startswith("INSERT") and not seen:
            seen.append(True)
            call()

    event.listen(store.engine, "before_cursor_execute", before)


def _url(folder: Path) -> str:
    return f"sqlite:///{folder / 'autodb.sqlite3'}"


def _opened(folder: Path) -> Store:
    return open_store(_url(folder))


def _settled(store: Store) -> None:
    """Bring the write-ahead log into the file, so that one file is the database; close it."""
    with store.engine.connect() as connection:
        connection.exec_driver_sql("PRAGMA wal_checkpoint(TRUNCATE)")
    store.close()
