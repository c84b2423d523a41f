"""A calibration holds for what its cuts were made with; several of an axis stand side by side."""

from pathlib import Path

import numpy as np
import pytest
from sqlalchemy import select

from autodb.records.tables import CutTable
from autodb.sensing.ranges.validity import ANY, Holds, holds_of, partition, unstated, which
from autodb.store import models, open_store
from tests.conftest import Cli

pytestmark = pytest.mark.usefixtures("one_law")

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
    _import_text(cli, name, _text(recordings / name), *said)


def _text(path: Path) -> str:
    """Return a sample table: the standard cuts whole, of a week the first dozen."""
    lines = path.read_text("utf-8").splitlines(keepends=True)
    return "".join(lines if path.name == "standard-cuts.csv" else lines[:13])


def _import_text(cli: Cli, name: str, text: str, *said: str) -> None:
    Path(name).write_text(text, encoding="utf-8")
    Path(name).with_suffix(".toml").write_text("\n".join(["[recording]", *said]), encoding="utf-8")
    assert cli("import", name, "--machine", "lathe-1").code == 0


def _in_high_and_low_gear(text: str) -> tuple[str, str]:
    """Return the cuts of a table, half each, as the spindle's current shows them in two gears."""
    rows = [line.split(",") for line in text.splitlines()]
    at = [rows[0].index(f"spindle.current.{of}") for of in ("range", "air")]
    high, low = [rows[0], *rows[1::2]], [rows[0], *rows[2::2]]
    halved = [
        [f"{float(v) / 2.0:.6g}" if i in at else v for i, v in enumerate(row)] for row in low[1:]
    ]
    tables = (high, [rows[0], *halved])
    return tuple("\n".join(",".join(row) for row in table) + "\n" for table in tables)  # type: ignore[return-value]


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


def test_another_gear_range_is_not_sensed_by_the_spindle_only(lathe: Cli, recordings: Path) -> None:
    _import(lathe, recordings, "standard-cuts.csv", 'gear_range = "high"')
    _import(lathe, recordings, "shop-week-1.csv", 'gear_range = "low"')
    _import(lathe, recordings, "shop-week-2.csv")
    assert lathe("calibrate", "--machine", "lathe-1").code == 0
    assert lathe("refresh", "--machine", "lathe-1").code == 0
    other = _reasons("shop-week-1.csv")
    assert other["y"] == {"spindle was calibrated with gear range 'high', not 'low'"}
    assert other["z"] == {""}
    assert _reasons("shop-week-2.csv")["y"] == {""}, "a recording that states none goes with any"


def test_another_coolant_is_sensed_by_no_axis(lathe: Cli, recordings: Path) -> None:
    _import(lathe, recordings, "standard-cuts.csv", 'coolant = "flood"')
    _import(lathe, recordings, "shop-week-1.csv", 'coolant = "dry"')
    assert lathe("calibrate", "--machine", "lathe-1").code == 0
    assert lathe("refresh", "--machine", "lathe-1").code == 0
    other = _reasons("shop-week-1.csv")
    assert other["z"] == {"z was calibrated with coolant 'flood', not 'dry'"}
    assert other["y"] == {"spindle was calibrated with coolant 'flood', not 'dry'"}


def test_two_gear_ranges_are_two_calibrations_and_each_cut_takes_its_own(
    lathe: Cli, recordings: Path
) -> None:
    high, low = _in_high_and_low_gear((recordings / "standard-cuts.csv").read_text("utf-8"))
    _import_text(lathe, "a.csv", high, 'gear_range = "high"')
    _import_text(lathe, "b.csv", low, 'gear_range = "low"')
    done = lathe("calibrate", "--machine", "lathe-1", "--card", "card.html")
    assert done.code == 0, done.err
    said = " ".join(done.out.split())
    assert "axis spindle (gear range 'high'): I =" in said
    assert "axis spindle (gear range 'low'): I =" in said
    assert "axis z: I =" in said
    card = Path("card.html").read_text("utf-8")
    assert 'id="axis-spindle-' in card
    assert "in other cuts than those with gear range &#39;low&#39;" in card
    high, low = _in_high_and_low_gear(_text(recordings / "shop-week-1.csv"))
    _import_text(lathe, "c.csv", high, 'gear_range = "high"')
    _import_text(lathe, "d.csv", low, 'gear_range = "low"')
    _import(lathe, recordings, "shop-week-2.csv")
    assert lathe("refresh", "--machine", "lathe-1").code == 0
    assert _reasons("c.csv")["y"] == _reasons("d.csv")["y"] == {""}
    assert _reasons("shop-week-2.csv")["y"] == {
        "spindle was calibrated with gear range 'high' or 'low', and the cut's is not stated"
    }
    assert "nothing new" in lathe("refresh", "--machine", "lathe-1").out
    newest = _newest_parameters()
    sensed_by = [force.calibration for force in newest.forces if force.component == "y"]
    assert {row.gear_range for row in sensed_by if row} == {"high", "low"}
    why = lathe("trace", "parameters", str(newest.id)).out
    assert "gear range 'high'" in why
    assert "gear range 'low'" in why


