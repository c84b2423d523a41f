"""A file of an inbox is taken once, by what it is; an entry that is none costs itself alone."""

import os
import shutil
import socket
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
from sqlalchemy import Executable, select

from autodb.agent.ingest import arrival
from autodb.agent.ingest.importing import import_file
from autodb.agent.ingest.inbox import Inbox
from autodb.agent.learn.passes import RefreshReport
from autodb.agent.operate.refreshing import refresh
from autodb.assets import kit
from autodb.files.checksums import checksum
from autodb.store import models, open_store
from tests.conftest import Cli, Once

URL = "sqlite:///autodb.sqlite3"
MACHINE = "lathe-1"
RECORDINGS = kit("sample_jobs") / "stepped_shaft" / "recordings"
CUTS = 16


@pytest.fixture(autouse=True)
def there(cli: Cli, once: Once) -> Cli:
    """Return a database with a lathe that has cut nothing, and an empty inbox."""

    def make() -> None:
        cli("init")
        cli("machine", "add", MACHINE)
        Path("in").mkdir()

    once(make)
    return cli


def _week(first: int = 0, last: int = CUTS) -> pd.DataFrame:
    return pd.read_csv(RECORDINGS / "shop-week-1.csv").iloc[first:last]


def _take() -> RefreshReport:
    store = open_store(URL)
    try:
        return refresh(store, MACHINE, inbox=Inbox(Path("in"), settled_s=0.0))
    finally:
        store.close()


def _rows(query: Executable) -> list[tuple[Any, ...]]:
    store = open_store(URL)
    try:
        with store.reading() as session:
            return [tuple(row) for row in session.execute(query)]
    finally:
        store.close()


def _numbers() -> list[float]:
    """Return the numbers of the cuts that count."""
    counts = select(models.Cut.number).where(models.Cut.superseded_at.is_(None))
    return sorted(number for (number,) in _rows(counts))


def _hidden() -> list[str]:
    return [path.name for path in Path("in").rglob(".*")]


# --- entries that nothing can be read of


def _pipe(path: Path) -> None:
    os.mkfifo(path)


