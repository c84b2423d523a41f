"""Backups: whole copies, taken under load, that replace nothing unasked."""

import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from autodb.errors import UnusableInput
from autodb.store import create_store, models, open_store
from autodb.store.backups import backup
from tests.conftest import Cli
from tests.helpers.kept import DB, rows_of

pytestmark = pytest.mark.usefixtures("one_law")


def test_a_backup_holds_the_same_rows(cli: Cli, recordings: Path) -> None:
    del recordings
    assert "schema" in cli("backup", "copy.sqlite3").out
    assert rows_of(Path("copy.sqlite3")) == rows_of(DB)
    assert not list(Path().glob(".copy*"))
    assert not Path("copy.sqlite3-wal").exists()


def test_a_backup_never_overwrites_unasked(cli: Cli, refused: Callable[..., str]) -> None:
    cli("init")
    Path("notes").write_text("something else")
    assert "notes: is there already" in refused("backup", "notes")
    assert "notes: is no backup" in refused("backup", "notes", "--replace")
    assert Path("notes").read_text() == "something else"
    assert cli("backup", "copy.sqlite3").code == 0
    assert cli("backup", "copy.sqlite3", "--replace").code == 0
    assert "cannot be a backup file" in refused("backup", DB, "--replace")
    assert "cannot be a backup file" in refused("backup", "/dev/null", "--replace")
    assert "the database's own log" in refused("backup", f"{DB}-wal")
    Path("link.sqlite3").symlink_to("copy.sqlite3")
    assert cli("backup", "link.sqlite3", "--replace").code == 0
    assert Path("link.sqlite3").is_symlink()
    assert "no such folder" in refused("backup", "nowhere/copy.sqlite3")
    cli("machine", "add", "lathe-1")
    assert "copi.sqlite3: no such file (did you mean copy" in refused("restore", "copi.sqlite3")
    assert "no database there" in refused("backup", "b.sqlite3", "--db", "sqlite:///none.sqlite3")
    assert "only SQLite and" in refused("backup", "b.sqlite3", "--db", "mysql://localhost/a")


def test_backups_during_writes_hold_whole_transactions(tmp_path: Path) -> None:
    """A thread writes two machines a transaction; every copy holds an even number, ever more."""
    url = f"sqlite:///{tmp_path / 'a.sqlite3'}"
    create_store(url)
    stop, wrote = threading.Event(), threading.Event()

    def write() -> None:
        store = open_store(url)
        number = 0
        while not stop.is_set():
            with store.writing() as session:
                session.add(models.Machine(name=f"left {number}"))
                session.flush()
                session.add(models.Machine(name=f"right {number}"))
            number += 1
            wrote.set()
        store.close()

    thread = threading.Thread(target=write)
    thread.start()
    seen = []
    try:
        for number in range(8):
            wrote.clear()
            assert wrote.wait(60)
            seen.append(backup(url, tmp_path / f"{number}.sqlite3").rows["machine"])
    finally:
        stop.set()
        thread.join()
    assert all(n % 2 == 0 for n in seen)
    assert seen == sorted(seen)
    assert seen[0] < seen[-1]
    for number, n in enumerate(seen):
        assert len(rows_of(tmp_path / f"{number}.sqlite3")["machine"]) == n


def test_a_damaged_database_is_not_copied(cli: Cli, recordings: Path) -> None:
    del recordings
    cli("backup", "copy.sqlite3")
    whole = Path("copy.sqlite3").read_bytes()
    Path("bad.sqlite3").write_bytes(whole[: len(whole) // 2] + b"\x00" * (len(whole) // 2))
    done = cli("backup", "again.sqlite3", "--db", "sqlite:///bad.sqlite3")
    assert done.code == 2
    assert "bad.sqlite3" in done.err
    assert not Path("again.sqlite3").exists()


def test_a_database_in_memory_has_no_backup() -> None:
    with pytest.raises(UnusableInput, match="in memory"):
        backup("sqlite://", Path("a"))
