"""`calibrate --update`: new cuts beside those that the calibrations in use were made on."""

from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest

from autodb.store import models, open_store
from tests.conftest import Cli


def _halves(sample_jobs: Path) -> tuple[Path, Path]:
    """Write every second standard cut to one table, the others to another."""
    source = sample_jobs / "stepped_shaft" / "recordings" / "standard-cuts.csv"
    cuts = pd.read_csv(source)
    side = source.with_suffix(".toml")
    for name, rows in (("first", cuts.iloc[::2]), ("second", cuts.iloc[1::2])):
        rows.to_csv(f"{name}.csv", index=False)
        if side.exists():
            Path(f"{name}.toml").write_text(side.read_text(encoding="utf-8"), encoding="utf-8")
    return Path("first.csv"), Path("second.csv")


def _last(machine: str) -> dict[str, tuple[int, list[float]]]:
    """Return of each axis of a machine of its newest: recordings, coefficients."""
    store = open_store("sqlite:///autodb.sqlite3")
    with store.reading() as session:
        (owner,) = session.query(models.Machine).filter_by(name=machine)
        rows = session.query(models.CalibrationVersion).filter_by(machine_id=owner.id)
        found = {
            row.axis: (len(row.recordings), list(row.coefficients))
            for row in rows.order_by(models.CalibrationVersion.version)
        }
    store.close()
    return found


def test_new_cuts_are_added_to_those_of_the_calibrations_in_use(
    cli: Cli, sample_jobs: Path
) -> None:
    first, second = _halves(sample_jobs)
    assert cli("init").code == 0
    for name, files in (("whole", (first, second)), ("step", (first,))):
        assert cli("machine", "add", name).code == 0
        assert cli("calibrate", *files, "--machine", name).code == 0
    whole = _last("whole")
    assert all(count == 1 for count, _ in _last("step").values())
    assert cli("calibrate", second, "--machine", "step", "--update").code == 0
    updated = _last("step")
    assert set(updated) == {"x", "z", "spindle"}
    for axis, (count, coefficients) in updated.items():
        assert count == 2
        assert coefficients == pytest.approx(whole[axis][1], rel=1e-9)


def test_update_needs_a_machine_and_recordings(refused: Callable[..., str], cli: Cli) -> None:
    cli("init")
    cli("machine", "add", "m")
    for given in (("--machine", "m"), ("a.csv",)):
        line = refused("calibrate", *given, "--update")
        assert "--update needs --machine NAME and recordings to add" in line


def test_cuts_without_a_force_are_told_what_would_do(
    refused: Callable[..., str], sample_jobs: Path
) -> None:
    source = sample_jobs / "stepped_shaft" / "recordings" / "standard-cuts.csv"
    cuts = pd.read_csv(source)
    cuts.drop(columns=[name for name in map(str, cuts) if name.startswith("force.")]).to_csv(
        "bare.csv"
    )
    line = refused("calibrate", "bare.csv")
    assert "no channel force.x, force.y or force.z" in line
    assert "--protocol NAME" in line
