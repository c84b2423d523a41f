"""One cut recorded as raw phase currents: one phase or three, in volts of a Hall sensor."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.proofs.machines.lathe.jobs import cut_at
from autodb.proofs.machines.lathe.phases import phases, raw_cut
from autodb.proofs.machines.sample import SAMPLE_LATHE, SAMPLE_PAIR, write_csv
from autodb.records import source as records
from autodb.records.tables import CutTable, Recording
from autodb.sensing.ranges.recorded import raw
from autodb.store import models, open_store
from tests.conftest import Cli

Array = NDArray[np.float64]

RATE = 1000.0
VOLT_PER_A = 0.1
SIDE = """
[channels]
"spindle.current.u" = {column = "U_SPINDLE", scale = 10, unit = "A"}
"z.current.u" = {column = "U_Z", scale = 0.01, unit = "A"}
[cut]
operation = "turn"
"""


@pytest.fixture(scope="module")
def cut() -> dict[str, Array]:
    """A cut that feeds at 6.7 mm/s: the z drive turns at 2.1 Hz, the spindle's at 74 Hz."""
    made = cut_at((2.0, 0.20, 2000.0, 62.0), duration_s=4.0)
    return raw_cut(SAMPLE_LATHE, SAMPLE_PAIR, made, 8, True)


@pytest.fixture
def volts(cut: dict[str, Array], tmp_path: Path) -> Path:
    """One Hall sensor an axis, 0.1 V/A, one logged in V and one in mV."""
    path = tmp_path / "hall.csv"
    sensed = {
        "t": cut["t"],
        "U_SPINDLE": VOLT_PER_A * cut["spindle.current.v"],
        "U_Z": 1000.0 * VOLT_PER_A * cut["z.current.w"],
    }
    write_csv(path, sensed)
    path.with_suffix(".toml").write_text(SIDE, encoding="utf-8")
    return path


def _row(table: CutTable) -> dict[str, float]:
    return {name: float(values[0]) for name, values in table.channels.items()}


def test_one_hall_sensor_an_axis_reads_what_three_phases_do(
    cut: dict[str, Array], volts: Path
) -> None:
    three = _row(raw.cut_of_recording(Recording(path=Path("three.csv"), channels=cut)).table)
    read = records.read(volts)
    assert isinstance(read, Recording)
    one = _row(raw.cut_of_recording(read).table)
    for name in ("spindle.current.range", "spindle.current.air", "z.current.range"):
        assert_allclose(one[name], three[name], rtol=0.005)
    assert_allclose(one["z.current.air"], three["z.current.air"], rtol=0.03)


def test_a_recording_of_one_phase_is_imported_with_its_cut(volts: Path, cli: Cli) -> None:
    assert cli("init").code == 0
    assert cli("machine", "add", "lathe-1").code == 0
    done = cli("import", volts, "--machine", "lathe-1")
    assert done.code == 0, done.err
    store = open_store("sqlite:///autodb.sqlite3")
    with store.reading() as session:
        (kept,) = session.query(models.Cut).all()
        assert set(kept.measured) >= {"spindle.current.range", "z.current.range"}
        assert not any(name.startswith("x.current") for name in kept.measured)
    store.close()


def test_a_range_that_folds_on_its_way_into_the_cut_is_left_out() -> None:
    """Air 3 A of load that weight drives, cut 5 A against it: what the range says is not known."""
    t = np.arange(24_000) / RATE
    load_A = np.interp(t, [10.0, 16.0], [-3.0, 5.0])
    rng = np.random.default_rng(13)
    made = phases(rng, np.abs(load_A), np.full(t.size, 12.0), RATE)
    channels = {"t": t, **{f"x.current.{name}": values for name, values in made.items()}}
    spindle = phases(rng, np.where(t > 10.0, 20.0, 10.0), np.full(t.size, 50.0), RATE)
    channels |= {f"spindle.current.{name}": values for name, values in spindle.items()}
    done = raw.cut_of_recording(Recording(path=Path("a.csv"), channels=channels))
    row = _row(done.table)
    assert_allclose(row["x.current.air"], 3.0, rtol=0.005)
    assert "x.current.range" not in row
    assert any("folds between air and cut" in line for line in done.notes)
    assert_allclose(row["spindle.current.range"], 20.0, rtol=0.01)


def test_velocity_and_temperature_of_a_cut_are_kept_with_it(cut: dict[str, Array]) -> None:
    """They say which calibration holds: direction of feed, warmth of the spindle."""
    t = cut["t"]
    theta = {"spindle.temperature": 30.0 + 0.0 * t}
    bare = {name: v for name, v in cut.items() if not name.endswith((".position", ".velocity"))}
    row = _row(raw.cut_of_recording(Recording(path=Path("a.csv"), channels=bare | theta)).table)
    assert_allclose(row["spindle.temperature"], 30.0)
    assert "z.velocity" not in row
    for moves in ({"z.velocity": -4.0 + 0.0 * t}, {"z.position": 100.0 - 4.0 * t}):
        row = _row(raw.cut_of_recording(Recording(path=Path("a.csv"), channels=bare | moves)).table)
        assert_allclose(row["z.velocity"], -4.0)


def test_a_stated_speed_stays_under_a_load_that_makes_the_motor_slip(
    cut: dict[str, Array], tmp_path: Path
) -> None:
    """The virtual spindle's frequency rises by 2 % in the cut; the work turns as before."""
    bare = {name: v for name, v in cut.items() if name != "spindle.speed"}
    path = tmp_path / "bare.csv"
    write_csv(path, bare)
    path.with_suffix(".toml").write_text('[cut]\noperation = "turn"\nspeed_rpm = 2000\n', "utf-8")
    read = records.read(path)
    assert isinstance(read, Recording)
    assert_allclose(_row(raw.cut_of_recording(read).table)["spindle.speed"], 2000.0)


def test_an_x_that_withdraws_is_no_other_radius_of_a_turned_cut(
    cut: dict[str, Array], tmp_path: Path
) -> None:
    """It stands 5 mm clear until the approach begins, and goes 20 mm away at the end."""
    t = cut["t"]
    away = np.where(t < 0.3, 5.0, 0.0) + np.where(t > t[-1] - 0.4, 20.0, 0.0)
    side = '[cut]\noperation = "turn"\nspeed_rpm = 2000\nwork_diameter_mm = 62\n'
    rows = []
    for name, moves in (("still", 0.0 * t), ("moves", away)):
        path = tmp_path / f"{name}.csv"
        bare = {key: values for key, values in cut.items() if key != "work.diameter"}
        write_csv(path, bare | {"x.position": 31.0 + moves})
        path.with_suffix(".toml").write_text(side, "utf-8")
        read = records.read(path)
        assert isinstance(read, Recording)
        rows.append(_row(raw.cut_of_recording(read).table))
    assert rows[0]["work.diameter"] == rows[1]["work.diameter"] == 62.0
    assert_allclose(rows[1]["spindle.current.range"], rows[0]["spindle.current.range"])


def test_how_long_a_cut_took_is_kept_with_it_unless_it_goes_on(cut: dict[str, Array]) -> None:
    whole = Recording(path=Path("a.csv"), channels=cut)
    begin_s, end_s = raw.cut_stretch(whole)
    assert_allclose(_row(raw.cut_of_recording(whole).table)["cut.duration"], end_s - begin_s)
    open_ = {name: values[cut["t"] < end_s - 1.0] for name, values in cut.items()}
    going_on = raw.cut_of_recording(Recording(path=Path("a.csv"), channels=open_))
    assert "cut.duration" not in _row(going_on.table)
