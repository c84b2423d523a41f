"""What spoils a raw cut sets it aside, what disturbs a part of it is left out, and nothing else is.

Seeds are 0, 1, 2, … as they come. Levels are those of the disturbances below.
"""

import re
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.agent.ingest.gathering import cuts_of_files
from autodb.errors import UnusableInput
from autodb.proofs.machines.lathe.disturbed import CutDisturbance, Disturbed
from autodb.proofs.machines.lathe.process import Array
from autodb.records.tables import Recording
from autodb.sensing.ranges.recorded import raw
from tests.conftest import Cli
from tests.helpers.campaigns import first
from tests.helpers.files import write
from tests.helpers.raw_cuts import condition, made, read, row_of, write_raw

pytestmark = pytest.mark.usefixtures("one_law")

CLEAN, SEEDS = range(30), range(12)
HEAVY = (1, 2, 3, 4, 5, 7, 8, 9, 10, 11, 13, 14)  # 12 cuts without the lightest condition

Read = tuple[Disturbed, raw.RawCut | str]


def _away(seed: int) -> float:
    """Return a frequency midway between two multiples of the spindle's, 100 to 180 Hz."""
    turning_hz = condition(seed).spindle_rpm / 60.0
    return (round((100.0 + 5.0 * seed) / turning_hz) + 0.5) * turning_hz


def _no_speed(name: str) -> bool:
    return name != "spindle.speed"


def _no_force(name: str) -> bool:
    return not name.startswith("force")


@pytest.fixture(scope="module")
def clean() -> list[Read]:
    """30 clean cuts of 8, 12 and 5 s: their force wanders by 2 % with 0.2 s of memory."""
    cuts = [made(seed, duration_s=(8.0, 12.0, 5.0)[seed % 3]) for seed in CLEAN]
    return [(cut, read(cut)) for cut in cuts]


def test_no_clean_cut_is_set_aside(clean: list[Read]) -> None:
    for _, found in clean:
        assert isinstance(found, raw.RawCut), found
        assert all("its range in air is excluded" in note for note in found.notes), found.notes


def _scores(clean: list[Read], name: str) -> Array:
    """Return (mean − truth)/standard error of a channel over the cuts that have it."""
    axis, part = name.split(".current.")
    rows = [(row_of(found), cut.cut_A if part == "range" else cut.air_A) for cut, found in clean]
    return np.array([(r[name] - truth[axis]) / r[f"{name}.sd"] for r, truth in rows])


@pytest.mark.parametrize(
    "name", ["spindle.current.range", "z.current.range", "spindle.current.air"]
)
def test_standard_errors_are_as_large_as_the_errors(clean: list[Read], name: str) -> None:
    """Scatter of one recording alone; 30 scores of unit rms have an rms of 0.6 to 1.4 (3 sd)."""
    assert 0.6 < np.sqrt(np.mean(_scores(clean, name) ** 2)) < 1.4


def test_means_of_clean_cuts_are_the_truth(clean: list[Read]) -> None:
    for cut, found in clean:
        row = row_of(found)
        for axis in ("z", "spindle"):
            assert_allclose(row[f"{axis}.current.range"], cut.cut_A[axis], rtol=0.012)
            air = row.get(f"{axis}.current.air", cut.air_A[axis])
            assert_allclose(air, cut.air_A[axis], rtol=0.005)


def test_an_approach_of_two_turns_of_a_slow_drive_says_its_range_in_air() -> None:
    """z turns at 1.3 Hz in the one and at 3.8 Hz in the other; averages want 2.2 s of the slow."""
    for seed in (3, 5):
        cut = made(seed)
        assert_allclose(row_of(read(cut))["z.current.air"], cut.air_A["z"], rtol=0.005)


def test_an_approach_that_is_short_and_not_steady_is_left_out_and_said() -> None:
    """z starts 0.4 s before the tool enters, so that its frequency in air is no one's."""
    cut = made(3)
    late = cut.channels["t"] < 1.6
    still = {
        name: np.where(late, values[0], values) if name.startswith("z.current") else values
        for name, values in cut.channels.items()
    }
    found = raw.cut_of_recording(Recording(path=Path("late.csv"), channels=still))
    assert "z.current.air" not in row_of(found)
    assert any(
        re.search(r"z: its range in air is excluded, .*not steady; approach for", note)
        for note in found.notes
    )


