"""How long recordings are kept: compressed without a change, dropped without losing a value."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import date, timedelta
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from sqlalchemy import select, update

from autodb.agent.ingest.inbox import Inbox
from autodb.agent.operate import retaining, trash
from autodb.agent.operate.refreshing import refresh
from autodb.agent.operate.retaining import Retained, retain
from autodb.assets import kit
from autodb.files.side import SideFile
from autodb.records.source import open_as_stored
from autodb.records.tables import CutTable
from autodb.store import Store, models, open_store
from tests.conftest import Cli, Once

pytestmark = pytest.mark.usefixtures("one_law")

URL = "sqlite:///autodb.sqlite3"
MACHINE = "lathe-1"
WEEK = "shop-week-1.csv"
RECORDINGS = kit("sample_jobs") / "stepped_shaft" / "recordings"
LATHE = "[axes.x]\n[axes.z]\n[axes.spindle]\ncarries = 'work'\n"
OLD, NEW = "2026-01-01T00:00:00+00:00", "2026-03-01T00:00:00+00:00"


@contextmanager
def _opened() -> Iterator[Store]:
    store = open_store(URL)
    try:
        yield store
    finally:
        store.close()


@pytest.fixture
def kept(standard_learnt: Cli, once: Once) -> Cli:
    """Return a lathe whose inbox keeps two halves of a week, the first 59 days older."""
    learnt = Path.cwd()

    def keep() -> None:
        shutil.copytree(learnt, ".", dirs_exist_ok=True)
        Path("in").mkdir()
        week = pd.read_csv(RECORDINGS / WEEK)
        for name, rows in (("old", slice(0, 6)), ("new", slice(6, 12))):
            week.iloc[rows].to_csv(f"in/{name}.csv", index=False)
            Path(f"in/{name}.toml").write_text('[recording]\ncoolant = "dry"\n', encoding="utf-8")
            with _opened() as store:
                refresh(store, MACHINE, inbox=Inbox(Path("in"), settled_s=0.0))
                with store.writing() as session:
                    mine = models.StoredRecording.path.endswith(f"{name}.csv")
                    came = OLD if name == "old" else NEW
                    row = update(models.StoredRecording).where(mine).values(imported_at=came)
                    session.execute(row)

    once(keep)
    return standard_learnt


def _policy(cli: Cli, text: str) -> None:
    Path("machine.toml").write_text(f"{LATHE}[retention]\n{text}\n", encoding="utf-8")
    done = cli("machine", "update", MACHINE, "--file", "machine.toml")
    assert done.code == 0, done.err


def _retain() -> Retained:
    with _opened() as store:
        return retain(store, MACHINE)


def _files() -> set[str]:
    return {path.name for path in Path("in").rglob("*") if path.is_file()}


def _row(name: str) -> models.StoredRecording:
    with _opened() as store, store.reading() as session:
        query = select(models.StoredRecording).where(
            models.StoredRecording.delivered_as.endswith(name)
        )
        row = session.scalars(query).one()
        session.expunge(row)
        return row


def _cuts(path: Path) -> CutTable:
    found = open_as_stored(path, SideFile()).choose().read()
    assert isinstance(found, CutTable)
    return found


def _thrown() -> list[str]:
    return [path.name for path in Path("in/kept/.trash").rglob("*.csv")]


@pytest.mark.usefixtures("kept")
def test_without_a_policy_nothing_goes() -> None:
    before = _files()
    assert _retain() == Retained()
    assert _files() == before


def test_an_old_recording_is_compressed_and_reads_the_same(kept: Cli) -> None:
    original = _cuts(next(Path("in/kept").rglob("old.csv")))
    _policy(kept, "compress_after_days = 30")
    done = kept("refresh", "--machine", MACHINE)
    assert "1 recordings compressed, " in done.out
    assert {"old.csv.parquet", "old.toml", "new.csv", "new.toml"} == _files()
    row = _row("old.csv")
    copy = _cuts(Path(str(row.stored_path)))
    assert copy.channels.keys() == original.channels.keys()
    for name, values in original.channels.items():
        np.testing.assert_array_equal(copy[name], values)
    assert copy.texts == original.texts
    assert kept("doctor").code == 0
    assert "compressed" not in kept("refresh", "--machine", MACHINE).out


def test_a_dropped_recording_leaves_all_that_was_derived(kept: Cli) -> None:
    with _opened() as store, store.reading() as session:
        before = session.scalars(select(models.SensedForce.value_N)).all()
    _policy(kept, "compress_after_days = 1\ndrop_after_days = 30")
    assert _retain().dropped == 1
    assert {"old.toml", "new.csv", "new.toml", "old.csv"} == _files()
    assert _thrown() == ["old.csv"]
    with _opened() as store, store.reading() as session:
        assert session.scalars(select(models.SensedForce.value_N)).all() == before
    assert kept("doctor").code == 0
    assert "old.csv" in kept("trace", "parameters", 3).out
    assert _retain() == Retained()

    # Delivered again it counts once, and is as old as it was
    pd.read_csv(RECORDINGS / WEEK).iloc[:6].to_csv("in/old.csv", index=False)
    with _opened() as store:
        done = refresh(store, MACHINE, inbox=Inbox(Path("in"), settled_s=0.0))
    assert [one.cuts for one in done.came_in] == [0]
    assert done.retained == ["1 recordings dropped, into kept/.trash; what was derived stays"]
    assert len(_thrown()) == 1


def test_files_that_no_inbox_keeps_are_not_touched(kept: Cli) -> None:
    Path("mine.csv").write_bytes((RECORDINGS / WEEK).read_bytes() + b"\n")
    kept("import", "mine.csv", "--machine", MACHINE)
    with _opened() as store, store.writing() as session:
        session.execute(
            update(models.StoredRecording)
            .where(models.StoredRecording.path.endswith("mine.csv"))
            .values(imported_at=OLD)
        )
    pd.read_csv(RECORDINGS / WEEK).iloc[5:9].to_csv("in/last.csv", index=False)
    with _opened() as store:
        refresh(store, MACHINE, inbox=Inbox(Path("in"), settled_s=0.0))
    _policy(kept, "drop_after_days = 10")
    _retain()
    assert Path("mine.csv").is_file()


def test_a_clock_that_jumped_back_makes_nothing_old(kept: Cli) -> None:
    _policy(kept, "drop_after_days = 10")
    with _opened() as store, store.writing() as session:
        last = models.StoredRecording.path.endswith("new.csv")
        session.execute(
            update(models.StoredRecording)
            .where(last)
            .values(imported_at="1970-01-01T00:00:10+00:00")
        )
    assert _retain() == Retained()


def _imported(name: str, at: str) -> None:
    with _opened() as store, store.writing() as session:
        mine = models.StoredRecording.path.endswith(f"{name}.csv")
        session.execute(update(models.StoredRecording).where(mine).values(imported_at=at))


def test_a_clock_that_jumped_ahead_drops_nothing(kept: Cli) -> None:
    """Until imports of three days lie behind what looks like a jump."""
    _policy(kept, "drop_after_days = 100")
    _imported("new", "2027-03-01T00:00:00+00:00")
    (said,) = _retain().left
    assert said.startswith("imports of 2026-01-01 and 2027-03-01 lie 424 days apart")
    for number, day in enumerate((2, 3)):
        pd.read_csv(RECORDINGS / WEEK).iloc[[20 + number]].to_csv(f"in/{day}.csv", index=False)
        with _opened() as store:
            refresh(store, MACHINE, inbox=Inbox(Path("in"), settled_s=0.0))
        assert "old.csv" in [path.name for path in Path("in/kept").glob("2*/*")]
        _imported(str(day), f"2027-03-0{day}T00:00:00+00:00")
    assert _retain().dropped == 1


def test_what_was_dropped_is_there_for_a_while_and_comes_back(
    kept: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    _policy(kept, "drop_after_days = 30")
    assert _retain().dropped == 1
    thrown = next(Path("in/kept/.trash").rglob("old.csv"))
    dropped = date.fromisoformat(thrown.parts[3])
    monkeypatch.setattr(trash, "_today", lambda: dropped + timedelta(days=400))
    _retain()
    assert _thrown() == ["old.csv"]  # there was no pass on another day
    _policy(kept, "drop_after_days = 3000")
    thrown.rename("in/old.csv")
    with _opened() as store:
        refresh(store, MACHINE, inbox=Inbox(Path("in"), settled_s=0.0))
    assert _row("old.csv").dropped_at is None
    assert kept("doctor").code == 0


def test_the_trash_is_emptied_after_a_month_and_a_week_of_passes(
    kept: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    _policy(kept, "drop_after_days = 30")
    _retain()
    dropped = date.fromisoformat(next(Path("in/kept/.trash").rglob("old.csv")).parts[3])
    for number in range(1, 8):
        day = (dropped + timedelta(days=4 * number)).isoformat()
        with _opened() as store, store.writing() as session:
            session.add(models.RefreshPass(machine_id=1, status="done", finished_at=day))
        monkeypatch.setattr(trash, "_today", lambda: dropped + timedelta(days=29))
        _retain()
        assert _thrown() == ["old.csv"]
    monkeypatch.setattr(trash, "_today", lambda: dropped + timedelta(days=30))
    _retain()
    assert _thrown() == []


def test_a_kill_before_the_original_goes_is_made_good(
    kept: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    _policy(kept, "compress_after_days = 30")
    unlink = Path.unlink

    def killed(path: Path, missing_ok: bool = False) -> None:
        if path.name == "old.csv":
            raise KeyboardInterrupt
        unlink(path, missing_ok=missing_ok)

    with monkeypatch.context() as patched:
        patched.setattr(Path, "unlink", killed)
        with pytest.raises(KeyboardInterrupt):
            _retain()
    assert {"old.csv", "old.csv.parquet"} <= _files()
    assert _retain() == Retained()
    assert "old.csv" not in _files()


def test_what_would_read_otherwise_stays_as_it_is(
    kept: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    _policy(kept, "compress_after_days = 30")
    write = retaining._write

    def other(path: Path, side: SideFile, target: Path) -> None:
        write(path, side, target)
        table = pd.read_parquet(target)
        table["t"] += 1.0
        table.to_parquet(target)

    monkeypatch.setattr(retaining, "_write", other)
    done = _retain()
    assert done.compressed == 0
    assert "not compressed: column 't' reads otherwise" in done.left[0]
    assert "old.csv" in _files()
    assert "old.csv.parquet" not in _files()


def test_a_recording_that_was_altered_is_not_compressed(kept: Cli) -> None:
    _policy(kept, "compress_after_days = 30")
    path = next(Path("in/kept").rglob("old.csv"))
    path.write_text(path.read_text(encoding="utf-8") + "\n", encoding="utf-8")
    assert "not as it was imported" in _retain().left[0]
    assert path.is_file()


def test_a_policy_that_drops_before_it_compresses_is_refused(cli: Cli) -> None:
    cli("init")
    text = f"{LATHE}[retention]\ncompress_after_days = 30\ndrop_after_days = 20\n"
    Path("machine.toml").write_text(text, encoding="utf-8")
    done = cli("machine", "add", MACHINE, "--file", "machine.toml")
    assert done.code == 2
    assert "drop_after_days" in done.err