def _socket(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as made:
        made.bind(str(path))


ODD: dict[str, tuple[Callable[[Path], object], str]] = {
    "pipe.csv": (_pipe, "pipe.csv: a pipe; deliver a file"),
    "socket.csv": (_socket, "socket.csv: a socket; deliver a file"),
    "zero.csv": (lambda p: p.symlink_to("/dev/zero"), "zero.csv: a link; deliver the file"),
    "loop.csv": (lambda p: p.symlink_to(p.name), "loop.csv: a link; deliver the file"),
    "folder.csv": (lambda p: p.symlink_to("/"), "folder.csv: a link; deliver the file"),
    "two\nlines.csv": (lambda p: p.write_text("cut"), "'two\\nlines.csv': a name that is not text"),
    os.fsdecode(b"\xff.csv"): (
        lambda p: p.write_text("cut"), "'\\udcff.csv': a name that is not text",
    ),
}  # fmt: skip


def test_an_odd_entry_costs_itself_alone() -> None:
    for name, (make, _) in ODD.items():
        make(Path("in") / name)
    _week().to_csv("in/week.csv", index=False)
    said = _take().set_aside
    for _, words in ODD.values():
        assert any(line.startswith(words) for line in said), words
    assert _numbers() == list(_week()["cut"])
    assert len(list(Path("in").iterdir())) == len(ODD) + 1
    assert _hidden() == []


def test_a_file_that_may_not_be_read_costs_itself_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    real = os.open

    def refuse(path: object, *rest: int) -> int:
        if str(path).endswith("theirs.csv"):
            raise PermissionError(13, "Permission denied")
        return real(path, *rest)  # type: ignore[arg-type]

    _week(0, 8).to_csv("in/theirs.csv", index=False)
    _week(8).to_csv("in/week.csv", index=False)
    with monkeypatch.context() as patched:
        patched.setattr("autodb.agent.ingest.entries.os.open", refuse)
        said = _take().set_aside
    assert any(line.startswith("theirs.csv: cannot be read (Permission denied)") for line in said)
    assert _numbers() == list(_week(8)["cut"])
    _take()
    assert _numbers() == list(_week()["cut"])


# --- files that change while they are taken


def test_a_new_file_renamed_over_one_that_is_imported_is_another(
    there: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A logger gives each day's file the same name, and does so while the last is read."""
    latest = Path("in/latest.csv")
    _week(0, 8).to_csv(latest, index=False)
    real = import_file

    def meanwhile(*given: object, **named: object) -> object:
        if not Path("next.csv").exists() and latest.exists():
            _week(8).to_csv("next.csv", index=False)
            shutil.copy("next.csv", "moved.csv")
            Path("moved.csv").rename(latest)
        return real(*given, **named)  # type: ignore[arg-type]

    monkeypatch.setattr(arrival, "import_file", meanwhile)
    _take()
    assert _numbers() == list(_week(0, 8)["cut"])
    _take()
    assert _numbers() == list(_week()["cut"])
    kept = _rows(select(models.StoredRecording.path, models.StoredRecording.sha256))
    assert [checksum(Path(path)) for path, _ in kept] == [sha256 for _, sha256 in kept]
    assert there("doctor").code == 0
    assert _hidden() == []


def test_a_file_that_grows_while_it_is_imported_is_taken_by_the_next_pass(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    path = Path("in/week.csv")
    _week(0, 8).to_csv(path, index=False)
    real = import_file

    def meanwhile(*given: object, **named: object) -> object:
        _week(8).to_csv(path, index=False, header=False, mode="a")
        return real(*given, **named)  # type: ignore[arg-type]

    with monkeypatch.context() as patched:
        patched.setattr(arrival, "import_file", meanwhile)
        assert "week.csv: still being written; the next pass takes it" in _take().set_aside
    assert _numbers() == []
    assert not list(Path("in/kept").rglob("*.csv"))
    _take()
    assert _numbers() == list(_week()["cut"])


def test_a_logger_that_paused_and_goes_on_is_read_on(there: Cli) -> None:
    with Path("in/week.csv").open("w") as logger:
        _week(0, 6).to_csv(logger, index=False)
        logger.flush()
        _take()
        assert _numbers() == list(_week(0, 6)["cut"])
        for first, last in ((6, 12), (12, CUTS)):
            _week(first, last).to_csv(logger, index=False, header=False)
            logger.flush()
            ill = there("doctor")
            assert ill.code == 1
            assert "has grown since it was imported" in ill.out
            _take()
            assert _numbers() == list(_week(0, last)["cut"])
            assert there("doctor").code == 0
    assert not list(Path("in").glob("*.csv"))
    assert _hidden() == []


def test_what_lies_where_a_recording_lay_and_is_not_more_of_it_is_said() -> None:
    _week(0, 8).to_csv("in/week.csv", index=False)
    _take()
    (kept,) = Path("in/kept").rglob("week.csv")
    _week().to_csv(kept, index=False)
    kept.write_text(kept.read_text().replace("turn", "turm", 1))
    said = _take().set_aside
    assert any("its beginning differs from what was imported" in line for line in said)
    assert _numbers() == list(_week(0, 8)["cut"])


def test_a_recording_over_time_is_read_on() -> None:
    lines = (RECORDINGS / "air-moves.csv").read_text().splitlines(keepends=True)
    with Path("in/moves.csv").open("w") as logger:
        logger.writelines(lines[:2000])
        logger.flush()
        _take()
        logger.writelines(lines[2000:3000])
    _take()
    row = models.StoredRecording
    rows = _rows(select(row.id, row.rows, row.continues_id))
    assert rows == [(1, 1999, None), (2, 2999, 1)]


# --- what is kept and not in the database


def test_after_an_older_backup_what_is_kept_is_read_again(there: Cli) -> None:
    _week(0, 8).to_csv("in/monday.csv", index=False)
    _take()
    there("backup", "monday.sqlite3")
    (Path("in") / "cell").mkdir()
    _week(8).to_csv("in/cell/tuesday.csv", index=False)
    Path("in/cell/tuesday.toml").write_text('[recording]\nstart = "2026-03-03"\n')
    _take()
    said = there("restore", "monday.sqlite3", "--replace")
    assert "lathe-1: 1 recordings that its inbox keeps are not in it" in said.out
    assert "kept recordings not imported: lathe-1: " in there("doctor").out
    assert [one.file for one in _take().came_in] == ["tuesday.csv"]
    assert _numbers() == list(_week()["cut"])
    row = models.StoredRecording
    ((came_as, side),) = _rows(select(row.delivered_as, row.side).where(row.id == 2))
    assert came_as == str(Path("in/cell/tuesday.csv").resolve())
    assert side == {"recording": {"start": "2026-03-03"}}
    assert there("doctor").code == 0


def test_killed_as_it_leaves_the_inbox_it_is_there_again(monkeypatch: pytest.MonkeyPatch) -> None:
    _week().to_csv("in/week.csv", index=False)
    store = open_store(URL)
    with monkeypatch.context() as patched:
        patched.setattr(Path, "unlink", lambda *_, **__: os._exit(9))
        child = os.fork()
        if child == 0:
            refresh(store, MACHINE, inbox=Inbox(Path("in"), settled_s=0.0))
            os._exit(0)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 9
    store.close()
    _take()
    assert _numbers() == list(_week()["cut"])
    assert not list(Path("in").glob("*.csv"))
    assert _hidden() == []


def test_a_newer_file_keeps_the_name(tmp_path: Path) -> None:
    leaving, path = tmp_path / ".0123456789abcdef.leaving.a.csv", tmp_path / "a.csv"
    leaving.write_text("older")
    path.write_text("newer")
    arrival.back(leaving, path)
    assert path.read_text() == "newer"
    assert (tmp_path / "a-0123456789abcdef.csv").read_text() == "older"
    assert not leaving.exists()
