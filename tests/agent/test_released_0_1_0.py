"""A database of 0.1.0: what it learnt by another law is traced, and learnt anew."""

import json
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from autodb.store import migrate
from tests.conftest import Cli
from tests.helpers.released import content, recorded, unpacked

pytestmark = pytest.mark.usefixtures("one_law")

DB = Path("autodb.sqlite3")
URL = f"sqlite:///{DB}"


@pytest.fixture
def schema(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Have the database as the one in the working folder; return its schema's number."""
    monkeypatch.chdir(tmp_path)
    return unpacked("0.1.0", DB)


def test_todays_law_predicts_what_was_recorded(schema: str, cli: Cli, sample_jobs: Path) -> None:
    """Learnt anew from the same cuts: the two 95 % intervals have a common part.

    Today's also learns what the dynamometer measured of them, not what the currents sensed alone.
    """
    assert schema == "0001"
    assert cli("init").code == 0
    assert {row["operation"] for row in content(DB)["cutting_parameters"]} == {"turn"}
    traced = cli("trace", "prediction", 1).out
    assert "shop-week-1.csv" in traced
    assert "K_c" in traced
    job = sample_jobs / "stepped_shaft" / "job.toml"
    assert "belong to an earlier autodb's law" in cli("predict", job, "--machine", "lathe-1").err
    assert cli("refresh", "--machine", "lathe-1").code == 0
    cuts = json.loads(cli("predict", job, "--machine", "lathe-1", "--json").out)["cuts"]
    for cut, was in zip(cuts, recorded("0.1.0")["cuts"], strict=True):
        for name in ("force_y_N", "force_z_N"):
            assert was[name]["low"] < cut[name]["high"]
            assert cut[name]["low"] < was[name]["high"]


def test_what_the_lower_schema_cannot_hold_does_not_stay_behind(schema: str, cli: Cli) -> None:
    """Posteriors and what was predicted from them go; what the released version learnt stays."""
    before = content(DB)
    cli("init")
    assert "carbide insert: version 1" in cli("refresh", "--machine", "lathe-1").out
    Path("face.toml").write_text(
        'name = "f"\nmaterial = "steel bar"\ntool = "carbide insert"\n[[cut]]\noperation = "face"\n'
        "diameter_mm = 60\ndepth_mm = 1\nfeed_mm_rev = 0.1\nspeed_rpm = 1200\n"
    )
    assert cli("predict", "face.toml", "--machine", "lathe-1").code == 0
    with closing(sqlite3.connect(DB)) as file:
        by_law = "SELECT id FROM cutting_parameters WHERE law = 'linear_edge_nose' ORDER BY id"
        turned = [number for (number,) in file.execute(by_law)]
    assert len(content(DB)["cutting_parameters"]) == len(turned) + 1
    migrate(URL, schema)
    after = content(DB)
    assert [row["id"] for row in after["cutting_parameters"]] == turned
    assert after["prediction"] == before["prediction"]
    learnt_from = after["cutting_parameters_force"]
    assert {row["cutting_parameters_id"] for row in learnt_from} == set(turned)


def test_a_line_whose_shared_error_the_lower_schema_cannot_say_goes(schema: str, cli: Cli) -> None:
    """Read by the released version its interval would be too narrow; its own line stays."""
    before = content(DB)["calibration"]
    cli("init")
    assert cli("calibrate", "--machine", "lathe-1").code == 0
    with closing(sqlite3.connect(DB)) as file:
        (lines,) = file.execute(
            "SELECT count(*) FROM calibration WHERE kind = 'line' AND cut_sd IS NOT NULL"
        ).fetchone()
    assert lines > 0
    migrate(URL, schema)
    assert content(DB)["calibration"] == before
