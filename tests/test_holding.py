"""A calibration holds for a gear range and a coolant: others are neither mixed in nor sensed."""

from pathlib import Path

import pytest
from sqlalchemy import select

from autodb.store import models, open_store
from tests.conftest import Cli

URL = "sqlite:///autodb.sqlite3"


@pytest.fixture
def recordings(sample_jobs: Path) -> Path:
    """Return where the sample job's recordings are."""
    return sample_jobs / "stepped_shaft" / "recordings"


@pytest.fixture
def lathe(cli: Cli) -> Cli:
    """Return the command line on an empty lathe."""
    assert cli("init").code == 0
    assert cli("machine", "add", "lathe-1").code == 0
    return cli


def _import(cli: Cli, recordings: Path, name: str, *said: str) -> None:
    """Import a sample recording whose side file states these lines of its [recording]."""
    Path(name).write_bytes((recordings / name).read_bytes())
    Path(name).with_suffix(".toml").write_text("\n".join(["[recording]", *said]), encoding="utf-8")
    assert cli("import", name, "--machine", "lathe-1").code == 0


def _reasons(name: str) -> dict[str, set[str]]:
    """Return why each component of a recording's turned cuts is not sensed; '' where it is."""
    store = open_store(URL)
    with store.reading() as session:
        rows = session.scalars(select(models.SensedForce)).all()
        found: dict[str, set[str]] = {}
        for row in rows:
            if Path(row.cut.recording.path).name == name and row.cut.operation == "turn":
                found.setdefault(row.component, set()).add(row.reason or "")
    store.close()
    return found


def test_another_gear_range_is_not_felt_by_the_spindle_only(lathe: Cli, recordings: Path) -> None:
    _import(lathe, recordings, "standard-cuts.csv", 'gear_range = "high"')
    _import(lathe, recordings, "shop-week-1.csv", 'gear_range = "low"')
    _import(lathe, recordings, "shop-week-2.csv")
    assert lathe("calibrate", "--machine", "lathe-1").code == 0
    assert lathe("refresh", "--machine", "lathe-1").code == 0
    other = _reasons("shop-week-1.csv")
    assert other["y"] == {"spindle was calibrated with gear range 'high', not 'low'"}
    assert other["z"] == {""}
    assert _reasons("shop-week-2.csv")["y"] == {""}, "a recording that states none goes with any"


def test_another_coolant_is_felt_by_no_axis(lathe: Cli, recordings: Path) -> None:
    _import(lathe, recordings, "standard-cuts.csv", 'coolant = "flood"')
    _import(lathe, recordings, "shop-week-1.csv", 'coolant = "dry"')
    assert lathe("calibrate", "--machine", "lathe-1").code == 0
    assert lathe("refresh", "--machine", "lathe-1").code == 0
    other = _reasons("shop-week-1.csv")
    assert other["z"] == {"z was calibrated with coolant 'flood', not 'dry'"}
    assert other["y"] == {"spindle was calibrated with coolant 'flood', not 'dry'"}


def test_gear_ranges_are_not_calibrated_together(lathe: Cli, recordings: Path) -> None:
    text = (recordings / "standard-cuts.csv").read_text("utf-8").splitlines()
    for name, lines, gear in (
        ("a.csv", text[:17], "high"),
        ("b.csv", [text[0], *text[17:]], "low"),
    ):
        Path(name).write_text("\n".join(lines) + "\n", encoding="utf-8")
        Path(name).with_suffix(".toml").write_text(
            f'[recording]\ngear_range = "{gear}"\n', encoding="utf-8"
        )
        assert lathe("import", name, "--machine", "lathe-1").code == 0
    done = lathe("calibrate", "--machine", "lathe-1")
    assert done.code == 2
    assert "cuts with gear range 'high' (a.csv), 'low' (b.csv)" in " ".join(done.err.split())
