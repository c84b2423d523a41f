"""Sweeps: no program leaves the travel, and passes tell what they were chosen for."""

import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.errors import UnusableInput
from autodb.files.machine import MachineFile
from autodb.nc import DIALECTS
from autodb.nc.sweep import MARGIN_MM, SweepWay, sweep_program, sweep_stretch
from autodb.records.tables import Recording
from autodb.sensing.drives.feed_axis import identify
from autodb.sensing.drives.reconstruct import DriveModel
from autodb.sensing.drives.sweep import (
    REST_S,
    STEP_S,
    candidates,
    pass_motion,
    shortest_sweep,
    speed_ladder,
)
from tests.conftest import Cli
from tests.helpers import nc
from tests.helpers.screw_axis import (
    COULOMB_A,
    MASS_A,
    NOISE_A,
    VISCOUS_A,
    screw_moves,
    write_moves,
)

DRAWS = 60


def _machine(rng: np.random.Generator, *, lathe: bool) -> dict[str, Any]:
    """Draw a machine: travels of 50 to 900 mm anywhere, feeds of 2 to 40 m/min."""
    axes: dict[str, Any] = {}
    for axis in "xz" if lathe else "xyz":
        low = float(rng.uniform(-500.0, 500.0))
        axes[axis] = {
            "limits": {
                "travel_low_mm": low,
                "travel_high_mm": low + float(rng.uniform(50.0, 900.0)),
                "speed_mm_min": float(rng.uniform(2000.0, 40_000.0)),
            }
        }
        if rng.random() < 0.4:
            axes[axis]["vertical"] = str(rng.choice(["up", "down"]))
    axes["spindle"] = {"carries": "work" if lathe else "tool"}
    return {"diameter": bool(rng.random() < 0.5), "axes": axes}


def _motions(text: str, machine: MachineFile, dialect: str, *, lathe: bool) -> list[nc.Motion]:
    if lathe and dialect == "fanuc":
        return nc.motions(text, nc.fanuc_lathe({}, diameter=bool(machine.diameter)), skip=True)
    return nc.motions(text, nc.other({}, lathe=lathe), skip=True)


@pytest.mark.parametrize(
    ("dialect", "lathe"), list(itertools.product(DIALECTS, (True, False))), ids=str
)
def test_no_program_leaves_the_travel_or_sinks_below_the_safe_height(
    dialect: str, lathe: bool
) -> None:
    """Sixty machines each, read back by another reader of programs."""
    rng = np.random.default_rng([7, lathe, len(dialect)])
    for _ in range(DRAWS):
        machine = MachineFile.model_validate(_machine(rng, lathe=lathe))
        axis = str(rng.choice(["x", "z"]))
        own = machine.axes[axis]
        low, high = own.limits.travel_low_mm, own.limits.travel_high_mm
        assert low is not None
        assert high is not None
        safe = float(rng.uniform(low + 5.0, high - 5.0)) if own.vertical else None
        on = sweep_stretch(machine, axis, source="m.toml", safe_mm=safe)
        passes = speed_ladder(on.low_mm, on.high_mm, fastest_mm_min=on.fastest_mm_min)
        parked = {
            name: 0.5 * (one.limits.travel_low_mm + one.limits.travel_high_mm)  # type: ignore[operator]
            for name, one in machine.axes.items()
            if name in "xyz" and name != axis
        }
        text = sweep_program(
            [SweepWay(p.start_mm, p.end_mm, p.feed_mm_min, REST_S) for p in passes],
            on, machine, dialect=dialect, parked_mm=parked, source="m.toml", name="sweep",
        )  # fmt: skip
        motions = _motions(text, machine, dialect, lathe=lathe)
        assert len(motions) == len(parked) + 1 + 2 * len(passes)
        for motion_ in motions[: len(parked) + 1]:
            assert motion_.machine
            assert motion_.modes.rapid
            assert motion_.stops == 0
        for name, mm in parked.items():
            assert_allclose(motions[-1].after[name], mm, atol=0.001)
        for way in motions[len(parked) + 1 :]:
            assert way.stops == 1, "a stop before the first pass"
            assert not way.modes.rapid
            assert not way.modes.turning, "the spindle is off"
            assert way.modes.feed_per == "min"
            assert way.modes.feed is not None
            assert 0 < way.modes.feed <= on.fastest_mm_min
            assert {k for k, v in way.after.items() if v != way.before[k]} == {axis}
            place = way.after[axis]
            assert low + MARGIN_MM - 0.01 <= place <= high - MARGIN_MM + 0.01
            if own.vertical == "up" and safe is not None:
                assert place >= safe - 0.001
            if own.vertical == "down" and safe is not None:
                assert place <= safe + 0.001


