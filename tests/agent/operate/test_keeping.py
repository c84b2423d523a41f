"""A database that lasts: copies taken under load, restored whole or not at all, exports, doctor."""

import gzip
import json
import os
import shutil
import signal
import sqlite3
import threading
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest

from autodb.agent.operate.access import Access, Role, note
from autodb.errors import UnusableInput
from autodb.store import create_store, head, models, open_store
from autodb.store.backups import backup
from autodb.store.copies import connect
from autodb.store.exports import read_manifest
from autodb.store.restoring import restore
from autodb.store.rowsums import UNCOUNTED
from tests.conftest import ROOT, Cli, Once

DB = Path("autodb.sqlite3")
URL = "sqlite:///autodb.sqlite3"
NOW = "2026-01-01T00:00:00+00:00"


def _content(path: Path) -> dict[str, list[dict[str, Any]]]:
    """Return the rows of each table, whatever the order of rows and columns."""
    with closing(sqlite3.connect(path)) as connection:
        connection.row_factory = lambda cursor, row: dict(
            sorted(zip([column[0] for column in cursor.description], row, strict=True))
        )
        found = connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'")
        names = [row["name"] for row in found]
        return {n: sorted(connection.execute(f"SELECT * FROM {n}"), key=repr) for n in names}


@pytest.fixture
def recordings(cli: Cli, sample_jobs: Path, once: Once) -> Path:
    """Return a folder of our own with recordings that the machine in the database has learnt."""

    def learn() -> None:
        source = sample_jobs / "stepped_shaft" / "recordings"
        folder = Path("recordings").absolute()
        folder.mkdir()
        for name in ("standard-cuts.csv", "air-moves.csv"):
            shutil.copy(source / name, folder / name)
        cli("init")
        cli("machine", "add", "lathe-1", "--file", sample_jobs / "stepped_shaft" / "machine.toml")
        cli("import", *sorted(folder.iterdir()), "--machine", "lathe-1")
        cli("calibrate", "--machine", "lathe-1")
        cli("identify", folder / "air-moves.csv", "--machine", "lathe-1")
        cli("refresh", "--machine", "lathe-1")
        job = sample_jobs / "stepped_shaft" / "job.toml"
        assert cli("predict", job, "--machine", "lathe-1").code == 0

    return once(learn) / "recordings"


def _fill_what_nothing_writes_yet() -> None:
    """Add a row to every table that nothing filled before, with values that are easy to lose."""
    store = open_store(URL)
    with store.writing() as session:
        estimator = models.Estimator(
            machine_id=1, kind="lstm", component="z", version=1, model={"α": [1e-300, 0.1]},
            scores={"rmse_N": 21.5}, recordings=[session.get_one(models.StoredRecording, 1)],
            calibrations=[session.get_one(models.CalibrationVersion, 1)],
        )  # fmt: skip
        session.add(estimator)
        prior = models.FleetPrior(
            material_id=1, operation="turn", component="y", law="linear_edge_nose", version=1,
            mean=[1.0], covariance=[[2.0]], machines=1,
            parameters=[session.get_one(models.CuttingParameters, 1)],
        )  # fmt: skip
        done = models.RefreshPass(machine_id=1, status="done", finished_at=NOW, report={"n": 1})
        mismatch = models.Mismatch(
            recording_id=1, channel="force.z", term="tool_wear", kind="missing", confidence=0.9,
            parameters={}, statement="…", alternatives=[], intervals=[[1.0, 2.0]],
        )  # fmt: skip
        session.add_all([prior, done, mismatch])
        session.flush()
        mismatch.models = [session.get_one(models.ChannelModel, 1)]
        mismatch.parameters_of_pairs = [session.get_one(models.CuttingParameters, 1)]
        session.get_one(models.CalibrationVersion, 1).repeats = [session.get_one(models.Cut, 1)]
        session.add_all([
            models.SensedWaveform(
                recording_id=1, estimator_id=estimator.id, component="z", path="p", sha256="s",
                bytes=2**40, rows=3,
            ),
            models.RecordingChannel(
                recording_id=2, time_base="t", name="z.current", unit="A", rows=1, mean=0.1 + 0.2
            ),
            models.DriveScale(
                machine_id=1, axis="z", version=1, kind="force", per_ampere=402.1, share=0.1 + 0.2,
                source="force.z", recording_id=1,
            ),
            models.ToolProperty(tool_id=1, code="RE", value=0.8, unit="mm"),
            models.ConventionalParameter(
                material_id=1, operation="turn", component="y", name="K_c", unit="N/mm²",
                value=2000.0, lower=1800.0, upper=2200.0, source="handbook",
            ),
            models.PairState(
                machine_id=1, pair_id=1, operation="turn", refresh_pass_id=done.id
            ),
            models.InboxFile(machine_id=1, path="a", sha256="b", status="refused", reason="c"),
            models.AccessToken(name="panel", sha256="0" * 64, role="read"),
        ])  # fmt: skip
        note(session, Access("panel", Role.READ, None), "read", row=("pair", 1), α=[1e-300, 0.1])
    store.close()


