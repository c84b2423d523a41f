"""What is replaced has one writer, is whole or as it was, and nothing of a killed writer stays."""

import os
import signal
import sqlite3
import time
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path

import pytest

from autodb.errors import UnusableInput
from autodb.files import targets
from autodb.files.targets import hidden, replace_by, write_text
from autodb.store import create_store, models, open_store
from autodb.store.backups import backup
from autodb.store.exports import export, read_manifest
from autodb.store.restoring import restore
from tests.helpers.children import at_once, begun

pytestmark = pytest.mark.filterwarnings("ignore:This process .* is multi-threaded")
ROUNDS = 2
ROWS = 20_000
"""Rows of a database that takes long enough to copy for two copies to meet."""


def _killed(work: Callable[[], object]) -> None:
    """Run in a child that is killed at the first `_die`."""
    assert os.waitstatus_to_exitcode(os.waitpid(begun(work), 0)[1]) == -signal.SIGKILL


def _die(*_: object) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def _stray(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir() if path.name.startswith("."))


@pytest.fixture(scope="module")
def filled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a database of some megabytes."""
    path = tmp_path_factory.mktemp("filled") / "full.sqlite3"
    url = f"sqlite:///{path}"
    create_store(url)
    store = open_store(url)
    rows = [
        {"who": f"panel {n}", "action": "read", "at": "2026", "sha256": ""} for n in range(ROWS)
    ]
    with store.writing() as session:
        session.bulk_insert_mappings(models.AuditEntry.__mapper__, rows)
    store.close()
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("PRAGMA journal_mode=DELETE")
    return path


def _audited(path: Path) -> int:
    with closing(sqlite3.connect(path)) as connection:
        assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
        return int(connection.execute("SELECT COUNT(*) FROM audit_entry").fetchone()[0])


def test_two_backups_at_once_leave_one_that_is_whole(filled: Path, tmp_path: Path) -> None:
    target = tmp_path / "copy.sqlite3"
    backup(f"sqlite:///{filled}", target)

    def again() -> None:
        backup(f"sqlite:///{filled}", target, replace=True)

    for _ in range(ROUNDS):
        assert at_once(again, again) == [0, 0]
        assert _audited(target) == ROWS
    assert _stray(tmp_path) == []


def test_two_restores_at_once_leave_the_database(filled: Path, tmp_path: Path) -> None:
    database = tmp_path / "autodb.sqlite3"
    url = f"sqlite:///{database}"
    restore(url, filled)

    def again() -> None:
        restore(url, filled, replace=True)

    for _ in range(ROUNDS):
        assert at_once(again, again) == [0, 0]
        assert _audited(database) == ROWS
    assert _stray(tmp_path) == []


def test_of_two_exports_into_one_folder_one_is_there(filled: Path, tmp_path: Path) -> None:
    store = open_store(f"sqlite:///{filled}")
    for number in range(ROUNDS):
        folder = tmp_path / f"out {number}"

        def out(folder: Path = folder) -> None:
            export(store, folder)

        assert sorted(at_once(out, out)) == [0, 2]
        assert read_manifest(folder).tables["audit_entry"].rows == ROWS
    store.close()
    assert _stray(tmp_path) == []


def _written_slowly(target: Path, letter: str) -> Callable[[], None]:
    def write() -> None:
        with hidden(target) as part, part.open("w") as file:
            for _ in range(20):
                file.write(letter * 1000)
                file.flush()
                time.sleep(1e-3)
            replace_by(part, target)

    return write


def test_a_file_is_of_one_writer(tmp_path: Path) -> None:
    target = tmp_path / "card.html"
    for _ in range(ROUNDS):
        assert at_once(*(_written_slowly(target, letter) for letter in "abc")) == [0, 0, 0]
        text = target.read_text()
        assert len(text) == 20_000
        assert len(set(text)) == 1
    assert _stray(tmp_path) == []


def test_who_waits_too_long_gets_a_message(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(targets, "SOON_S", 0.01)
    monkeypatch.setattr(targets, "BUSY_S", 0.05)
    said: list[str] = []
    target = tmp_path / "copy.sqlite3"
    with (
        hidden(target),
        pytest.raises(UnusableInput, match="another program has been writing it"),
        hidden(target, said.append),
    ):
        pass
    assert said == ["waiting for another that writes copy.sqlite3"]
    assert _stray(tmp_path) == []


def _folder(parent: Path, text: str) -> Callable[[], None]:
    def write() -> None:
        with hidden(parent / "ex") as new:
            (new / "axis").mkdir(parents=True)
            (new / "axis" / "report.html").write_text(text)
            replace_by(new, parent / "ex")

    return write


MOMENTS: Sequence[tuple[str, str]] = (
    ("autodb.files.targets._content", "old"),
    ("autodb.files.targets.sync", "old"),
    ("pathlib.Path.rename", "old"),
    ("autodb.files.targets.shutil.rmtree", "new"),
)
"""Where a writer of a folder is killed, and which one lies there once another has begun."""


@pytest.mark.parametrize(("moment", "left"), MOMENTS)
def test_a_folder_of_a_killed_writer_is_whole_and_its_leavings_go(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, moment: str, left: str
) -> None:
    _folder(tmp_path, "old")()
    with monkeypatch.context() as patched:
        patched.setattr(moment, _die)
        _killed(_folder(tmp_path, "new"))
    assert _stray(tmp_path)
    with hidden(tmp_path / "ex"):
        assert (tmp_path / "ex" / "axis" / "report.html").read_text() == left
    assert _stray(tmp_path) == []
    _folder(tmp_path, "again")()
    assert (tmp_path / "ex" / "axis" / "report.html").read_text() == "again"


def test_killed_between_two_renames_the_old_folder_lies_there_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _folder(tmp_path, "old")()
    real, done = Path.rename, []

    def second(self: Path, target: Path) -> Path:
        done.append(self)
        if len(done) == 2:
            _die()
        return real(self, target)

    with monkeypatch.context() as patched:
        patched.setattr(Path, "rename", second)
        _killed(_folder(tmp_path, "new"))
    assert not (tmp_path / "ex").exists()
    with hidden(tmp_path / "ex"):
        assert (tmp_path / "ex" / "axis" / "report.html").read_text() == "old"
    assert _stray(tmp_path) == []


def test_what_lies_there_is_what_was_written_or_it_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = Path.replace

    def spoilt(self: Path, target: Path) -> Path:
        moved = real(self, target)
        moved.write_text("another")
        return moved

    monkeypatch.setattr(Path, "replace", spoilt)
    with pytest.raises(UnusableInput, match="differs from what was written"):
        write_text(tmp_path / "card.html", "card")


def test_another_targets_files_are_left_alone(tmp_path: Path) -> None:
    other = tmp_path / ".0123456789abcdef.partial.b.a"
    other.write_text("of b.a")
    with hidden(tmp_path / "a"):
        pass
    assert _stray(tmp_path) == [other.name]
