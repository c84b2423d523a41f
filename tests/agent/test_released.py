"""Databases written by released versions open, answer the same, and go down again unchanged."""

import gzip
import json
import sqlite3
from collections.abc import Callable
from pathlib import Path
from typing import Any

import alembic.op
import pytest
from sqlalchemy import inspect

from autodb.store import create_store, head, migrate, models, open_store
from autodb.store.engines import engine_of
from tests.conftest import Cli

pytestmark = pytest.mark.usefixtures("one_law")

RELEASED = sorted(path.name.removesuffix(".sqlite3.gz") for path in
                  (Path(__file__).parent / "released").glob("*.sqlite3.gz"))  # fmt: skip


@pytest.fixture(params=RELEASED)
def version(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """Unpack a released version's database as the one in the working folder; return its version."""
    name = str(request.param)
    packed = Path(__file__).parent / "released" / f"{name}.sqlite3.gz"
    (tmp_path / "autodb.sqlite3").write_bytes(gzip.decompress(packed.read_bytes()))
    return name


def _content(path: Path) -> dict[str, list[tuple[Any, ...]]]:
    connection = sqlite3.connect(path)
    names = connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'").fetchall()
    content = {name: connection.execute(f"SELECT * FROM {name}").fetchall() for (name,) in names}
    connection.close()
    return content


def _schema(url: str) -> dict[str, Any]:
    """Return columns, keys, checks and indices of every table, without the names of constraints."""
    engine = engine_of(url)
    look = inspect(engine)
    found = {}
    for name in look.get_table_names():
        found[name] = {
            "columns": [
                (c["name"], str(c["type"]), c["nullable"], c["default"])
                for c in look.get_columns(name)
            ],
            "unique": sorted(sorted(u["column_names"]) for u in look.get_unique_constraints(name)),
            "checks": sorted(
                c["sqltext"].replace('"', "") for c in look.get_check_constraints(name)
            ),
            "keys": sorted(
                (k["constrained_columns"], k["referred_table"], k["options"].get("ondelete", ""))
                for k in look.get_foreign_keys(name)
            ),
            "indices": sorted((i["name"], i["column_names"]) for i in look.get_indexes(name)),
        }
    engine.dispose()
    return found


def test_a_released_database_is_upgraded_and_says_from_where(
    version: str, cli: Cli, tmp_path: Path
) -> None:
    del version
    before = _content(tmp_path / "autodb.sqlite3")
    assert "schema 0001, this version needs" in cli("machine", "list").err
    assert f"upgraded from schema 0001 to {head()}" in cli("init").out
    after = _content(tmp_path / "autodb.sqlite3")
    for table in before:
        assert len(after[table]) == len(before[table]), table
    assert "z" in cli("machine", "show", "lathe-1").out


def test_it_gives_the_parameters_and_predictions_that_were_recorded(
    version: str, cli: Cli, sample_jobs: Path
) -> None:
    assert cli("init").code == 0
    recorded = json.loads((Path(__file__).parent / "released" / f"{version}.json").read_text())
    store = open_store("sqlite:///autodb.sqlite3")
    with store.reading() as session:
        rows = session.query(models.CuttingParameters).order_by(models.CuttingParameters.id).all()
        for row, was in zip(rows, recorded["parameters"], strict=True):
            assert (row.component, row.version) == (was["component"], was["version"])
            assert row.operation == "turn"
            assert row.mean == was["mean"]
            assert row.covariance == was["covariance"]
    store.close()
    traced = cli("trace", "prediction", 1).out
    assert "shop-week-1.csv" in traced
    assert "K_c" in traced
    _learnt_anew_it_predicts_what_was_recorded(cli, sample_jobs, recorded["cuts"])


def _learnt_anew_it_predicts_what_was_recorded(
    cli: Cli, sample_jobs: Path, recorded: list[dict[str, Any]]
) -> None:
    """Today's law, learnt from the same cuts: the two 95 % intervals have a common part.

    Today's also learns what the dynamometer measured of them, not what the currents sensed alone.
    """
    job = sample_jobs / "stepped_shaft" / "job.toml"
    assert "belong to an earlier autodb's law" in cli("predict", job, "--machine", "lathe-1").err
    assert cli("refresh", "--machine", "lathe-1").code == 0
    cuts = json.loads(cli("predict", job, "--machine", "lathe-1", "--json").out)["cuts"]
    for cut, was in zip(cuts, recorded, strict=True):
        for name in ("force_y_N", "force_z_N"):
            assert was[name]["low"] < cut[name]["high"]
            assert cut[name]["low"] < was[name]["high"]


def test_it_goes_down_again_unchanged(version: str, tmp_path: Path) -> None:
    del version
    path = tmp_path / "autodb.sqlite3"
    url = f"sqlite:///{path}"
    before, schema = _content(path), _schema(url)
    create_store(url)
    assert _content(path) != before
    migrate(url, "0001")
    assert _content(path) == before
    assert _schema(url) == schema


def test_an_upgrade_that_fails_halfway_leaves_the_released_database(
    version: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    del version
    path = tmp_path / "autodb.sqlite3"
    before, schema = _content(path), _schema(f"sqlite:///{path}")
    real, changed = alembic.op.batch_alter_table, []

    def alter(name: str, **options: Any) -> Any:
        changed.append(name)
        if len(changed) == 7:
            raise RuntimeError
        return real(name, **options)

    monkeypatch.setattr(alembic.op, "batch_alter_table", alter)
    with pytest.raises(RuntimeError):
        create_store(f"sqlite:///{path}")
    assert _content(path) == before
    assert _schema(f"sqlite:///{path}") == schema


def test_a_database_with_rows_that_lead_nowhere_is_not_upgraded(
    version: str, refused: Callable[..., str], tmp_path: Path
) -> None:
    del version
    path = tmp_path / "autodb.sqlite3"
    connection = sqlite3.connect(path)
    connection.execute("DELETE FROM recording WHERE id = 1")
    connection.commit()
    connection.close()
    before = _content(path)
    assert "points to no recording; restore a backup" in refused("init")
    assert _content(path) == before


def test_what_the_lower_schema_cannot_hold_does_not_stay_behind(
    version: str, cli: Cli, tmp_path: Path
) -> None:
    """Posteriors and what was predicted from them go; what the released version learnt stays."""
    del version
    path = tmp_path / "autodb.sqlite3"
    before = _content(path)
    cli("init")
    assert "carbide insert: version 1" in cli("refresh", "--machine", "lathe-1").out
    Path("face.toml").write_text(
        'name = "f"\nmaterial = "steel bar"\ntool = "carbide insert"\n[[cut]]\noperation = "face"\n'
        "diameter_mm = 60\ndepth_mm = 1\nfeed_mm_rev = 0.1\nspeed_rpm = 1200\n"
    )
    assert cli("predict", "face.toml", "--machine", "lathe-1").code == 0
    connection = sqlite3.connect(path)
    by_law = "SELECT id FROM cutting_parameters WHERE law = 'linear_edge_nose' ORDER BY id"
    turned = connection.execute(by_law).fetchall()
    connection.close()
    assert len(_content(path)["cutting_parameters"]) == len(turned) + 1
    migrate(f"sqlite:///{path}", "0001")
    after = _content(path)
    assert [row[:1] for row in after["cutting_parameters"]] == turned
    assert after["prediction"] == before["prediction"]
    assert {row[0] for row in after["cutting_parameters_force"]} == {row[0] for row in turned}


def test_a_line_whose_shared_error_the_lower_schema_cannot_say_goes(
    version: str, cli: Cli, tmp_path: Path
) -> None:
    """Read by the released version its interval would be too narrow; its own line stays."""
    del version
    path = tmp_path / "autodb.sqlite3"
    before = _content(path)["calibration"]
    cli("init")
    assert cli("calibrate", "--machine", "lathe-1").code == 0
    connection = sqlite3.connect(path)
    lines = connection.execute(
        "SELECT count(*) FROM calibration WHERE kind = 'line' AND cut_sd IS NOT NULL"
    ).fetchone()
    connection.close()
    assert lines[0] > 0
    migrate(f"sqlite:///{path}", "0001")
    assert _content(path)["calibration"] == before