# --- backup


def test_a_backup_holds_the_same_rows(cli: Cli, recordings: Path) -> None:
    del recordings
    assert "schema" in cli("backup", "copy.sqlite3").out
    assert _content(Path("copy.sqlite3")) == _content(DB)
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
    assert "is no file for a backup" in refused("backup", DB, "--replace")
    assert "is no file for a backup" in refused("backup", "/dev/null", "--replace")
    assert "the database's own log" in refused("backup", f"{DB}-wal")
    Path("link.sqlite3").symlink_to("copy.sqlite3")
    assert cli("backup", "link.sqlite3", "--replace").code == 0
    assert Path("link.sqlite3").is_symlink()
    assert "no such folder" in refused("backup", "nowhere/copy.sqlite3")
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
        assert len(_content(tmp_path / f"{number}.sqlite3")["machine"]) == n


def test_a_damaged_database_is_not_copied(cli: Cli, recordings: Path) -> None:
    del recordings
    cli("backup", "copy.sqlite3")
    whole = Path("copy.sqlite3").read_bytes()
    Path("bad.sqlite3").write_bytes(whole[: len(whole) // 2] + b"\x00" * (len(whole) // 2))
    done = cli("backup", "again.sqlite3", "--db", "sqlite:///bad.sqlite3")
    assert done.code == 2
    assert "bad.sqlite3" in done.err
    assert not Path("again.sqlite3").exists()


# --- restore


def test_restoring_brings_back_what_was_backed_up(
    cli: Cli, refused: Callable[..., str], recordings: Path
) -> None:
    del recordings
    before = _content(DB)
    cli("backup", "copy.sqlite3")
    cli("machine", "add", "later")
    assert "--replace" in refused("restore", "copy.sqlite3")
    assert len(_content(DB)["machine"]) == 2
    assert cli("restore", "copy.sqlite3", "--replace").code == 0
    assert _content(DB) == before
    assert cli("refresh", "--machine", "lathe-1").code == 0
    cli("init", "--db", "sqlite:///empty.sqlite3")
    assert cli("restore", "copy.sqlite3", "--db", "sqlite:///empty.sqlite3").code == 0
    assert _content(Path("empty.sqlite3")) == before


def test_a_backup_of_a_released_version_is_upgraded(cli: Cli) -> None:
    packed = ROOT / "tests" / "released" / "0.1.0.sqlite3.gz"
    Path("old.sqlite3").write_bytes(gzip.decompress(packed.read_bytes()))
    before = Path("old.sqlite3").read_bytes()
    assert f"schema 0001, upgraded to {head()}" in cli("restore", "old.sqlite3").out
    assert "lathe-1" in cli("machine", "list").out
    assert Path("old.sqlite3").read_bytes() == before


def _text(path: Path) -> None:
    path.write_text("no database, but long enough to be looked at as one " * 20)


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
    assert "a" in _content(DB)
    _text(Path("text"))
    line = refused("restore", "good.sqlite3", "--db", "sqlite:///text")
    assert "is there and cannot be read as a database" in line


def test_a_damaged_database_is_found_and_set_aside_by_a_restore(cli: Cli) -> None:
    cli("init")
    for number in range(200):
        cli("machine", "add", f"machine-{number}")
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
    names = {row["name"] for row in _content(DB)["machine"]}
    assert names == ({"old"} if after else {"old", "newer"})
    assert cli("doctor").code == 0
    assert cli("restore", "copy.sqlite3", "--replace").code == 0
    assert not list(Path().glob(".*partial*"))


# --- export


def test_an_export_comes_back_row_for_row(cli: Cli, recordings: Path) -> None:
    del recordings
    _fill_what_nothing_writes_yet()
    before = _content(DB)
    assert all(before.values()), [name for name, rows in before.items() if not rows]
    assert cli("export", "out").code == 0
    assert cli("restore", "out", "--db", "sqlite:///again.sqlite3").code == 0
    assert _content(Path("again.sqlite3")) == before


def test_what_is_unknown_is_null(cli: Cli, recordings: Path) -> None:
    del cli, recordings
    with closing(sqlite3.connect(DB)) as connection:
        for column, table in (("common", "sensed_force"), ("rotary_order", "machine")):
            texts = connection.execute(f"SELECT {column} FROM {table}").fetchall()
            assert (None,) in texts
            assert ("null",) not in texts


def test_an_export_is_typed_and_counted(cli: Cli, recordings: Path) -> None:
    del recordings
    cli("export", "out")
    manifest = read_manifest(Path("out"))
    content = _content(DB)
    assert {n: e.rows for n, e in manifest.tables.items()} == {
        name: len(rows) for name, rows in content.items() if name not in UNCOUNTED
    }
    types = {f.name: str(f.type) for f in pq.read_schema("out/calibration.parquet")}
    assert (types["id"], types["current_low"], types["offered"]) == ("int64", "double", "bool")
    assert json.loads(pq.read_table("out/cut.parquet")["measured"][0].as_py())


def test_the_export_of_one_machine_holds_no_other(
    cli: Cli, recordings: Path, refused: Callable[..., str]
) -> None:
    del recordings
    cli("machine", "add", "other")
    other = Path("other.csv")
    other.write_text("cut,t,z.current,work.material,tool\n1,0,2,brass,cutter\n2,1,3,brass,cutter\n")
    cli("import", other, "--machine", "other")
    assert "no machine 'lathe-2' (did you mean lathe-1" in refused(
        "export", "out", "--machine", "lathe-2"
    )
    assert cli("export", "out", "--machine", "lathe-1").code == 0
    assert cli("restore", "out", "--db", "sqlite:///one.sqlite3").code == 0
    mine, one = _content(DB), _content(Path("one.sqlite3"))
    assert [row["name"] for row in one["machine"]] == ["lathe-1"]
    assert one["cutting_parameters_force"] == mine["cutting_parameters_force"]
    assert len(one["cut"]) == len(mine["cut"]) - 2
    assert len(one["recording"]) == len(mine["recording"]) - 1
    assert [row["id"] for row in one["pair"]] == [1]
    assert len(mine["pair"]) == 2
    assert cli("doctor", "--db", "sqlite:///one.sqlite3").code == 0
    assert cli("export", "whole").code == 0


def _alter(folder: Path) -> None:
    path = folder / "cut.parquet"
    path.write_bytes(path.read_bytes()[:-1] + b"0")


def _lose(folder: Path) -> None:
    (folder / "cut.parquet").unlink()


def _swap(folder: Path) -> None:
    shutil.copy(folder / "tool.parquet", folder / "cut.parquet")
    manifest = json.loads((folder / "manifest.json").read_text())
    manifest["tables"]["cut"] = manifest["tables"]["tool"]
    (folder / "manifest.json").write_text(json.dumps(manifest))


def _from_a_later_version(folder: Path) -> None:
    text = (folder / "manifest.json").read_text()
    (folder / "manifest.json").write_text(text.replace('"format": 1', '"format": 2'))


def _no_manifest(folder: Path) -> None:
    (folder / "manifest.json").unlink()


def _broken_manifest(folder: Path) -> None:
    (folder / "manifest.json").write_text("{}")


def _without_what_is_pointed_to(folder: Path) -> None:
    manifest = json.loads((folder / "manifest.json").read_text())
    del manifest["tables"]["recording"]
    (folder / "manifest.json").write_text(json.dumps(manifest))


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (_alter, "cut.parquet: altered"),
        (_lose, "cut.parquet: not there"),
        (_swap, "cut.parquet: not the columns"),
        (_from_a_later_version, "manifest.json: format 2"),
        (_no_manifest, "manifest.json: not there"),
        (_broken_manifest, "manifest.json: not a manifest"),
        (_without_what_is_pointed_to, "is missing, or none"),
    ],
)
def test_a_spoilt_export_is_refused_naming_the_file(
    cli: Cli,
    refused: Callable[..., str],
    recordings: Path,
    spoil: Callable[[Path], None],
    says: str,
) -> None:
    del recordings
    cli("export", "out")
    spoil(Path("out"))
    assert says in refused("restore", "out", "--db", "sqlite:///new.sqlite3")
    assert not Path("new.sqlite3").exists()


