"""Load from a drive: known loads come back, and their interval holds them and says where not."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from autodb import signals
from autodb.records.tables import Recording
from autodb.sensing.drives.feed_axis import identify, predict_effort
from autodb.sensing.drives.fit.axis_model import IdentifiedTerm
from autodb.sensing.drives.reconstruct import DriveModel, observe, reconstruct, rows_at_limit
from tests.conftest import Cli
from tests.helpers.screw_axis import (
    COULOMB_A,
    MACHINE,
    RATE,
    Array,
    _motion,
    bare,
    emps_axis,
    screw_moves,
    write_moves,
)


@pytest.fixture(scope="module")
def model() -> DriveModel:
    """Return the axis as it is identified from moves in air."""
    return DriveModel.of(identify(screw_moves(1)))


def _steps(n: int) -> Array:
    """Loads of 2 A for half a second, every second and a half."""
    return np.where(np.arange(n) % int(1.5 * RATE) < int(0.5 * RATE), 2.0, 0.0)


def test_a_known_load_comes_back_within_its_interval(model: DriveModel) -> None:
    """Friction differs by 10 % from the day of the moves, as its sd says; by 60 % it shows."""
    for seed, friction, least, most in (
        (10, 1.1, 0.9, 1.0),
        (11, 0.9, 0.9, 1.0),
        (12, 1.6, 0, 0.3),
    ):
        n = len(screw_moves(seed))
        cut = screw_moves(seed, _steps(n), friction=friction)
        load = reconstruct(cut, model, bandwidth_hz=10.0)
        truth = signals.lowpass(_steps(n), rate_hz=RATE, cutoff_hz=10.0)
        moves = ~(load.standing | load.turned)
        left = (load.value - truth)[moves]
        assert least <= np.mean(np.abs(left) < 1.96 * load.sd[moves]) <= most
        assert float(np.std(left - np.mean(left))) < 0.75


def test_an_observer_knows_nothing_of_what_comes_later(model: DriveModel) -> None:
    cut = screw_moves(20, _steps(len(screw_moves(20))))
    later = len(cut) // 2
    changed = {
        name: np.concatenate([v[:later], v[later:] + (0.0 if name == "t" else 1.0)])
        for name, v in cut.channels.items()
    }
    whole = observe(cut, model, bandwidth_hz=10.0).value
    other = observe(replace(cut, channels=changed), model, bandwidth_hz=10.0).value
    assert_array_equal(whole[:later], other[:later])
    assert np.any(whole[later:] != other[later:])
    truth = _steps(len(cut))
    delayed = np.interp(cut.t_s - 2.0 / (np.sqrt(2.0) * 2.0 * np.pi * 10.0), cut.t_s, truth)
    rows = slice(int(RATE), None)
    assert float(np.sqrt(np.mean((whole - delayed)[rows] ** 2))) < 0.35


def test_an_observer_filters_a_swinging_load_as_it_filters_the_effort(model: DriveModel) -> None:
    """Of an axis that is a mass on a spring and nothing else, it sees no load."""
    swinging = [
        IdentifiedTerm("compliance", "coefficient", 2e-3, 0.0, "A·s²/mm"),
        IdentifiedTerm("compliance", "frequency", 8.0, 0.0, "Hz"),
        IdentifiedTerm("compliance", "damping", 0.1, 0.0, "1"),
    ]
    moves = screw_moves(21)
    effort = predict_effort(moves, model.axis, swinging)
    alone = replace(model, terms=swinging, covariance=np.zeros((3, 3)), off_law=None)
    cut = replace(moves, channels={**moves.channels, model.channel: effort})
    seen = observe(cut, alone, bandwidth_hz=10.0).value[int(RATE) :]
    assert float(np.std(seen)) < 0.02 * float(np.std(effort))


def test_it_is_unsure_where_the_axis_stands_turns_or_never_was(model: DriveModel) -> None:
    cut = screw_moves(30)
    load = reconstruct(cut, model, bandwidth_hz=10.0)
    steady = ~(load.standing | load.turned)
    assert np.median(load.sd[load.standing]) > COULOMB_A / np.sqrt(3.0) * 0.9
    assert np.median(load.sd[steady]) < 0.15
    far = replace(cut, channels={**cut.channels, "z.position": cut.channels["z.position"] + 500.0})
    beyond = reconstruct(far, model, bandwidth_hz=10.0)
    assert beyond.outside.all()
    assert np.all(beyond.sd >= load.sd - 1e-12)
    assert np.median(beyond.sd[steady]) > 1.5 * np.median(load.sd[steady])


def test_what_the_drive_takes_back_and_where_it_is_cut_off_is_marked(model: DriveModel) -> None:
    pulled = screw_moves(31, np.full(len(screw_moves(31)), -3.0))
    velocity = np.gradient(pulled["z.position"], pulled.t_s)
    load = reconstruct(pulled, model, bandwidth_hz=10.0)
    fast = np.abs(velocity) > 5.0
    assert np.mean(load.braking[fast & (velocity > 0)]) > 0.95
    assert np.mean(load.braking[fast & (velocity < 0)]) < 0.05
    effort = pulled["z.current"]
    assert not rows_at_limit(effort).any(), "noise has one largest value"
    clipped = np.clip(effort, -3.5, 3.5)
    assert_array_equal(rows_at_limit(clipped), np.abs(clipped) >= 0.98 * 3.5)


def test_the_load_pulses_of_a_real_axis_are_rebuilt(emps: Path, pulses: Path) -> None:
    """Fitted to one file, pulses of 178 N in the other; the pulses' own channel is not used."""
    air, _ = emps_axis(emps, by_law=False)
    cut, truth = emps_axis(pulses, by_law=True)
    truth = signals.lowpass(truth, rate_hz=cut.rate_hz, cutoff_hz=10.0)
    terms = ("inertia", "viscous", "coulomb", "gravity", "asymmetry")
    found = identify(air, terms=terms)
    assert found.held_out_error < 0.035, "weight and asymmetry differ in a few rows only"
    inner = slice(500, -500)
    left = {}
    for name, model in (
        ("ours", DriveModel.of(found)),
        ("symmetric", DriveModel.of(identify(air))),
    ):
        load = reconstruct(cut, model, bandwidth_hz=10.0)
        slope, _ = np.polyfit(truth[inner], -load.value[inner], 1)
        assert abs(slope - 1.0) < 0.02
        error = (-load.value - truth)[inner]
        left[name] = float(np.sqrt(np.mean(error**2)))
        assert 0.8 < np.mean(np.abs(error) < 1.96 * load.sd[inner]) < 1.0
    assert left["ours"] < left["symmetric"] < 5.0
    observed = observe(cut, DriveModel.of(found), bandwidth_hz=10.0)
    assert float(np.std(-observed.value[inner] - truth[inner])) < 30.0, "delayed by its filter"


