"""Commands that answer print JSON when they are asked to, and nothing else on the output."""

import json
from pathlib import Path
from typing import Any

import pytest

from tests.conftest import ROOT, Cli

pytestmark = pytest.mark.usefixtures("one_law")

RECORDINGS = ROOT / "sample_jobs" / "stepped_shaft" / "recordings"
CUTS = RECORDINGS / "standard-cuts.csv"


@pytest.fixture
def calibrated(cli: Cli) -> Cli:
    """Return the command line in a folder with the database of a calibrated lathe."""
    cli("init")
    cli("machine", "add", "lathe-1")
    cli("import", CUTS)
    cli("calibrate")
    return cli


@pytest.fixture
def answered(calibrated: Cli) -> Any:
    """Return a function that runs a command with --json, and reads what it printed."""

    def ask(*words: object, code: int = 0) -> Any:
        done = calibrated(*words, "--json")
        assert done.code == code, done.err
        return json.loads(done.out)

    return ask


def test_answers_are_json(answered: Any) -> None:
    (imported,) = answered("import", CUTS)
    assert (imported["file"], imported["already_there"]) == (str(CUTS), True)
    axes = answered("calibrate")["calibrations"]
    assert {one["axis"] for one in axes} == {"x", "z", "spindle"}
    (machine,) = answered("machine", "list")
    assert machine.items() <= answered("machine", "show", "lathe-1").items()
    assert machine["name"] == "lathe-1"
    assert {one["force"] for one in answered("sensors")["sensors"]} >= {"force.y", "force.z"}
    assert answered("mismatch", "list") == {"mismatches": []}
    assert answered("predictions", "match") == {"cuts": [], "asked": []}
    assert "calibration 1" in answered("trace", "calibration", 1)["text"]
    assert all(one["passed"] for one in answered("doctor"))


def test_calibrations_of_files_and_models_are_json(answered: Any) -> None:
    alone = answered("calibrate", CUTS)
    (z,) = (one for one in alone["calibrations"] if one["axis"] == "z")
    assert z["usable"]
    assert z["r_squared"] > 0.9
    model = answered("identify", RECORDINGS / "air-moves.csv")
    assert {term["term"] for term in model["terms"]} >= {"inertia", "coulomb"}
    assert model["version"] is None
    assert Path("autodb.sqlite3").exists()


def test_what_keeps_the_database_says_so_in_json(answered: Any) -> None:
    kept = answered("backup", "copy.sqlite3")
    assert kept["file"] == "copy.sqlite3"
    assert kept["rows"]["calibration"] == 3
    Path("copies").mkdir()
    dated = answered("backup", "copies", "--keep", 2)
    assert [Path(one["path"]).exists() for one in dated["there"]] == [True]
    gone = answered("withdraw", 1, "--why", "another bar")
    assert gone["cuts"] > 0
    assert not gone["already"]
    assert answered("withdraw", 1, "--undo")["recording"] == 1


def test_protocols_are_json(answered: Any) -> None:
    listed = {one["name"]: one for one in answered("standard", "list")}
    shown = answered("standard", "show", "turning-aluminium")
    assert listed["turning-aluminium"].items() <= shown.items()
    assert sorted(set(shown["order"])) == sorted(cut["name"] for cut in shown["cut"])


def test_a_card_that_is_written_is_said_beside_the_answer(calibrated: Cli) -> None:
    done = calibrated("calibrate", "--card", "card.html", "--json")
    assert json.loads(done.out)["calibrations"]
    assert "card: card.html" in done.err
