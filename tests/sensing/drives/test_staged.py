"""Axes of a known truth, identified in stages: passes, stick-slip, stages, and the joint fit."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.records.tables import Recording
from autodb.reports.axis import render_axis
from autodb.sensing.drives.feed_axis import default_terms, identify
from autodb.sensing.drives.fit.axis_model import Identified, IdentifiedTerm
from autodb.sensing.drives.fit.thermal import thermal_state
from autodb.sensing.drives.moves.passes import both_ways, is_sweep, passes_of, sweeps_speeds
from autodb.sensing.drives.moves.prepared import Prepared, prepared
from autodb.sensing.drives.staged.agreement import screw_agreement
from autodb.sensing.drives.staged.routine import Staged, staged
from autodb.sensing.drives.staged.segments import length_of, pass_segments
from autodb.sensing.drives.staged.sticking import StickingVerdict, sticking
from autodb.sensing.drives.staged.weight import weight_of
from autodb.sensing.drives.sweep import pass_motion, speed_ladder
from tests.conftest import Cli
from tests.helpers.bent_sweep import bent_sweep
from tests.helpers.files import write
from tests.helpers.staged_axis import (
    MIDDLE_MM,
    PITCH_MM,
    SPEEDS_MM_S,
    Axis,
    recorded,
    stick_slip,
    sweep,
)

Array = NDArray[np.float64]

AXIS = Axis()
PULLED_MM_S = (0.5, 1.0, 2.0, 4.0, 16.0, 25.0, 40.0, 60.0, 90.0)
FIRM_N_PER_A = 100.0
MACHINE = 'axes.z = { vertical = "up", screw_pitch_mm = 10, current_sign = -1 }\n'


@pytest.fixture(scope="module")
def moves() -> Recording:
    """Return three sweeps of the axis over its speeds."""
    return recorded(AXIS, 1)


@pytest.fixture(scope="module")
def rows(moves: Recording) -> Prepared:
    """Return it ready to be fitted."""
    return prepared(moves)


@pytest.fixture(scope="module")
def found(rows: Prepared) -> Staged:
    """Return its stages."""
    return staged(rows, pitch_mm=PITCH_MM, cold=False)


@pytest.fixture(scope="module")
def model(moves: Recording) -> Identified:
    """Return its joint fit."""
    return identify(moves, terms=(*default_terms("axis"), "stribeck", "position_friction"))


def test_passes_are_found_with_speed_direction_and_repeat(found: Staged) -> None:
    levels = found.levels
    known = [k for k, v in levels.items() if min(abs(v / one - 1.0) for one in SPEEDS_MM_S) < 0.02]
    assert len(known) == len(SPEEDS_MM_S)
    for k in known:
        for sense in (1, -1):
            own = [p for p in found.passes if (p.level, p.sense) == (k, sense)]
            assert [p.repeat for p in own] == [0, 1, 2]
    fast = [p for p in found.passes if p.speed_mm_s > 100.0]
    assert all(p.low_mm > MIDDLE_MM - 70.0 and p.high_mm < MIDDLE_MM + 70.0 for p in fast)


def test_motion_without_constant_speed_has_no_passes() -> None:
    t = np.arange(20_000) / 200.0
    for x in (30.0 * np.sin(2 * np.pi * 0.4 * t), 10.0 * (t - 50.0) ** 2, 0.01 * t):
        assert not passes_of({"t": t, "position": x})


def test_passes_survive_a_noisy_encoder_and_block_borders(found: Staged) -> None:
    x, _, _ = sweep()
    noisy = x + np.random.default_rng(3).normal(0.0, 0.02, len(x))
    seen = passes_of({"t": np.arange(len(x)) / 100.0, "position": noisy})
    assert len(both_ways(seen)) == len(found.levels)
    assert abs(len(seen) - len(found.passes)) <= 4, "moves between the passes are short"


def _pulled(seed: int, *, behind_spring: bool) -> dict[str, Array]:
    """Return passes of the mass on its spring, there and back, two rounds: t, position, effort."""
    rng = np.random.default_rng(seed)
    place, load = stick_slip(PULLED_MM_S, 8.0)
    t = np.arange(len(place)) / 200.0
    x, effort = [np.zeros(40)], [np.zeros(40)]
    for _ in range(2):
        for k, speed in enumerate(PULLED_MM_S):
            n = min(len(t), round(60.0 / speed * 200.0))
            way = (place[:n, k] if behind_spring else speed * t[:n]) - place[0, k]
            for sense, start in ((1.0, 0.0), (-1.0, way[-1])):
                x += [start + sense * way, np.full(40, start + sense * way[-1])]
                effort += [sense * load[:n, k] / FIRM_N_PER_A, np.zeros(40)]
    position, current = np.concatenate(x), np.concatenate(effort)
    current += 3.0 + rng.normal(0.0, 0.03, len(current))
    position += rng.normal(0.0, 1e-4, len(position))
    return {"t": np.arange(len(position)) / 200.0, "position": position, "effort": current}


def _verdicts(made: dict[str, Array]) -> dict[int, StickingVerdict]:
    return sticking(passes_of(made), made, made["effort"])


@pytest.mark.parametrize("behind_spring", [True, False], ids=["slide", "motor"])
def test_a_mass_that_sticks_on_its_spring_is_seen(behind_spring: bool) -> None:
    """Seen at the slide it halts; at the motor only its effort tells."""
    found = _verdicts(_pulled(1, behind_spring=behind_spring))
    assert_allclose([one.speed_mm_s for one in found.values()], PULLED_MM_S, rtol=0.02)
    assert [one.sticks for one in found.values()] == [v <= 4.0 for v in PULLED_MM_S]
    slow = next(iter(found.values()))
    assert slow.over_time > 2.0
    assert (slow.halts >= 3) == behind_spring


def test_clean_passes_raise_no_alarm() -> None:
    """Of 48 levels none; 1 in 1000 may."""
    for seed in range(20, 26):
        made = recorded(AXIS, seed)
        inputs = {"t": made.t_s, "position": made["z.position"]}
        verdicts = sticking(passes_of(inputs), inputs, made["z.current"])
        assert sum(one.tested for one in verdicts.values()) >= 5
        assert not any(one.sticks for one in verdicts.values())


def test_stages_find_the_truth(found: Staged) -> None:
    assert_allclose(found.weight.value, AXIS.weight, atol=3.0 * found.weight.sd)
    assert found.weight.sd < 0.005
    assert found.inertia is not None
    assert_allclose(found.inertia.value, AXIS.inertia, atol=3.0 * found.inertia.sd)
    assert found.inertia.sd < 0.05 * AXIS.inertia
    slope, _, sine = found.along.values
    slope_sd, _, sine_sd = np.sqrt(np.diag(found.along.covariance))
    assert_allclose(slope, AXIS.slope, atol=3.0 * slope_sd)
    assert_allclose(sine, AXIS.ripple, atol=3.0 * sine_sd)
    assert slope_sd < 0.1 * AXIS.slope
    assert found.length.mm == pytest.approx(PITCH_MM / 3.0)
    assert 0.01 < found.averages.differ < 0.06
    turn = np.linspace(-5.0, 5.0, 50)
    for place in (MIDDLE_MM, MIDDLE_MM + 40.0):
        for speed in (1.0, 4.0, 30.0, 120.0):
            for sense in (1, -1):
                size, sd = found.friction(np.array([place]), np.array([speed]), sense)
                truth = AXIS.size(place + turn, np.full(50, sense * speed)).mean()
                assert_allclose(size[0], truth, atol=3.5 * sd[0])
                assert sd[0] < 0.06 * truth


def test_speeds_that_stick_tell_no_weight(moves: Recording) -> None:
    """Downwards slow passes bear a saw that only ever pulls one way: all speeds tell it wrong."""
    x, v = moves["z.position"], moves["z.velocity"]
    saw = (x / 0.9) % 1.0
    sticking_A = np.where((v < -0.2) & (v > -3.0), -0.9 * saw, 0.0)
    channels = {**moves.channels, "z.current": moves["z.current"] + sticking_A}
    rough = prepared(Recording(path=Path("rough.csv"), channels=channels))
    made = staged(rough, pitch_mm=PITCH_MM, cold=False)
    stuck = [made.levels[k] for k, one in made.verdicts.items() if one.sticks]
    assert_allclose(stuck, [1.0, 2.0], rtol=0.01)
    assert_allclose(made.weight.value, AXIS.weight, atol=3.0 * made.weight.sd)
    cut = pass_segments(made.passes, x, made.length.mm)
    whole = weight_of(cut, cut.means(rough.whole_effort), list(made.levels), path="rough.csv")
    assert abs(whole.value - AXIS.weight) > 8.0 * made.weight.sd


def test_warming_is_told_by_passes_repeated_at_one_speed() -> None:
    warm = replace(AXIS, drop=0.19)
    made = prepared(recorded(warm, 4, cycles=24, run_sd=0.0))
    seen = staged(made, pitch_mm=PITCH_MM, cold=True)
    assert seen.cold
    assert seen.warming is not None
    share = seen.warming.lost(made.inputs)
    most = int(np.argmax(share))
    sd = float(seen.warming.sd(seen.warming.slopes(made.inputs)[[most]])[0])
    t, v = made.inputs["t"], np.abs(made.inputs["velocity"])
    heat = np.zeros(len(t))
    for i in range(1, len(t)):  # the truth, step by step
        heat[i] = heat[i - 1] + (t[1] / warm.time_constant_s) * (v[i] * 0.006 - heat[i - 1])
    assert_allclose(share[most], warm.drop * heat[most], atol=3.0 * sd)
    assert sd < 0.05
    size, size_sd = seen.friction(np.array([MIDDLE_MM]), np.array([120.0]), 1)
    truth = float(warm.size(MIDDLE_MM + np.linspace(-5, 5, 50), np.full(50, 120.0)).mean())
    assert_allclose(size[0], truth, atol=3.0 * size_sd[0])


def test_staged_and_joint_agree_on_one_axis(
    found: Staged, model: Identified, rows: Prepared
) -> None:
    both = screw_agreement(found, model, rows.inputs)
    assert both.agrees
    names = [row.name for row in both.rows]
    assert {"weight", "inertia"} < set(names)
    assert sum(name.startswith("friction at") for name in names) >= 12
    assert "the joint fit has no warmup" in both.left_out[0]


def test_a_joint_fit_that_is_off_does_not_agree(
    found: Staged, model: Identified, rows: Prepared
) -> None:
    assert model.steady is not None
    stiff = replace(model, steady=replace(model.steady, values=1.15 * model.steady.values))
    both = screw_agreement(found, stiff, rows.inputs)
    assert not both.agrees
    assert "weight" in [row.name for row in both.differing]
    heavy = [replace(t, value=2.0 * t.value) if t.term == "inertia" else t for t in model.terms]
    one = screw_agreement(found, replace(model, terms=tuple(heavy)), rows.inputs)
    assert [row.name for row in one.differing] == ["inertia"]


def test_segments_without_a_pitch_follow_the_ripple_found(found: Staged, rows: Prepared) -> None:
    x = rows.inputs["position"]
    told = length_of(found.passes, x, rows.whole_effort, pitch_mm=None)
    assert told.period_mm == pytest.approx(PITCH_MM, rel=0.02)
    assert "ripple found" in told.why
    noise = np.random.default_rng(2).normal(0.0, 0.05, len(x))
    plain = length_of(found.passes, x, noise, pitch_mm=None)
    assert plain.period_mm is None
    assert "a fortieth of the travel" in plain.why


def test_a_sweep_at_creep_counts_by_the_way_gone(moves: Recording) -> None:
    assert is_sweep(moves, "z")
    assert not is_sweep(moves, "x")
    short = passes_of({"t": moves.t_s[:4000], "position": moves["z.position"][:4000]})
    assert not sweeps_speeds(short)
    told, way, time = (identify(moves, by_way=how) for how in (None, True, False))
    assert told.terms == way.terms
    assert told.terms != time.terms


def test_the_moves_that_sweep_writes_will_do() -> None:
    """Two rounds at twelve feeds, slow ones over a part of the travel."""
    made = [pass_motion(one) for one in speed_ladder(20.0, 180.0, fastest_mm_min=9000.0)]
    x, v, a = (
        np.concatenate([one[name][::4] for one in made])
        for name in ("position", "velocity", "acceleration")
    )
    effort = AXIS.weight + np.clip(v / 0.05, -1, 1) * AXIS.size(x, v) + AXIS.inertia * a
    effort += 0.02 * np.random.default_rng(6).standard_normal(len(x))
    channels = {
        "t": np.arange(len(x)) / 25.0,
        "z.position": x,
        "z.velocity": v,
        "z.current": effort,
    }
    written = Recording(path=Path("ladder.csv"), channels=channels)
    assert is_sweep(written, "z")
    seen = staged(prepared(written), pitch_mm=PITCH_MM, cold=False)
    assert len(seen.levels) == 12
    assert max(one.repeat for one in seen.passes) >= 1
    assert_allclose(seen.weight.value, AXIS.weight, atol=0.01)
    assert len(seen.compared) >= 8


def test_passes_that_tell_no_stage_are_refused(moves: Recording) -> None:
    x = moves["z.position"]
    one_round = prepared(recorded(AXIS, 2, repeats=1))
    with pytest.raises(UnusableInput, match="passed twice in one direction"):
        staged(one_round, pitch_mm=None, cold=False)
    wave = {**moves.channels, "z.position": 50.0 * np.sin(np.arange(len(x)) / 100.0)}
    with pytest.raises(UnusableInput, match="constant speeds in both directions, and the staged"):
        staged(prepared(Recording(path=Path("w.csv"), channels=wave)), pitch_mm=None, cold=False)


def test_the_page_tells_the_thermal_state(moves: Recording, model: Identified) -> None:
    assert "Thermal state" not in render_axis(model, moves)
    shape = {"drop": (0.2, "1"), "time_constant": (30.0, "s"), "levelling": (0.0, "1")}
    warm = [IdentifiedTerm("warmup", name, value, 0.0, unit) for name, (value, unit) in
            shape.items()]  # fmt: skip
    state = thermal_state(moves, "z", model.protocol, warm)
    assert state is not None
    assert state.begin == 0.0
    assert 0.0 < state.end < state.most < 1.0
    fast = np.abs(moves["z.velocity"]) > 100.0
    last_s = float(moves.t_s[fast][-1])
    cooled = np.exp(-(moves.t_s[-1] - last_s) / 30.0)
    assert state.end < 1.01 * state.most * cooled + 0.02
    page = render_axis(replace(model, terms=(*model.terms, *warm)), moves)
    assert f"{100.0 * state.end:.0f}\u00a0% at the end" in page


def _file(name: str, moves: Recording, *, sign: float = 1.0) -> Path:
    columns = {**moves.channels, "z.current": sign * moves["z.current"]}
    return write(Path(name), columns)


def test_identify_staged(cli: Cli) -> None:
    """The pitch and the sign are the machine's; what is stored is the joint fit all the same."""
    short = recorded(AXIS, 7, repeats=2, speeds=(1.0, 2.0, 4.0, 8.0, 30.0, 60.0, 120.0))
    _file("sweep.parquet", short, sign=-1.0)
    Path("m.toml").write_text(MACHINE, encoding="utf-8")
    assert cli("init").code == 0
    assert cli("machine", "add", "m", "--file", "m.toml").code == 0
    terms = ("--terms", "inertia,viscous,coulomb,gravity,stribeck")
    done = cli("identify", "sweep.parquet", "--machine", "m", *terms)
    assert done.code == 0, done.err
    assert "Staged" not in done.out
    done = cli("identify", "sweep.parquet", "--machine", "m", *terms, "--staged")
    assert done.code == 0, done.err
    said = " ".join(done.out.split())
    for line in ("a third of the screw's pitch, 10 mm", "Stage by stage", "Staged and joint",
                 "friction at 100 mm, +60", "slow passes count by the way gone",
                 "version 1 of machine 'm': already there"):  # fmt: skip
        assert line in said
    weight = next(line for line in done.out.splitlines() if line.strip().startswith("weight  "))
    assert "1.99" in weight or "2.00" in weight


def test_options_that_do_not_go_together(refused: Callable[..., str], moves: Recording) -> None:
    few = {name: values[:3000] for name, values in moves.channels.items()}
    write(Path("few.csv"), few)
    assert "--pitch goes with --staged" in refused("identify", "few.csv", "--pitch", "10")
    assert "constant speeds in both directions" in refused("identify", "few.csv", "--staged")


def test_ramps_that_are_over_before_the_filter_follows_tell_no_inertia() -> None:
    """They last 0.08 s, at 50 Hz and a low-pass of 20 Hz: a third of the inertia was lost to it."""
    short = staged(prepared(bent_sweep(1, bent_A=0.0), axis="z"), pitch_mm=PITCH_MM, cold=False)
    assert short.inertia is None
    assert set(short.laws) == {1, -1}