@pytest.mark.parametrize("seed", first(3, SEEDS))
def test_chatter_of_15_percent_is_seen_by_the_dynamometer(seed: int) -> None:
    hertz = _away(seed)
    said = read(made(seed, CutDisturbance(chatter_share=0.15, chatter_hz=hertz)))
    assert isinstance(said, str)
    assert "chatter in the cut: force." in said
    found = re.search(r"at ([\d.]+) Hz, no multiple", said)
    assert found is not None
    assert_allclose(float(found[1]), hertz, atol=0.6)


@pytest.mark.parametrize("seed", first(3, SEEDS))
def test_chatter_of_30_percent_is_seen_in_the_currents(seed: int) -> None:
    """Half of it reaches the currents."""
    said = read(made(seed, CutDisturbance(chatter_share=0.3, chatter_hz=_away(seed))), _no_force)
    assert isinstance(said, str)
    assert "chatter in the cut" in said
    assert ".current swings" in said


def test_a_swing_once_a_revolution_is_no_chatter() -> None:
    for seed in SEEDS:
        turning_hz = condition(seed).spindle_rpm / 60.0
        cut = made(seed, CutDisturbance(chatter_share=0.3, chatter_hz=4.0 * turning_hz))
        assert isinstance(read(cut), raw.RawCut)


def test_without_a_speed_chatter_is_not_looked_for_and_that_is_said() -> None:
    found = read(made(2, CutDisturbance(chatter_share=0.3, chatter_hz=_away(2))), _no_speed)
    assert isinstance(found, raw.RawCut)
    assert found.notes == ("chatter was not searched for: the spindle's speed is not known",)


@pytest.mark.parametrize("seed", first(3, SEEDS))
def test_a_stop_of_0_4_s_in_the_middle_is_seen(seed: int) -> None:
    at_s = 4.0 + 0.3 * seed
    said = read(made(seed, CutDisturbance(stop_s=(at_s, at_s + 0.4))))
    assert isinstance(said, str)
    found = re.search(r"interrupted from ([\d.]+) to ([\d.]+) s", said)
    assert found is not None
    assert_allclose([float(found[1]), float(found[2])], [at_s, at_s + 0.4], atol=0.15)


@pytest.mark.parametrize("seed", first(3, SEEDS))
def test_a_stop_of_0_8_s_is_seen_by_the_feed_axis_alone(seed: int) -> None:
    said = read(made(seed, CutDisturbance(stop_s=(6.0, 6.8))), lambda name: name[0] in "tz")
    assert isinstance(said, str)
    assert "the cut is interrupted" in said


@pytest.mark.parametrize("seed", first(3, HEAVY))
def test_a_spindle_at_its_current_limit_is_seen(seed: int) -> None:
    """The limit is what the cut takes on average, and the force wanders by 6 %."""
    cut = made(seed, CutDisturbance(limit_share=1.0, wander_share=0.06))
    said = read(cut)
    assert isinstance(said, str)
    assert "spindle.current is at its limit" in said
    found = re.search(r"stays at ([\d.]+) A", said)
    assert found is not None
    assert_allclose(float(found[1]), cut.cut_A["spindle"], rtol=0.005)


@pytest.mark.parametrize("seed", first(3, SEEDS))
@pytest.mark.parametrize("recorded", [True, False], ids=["speed", "frequency"])
def test_a_braking_spindle_is_left_out(seed: int, recorded: bool) -> None:
    """0.3 s after the tool left it brakes in 0.6 to 2 s, at 1.5 times the range of the cut."""
    cut = made(seed, CutDisturbance(brake_s=(0.6, 1.2, 2.0)[seed % 3], brake_after_s=0.3))
    found = read(cut, lambda name: recorded or _no_speed(name))
    row = row_of(found)
    assert isinstance(found, raw.RawCut)
    from_s = re.search(
        r"from ([\d.]+) s on the spindle slows down, its range up to", found.notes[0]
    )
    assert from_s is not None
    assert_allclose(float(from_s[1]), 2.0 + 0.4 + 10.0 + 0.3, atol=0.25)
    assert_allclose(row["spindle.current.range"], cut.cut_A["spindle"], rtol=0.012)
    assert_allclose(row["spindle.current.air"], cut.air_A["spindle"], rtol=0.005)


