"""Exports: they come back row for row, and a spoilt one is refused."""

import json
import shutil
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from autodb.agent.operate.access import Access, Role, note
from autodb.store import models, open_store
from autodb.store.exports import read_manifest
from autodb.store.rowsums import UNCOUNTED
from tests.conftest import Cli
from tests.helpers.kept import DB, URL, rows_of

pytestmark = pytest.mark.usefixtures("one_law")

NOW = "2026-01-01T00:00:00+00:00"


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
        mismatch.further = [session.get_one(models.StoredRecording, 2)]
        mismatch.pairs = [session.get_one(models.Pair, 1)]
        mismatch.found_in = {"cuts": 24, "excluded": 7, "edges": ["B1"]}
        mismatch.models = [session.get_one(models.ChannelModel, 1)]
        mismatch.parameters_of_pairs = [session.get_one(models.CuttingParameters, 1)]
        mismatch.calibrations = [session.get_one(models.CalibrationVersion, 1)]
        mismatch.decisions = [
            models.MismatchDecision(status="open", why="a new bar", decided_at=NOW)
        ]
        session.get_one(models.CalibrationVersion, 1).repeats = [session.get_one(models.Cut, 1)]
        changed = models.ChangedEdge(machine_id=1, tool_id=1, at=NOW, said_by="Mária")
        cut = session.get_one(models.Cut, 2)
        cut.edge_change, cut.edge_used_s = changed, 0.1 + 0.2
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
            models.PredictedCutMade(
                prediction_id=1, number=1, name="Ø56", cut_id=1, matched_by="stated",
                expected={"force.z": [0.1 + 0.2, 0.0, 1.0]},
            ),
            models.InboxFile(machine_id=1, path="a", sha256="b", status="refused", reason="c"),
            models.AccessToken(name="panel", sha256="0" * 64, role="read"),
        ])  # fmt: skip
        note(session, Access("panel", Role.READ, None), "read", row=("pair", 1), α=[1e-300, 0.1])
    store.close()


def test_an_export_comes_back_row_for_row(cli: Cli, recordings: Path) -> None:
    del recordings
    _fill_what_nothing_writes_yet()
    before = rows_of(DB)
    assert all(before.values()), [name for name, rows in before.items() if not rows]
    assert cli("export", "out").code == 0
    assert cli("restore", "out", "--db", "sqlite:///again.sqlite3").code == 0
    assert rows_of(Path("again.sqlite3")) == before


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
    content = rows_of(DB)
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
    mine, one = rows_of(DB), rows_of(Path("one.sqlite3"))
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
