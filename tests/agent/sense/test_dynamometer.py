"""A machine's table dynamometer from the command line, on the reference table."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray

from autodb.proofs.machines.mill.reference_ringing import draw_ringing, mill_ringing, tap_table
from autodb.proofs.machines.mill.reference_table import (
    WORK_KG,
    RecordedTable,
    draw_table,
    mill_on_table,
    record_tilted,
)
from autodb.proofs.runs.mill.published_table import filtered
from autodb.proofs.runs.mill.table_run import table_recording
from tests.conftest import Cli, Once

Array = NDArray[np.float64]

SEED = 103
MACHINE = """
[axes.x]
[axes.y]
[axes.z]
[axes.a]
carries = "work"
[axes.c]
carries = "work"
carried_by = "a"
"""


def _write(path: Path, seen: RecordedTable, every: int = 1) -> Path:
    columns = {n: v[::every] for n, v in table_recording(seen).channels.items()}
    pd.DataFrame(columns).to_csv(path, index=False, float_format="%.6g")
    return path


@pytest.fixture
def levelled(cli: Cli, once: Once) -> Cli:
    """Return the command line on a mill whose table dynamometer is identified; cut.csv."""

    def make() -> None:
        table = draw_table(SEED)
        cli("init")
        Path("mill.toml").write_text(MACHINE, encoding="utf-8")
        assert cli("machine", "add", "mill", "--file", "mill.toml").code == 0
        moves = _write(Path("tilts.csv"), record_tilted(SEED, table, added_kg=WORK_KG))
        cut = mill_on_table(SEED, table, 1)
        _write(Path("cut.csv"), cut, 2)
        np.save("true.npy", cut.true_N[:, ::2])
        early = cli("reconstruct", "cut.csv", "--machine", "mill", "--estimator", "table")
        assert early.code == 2
        assert "calibrate MOVES… --machine mill --table" in early.err
        done = cli("calibrate", moves, "--machine", "mill", "--table")
        assert done.code == 0, done.err
        assert "Table dynamometer 1 of mill" in done.out
        assert "the resonance in x, y, z is not determined" in done.out
        assert "rotary axes from bed to table: a, c" in done.out
        mass = float(done.out.split("mass on the sensor: ")[1].split()[0])
        assert mass == pytest.approx(table.sensor_kg + WORK_KG, rel=0.005)

    once(make)
    return cli


def test_forces_come_in_machine_axes_with_heat_taken_off(levelled: Cli) -> None:
    """The error in z is a tenth of the heat; 95 % intervals hold nine rows of ten and more."""
    use = ("--machine", "mill", "--estimator", "table")
    done = levelled("reconstruct", "cut.csv", *use, "--page", "cut.html")
    assert done.code == 0, done.err
    assert "x, y, z: heat of chips: up to" in done.out
    assert "standing" not in done.out
    told = pd.read_csv("cut-load.csv")
    true = filtered(np.load("true.npy"), 500.0, 2500.0)
    for k, c in enumerate("xyz"):
        off = told[f"force.{c}"].to_numpy() - true[k]
        assert np.sqrt(np.mean(off**2)) < 6.0
        assert np.mean(np.abs(off) <= 1.96 * told[f"{c}.load.sd"]) > 0.9
    assert "Load on the axes" in Path("cut.html").read_text("utf-8")
    assert "force.x.upper" not in told
    turning = pd.read_csv("cut.csv").assign(**{"spindle.speed": 2546.0})
    turning.to_csv("turning.csv", index=False, float_format="%.6g")
    assert levelled("reconstruct", "turning.csv", *use).code == 0
    within = pd.read_csv("turning-load.csv")
    assert (within["force.x.lower"] <= within["force.x"]).all()
    assert (within["force.x.upper"] >= within["force.x"]).all()
    rows = round(60.0 / 2546.0 * 2500.0)
    some = within["force.x"].rolling(rows, center=True).max()
    close = within["force.x.upper"] - some
    assert close.dropna().abs().median() < 5.0
    lighter = levelled("reconstruct", "cut.csv", *use, "--removed", "1.0", "--out", "less.csv")
    assert lighter.code == 0
    late = pd.read_csv("less.csv")["force.z"] - told["force.z"]
    assert 0.1 < late.abs().max() < 9.81  # what the kilogram weighs, less what heat takes for it


def test_all_sensors_together_say_who_told_it_and_who_not(levelled: Cli) -> None:
    done = levelled("reconstruct", "cut.csv", "--machine", "mill", "--estimator", "fused")
    assert done.code == 0, done.err
    assert "by weight 100 % table dynamometer" in done.out
    assert "not used: drive model: cut.csv: no drive effort" in done.out
    told = pd.read_csv("cut-load.csv")
    assert (told["x.weight.table_dynamometer"] == 1.0).all()
    listed = levelled("sensors", "mill")
    assert listed.out.count("table dynamometer") == 3
    assert "no sensor measures" not in listed.out


def _moved(seconds: float, rate_hz: float, load_N: Array | None = None) -> dict[str, Array]:
    """Return a drive that goes there and back, with what moving takes and a load, noise of 3 N."""
    t = np.arange(round(seconds * rate_hz)) / rate_hz
    x = 40.0 + 20.0 * np.sin(2.0 * np.pi * 0.3 * t)
    v = np.gradient(x, t)
    moving_N = 0.1 * np.gradient(v, t) + 0.5 * v + 60.0 * np.tanh(v / 0.05) + 12.0
    noise_N = 3.0 * np.random.default_rng([round(rate_hz), 90]).standard_normal(len(t))
    effort_N = moving_N + noise_N + (0.0 if load_N is None else load_N)
    return {"t": t, "x.position": x, "x.velocity": v, "x.drive_force": effort_N}


def test_a_drive_and_a_table_are_compared_in_the_band_of_both(levelled: Cli) -> None:
    """Teeth pass at 85 Hz, which the drive at 10 Hz does not tell: no disagreement."""
    pd.DataFrame(_moved(40.0, 250.0)).to_csv("air.csv", index=False, float_format="%.6g")
    made = levelled("identify", "air.csv", "--machine", "mill")
    assert made.code == 0, made.err
    cut, true = pd.read_csv("cut.csv"), np.load("true.npy")
    drive = _moved(len(cut) / 2500.0, 2500.0, -true[0])
    both = cut.assign(**{name: one for name, one in drive.items() if name != "t"})
    both.to_csv("both.csv", index=False, float_format="%.6g")
    done = levelled("reconstruct", "both.csv", "--machine", "mill", "--estimator", "fused")
    assert done.code == 0, done.err
    assert "agree" not in done.out
    assert "up to 10 Hz" in done.out
    told = pd.read_csv("both-load.csv")
    off = told["force.x"] - filtered(true, 10.0, 2500.0)[0]
    assert np.sqrt(np.mean(off**2)) < 6.0
    assert told["x.weight.drive_model"].mean() > 0.0


def test_taps_determine_a_resonance_that_forces_are_corrected_for(levelled: Cli) -> None:
    table, ringing = draw_table(SEED), draw_ringing(SEED)
    taps = str(_write(Path("taps.csv"), tap_table(SEED, table, ringing)))
    cut = mill_ringing(SEED, table, ringing, 1)
    _write(Path("ringing.csv"), cut, 2)
    use = ("--machine", "mill", "--estimator", "table", "--bandwidth", "900")
    plain = levelled("reconstruct", "ringing.csv", *use, "--out", "plain.csv")
    assert plain.code == 0, plain.err
    done = levelled("calibrate", "tilts.csv", taps, "--machine", "mill", "--table")
    assert done.code == 0, done.err
    for k, name in enumerate("xyz"):
        hz = float(done.out.split(f"resonance in {name}: ")[1].split()[0])
        assert hz == pytest.approx(ringing.natural_hz[0, k], rel=0.005)
    again = levelled("reconstruct", "ringing.csv", *use)
    assert again.code == 0, again.err
    assert "resonance of the sensor's x at" in again.out
    true = filtered(cut.true_N[:, ::2], 900.0, 2500.0)
    before, after = (
        [float(np.std((told[f"force.{c}"] - true[k])[cut.whole[::2]])) for k, c in enumerate("xy")]
        for told in (pd.read_csv("plain.csv"), pd.read_csv("ringing-load.csv"))
    )
    assert max(after) < 0.3 * min(before)


def test_the_same_moves_again_are_already_there(levelled: Cli) -> None:
    again = levelled("calibrate", "tilts.csv", "--machine", "mill", "--table")
    assert again.code == 0
    assert "already there" in again.out
    assert "Table dynamometer 1" in again.out


def test_moves_without_the_work_determine_the_gain(levelled: Cli) -> None:
    """Of a sensor whose own gains are drawn: mass within 0.3 %, forces with a smaller share."""
    table = draw_table(SEED)
    bare = str(_write(Path("bare.csv"), record_tilted(SEED, table, added_kg=0.0)))
    use = ("calibrate", "tilts.csv", "--machine", "mill", "--table", "--bare", bare)
    done = levelled(*use, "--work-mass", f"{WORK_KG:g}")
    assert done.code == 0, done.err
    assert "Table dynamometer 2 of mill" in done.out
    mass = float(done.out.split("mass on the sensor: ")[1].split()[0])
    assert mass == pytest.approx(table.sensor_kg + WORK_KG, rel=0.003)
    half = float(done.out.split("by work of 10.1 kg, ± ")[1].split()[0])
    assert 0.3 < half < 0.8
    again = levelled(*use, "--work-mass", f"{WORK_KG:g}")
    assert "already there" in again.out
    for half_asked in (use, ("calibrate", "tilts.csv", "--machine", "mill", "--work-mass", "3")):
        ran = levelled(*half_asked)
        assert ran.code == 2
        assert "--bare FILE and --work-mass KG go together" in ran.err


def test_what_tells_no_table_is_refused_in_one_line(levelled: Cli) -> None:
    def refused(*arguments: str) -> str:
        ran = levelled(*arguments)
        assert ran.code == 2
        assert len(ran.err.strip().splitlines()) == 1
        return ran.err

    table = ("--machine", "mill", "--table")
    assert "--machine NAME" in refused("calibrate", "tilts.csv", "--table")
    assert "use one at a time" in refused("calibrate", "tilts.csv", *table, "--network")
    assert "never rests" in refused("calibrate", "cut.csv", *table)
    moves = pd.read_csv("tilts.csv")
    moves.drop(columns="c.angle").to_csv("lacks.csv", index=False)
    assert "no channel 'c.angle'" in refused("calibrate", "lacks.csv", *table)
    levelled("machine", "add", "plain")
    plain = refused("calibrate", "tilts.csv", "--machine", "plain", "--table")
    assert "no rotary axis that carries the work" in plain
    drive = ("reconstruct", "cut.csv", "--machine", "mill")
    assert "--removed goes with" in refused(*drive, "--removed", "1.0")
    assert "no sensor measures" in refused(
        "reconstruct", "cut.csv", "--machine", "plain", "--estimator", "fused"
    )