@pytest.mark.parametrize("seed", first(3, SEEDS))
def test_lubrication_pulses_are_left_out(seed: int) -> None:
    """They raise z's range by 60 % every 2.5 s and fade in 0.2 s: the mean would rise by 5 %."""
    what = CutDisturbance(pulse_share=0.6, pulse_every_s=2.5, pulse_first_s=0.4 + 0.15 * seed)
    cut = made(seed, what)
    found = read(cut)
    row = row_of(found)
    assert isinstance(found, raw.RawCut)
    (note,) = (note for note in found.notes if "way lubrication" in note)
    every_s = re.search(r"every ([\d.]+) s", note)
    assert every_s is not None
    assert_allclose(float(every_s[1]), 2.5, atol=0.15)
    assert_allclose(row["z.current.range"], cut.cut_A["z"], rtol=0.012)
    assert_allclose(row.get("z.current.air", cut.air_A["z"]), cut.air_A["z"], rtol=0.01)


def test_a_short_cut_is_set_aside_with_what_would_work() -> None:
    short = read(made(2, duration_s=0.5))  # 1500 rpm
    few = read(made(3, duration_s=1.0))  # 800 rpm: 10 revolutions take 0.75 s
    assert isinstance(short, str)
    assert isinstance(few, str)
    assert re.search(r"too short: .*; make a cut of 1\.4 s or longer", short)
    assert re.search(r"too short: .* revolutions .*; make a cut of 1\.8 s or longer", few)


def test_others_go_on_when_one_of_several_is_set_aside(cli: Cli, tmp_path: Path) -> None:
    good = [write_raw(tmp_path / f"cut{seed}.parquet", seed) for seed in (2, 5)]
    bad = write_raw(tmp_path / "stopped.parquet", 2, CutDisturbance(stop_s=(4.0, 4.6)))
    assert cli("init").code == 0
    assert cli("machine", "add", "lathe-1").code == 0
    done = cli("import", good[0], bad, good[1], "--machine", "lathe-1")
    assert done.code == 0, done.err
    assert f"excluded: {bad}: the cut is interrupted from" in done.out
    assert "recording 2: cut5.parquet: imported" in done.out
    alone = cli("import", bad, "--machine", "lathe-1")
    assert alone.code == 2
    assert "the cut is interrupted from" in alone.err
    none = cli("import", bad, bad, "--machine", "lathe-1")
    assert none.code == 2
    assert none.err == "autodb: none of the 2 cuts can be used; all are excluded\n"


def test_raw_cuts_calibrate_without_the_one_that_is_set_aside(cli: Cli, tmp_path: Path) -> None:
    good = [write_raw(tmp_path / f"cut{seed}.parquet", seed) for seed in range(6)]
    pulses = CutDisturbance(pulse_share=0.6, pulse_every_s=1.5, pulse_first_s=0.4)
    noted = write_raw(tmp_path / "oiled.parquet", 11, pulses, duration_s=8.0)
    bad = write_raw(tmp_path / "shaking.parquet", 8, CutDisturbance(0.02, 0.3, _away(8)))
    done = cli("calibrate", *good, noted, bad)
    assert done.code == 0, done.err
    assert f"excluded: {bad}: chatter in the cut" in done.out
    assert f"{noted}: z: " in done.out
    assert "axis spindle: I = spindle.current.range − spindle.current.air" in done.out


def test_cuts_of_several_files_are_one_table(tmp_path: Path) -> None:
    """Numbered in order; what one file lacks is not known of its cuts."""
    raws = [write_raw(tmp_path / f"cut{seed}.parquet", seed) for seed in (3, 5)]
    table = write(
        tmp_path / "cuts.csv",
        {"cut": [7, 8], "tool.edge": ["a", "b"], "force.z": [1.0, 2.0], "cutting.feed": [0.1, 0.1]},
    )  # fmt: skip
    told: list[str] = []
    joined = cuts_of_files([table, *raws], columns=None, tell=told.append)
    assert_allclose(joined.cut, [1, 2, 3, 4])
    assert_allclose(joined["cutting.feed"], [0.1, 0.1, 0.3, 0.4])
    assert joined.texts["tool"] == ["", "", "carbide insert", "carbide insert"]
    assert joined.texts["tool.edge"] == ["a", "b", "", ""]
    assert np.isnan(joined["spindle.current.range.sd"][:2]).all()
    assert (joined["spindle.current.range.sd"][2:] > 0.0).all()
    assert told == []


def test_a_unit_that_differs_between_files_is_refused(tmp_path: Path) -> None:
    paths = [write(tmp_path / f"{n}.csv", {"cut": [1], "z.current": [1.0]}) for n in "ab"]
    paths[1].with_suffix(".toml").write_text(
        '[channels]\n"z.current" = {column = "z.current", unit = "raw"}\n'
    )
    with pytest.raises(UnusableInput, match=r"z\.current is in A and raw in different files"):
        cuts_of_files(paths, columns=None, tell=print)
