"""A database of 0.2.0: what it learnt, decided and identified holds, and can be taken back.

It predicts with its parameters as they are. By the law of today three answers of turning are
others on purpose, each held below: the passive force and, with it, the feed force, as the
inclination of an insert has ISO 3002's sign; and the power, which is torque times angular speed.
"""

import json
from pathlib import Path
from typing import Any

import pytest

from autodb.store import migrate
from tests.conftest import Cli
from tests.helpers.released import content, recorded, unpacked

pytestmark = pytest.mark.usefixtures("one_law")

DB = Path("autodb.sqlite3")
URL = f"sqlite:///{DB}"
SLOT = """
name = "slot"
material = "C45"
tool = "mill-10"
[[cut]]
name = "new"
operation = "slot"
depth_mm = 1.5
feed_mm_tooth = 0.12
speed_rpm = 2400.0
"""
EQUAL = 0.01
"""Share of itself by which the cutting force may move. Its speed is that at the mean radius, which
moves it by up to 0.2 %, and the direction of the chip does the rest: 0.4 % at most here."""
TURNED_ROUND = 0.1
"""Share of the cutting force by which the passive force is larger, at most. Chosen: an insert of
an inclination of -7° pushes the tool off the work, it pulled it in; 0.04 to 0.09 here."""
AND_WITH_IT = 0.05
"""Share of itself by which the feed force moves with that: 0.039 at most here."""


@pytest.fixture
def upgraded(cli: Cli) -> Cli:
    """Return the command line on the database of 0.2.0, upgraded."""
    assert unpacked("0.2.0", DB) == "0009"
    assert cli("init").code == 0
    return cli


def _cuts(cli: Cli, job: Path, machine: str) -> list[dict[str, Any]]:
    done = cli("predict", job, "--machine", machine, "--json")
    assert done.code == 0, done.err
    cuts: list[dict[str, Any]] = json.loads(done.out)["cuts"]
    return cuts


def _was(number: int) -> list[dict[str, Any]]:
    cuts: list[dict[str, Any]] = recorded("0.2.0")["predictions"][number - 1]["cuts"]
    return cuts


def test_turned_cuts_are_predicted_as_they_were(upgraded: Cli, sample_jobs: Path) -> None:
    stepped = (sample_jobs / "stepped_shaft" / "job.toml").read_text("utf-8")
    Path("job.toml").write_text(stepped, encoding="utf-8")
    worn = stepped.replace("speed_m_min = 220", "speed_m_min = 220\ncutting_time_s = 600")
    Path("worn.toml").write_text(worn, encoding="utf-8")
    for job, number in (("job.toml", 2), ("worn.toml", 3)):
        for now, was in zip(_cuts(upgraded, Path(job), "lathe-1"), _was(number), strict=True):
            value = {name: now[name]["value"] for name in now if name.startswith(("for", "tor"))}
            cutting = was["force_y_N"]["value"]
            assert value["force_y_N"] == pytest.approx(cutting, rel=EQUAL)
            assert value["torque_N_m"] == pytest.approx(was["torque_N_m"]["value"], rel=EQUAL)
            outwards = value["force_x_N"] - was["force_x_N"]["value"]
            assert 0.0 < outwards < TURNED_ROUND * cutting
            assert value["force_z_N"] == pytest.approx(was["force_z_N"]["value"], rel=AND_WITH_IT)
            for name in ("force_x_N", "force_y_N", "force_z_N", "torque_N_m"):
                assert now[name]["low"] < was[name]["value"] < now[name]["high"], name
                assert was[name]["low"] < now[name]["value"] < was[name]["high"], name