MILL: dict[str, Any] = {
    "axes": {
        "x": {"limits": {"travel_low_mm": 0, "travel_high_mm": 500, "speed_mm_min": 10_000}},
        "z": {
            "vertical": "up",
            "limits": {"travel_low_mm": 0, "travel_high_mm": 400, "speed_mm_min": 8000},
        },
        "spindle": {"carries": "tool"},
    }
}


def _without(*path: str) -> MachineFile:
    import copy

    table = copy.deepcopy(MILL)
    at = table
    for key in path[:-1]:
        at = at[key]
    del at[path[-1]]
    return MachineFile.model_validate(table)


def test_what_a_sweep_needs_is_asked_for() -> None:
    whole = MachineFile.model_validate(MILL)
    for machine, axis, more, line in (
        (whole, "y", {}, "no axis 'y'"),
        (whole, "z", {}, "axis z bears weight; state its lowest safe place with --safe MM"),
        (whole, "z", {"safe_mm": 900.0}, "--safe: 900 mm is not between 1 and 399 mm"),
        (whole, "x", {"between_mm": (10.0, 600.0)}, "--between: 10 to 600 mm is no stretch"),
        (_without("axes", "x", "limits", "speed_mm_min"), "x", {}, "speed_mm_min is missing"),
        (_without("axes", "x", "limits", "travel_low_mm"), "x", {}, "travel_low_mm or"),
    ):
        with pytest.raises(UnusableInput, match=line):
            sweep_stretch(machine, axis, source="m.toml", **more)
    on = sweep_stretch(whole, "x", source="m.toml")
    way = [SweepWay(1.0, 400.0, 5000.0, 0.5)]
    refused: tuple[tuple[dict[str, float], list[SweepWay], str], ...] = (
        ({}, way, "axis z is not parked; use --park z=MM"),
        ({"z": 500.0}, way, "z = 500 mm is not known to lie in its travel"),
        ({"z": 300.0, "x": 1.0}, way, "--park: x is no other axis"),
        ({"z": 300.0}, [SweepWay(1.0, 600.0, 5000.0, 0.5)], "a pass to 600 mm is outside"),
        ({"z": 300.0}, [SweepWay(1.0, 400.0, 20_000.0, 0.5)], "above axis x's 10000 mm/min"),
    )
    for parked, ways, line in refused:
        with pytest.raises(UnusableInput, match=line):
            sweep_program(
                ways, on, whole, dialect="fanuc", parked_mm=parked, source="m.toml", name="s"
            )  # fmt: skip


@pytest.mark.parametrize("within", [0.05, 0.01])
def test_a_design_identifies_the_axis_as_surely_as_it_says(within: float) -> None:
    """The moves that were designed are made on the axis that the model came from.

    What is expected is from noise, and friction off its law by 1 % at each speed; the fit, which
    lets friction be any curve, may need up to three times that.
    """
    model = DriveModel.of(identify(screw_moves(1)))
    found = shortest_sweep(
        model, candidates(0.0, 300.0, fastest_mm_min=10_000.0), within=within, longest_s=900.0
    )
    assert found.enough
    made = _made(found.passes, seed=3)
    again = identify(made)
    expected = {name: half for name, half, _ in found.reached}
    for term, truth in zip(again.fitted, (MASS_A, VISCOUS_A, COULOMB_A, 0.0), strict=True):
        assert term.sd is not None
        half = 1.96 * term.sd
        assert abs(term.value - truth) < 2.5 * half
        assert half < 3.0 * expected[f"{term.key} {term.parameter}"]