def test_an_export_never_overwrites(cli: Cli, refused: Callable[..., str]) -> None:
    cli("init")
    Path("out").mkdir()
    assert cli("export", "out").code == 0
    assert "is there already" in refused("export", "out")
    assert "no such folder" in refused("export", "a/b")


# --- doctor


def test_the_doctor_passes_what_is_sound(cli: Cli, recordings: Path) -> None:
    del recordings
    done = cli("doctor")
    assert done.code == 0
    assert "FAILED" not in done.out
    assert done.out.count("passed") == 13


def _ill(statement: str) -> None:
    with closing(connect(DB)) as connection:
        connection.execute(statement)


@pytest.mark.parametrize(
    ("statement", "says"),
    [
        ("DELETE FROM recording WHERE id = 1", "rows that point to no row: "),
        ("UPDATE cut SET measured = '{' WHERE id = 3", "unreadable JSON: cut 3: measured"),
        ("DELETE FROM calibration_recording", "derived rows without a source: calibration 1"),
        ("DELETE FROM prediction_parameters", "derived rows without a source: prediction 1"),
        ("UPDATE cut SET pair_id = NULL", "pairs nobody cut: pair 1: steel bar"),
        ("UPDATE alembic_version SET version_num = '0001'", "schema: 'autodb init'"),
    ],
)
def test_the_doctor_names_what_is_ill(
    cli: Cli, recordings: Path, statement: str, says: str
) -> None:
    del recordings
    _ill(statement)
    done = cli("doctor")
    assert done.code == 1
    assert says in done.out


