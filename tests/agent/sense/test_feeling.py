"""Milled cuts recorded over time: sensed by a table dynamometer, and learnt from by refresh."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.proofs.machines.mill.reference_milling import ORDERS, MillEngagement, orders, waves
from autodb.records.tables import Recording
from autodb.records.timed import on_even_rows
from autodb.sensing.ranges.in_cut import mean_of, steady_rows
from autodb.timing.verdict import even
from tests.conftest import Cli, Once

pytestmark = pytest.mark.usefixtures("one_law")

Array = NDArray[np.float64]

RATE_HZ, RPM = 1000.0, 2400.0
T = np.arange(0.0, 5.0, 1.0 / RATE_HZ)
INSIDE = (T > 1.2) & (T < 3.8)
TILT = np.radians(-30.0)
KG, ARM_M = 25.0, 0.1
CUTS = ((0.03, 1.0), (0.05, 1.0), (0.03, 2.0), (0.05, 2.0), (0.07, 1.5), (0.04, 1.5), (0.06, 2.0))
NEW = (0.045, 1.8)
MACHINE = '[axes.x]\n[axes.y]\n[axes.z]\n[axes.a]\ncarries = "work"\n'
SIDE = """[recording]
work = "C45"
[tool]
name = "mill-10"
kind = "end_mill"
diameter_mm = 10.0
teeth = 4
helix_deg = 36.5
[cut]
operation = "slot"
depth_mm = {depth}
feed_mm_tooth = {feed}
speed_rpm = {rpm}
"""


def _forces(feed: float, depth: float) -> tuple[Array, Array]:
    """Return the waves (3, n) of a slot along +x and their means, by the generator's own orders."""
    found = orders(MillEngagement(depth, 10.0, feed, False, 0.0, 0.0))
    theta = 2.0 * np.pi * RPM / 60.0 * T
    return waves(found, theta, np.ones(ORDERS + 1, dtype=np.complex128)) * INSIDE, found[:, 0].real


def _read(process_N: Array, angle: Array, seed: int) -> dict[str, Array]:
    """Return what a dynamometer on a table that turns about x reads, with noise of 1 N."""
    s, c = np.sin(angle), np.cos(angle)
    weight = KG * 9.80665 * np.array([0.0 * s, -s, c - 1.0])
    x, y, z = process_N
    turned = np.array([x, c * y - s * z, s * y + c * z]) + weight
    rate = np.gradient(angle, 1.0 / RATE_HZ)
    faster = np.gradient(rate, 1.0 / RATE_HZ)
    # The arm is along y: it is thrown outwards, and held up as the table turns faster
    turned[1] -= KG * ARM_M * rate**2
    turned[2] += KG * ARM_M * faster
    noise = np.random.default_rng([seed, 80]).standard_normal(turned.shape)
    forces = {f"force.{axis}": turned[k] + noise[k] for k, axis in enumerate("xyz")}
    return {"t": np.arange(len(angle)) / RATE_HZ, "a.angle": np.degrees(angle)} | forces


def _write(path: Path, columns: dict[str, Array]) -> Path:
    pd.DataFrame(columns).to_csv(path, index=False, float_format="%.5g")
    return path


def _tilts(seed: int = 1) -> dict[str, Array]:
    """Return rests upright and at −60, −30 and 30°, with moves of a second between them."""
    parts, now = [np.zeros(2000)], 0.0
    for goal in (-60.0, 0.0, -30.0, 0.0, 30.0, 0.0):
        u = np.linspace(0.0, 1.0, 1000)
        parts += [now + (goal - now) * u**3 * (10.0 - 15.0 * u + 6.0 * u**2), np.full(2000, goal)]
        now = goal
    angle = np.radians(np.concatenate(parts))
    return _read(np.zeros((3, len(angle))), angle, seed)


def _cut(number: int, feed: float, depth: float) -> Path:
    process, _ = _forces(feed, depth)
    path = _write(Path(f"cut-{number}.csv"), _read(process, np.full(len(T), TILT), 10 + number))
    side = SIDE.format(feed=feed, depth=depth, rpm=RPM)
    path.with_suffix(".toml").write_text(side, encoding="utf-8")
    return path


@pytest.fixture
def milled(cli: Cli, once: Once) -> Cli:
    """Return the command line on a mill with a table dynamometer and seven recorded slots."""

    def make() -> None:
        cli("init")
        Path("mill.toml").write_text(MACHINE, encoding="utf-8")
        cli("machine", "add", "mill", "--file", "mill.toml")
        made = cli("calibrate", _write(Path("tilts.csv"), _tilts()), "--machine", "mill", "--table")
        assert made.code == 0, made.err
        for number, (feed, depth) in enumerate(CUTS):
            done = cli("import", _cut(number, feed, depth), "--machine", "mill")
            assert done.code == 0, done.err
            assert "1 cut" in done.out
        learnt = cli("refresh", "--machine", "mill")
        assert learnt.code == 0, learnt.err
        assert "21 forces sensed" in learnt.out
        assert "C45 / mill-10: version 1 from 7 cuts" in learnt.out

    once(make)
    return cli


JOB = """name = "slot"
material = "C45"
tool = "mill-10"
[[cut]]
name = "new"
operation = "slot"
depth_mm = {depth}
feed_mm_tooth = {feed}
speed_rpm = {rpm}
"""


