"""No sweep comes near the jaws or the tailstock of a lathe: read back by another reader."""

from typing import Any

import numpy as np
import pytest

from autodb.errors import UnusableInput
from autodb.files.machine import MachineFile
from autodb.nc.sweep import SweepWay, sweep_program, sweep_stretch
from tests.helpers import nc

TRAVEL = {"x": (-10.0, 160.0), "z": (-5.0, 520.0)}


def lathe(*, setup: dict[str, Any] | None, **bodies: Any) -> MachineFile:
    """Return a lathe whose axis of the spindle is at x = 0, its jaws' face at z = 60."""
    axes: dict[str, Any] = {
        axis: {"limits": {"travel_low_mm": low, "travel_high_mm": high, "speed_mm_min": 9e3}}
        for axis, (low, high) in TRAVEL.items()
    }
    axes["spindle"] = {"carries": "work"}
    if setup is not None:
        setup = {
            "tool": 1, "spindle": "M4", "clearance_mm": 3.0,
            "zero": {"x_mm": 0.0, "z_mm": 150.0}, "retract": {"x_mm": 150.0, "z_mm": 500.0},
            "jaws": {"z_mm": 60.0, "diameter_mm": 160.0}, **setup, **bodies,
        }  # fmt: skip
    return MachineFile.model_validate({"diameter": True, "axes": axes, "setup": setup})


TAILSTOCK = {"tailstock": {"z_mm": 400.0, "diameter_mm": 50.0}}


def program(
    machine: MachineFile, axis: str, parked: float, between: tuple[float, float] | None = None
) -> str:
    on = sweep_stretch(machine, axis, source="m.toml", between_mm=between)
    ways = [SweepWay(on.low_mm, on.high_mm, 1000.0, 0.5)]
    other = "x" if axis == "z" else "z"
    return sweep_program(
        ways, on, machine, dialect="fanuc", parked_mm={other: parked}, source="m.toml", name="s"
    )


def test_drawn_sweeps_keep_clear_of_what_turns_or_are_refused() -> None:
    rng, made, refused = np.random.default_rng(3), 0, 0
    machine = lathe(setup=TAILSTOCK)
    for _ in range(200):
        axis = str(rng.choice(["x", "z"]))
        other = "x" if axis == "z" else "z"
        parked = round(float(rng.uniform(*TRAVEL[other])), 3)
        low, high = sorted(rng.uniform(TRAVEL[axis][0] + 2, TRAVEL[axis][1] - 2, 2).tolist())
        try:
            text = program(machine, axis, parked, (low, high))
        except UnusableInput as error:
            assert "jaws" in str(error) or "tailstock" in str(error)
            refused += 1
            continue
        made += 1
        for motion in nc.motions(text, nc.fanuc_lathe({}, diameter=True), skip=True):
            if not motion.before.keys() >= {"x", "z"}:
                continue
            shares = np.linspace(0.0, 1.0, 200)
            x, z = (motion.before[a] + shares * (motion.after[a] - motion.before[a]) for a in "xz")
            assert not ((z < 62.99) & (np.abs(x) < 82.99)).any()
            assert not ((z > 397.01) & (np.abs(x) < 27.99)).any()
    assert made > 40
    assert refused > 40


def test_a_sweep_that_would_hit_is_refused_with_what_would_work() -> None:
    machine = lathe(setup=TAILSTOCK)
    with pytest.raises(UnusableInput, match=r"to the jaws .*use --between, or --park farther"):
        program(machine, "z", 40.0)
    with pytest.raises(UnusableInput, match="to the jaws"):
        program(machine, "x", 50.0)
    with pytest.raises(UnusableInput, match="to the tailstock"):
        program(machine, "x", 450.0)
    for parked, axis in ((150.0, "z"), (300.0, "x")):
        assert "CHECKED AGAINST JAWS AND TAILSTOCK" in program(machine, axis, parked)
    unsaid = lathe(setup={}, jaws={"z_mm": 60.0})
    with pytest.raises(UnusableInput, match=r"setup\.jaws\.diameter_mm is missing"):
        program(unsaid, "z", 150.0)
    assert "JAWS AND TAILSTOCK WERE NOT CHECKED" in program(lathe(setup=None), "z", 150.0)
