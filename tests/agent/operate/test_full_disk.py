"""A disk that is full: what writes says so, what reads still works, nothing is lost."""

import errno
import os
import resource
import signal
import subprocess
from collections.abc import Callable, Iterator
from contextlib import closing, suppress
from pathlib import Path

import pytest
from sqlalchemy import select

from autodb.files.excuses import excuse
from autodb.files.targets import write_text
from autodb.store import create_store, models, open_store
from autodb.store.copies import connect
from autodb.store.watched import Watched
from tests.conftest import Cli

pytestmark = pytest.mark.usefixtures("made_anew")

MEGABYTES = 8
READ: tuple[tuple[str, ...], ...] = (
    ("machine", "list"),
    ("machine", "show", "m"),
    ("lookup", "--machine", "m"),
    ("doctor",),
)
WRITTEN: tuple[tuple[str, ...], ...] = (
    ("machine", "add", "other"),
    ("token", "add", "panel"),
    ("import", "new.csv", "--machine", "m"),
    ("refresh", "--machine", "m", "--inbox", "in"),
    ("backup", "copy.sqlite3"),
    ("export", "tables"),
    ("restore", "{room}/copy.sqlite3", "--replace"),
    ("init", "--db", "sqlite:///new.sqlite3"),
)


def _table(path: Path, rows: int) -> None:
    path.parent.mkdir(exist_ok=True)
    cuts = "".join(f"{n},{n},{2 + n},brass,cutter\n" for n in range(1, rows + 1))
    path.write_text(f"cut,t,z.current,work.material,tool\n{cuts}")


@pytest.fixture
def full(cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Return a working folder on a small disk of its own; skips where none may be made."""
    del cli  # it goes to a working folder first
    at = tmp_path / "full"
    at.mkdir()
    made = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", f"size={MEGABYTES}m", "tmpfs", at],
        capture_output=True,
        check=False,
    )
    if made.returncode:
        pytest.skip("no disk may be mounted here")
    monkeypatch.chdir(at)
    try:
        yield at
    finally:
        monkeypatch.chdir(tmp_path)
        subprocess.run(["umount", "-l", at], check=True)


def _fill(at: Path) -> Path:
    """Write until there is no room; return what takes it."""
    filler = at / "filler"
    handle = os.open(filler, os.O_CREAT | os.O_WRONLY)
    with suppress(OSError):
        while True:
            os.write(handle, bytes(4096))
    os.close(handle)
    assert os.statvfs(at).f_bavail == 0
    return filler


def _log_of_a_killed_writer(path: Path) -> None:
    """Leave a write-ahead log with a machine in it, and no file by which it is shared."""
    child = os.fork()
    if child == 0:
        store = open_store(f"sqlite:///{path}")
        with store.writing() as session:
            session.add(models.Machine(name="in the log"))
        os.kill(os.getpid(), signal.SIGKILL)
    os.waitpid(child, 0)
    path.with_name(f"{path.name}-shm").unlink()
    assert path.with_name(f"{path.name}-wal").stat().st_size > 0


@pytest.mark.parametrize("killed", [False, True])
def test_commands_on_a_full_disk_read_or_say_so(
    full: Path, tmp_path: Path, cli: Cli, refused: Callable[..., str], killed: bool
) -> None:
    cli("init")
    cli("machine", "add", "m")
    _table(full / "old.csv", 2)
    assert cli("import", "old.csv", "--machine", "m").code == 0
    _table(full / "new.csv", 5)
    _table(full / "in" / "came.csv", 4)
    cli("backup", tmp_path / "copy.sqlite3")
    if killed:
        _log_of_a_killed_writer(full / "autodb.sqlite3")
    filler = _fill(full)
    for command in READ:
        assert cli(*command).code == 0, command
    assert ("in the log" in cli("machine", "list").out) == killed
    for command in WRITTEN:
        said = refused(*(word.format(room=tmp_path) for word in command))
        assert f"disk full under {full}; make room on the disk" in said, command
    assert cli("backup", tmp_path / "rescued.sqlite3").code == 0
    filler.unlink()
    assert cli("doctor").code == 0
    assert cli("machine", "list").out.count("other") == 0
    came = cli("refresh", "--machine", "m", "--inbox", "in").out
    assert "came.csv: recording 2, 2 new cuts, 2 there already" in came


def test_a_log_that_cannot_be_shared_is_read_all_the_same(tmp_path: Path) -> None:
    """Where a file may not grow, as on a full disk, also for those who may mount none.

    Nobody keeps the others out for longer than he reads, who watches for changes neither.
    """
    path = tmp_path / "a.sqlite3"
    create_store(f"sqlite:///{path}")
    _log_of_a_killed_writer(path)
    child = os.fork()
    if child == 0:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))
        os._exit(0 if _machines_thrice(path) == 3 * ["in the log"] else 1)
    assert os.waitpid(child, 0)[1] == 0


def _machines_thrice(path: Path) -> list[str]:
    """Read the machines' names over three connections, while a fourth is asked for changes."""
    found: list[str] = []
    store = open_store(f"sqlite:///{path}")
    watched = Watched(store)
    for _ in range(2):
        watched.mark()
        with store.reading() as session:
            found += session.scalars(select(models.Machine.name)).all()
    with closing(connect(path)) as file:
        found += [name for (name,) in file.execute("SELECT name FROM machine")]
    return found


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT])
def test_a_full_disk_is_named_by_what_was_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    """Also by a handle, of which nothing else says where it leads."""

    def full(_handle: int) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr("autodb.files.targets.os.fsync", full)
    with pytest.raises(OSError, match=os.strerror(number)) as found:
        write_text(tmp_path / "a.txt", "text")
    assert excuse(found.value) == f"disk full under {tmp_path}; make room on the disk"
    assert list(tmp_path.iterdir()) == []