def test_a_slot_never_cut_is_predicted_from_recorded_ones(milled: Cli) -> None:
    """Mean forces within their intervals; that across the feed is known to a tenth and better."""
    feed, depth = NEW
    Path("job.toml").write_text(JOB.format(feed=feed, depth=depth, rpm=RPM), encoding="utf-8")
    ran = milled("predict", "job.toml", "--machine", "mill", "--json")
    assert ran.code == 0, ran.err
    told = json.loads(ran.out)
    _, mean = _forces(feed, depth)
    for k, c in enumerate("xyz"):
        force = told["cuts"][0][f"force_{c}_N"]
        assert force["low"] <= mean[k] <= force["high"]
    across = told["cuts"][0]["force_y_N"]
    assert across["high"] - across["low"] < 0.2 * mean[1]
    assert told["behind"]["cuts"] == len(CUTS)


def test_nothing_is_sensed_twice(milled: Cli) -> None:
    again = milled("refresh", "--machine", "mill")
    assert again.code == 0
    assert "nothing new" in again.out
    traced = milled("trace", "parameters", "1")
    assert "table of force." in traced.out


def test_a_new_version_of_the_sensor_feels_all_cuts_anew(milled: Cli) -> None:
    moves = _write(Path("again.csv"), _tilts(2))
    made = milled("calibrate", moves, "--machine", "mill", "--table")
    assert "Table dynamometer 2 of mill" in made.out
    done = milled("refresh", "--machine", "mill")
    assert "21 forces sensed" in done.out
    assert "version 2 from 7 cuts" in done.out
    traced = milled("trace", "parameters", "2")
    assert "table of force.x, version 2" in traced.out
    assert "table of force.x, version 1" not in traced.out


def test_a_recording_that_is_gone_is_said_not_to_be_sensed(milled: Cli) -> None:
    path = _cut(9, 0.05, 1.2)
    assert milled("import", path, "--machine", "mill").code == 0
    path.unlink()
    done = milled("refresh", "--machine", "mill")
    assert done.code == 0
    assert "0 forces sensed, 3 not sensed" in done.out
    assert "cut-9.csv: the file is missing or has changed" in done.out


def test_where_the_cut_is_steady() -> None:
    rows = steady_rows(_forces(0.05, 2.0)[0], even(T), where="cut.csv")
    assert 1.2 < T[rows.start] < 1.6
    assert 3.4 < T[rows.stop] < 3.8
    mean = mean_of(_forces(0.05, 2.0)[0][1], np.full(len(T), 3.0), rows)
    assert mean.force_N == pytest.approx(_forces(0.05, 2.0)[1][1], rel=0.01)
    assert mean.sd_N == pytest.approx(3.0)
    with pytest.raises(UnusableInput, match=r"no 0\.5 s of a steady cut"):
        steady_rows(_forces(0.05, 2.0)[0][:, 1100:1500], even(T[1100:1500]), where="cut.csv")


def test_a_steady_cut_is_not_taken_over_a_gap() -> None:
    """Rows 1.5 to 2.2 s are missing: the longer stretch, behind them, is taken."""
    there = (T < 1.5) | (T >= 2.2)
    forces = _forces(0.05, 2.0)[0][:, there]
    raw = Recording(Path("cut.csv"), {"t": T[there], "force.x": forces[0]})
    timing = on_even_rows(raw).timing
    assert len(timing.pieces) == 2
    rows = steady_rows(forces, timing, where="cut.csv")
    assert T[there][rows.start] > 2.2
    assert 3.4 < T[there][rows.stop] < 3.8


def test_a_drive_in_newtons_feels_recorded_cuts_too(cli: Cli) -> None:
    """A slot along x at 4 mm/s: the mean is the generator's within a tenth."""
    t = np.arange(0.0, 40.0, 0.004)
    x = 40.0 + 20.0 * np.sin(2.0 * np.pi * 0.3 * t)
    rng = np.random.default_rng(91)

    def effort(x_mm: Array, t_s: Array, load_N: Array) -> Array:
        v = np.gradient(x_mm, t_s)
        rubs = 60.0 * np.tanh(v / 0.05) + 0.5 * v + 0.1 * np.gradient(v, t_s)
        return rubs + load_N + 3.0 * rng.standard_normal(len(t_s))

    air = {"t": t, "x.position": x, "x.drive_force": effort(x, t, 0.0 * t)}
    cli("init")
    cli("machine", "add", "mill")
    made = cli("identify", _write(Path("air.csv"), air), "--machine", "mill")
    assert made.code == 0, made.err
    forces, mean = _forces(0.05, 2.0)
    slow, at = forces[0][::4], T[::4]
    way = 30.0 + 4.0 * at
    cut = {"t": at, "x.position": way, "x.drive_force": effort(way, at, -slow)}
    path = _write(Path("cut.csv"), cut)
    side = SIDE.format(feed=0.05, depth=2.0, rpm=RPM)
    path.with_suffix(".toml").write_text(side, encoding="utf-8")
    assert cli("import", path, "--machine", "mill").code == 0
    done = cli("refresh", "--machine", "mill")
    assert done.code == 0, done.err
    assert "1 forces sensed" in done.out
    traced = cli("trace", "force", "1")
    sensed_N = float(traced.out.split("force.x of cut 1: ")[1].split(" ")[0])
    assert sensed_N == pytest.approx(mean[0], rel=0.1)