def test_power_is_torque_times_angular_speed(upgraded: Cli, sample_jobs: Path) -> None:
    """It was the cutting force times the speed at the smaller diameter: D for D + depth."""
    job = sample_jobs / "stepped_shaft" / "job.toml"
    geometry = ((56.0, 2.0), (48.0, 2.0), (40.0, 1.5), (39.0, 1.0))
    rows = zip(_cuts(upgraded, job, "lathe-1"), _was(2), geometry, strict=True)
    for now, was, (diameter_mm, depth_mm) in rows:
        larger = was["power_W"]["value"] * (1.0 + depth_mm / diameter_mm)
        assert now["power_W"]["value"] == pytest.approx(larger, rel=EQUAL)


def test_milled_cuts_are_predicted_as_they_were(upgraded: Cli) -> None:
    Path("slot.toml").write_text(SLOT, encoding="utf-8")
    (now,), (was,) = _cuts(upgraded, Path("slot.toml"), "mill"), _was(4)
    for found, before in ((now, was), (now["peaks"], was["peaks"])):
        for name in before:
            if name.startswith(("force", "torque", "power")):
                assert found[name]["value"] == pytest.approx(before[name]["value"], rel=1e-9)
                assert before[name]["low"] < found[name]["value"] < before[name]["high"]


def test_what_was_decided_stands_and_can_be_reversed(upgraded: Cli) -> None:
    shown = upgraded("mismatch", "show", 3).out
    assert "status: confirmed by planner" in shown
    assert "steel bar / carbide insert version 3" in shown
    assert "status: confirmed by shop" in upgraded("mismatch", "show", 4).out
    assert "status: rejected by planner" in upgraded("mismatch", "show", 1).out
    listed = json.loads(upgraded("mismatch", "list", "--machine", "lathe-1", "--json").out)
    assert [one["id"] for one in listed["mismatches"]] == [2]
    assert upgraded("mismatch", "reopen", 4, "--why", "another look").code == 0
    done = upgraded("mismatch", "reopen", 3, "--why", "another look")
    assert done.code == 0
    assert "is open again" in done.out
    versions = content(DB)["cutting_parameters"]
    assert versions[2]["undone_at"]
    assert not versions[1]["undone_at"]


def test_models_sensors_and_the_log_are_taken_up(upgraded: Cli) -> None:
    lathe = json.loads(upgraded("sensors", "--machine", "lathe-1", "--json").out)
    assert [(one["force"], one["kind"]) for one in lathe["sensors"]] == [
        ("force.x", "current range"), ("force.y", "current range"), ("force.z", "current range"),
        ("force.z", "drive model"),
    ]  # fmt: skip
    mill = upgraded("sensors", "--machine", "mill").out
    assert mill.count("table dynamometer") == 3
    assert "force constant 399.5 N/A" in upgraded("trace", "scale", 1).out
    assert "inertia" in upgraded("trace", "model", 1).out
    assert "steel bar" in upgraded("fleet", "show").out
    assert "planner" in upgraded("token", "list").out
    chained = content(DB)["audit_entry"]
    assert [entry["action"] for entry in chained] == [
        "token added", "mismatch confirmed", "mismatch rejected",
    ]  # fmt: skip
    assert all(len(entry["sha256"]) == 64 for entry in chained)


def test_learning_goes_on_from_its_versions(upgraded: Cli) -> None:
    """The lathe's cuts have measured forces that 0.2.0 did not read; the mill's hold nothing new.

    Down again, all that 0.2.0 wrote is there as it was.
    """
    lathe = upgraded("refresh", "--machine", "lathe-1").out
    assert "99 forces measured" in lathe
    assert "steel bar / carbide insert: version 4 from 107 cuts" in lathe
    assert "nothing new" in upgraded("refresh", "--machine", "mill").out
    assert upgraded("mismatch", "reject", 2, "--why", "sound cuts").code == 0
    migrate(URL, "0009")
    unpacked("0.2.0", Path("released.sqlite3"))
    before, after = content(Path("released.sqlite3")), content(DB)
    for table in ("recording", "cut", "calibration", "channel_model", "drive_scale", "estimator",
                  "prediction", "audit_entry", "fleet_prior"):  # fmt: skip
        assert after[table] == before[table], table
