"""What may happen to a refresh from an inbox, and what is left: never less, never twice.

Each fault ends in the state of an undisturbed run, once what was wrong is put right.
"""

import errno
import os
import shutil
import signal
import sqlite3
import threading
import time
from collections.abc import Callable, Iterator
from datetime import datetime, tzinfo
from pathlib import Path

import pytest
from numpy.testing import assert_allclose
from sqlalchemy import event, select
from sqlalchemy.engine import Engine

from autodb.agent.ingest.arrival import Arrival
from autodb.cli import run
from autodb.proofs.runs.keeping.faults_run import (
    CLOCKS,
    MACHINE,
    State,
    is_sound,
    prepare,
    state_of,
    take,
)
from autodb.store import models, open_store
from autodb.store.engines import LOCKED_MS
from tests.conftest import learn_by_one_law
from tests.helpers.campaigns import first
from tests.helpers.children import at_once

URL = "sqlite:///autodb.sqlite3"


@pytest.fixture(scope="module", autouse=True)
def _one_law() -> Iterator[None]:
    """Learn by one law: what is asked is what becomes of rows and files."""
    with pytest.MonkeyPatch.context() as patch:
        learn_by_one_law(patch)
        yield


@pytest.fixture(scope="module")
def before(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a calibrated lathe, and an inbox with what came in."""
    folder = tmp_path_factory.mktemp("before") / "work"
    folder.mkdir()
    prepare(folder)
    return folder


@pytest.fixture
def work(before: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a copy of it, always in the same place, as the working folder."""
    folder = before.with_name("copy")
    if folder.exists():
        shutil.rmtree(folder)
    shutil.copytree(before, folder)
    monkeypatch.chdir(folder)
    return folder


@pytest.fixture(scope="module")
def undisturbed(before: Path) -> State:
    """Return what a refresh without any fault leaves."""
    folder = before.with_name("copy")
    if folder.exists():
        shutil.rmtree(folder)
    shutil.copytree(before, folder)
    take(folder)
    return state_of(folder)


def _said(capsys: pytest.CaptureFixture[str]) -> str:
    """Refresh by the command, which must refuse in one line; return it."""
    capsys.readouterr()
    assert run(["refresh", "--machine", MACHINE, "--inbox", "in"]) == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    return line


def _on_connect(statement: Callable[[sqlite3.Connection], str]) -> Callable[[], None]:
    """Have every new connection begin with a statement; return what ends that."""

    def connected(connection: sqlite3.Connection, _record: object) -> None:
        connection.execute(statement(connection))

    event.listen(Engine, "connect", connected)
    return lambda: event.remove(Engine, "connect", connected)


def _pages(connection: sqlite3.Connection) -> int:
    return int(connection.execute("PRAGMA page_count").fetchone()[0])


@pytest.mark.parametrize("pages", first(2, [0, 2, 1, 4]))
def test_a_full_disk_under_the_database(
    work: Path, undisturbed: State, capsys: pytest.CaptureFixture[str], pages: int
) -> None:
    full = _on_connect(lambda c: f"PRAGMA max_page_count={_pages(c) + pages}")
    try:
        assert f"disk full under {work}; make room on the disk" in _said(capsys)
    finally:
        full()
    take(work)
    left = state_of(work)
    assert left.files == undisturbed.files
    assert _but_ids(left) == _but_ids(undisturbed)


def _but_ids(state: State) -> dict[str, int]:
    """Return how many rows each table has; a file that was refused first is seen later."""
    return {name: len(rows) for name, rows in state.rows.items() if name != "refresh_pass"}


def test_a_full_disk_under_the_inbox(
    work: Path,
    undisturbed: State,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr(Arrival, "_link", full)
        said = _said(capsys)
        assert f"disk full under {work / 'in' / 'kept'}" in said
        assert "make room on the disk" in said
    assert len([one for one in (work / "in").iterdir() if one.is_file()]) == 6
    take(work)
    assert state_of(work) == undisturbed


def test_a_disk_that_cannot_be_written(
    work: Path, undisturbed: State, capsys: pytest.CaptureFixture[str]
) -> None:
    read_only = _on_connect(lambda _c: "PRAGMA query_only=ON")
    try:
        assert "give write permission, or use another database" in _said(capsys)
    finally:
        read_only()
    take(work)
    assert state_of(work) == undisturbed


def test_a_clock_that_jumps_back(
    work: Path, undisturbed: State, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Wrong(datetime):
        @classmethod
        def now(cls, tz: tzinfo | None = None) -> "Wrong":
            return cls(1990, 1, 1, tzinfo=tz)

    with monkeypatch.context() as patched:
        patched.setattr("autodb.store.models._base.datetime", Wrong)
        patched.setattr("autodb.agent.ingest.inbox.time.time", lambda: 631152000.0)
        patched.setattr(
            "autodb.agent.ingest.arrival.time.gmtime",
            lambda: time.struct_time((1990, 1) + 7 * (1,)),
        )
        take(work)
    assert state_of(work) == undisturbed
    take(work)  # and by the right clock again: nothing is new
    assert state_of(work) == undisturbed


def test_a_database_that_another_program_writes_to(work: Path, undisturbed: State) -> None:
    assert LOCKED_MS >= 2 * 60_000  # a minute's lock is outlived twice
    held, done = threading.Event(), threading.Event()

    def hold() -> None:
        other = sqlite3.connect(work / "autodb.sqlite3", isolation_level=None)
        other.execute("BEGIN IMMEDIATE")
        held.set()
        time.sleep(0.5)
        other.execute("ROLLBACK")
        other.close()
        done.set()

    thread = threading.Thread(target=hold)
    thread.start()
    held.wait()
    take(work)
    thread.join()
    assert done.is_set()
    assert state_of(work) == undisturbed


def test_one_that_writes_for_longer_is_said(
    work: Path,
    undisturbed: State,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("autodb.store.engines.LOCKED_MS", 50)
    other = sqlite3.connect(work / "autodb.sqlite3", isolation_level=None)
    other.execute("BEGIN IMMEDIATE")
    try:
        assert "wait until the other program that writes to it is done" in _said(capsys)
    finally:
        other.execute("ROLLBACK")
        other.close()
    take(work)
    assert state_of(work) == undisturbed


def test_recordings_that_come_out_of_order_and_again(work: Path, undisturbed: State) -> None:
    """The pair's posterior is the same, whichever came first, and however often."""
    inbox, later = work / "in", work / "later"
    later.mkdir()
    for name in ("week-0.csv", "again.csv"):
        (inbox / name).rename(later / name)
    take(work)
    for name in ("again.csv", "week-0.csv"):
        (later / name).rename(inbox / name)
        take(work)
    shutil.copyfile(next(inbox.rglob("kept/*/week-1.csv")), inbox / "week-1.csv")
    take(work)
    left = state_of(work)
    for table in ("recording", "cut", "sensed_force"):
        assert len(left.rows[table]) == len(undisturbed.rows[table])
    shuffled = _believed(work)
    shutil.rmtree(work)
    shutil.copytree(work.with_name("work"), work)
    take(work)
    straight = _believed(work)
    assert shuffled.n_cuts == straight.n_cuts
    # errors that cuts share stand in the order in which they came
    assert_allclose(sorted(shuffled.mean), sorted(straight.mean), rtol=0.0, atol=1e-9)


def _believed(work: Path) -> models.CuttingParameters:
    """Return the newest parameters that a database holds."""
    store = open_store(f"sqlite:///{work / 'autodb.sqlite3'}")
    with store.reading() as session:
        newest = session.scalars(
            select(models.CuttingParameters).order_by(models.CuttingParameters.id)
        ).all()[-1]
        session.expunge(newest)
    store.close()
    return newest


FORKS = "ignore:This process .* is multi-threaded:DeprecationWarning"


@pytest.fixture(scope="module")
def writes(before: Path, undisturbed: State) -> int:
    """Return how many statements of a refresh without any fault write."""
    del undisturbed  # it has taken in what is in this folder's copy, which is made anew
    folder = before.with_name("copy")
    shutil.rmtree(folder)
    shutil.copytree(before, folder)
    written: list[None] = []
    end = _on_write(lambda: written.append(None))
    try:
        take(folder)
    finally:
        end()
    return len(written)


def _on_write(call: Callable[[], object]) -> Callable[[], None]:
    """Have every statement that writes call something first; return what ends that."""

    def before(_c: object, _k: object, statement: str, *_: object) -> None:
        if statement.startswith(("INSERT", "UPDATE", "DELETE")):
            call()

    event.listen(Engine, "before_cursor_execute", before)
    return lambda: event.remove(Engine, "before_cursor_execute", before)


@pytest.mark.filterwarnings(FORKS)
@pytest.mark.parametrize("share", first(1, [0.5, 0.2, 0.9]))
def test_a_kill_at_a_write_loses_nothing_and_counts_nothing_twice(
    work: Path, undisturbed: State, writes: int, share: float
) -> None:
    """At a share of what it writes, whatever the time is that this takes."""
    left = iter(range(int(share * writes)))

    def die() -> None:
        if next(left, None) is None:
            os.kill(os.getpid(), signal.SIGKILL)

    def refreshed() -> None:
        _on_write(die)
        take(work)

    (ended,) = at_once(refreshed)
    assert ended == -signal.SIGKILL
    assert is_sound(work)
    take(work)
    assert state_of(work) == undisturbed


@pytest.mark.filterwarnings(FORKS)
@pytest.mark.parametrize("last", first(1, [1, 8]))
def test_kills_at_any_time_lose_nothing_and_count_nothing_twice(last: int) -> None:
    """Some kills; `autodb prove faults` has two hundred, and says how far each had come."""
    from autodb.proofs.runs.keeping.faults_run import run_faults

    kills = [one for seed in range(1, last + 1) for one in run_faults(seed)]
    assert all(one.sound and one.rows and one.files for one in kills), kills


def test_every_clock_column_that_is_not_compared_is_a_time() -> None:
    """What is left out of the comparison holds when, nothing else."""
    for table in models.Base.metadata.sorted_tables:
        for column in table.columns:
            if column.name in CLOCKS:
                assert str(column.type).startswith("VARCHAR"), (table.name, column.name)