def _made(passes: Any, *, seed: int) -> Recording:
    """Return a recording of passes on the axis of ``tests.sensing.drives.test_reconstruct``."""
    parts = [pass_motion(one) for one in passes]
    x, v, a = (
        np.concatenate([p[k] for p in parts]) for k in ("position", "velocity", "acceleration")
    )
    effort = MASS_A * a + COULOMB_A * np.sign(v) + VISCOUS_A * v
    effort += NOISE_A * np.random.default_rng(seed).standard_normal(len(v))
    channels = {
        "t": np.arange(len(v)) * STEP_S,
        "z.position": x,
        "z.velocity": v,
        "z.acceleration": a,
        "z.current": effort,
    }
    return Recording(path=Path("sweep.csv"), channels=channels)


def test_more_sureness_takes_longer_and_no_time_says_so() -> None:
    model = DriveModel.of(identify(screw_moves(1)))
    choices = candidates(0.0, 300.0, fastest_mm_min=10_000.0)
    loose, tight = (
        shortest_sweep(model, choices, within=share, longest_s=1800.0) for share in (0.05, 0.007)
    )
    assert loose.seconds < tight.seconds
    short = shortest_sweep(model, choices, within=0.0001, longest_s=200.0)
    assert not short.enough
    assert short.seconds <= 200.0


LATHE = """
diameter = true
[axes.x]
limits = { travel_low_mm = 0, travel_high_mm = 200, speed_mm_min = 8000 }
[axes.z]
limits = { travel_low_mm = 0, travel_high_mm = 500, speed_mm_min = 10000 }
[axes.spindle]
carries = "work"
"""


def test_a_sweep_of_a_machine_and_then_one_that_its_model_chooses(cli: Cli) -> None:
    Path("m.toml").write_text(LATHE, encoding="utf-8")
    assert cli("init").code == 0
    assert cli("machine", "add", "m", "--file", "m.toml").code == 0
    sweep = ("sweep", "--machine", "m", "--axis", "z", "--dialect", "fanuc", "--park", "x=190")
    printed = cli(*sweep)
    assert printed.code == 0, printed.err
    assert "G0 G53 X380.000" in printed.out, "X counts in diameters"
    refused = cli(*sweep, "--within", "2")
    assert refused.code == 2
    assert "axis z has no model yet" in " ".join(refused.err.split())
    write_moves(Path("air.csv"), screw_moves(1))
    assert cli("identify", "air.csv", "--machine", "m").code == 0
    done = cli(*sweep, "--within", "2", "--between", "50", "350", "--out", "z.nc")
    assert done.code == 0, done.err
    said = " ".join(done.out.split())
    assert "coulomb level" in said
    assert "z.nc: written, " in said
    assert (
        "already there"
        in cli(*sweep, "--within", "2", "--between", "50", "350", "--out", "z.nc").out
    )
    machine = MachineFile.model_validate({"diameter": True, "axes": {}} | {"axes": {"x": {}}})
    motions = _motions(Path("z.nc").read_text("utf-8"), machine, "fanuc", lathe=True)
    places = [m.after["z"] for m in motions if "z" in m.after]
    assert min(places) >= 50.0
    assert max(places) <= 350.0


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        ((), "give either --machine NAME or --machine-file FILE"),
        (("--machine-file", "m.toml", "--park", "x"), "'x' is not AXIS=MM"),
        (("--machine-file", "m.toml", "--park", "x=300"), "x = 300 mm is not known to lie"),
        (("--machine-file", "m.toml"), "axis x is not parked; use --park x=MM"),
        (("--machine-file", "none.toml"), "none.toml"),
    ],
)
def test_a_sweep_that_cannot_be_made_ends_in_one_line(
    cli: Cli, arguments: tuple[str, ...], line: str
) -> None:
    Path("m.toml").write_text(LATHE, encoding="utf-8")
    done = cli("sweep", "--axis", "z", "--dialect", "siemens", *arguments)
    assert done.code == 2
    assert line in " ".join(done.err.split())


def test_a_control_that_is_not_known_is_refused(cli: Cli) -> None:
    Path("m.toml").write_text(LATHE, encoding="utf-8")
    done = cli(
        "sweep", "--axis", "z", "--dialect", "fanak", "--machine-file", "m.toml", "--park", "x=1"
    )
    assert done.code == 2
    assert "did you mean fanuc" in done.err