def _newest_parameters() -> models.CuttingParameters:
    store = open_store(URL)
    with store.reading() as session:
        row = session.scalars(
            select(models.CuttingParameters).order_by(models.CuttingParameters.id.desc())
        ).first()
        assert row is not None
        for force in row.forces:
            assert force.calibration is not None or force.errors
            assert force.cut.recording.path
        session.expunge_all()
    store.close()
    return row


def test_a_gear_range_calibrated_later_takes_back_what_was_sensed_without_one(
    lathe: Cli, recordings: Path
) -> None:
    """Cuts that state none go with the only calibration there is, until there are two."""
    high, low = _in_high_and_low_gear((recordings / "standard-cuts.csv").read_text("utf-8"))
    _import_text(lathe, "a.csv", high, 'gear_range = "high"')
    assert lathe("calibrate", "a.csv", "--machine", "lathe-1").code == 0
    _import(lathe, recordings, "shop-week-1.csv")
    assert lathe("refresh", "--machine", "lathe-1").code == 0
    assert _reasons("shop-week-1.csv")["y"] == {""}
    first = _newest_parameters()
    _import_text(lathe, "b.csv", low, 'gear_range = "low"')
    assert lathe("calibrate", "b.csv", "--machine", "lathe-1").code == 0
    assert lathe("refresh", "--machine", "lathe-1").code == 0
    second = _newest_parameters()
    assert second.version > first.version
    assert second.previous_id is None
    of_y = [force for force in second.forces if force.component == "y"]
    cuts_of = {Path(force.cut.recording.path).name for force in of_y}
    assert cuts_of == {"a.csv", "b.csv"}


def test_a_newer_calibration_replaces_those_that_could_hold_for_the_same_cut() -> None:
    high, low = Holds(gear_range="high"), Holds(gear_range="low")
    assert high.against(low) == ["gear_range"]
    assert not high.against(ANY)
    assert not high.against(Holds(coolant="flood"))
    assert Holds("high", "dry").against(Holds("low", "flood")) == ["gear_range", "coolant"]


def test_each_cut_takes_the_calibration_that_holds_for_it() -> None:
    known = [Holds(gear_range="high"), Holds(gear_range="low")]
    assert which(known, Holds(gear_range="low", coolant="flood")) == 1
    assert which(known[:1], ANY) == 0
    assert which(known, Holds("mid")) == "calibrated with gear range 'high' or 'low', not 'mid'"
    assert which(known, ANY) == (
        "calibrated with gear range 'high' or 'low', and the cut's is not stated"
    )


def test_cuts_are_parted_by_what_they_state() -> None:
    high, low = Holds("high", "flood"), Holds("low")
    parts = partition([high, low, ANY, high])
    assert {key: rows.tolist() for key, rows in parts.items()} == {
        Holds("high", "flood"): [True, False, False, True],
        Holds("low", "flood"): [False, True, False, False],
    }
    cuts = [high, low, ANY, high]
    assert unstated(cuts, parts, np.array([True] * 4)) == (
        "1 cuts do not state their gear range, and others state several"
    )
    forth, back = Holds(feed_direction="+"), Holds(feed_direction="-")
    assert list(partition([forth, ANY])) == [ANY], "not every cut shows its direction"
    assert list(partition([forth, forth])) == [forth]
    assert list(partition([forth, back, ANY])) == [forth, back]
    alone = [high, ANY]
    assert unstated(alone, partition(alone), np.array([True] * 2)) is None
    assert unstated(cuts, parts, np.array([True, True, False, True])) is None, "it stands"


def test_the_direction_of_a_feed_axis_comes_from_its_velocity() -> None:
    channels = {"cut": np.arange(4.0), "z.velocity": np.array([-3.0, 3.0, 0.0, np.nan])}
    stated = {"gear_range": ["high"] * 4, "coolant": ["dry"] * 4, "spindle_state": ["warm"] * 4}
    table = CutTable(path=Path("t.csv"), channels=channels, texts=stated)
    assert holds_of(table, "z") == [
        Holds(coolant="dry", feed_direction="-"),
        Holds(coolant="dry", feed_direction="+"),
        Holds(coolant="dry"),
        Holds(coolant="dry"),
    ]
    assert holds_of(table, "spindle") == [Holds("high", "dry", "warm")] * 4