def test_a_machines_model_gives_newtons_on_the_tool(cli: Cli) -> None:
    """The force constant is 0.8 · 2π · 1000/10 = 502.7 N/A; its ± 10 % are not in the rows' sd."""
    from autodb.records import source as records

    cut = screw_moves(40, _steps(len(screw_moves(40))))
    write_moves(Path("air.csv"), screw_moves(1))
    write_moves(Path("cut.csv"), cut)
    Path("m.toml").write_text(MACHINE, encoding="utf-8")
    assert cli("init").code == 0
    assert cli("machine", "add", "m", "--file", "m.toml").code == 0
    refused = cli("reconstruct", "cut.csv", "--machine", "m")
    assert refused.code == 2
    assert "no model of z.current; make one with 'autodb identify MOVES --machine m'" in refused.err
    assert cli("identify", "air.csv", "--machine", "m").code == 0
    done = cli("reconstruct", "cut.csv", "--machine", "m", "--page", "page.html")
    assert done.code == 0, done.err
    said = " ".join(done.out.split())
    assert (
        "force constant 502.7 N/A ± 10 % (95 %), by torque constant 0.8 N·m/A (data sheet)" in said
    )
    assert "version 1 of machine 'm'; up to 10 Hz" in said
    table = records.read(Path("cut-load.csv"))
    load, force = np.loadtxt(
        "cut-load.csv", delimiter=",", skiprows=1, usecols=(1, 4), unpack=True, converters=bare
    )
    assert_allclose(force, -load)
    assert_allclose(table["force.z"], force)
    truth = 502.65 * signals.lowpass(_steps(len(cut)), rate_hz=RATE, cutoff_hz=10.0)
    assert float(np.corrcoef(load, truth)[0, 1]) > 0.98
    assert "load of z over time" in Path("page.html").read_text("utf-8")
    other = cli("reconstruct", "cut.csv", "--machine", "m", "--newtons-per-ampere", "100")
    assert "force constant 100 N/A ± 5 %" in " ".join(other.out.split())


def test_moves_stand_in_for_a_machine(cli: Cli) -> None:
    write_moves(Path("air.csv"), screw_moves(1))
    write_moves(Path("cut.csv"), screw_moves(41, moves=6))
    done = cli("reconstruct", "cut.csv", "--moves", "air.csv", "--observer", "--out", "o.csv")
    assert done.code == 0, done.err
    assert "in amperes; for newtons, determine the force constant with 'autodb scale'" in " ".join(
        done.out.split()
    )
    assert Path("o.csv").read_text("utf-8").startswith('"t","z.load","z.load.sd","z.state"\n')
    (z,) = json.loads(cli("reconstruct", "cut.csv", "--moves", "air.csv", "--json").out)["axes"]
    assert (z["axis"], z["unit"]) == ("z", "A")
    assert 0.0 < z["rms"] <= z["largest"]


