"""Restoring: what was backed up comes back whole, or not at all."""

import json
import os
import signal
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from autodb.store import create_store, head, models, open_store
from autodb.store.restoring import restore
from tests.conftest import Cli
from tests.helpers.kept import DB, URL, rows_of
from tests.helpers.released import VERSIONS, unpacked

pytestmark = pytest.mark.usefixtures("one_law", "made_anew")


def test_restoring_brings_back_what_was_backed_up(
    cli: Cli, refused: Callable[..., str], recordings: Path
) -> None:
    del recordings
    before = rows_of(DB)
    cli("backup", "copy.sqlite3")
    cli("machine", "add", "later")
    assert "--replace" in refused("restore", "copy.sqlite3")
    assert len(rows_of(DB)["machine"]) == 2
    assert cli("restore", "copy.sqlite3", "--replace").code == 0
    assert rows_of(DB) == before
    assert cli("refresh", "--machine", "lathe-1").code == 0
    cli("init", "--db", "sqlite:///empty.sqlite3")
    assert cli("restore", "copy.sqlite3", "--db", "sqlite:///empty.sqlite3").code == 0
    assert rows_of(Path("empty.sqlite3")) == before


@pytest.mark.parametrize("version", VERSIONS)
def test_a_backup_of_a_released_version_is_upgraded(cli: Cli, version: str) -> None:
    schema = unpacked(version, Path("old.sqlite3"))
    before = Path("old.sqlite3").read_bytes()
    assert f"schema {schema}, upgraded to {head()}" in cli("restore", "old.sqlite3").out
    assert "lathe-1" in cli("machine", "list").out
    assert Path("old.sqlite3").read_bytes() == before


def _text(path: Path) -> None:
    path.write_text("no database, but long enough to be read as one " * 20)


def _of_another_program(path: Path) -> None:
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("CREATE TABLE a (b)")


def _of_a_later_version(path: Path) -> None:
    create_store(f"sqlite:///{path}")
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("UPDATE alembic_version SET version_num = '9999'")
        connection.commit()


def _empty_file(path: Path) -> None:
    path.touch()


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (_text, "cannot be copied as a database"),
        (_of_another_program, "no autodb database"),
        (_of_a_later_version, "schema 9999 is not known"),
        (_empty_file, "no autodb database"),
        (lambda _path: None, "no such file"),
    ],
)
def test_what_is_no_backup_is_not_restored(
    cli: Cli, refused: Callable[..., str], make: Callable[[Path], None], says: str
) -> None:
    cli("init")
    cli("machine", "add", "kept")
    make(Path("source"))
    assert f"source: {says}" in refused("restore", "source", "--replace")
    assert "kept" in cli("machine", "list").out


def test_what_is_no_database_of_ours_is_never_replaced(
    cli: Cli, refused: Callable[..., str]
) -> None:
    cli("init", "--db", "sqlite:///good.sqlite3")
    _of_another_program(DB)
    assert "no autodb database" in refused("restore", "good.sqlite3", "--replace")
    assert "a" in rows_of(DB)
    _text(Path("text"))
    line = refused("restore", "good.sqlite3", "--db", "sqlite:///text")
    assert "is there and cannot be read as a database" in line


def test_a_damaged_database_is_found_and_moved_by_a_restore(cli: Cli) -> None:
    cli("init")
    store = open_store(URL)
    with store.writing() as session:
        session.add_all(models.Machine(name=f"machine-{number}") for number in range(200))
    store.close()
    cli("backup", "copy.sqlite3")
    whole = Path(DB).read_bytes()
    page = 4096
    Path(DB).write_bytes(whole[: 5 * page] + bytes(3 * page) + whole[8 * page :])
    found = cli("doctor")
    assert found.code == 1
    assert "integrity of the file" in found.out
    Path(DB).write_bytes(b"junk" * 4000)
    assert cli("restore", "copy.sqlite3", "--replace").code == 0
    assert Path(f"{DB}.damaged").read_bytes() == b"junk" * 4000
    assert "machine-199" in cli("machine", "list").out


