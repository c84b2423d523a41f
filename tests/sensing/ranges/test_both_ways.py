"""A feed axis in both directions: one gain, friction apart; what stands has no direction."""

import csv
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.agent.sense.calibrating import calibrate_table
from autodb.records.tables import CutTable
from autodb.sensing.ranges.chosen import sense_each
from autodb.sensing.ranges.feeding import inward_rad, moving
from tests.conftest import Cli

pytestmark = pytest.mark.usefixtures("one_law")

Array = NDArray[np.float64]

GAIN_N_A, FRICTION_A, WEIGHT_A, NOISE_A = 400.0, 2.0, 3.0, 0.03


def faces(seed: int, *, signed: bool, cuts: tuple[int, int] = (6, 4)) -> CutTable:
    """Return faces to the centre and away from it, and as many cylinders, of x alone.

    The work pushes x against its feed; a signed current has weight and friction in it, a range of
    two phases rises by the load, whichever way it goes.
    """
    rng = np.random.default_rng(seed)
    way = np.repeat([-1.0, 1.0], cuts)
    force = -way * rng.uniform(150.0, 600.0, len(way))
    current_A = WEIGHT_A + way * FRICTION_A - force / GAIN_N_A
    standing = len(way)
    channels = {
        "x.velocity": np.append(5.0 * way, np.zeros(standing)),
        "force.x": np.append(force, rng.uniform(100.0, 300.0, standing)),
        "spindle.speed": rng.choice([800.0, 1000.0, 1200.0], 2 * standing),
        "cutting.feed": rng.choice([0.1, 0.2, 0.3, 0.4], 2 * standing),
        "cutting.depth": rng.choice([0.5, 1.0, 1.5, 2.0], 2 * standing),
    }
    channels["cut"] = np.arange(1.0, 2 * standing + 1)
    noise = rng.normal(0.0, NOISE_A, 2 * standing)
    if signed:
        channels["x.current"] = np.append(current_A, np.full(standing, WEIGHT_A)) + noise
    else:
        rise = np.append(np.abs(force) / GAIN_N_A, np.zeros(standing))
        channels |= {
            "x.current.air": np.full(2 * standing, 5.0),
            "x.current.range": 5 + rise + noise,
        }
    operations = ["face"] * standing + ["turn"] * standing
    return CutTable(path=Path("faces.csv"), channels=channels, texts={"operation": operations})


@pytest.mark.parametrize("signed", [True, False], ids=["signed", "range"])
def test_both_directions_share_the_gain(signed: bool) -> None:
    """Of 20 axes 19 or more: one slope, its size the gain, within 12 % from ten cuts."""
    shared = 0
    for seed in range(20):
        table = faces(seed, signed=signed)
        done, left_out = calibrate_table(table, axes=("x",))
        assert [one.holds.feed_direction for one in done] == ["-", "+"]
        assert not left_out, "a cylinder has no direction of x, and needs none"
        inward, outward = (one.coefficients[1] for one in done)
        shared += abs(abs(inward) / abs(outward) - 1.0) < 1e-9
        assert_allclose(abs(inward), GAIN_N_A, rtol=0.12)
    assert shared >= 19


def test_a_gain_that_differs_by_direction_is_kept_apart() -> None:
    table = faces(1, signed=True, cuts=(14, 14))
    current, away = table["x.current"].copy(), table["x.velocity"] > 0
    current[away] = 5.0 - table["force.x"][away] / (0.6 * GAIN_N_A)
    channels = {**table.channels, "x.current": current}
    done, _ = calibrate_table(
        CutTable(path=table.path, channels=channels, texts=table.texts), axes=("x",)
    )
    slopes = {one.holds.feed_direction: one.coefficients[1] for one in done}
    assert_allclose(slopes["+"] / slopes["-"], 0.6, rtol=0.05)


@pytest.mark.parametrize("signed", [True, False], ids=["signed", "range"])
def test_forces_of_both_directions_are_sensed_and_none_of_an_axis_that_stands(
    signed: bool,
) -> None:
    done, _ = calibrate_table(faces(3, signed=signed), axes=("x",))
    others = faces(4, signed=signed)
    moves = moving(others, "x")
    for force_N, one, moved in zip(others["force.x"], sense_each(others, done), moves, strict=True):
        if moved:
            assert one.force_N is not None
            assert abs(one.force_N - force_N) < 5.0 * NOISE_A * GAIN_N_A
        else:
            assert one.reason == "x stands still: a passive force shows in no current"


def test_a_face_away_from_the_axis_is_fed_outward() -> None:
    table = faces(1, signed=True)
    away = table["x.velocity"] > 0
    assert_allclose(np.degrees(inward_rad(table)[away]), -90.0)
    assert_allclose(np.degrees(inward_rad(table)[:6]), 90.0)


def _written(table: CutTable, path: Path) -> Path:
    """Write a table with a pair and its tangential force, which is the same whichever way."""
    names = [*table.channels, "t", "force.y", "operation", "work.material", "tool", "work.diameter"]
    with path.open("w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(names)
        for k, operation in enumerate(table.texts["operation"]):
            known = [float(values[k]) for values in table.channels.values()]
            rows.writerow([*known, 60.0 * k, 900.0, operation, "steel", "insert", 60.0])
    return path


def test_outward_faces_are_learnt_and_predicted_outward_and_no_calibration_is_due(
    cli: Cli, tmp_path: Path
) -> None:
    """The currents of one direction are beyond those of the other: that says nothing of either."""
    path = _written(faces(5, signed=True, cuts=(12, 12)), tmp_path / "faces.csv")
    for command in ("init", "machine add lathe-1"):
        assert cli(*command.split()).code == 0
    assert cli("import", path, "--machine", "lathe-1").code == 0
    assert cli("calibrate", "--machine", "lathe-1").code == 0
    done = cli("refresh", "--machine", "lathe-1")
    assert "24 sensed" in done.out
    assert "calibration due" not in done.out
    found = {}
    for ends in ("60, 40", "40, 60"):
        start, end = ends.split(", ")
        pair = "--machine lathe-1 --material steel --tool insert --operation face"
        cut = f"--diameter {start} --end-diameter {end} --depth 1 --feed 0.2 --rpm 1000"
        asked = cli("lookup", *pair.split(), *cut.split())
        assert asked.code == 0, asked.err
        found[ends] = float(asked.out.split("mean")[1].split()[2])
    assert found["60, 40"] > 100.0
    assert_allclose(found["40, 60"], -found["60, 40"], rtol=0.02)