REFUSALS = [
    (("cut.csv",), "give either --machine NAME or --moves FILE"),
    (("cut.csv", "--machine", "m", "--terms", "coulomb"), "--terms goes with --moves"),
    (("cut.csv", "--moves", "air.csv", "--out", "a.txt"), "does not end in .csv"),
    (("cut.csv", "--moves", "air.csv", "--out", "none/a.csv"), "no such folder"),
    (("cut.csv", "--moves", "air.csv", "--page", "a.pdf"), "does not end in .html"),
    (("cut.csv", "--moves", "air.csv", "--bandwidth", "200"), "use up to 125 Hz"),
    (("still.csv", "--moves", "air.csv"), "no channel 'z.position'"),
]


@pytest.mark.parametrize(("arguments", "line"), REFUSALS, ids=[line for _, line in REFUSALS])
def test_what_cannot_be_reconstructed_ends_in_one_line(
    cli: Cli, arguments: tuple[str, ...], line: str
) -> None:
    write_moves(Path("air.csv"), screw_moves(1))
    cut = screw_moves(41, moves=6)
    write_moves(Path("cut.csv"), cut)
    bare = {name: v for name, v in cut.channels.items() if name != "z.position"}
    write_moves(Path("still.csv"), replace(cut, channels=bare))
    done = cli("reconstruct", *arguments)
    assert done.code == 2
    assert line in " ".join(done.err.split())
    assert not list(Path().glob("*-load.csv"))


def _table(seed: int, load_N_m: float = 0.0) -> Recording:
    """A tilting table: 20 N·m of weight off its axis, friction, inertia; degrees and N·m."""
    x, v, a = _motion(seed, 16)
    angle = np.radians(x)
    torque = 20.0 * np.cos(angle - 0.5) + 3.0 * np.sign(v) + 0.02 * v + 0.004 * a + load_N_m
    torque += 0.1 * np.random.default_rng([seed, 1]).standard_normal(len(v))
    channels = {"t": np.arange(len(v)) / RATE, "a.angle": x, "a.drive_torque": torque}
    return Recording(path=Path(f"table-{seed}.csv"), channels=channels)


def test_the_weight_of_a_tilted_table_is_taken_off_its_torque(cli: Cli) -> None:
    """The angle goes from −27 to 72 degrees: enough of a revolution to tell the weight's place."""
    found = identify(_table(50))
    by_name = {(t.term, t.parameter): t for t in found.fitted}
    for name, truth in (
        (("gravity", "cosine"), 20.0 * np.cos(0.5)),
        (("gravity", "sine"), 20.0 * np.sin(0.5)),
        (("coulomb", "level"), 3.0),
        (("inertia", "coefficient"), 0.004),
    ):
        term = by_name[name]
        assert term.sd is not None
        assert abs(term.value - truth) < 0.02 * truth
        assert term.sd < 0.02 * truth
    assert by_name["inertia", "coefficient"].unit == "N·m·s²/deg"
    load = reconstruct(_table(51, load_N_m=7.0), DriveModel.of(found), bandwidth_hz=10.0)
    steady = ~(load.standing | load.turned)
    assert load.unit == "N·m"
    assert abs(float(np.mean(load.value[steady])) - 7.0) < 0.3
    write_moves(Path("table.csv"), _table(50))
    done = cli("identify", "table.csv")
    assert done.code == 0, done.err
    assert "weight: at most 20" in " ".join(done.out.split())


def test_a_table_in_amperes_has_newton_metres_by_its_gear(cli: Cli) -> None:
    in_amperes = {
        name.replace("drive_torque", "current"): v for name, v in _table(52).channels.items()
    }
    write_moves(Path("table.csv"), replace(_table(52), channels=in_amperes))
    Path("m.toml").write_text(
        MACHINE.replace("axes.z", "axes.a").replace("screw_pitch_mm = 10", "gear_ratio = 90"),
        encoding="utf-8",
    )
    assert cli("init").code == 0
    assert cli("machine", "add", "m", "--file", "m.toml").code == 0
    assert cli("identify", "table.csv", "--machine", "m").code == 0
    done = cli("reconstruct", "table.csv", "--machine", "m")
    assert done.code == 0, done.err
    assert "force constant 72 N·m/A ± 10 % (95 %)" in " ".join(done.out.split())
    assert "force.a" not in Path("table-load.csv").read_text("utf-8").splitlines()[0]
    assert cli("identify", "table.csv", "--machine", "m").out.endswith("already there\n")