def test_the_doctor_finds_recordings_missing_and_altered(cli: Cli, recordings: Path) -> None:
    with (recordings / "standard-cuts.csv").open("a") as file:
        file.write("\n")
    (recordings / "air-moves.csv").unlink()
    done = cli("doctor")
    assert done.code == 1
    assert f"recordings not on the disk: recording 1: {recordings / 'air-moves.csv'}" in done.out
    assert f"altered on the disk: recording 2: {recordings / 'standard-cuts.csv'}" in done.out


def test_a_stored_copy_stands_in_for_a_recording_that_is_gone(cli: Cli, recordings: Path) -> None:
    moved = recordings.parent / "kept.csv"
    shutil.move(recordings / "air-moves.csv", moved)
    assert cli("doctor").code == 1
    _ill(f"UPDATE recording SET stored_path = '{moved}', stored_sha256 = sha256 WHERE id = 1")
    assert cli("doctor").code == 0
    moved.write_text("something else")
    assert "altered on the disk: recording 1" in cli("doctor").out


def test_the_doctor_needs_a_database(refused: Callable[..., str]) -> None:
    assert "'autodb init' makes one" in refused("doctor")


def test_a_database_in_memory_has_no_backup() -> None:
    with pytest.raises(UnusableInput, match="in memory"):
        backup("sqlite://", Path("a"))