def test_a_symlinked_database_stays_one(cli: Cli) -> None:
    Path("real").mkdir()
    Path("link.sqlite3").symlink_to("real/a.sqlite3")
    link = "sqlite:///link.sqlite3"
    cli("init", "--db", link)
    cli("machine", "add", "m", "--db", link)
    cli("backup", "copy.sqlite3", "--db", link)
    assert cli("restore", "copy.sqlite3", "--replace", "--db", link).code == 0
    assert Path("link.sqlite3").is_symlink()
    assert Path("real/a.sqlite3").is_file()


def test_reading_another_programs_file_changes_nothing(
    cli: Cli, refused: Callable[..., str]
) -> None:
    del cli
    _of_another_program(DB)
    before = Path(DB).read_bytes()
    refused("machine", "list")
    refused("doctor")
    assert Path(DB).read_bytes() == before


def test_a_manifest_that_says_other_than_the_files_is_refused(
    cli: Cli, refused: Callable[..., str]
) -> None:
    cli("init")
    cli("machine", "add", "m")
    cli("export", "out")
    manifest = Path("out/manifest.json")
    said = json.loads(manifest.read_text())
    restoring = ("restore", "out", "--db", "sqlite:///new.sqlite3")
    for spoilt, says in (
        ({**said, "tables": {}}, "is missing, or none of the schema's"),
        ({**said, "tables": {**said["tables"], "x": said["tables"]["cut"]}}, "table 'x'"),
        (
            {**said, "tables": {**said["tables"], "cut": {**said["tables"]["cut"], "rows": 7}}},
            "0 rows, manifest.json says 7",
        ),
    ):
        manifest.write_text(json.dumps(spoilt))
        assert says in refused(*restoring)
        assert not Path("new.sqlite3").exists()


def test_what_the_database_cannot_do_is_one_line(cli: Cli, refused: Callable[..., str]) -> None:
    cli("init")
    connection = sqlite3.connect(DB)
    connection.execute("DROP TABLE row_checksum")
    connection.close()
    assert "no such table" in refused("machine", "add", "m")


def test_a_database_that_is_open_elsewhere_is_not_replaced(
    cli: Cli, refused: Callable[..., str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("autodb.store.copies.WAIT_S", 0.05)
    cli("init")
    cli("machine", "add", "kept")
    cli("backup", "copy.sqlite3")
    store = open_store(URL)
    with store.reading() as session:
        assert session.query(models.Machine).count() == 1
        assert "another program has it open" in refused("restore", "copy.sqlite3", "--replace")
    store.close()
    assert cli("restore", "copy.sqlite3", "--replace").code == 0


@pytest.mark.filterwarnings("ignore:This process .* is multi-threaded:DeprecationWarning")
@pytest.mark.parametrize("after", [False, True])
def test_killed_at_the_rename_it_is_the_old_or_the_new(
    cli: Cli, monkeypatch: pytest.MonkeyPatch, after: bool
) -> None:
    """SIGKILL right before the rename leaves the old database, right after it the restored one."""
    cli("init")
    cli("machine", "add", "old")
    cli("backup", "copy.sqlite3")
    cli("machine", "add", "newer")
    real = Path.replace

    def killed(self: Path, target: Path) -> Path:
        if after:
            real(self, target)
        os.kill(os.getpid(), signal.SIGKILL)
        return target

    child = os.fork()
    if child == 0:
        try:
            monkeypatch.setattr(Path, "replace", killed)
            restore(URL, Path("copy.sqlite3"), replace=True)
        finally:
            os._exit(0)
    assert os.WIFSIGNALED(os.waitpid(child, 0)[1])
    names = {row["name"] for row in rows_of(DB)["machine"]}
    assert names == ({"old"} if after else {"old", "newer"})
    assert cli("doctor").code == 0
    assert cli("restore", "copy.sqlite3", "--replace").code == 0
    assert not list(Path().glob(".*partial*"))
