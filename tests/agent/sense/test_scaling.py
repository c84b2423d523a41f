"""Newtons an ampere by a known mass, a push and a standard cut: recovered, kept, used, refused."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb.records.tables import Recording
from autodb.sensing.drives.feed_axis import identify
from autodb.sensing.drives.reconstruct import DriveModel, reconstruct
from autodb.sensing.drives.scales import by_force, by_step
from tests.conftest import Cli
from tests.helpers.screw_axis import (
    COULOMB_A,
    MACHINE,
    NOISE_A,
    RATE,
    VISCOUS_A,
    screw_moves,
    write_moves,
)

Array = NDArray[np.float64]

NEWTONS_PER_AMPERE = 400.0
CONSTANT = {"0.8": "0.65", "0.72": "0.6", "0.88": "0.7"}
"""Torque constant of the test's machine and its bounds, N·m/A: 408.4 N/A."""
CUT_N = 325.78
"""force.z of the standard cut 'published' of turning-aluminium (P1, table 2)."""


def _with_mass(seed: int, mass_kg: float) -> Recording:
    """Return moves of the test's axis with a mass on it: F = m a, 1 kg mm/s² = 1 mN."""
    light = screw_moves(seed, moves=30)
    a = np.gradient(np.gradient(light["z.position"], light.t_s), light.t_s)
    current = light["z.current"] + mass_kg / 1000.0 * a / NEWTONS_PER_AMPERE
    return Recording(path=light.path, channels={**light.channels, "z.current": current})


def _push(seed: int, *, sign: float = -1.0) -> Recording:
    """Return moves against a load cell: the force of the work on the tool is minus the load."""
    n = len(screw_moves(seed))
    load_A = 2.0 * np.sin(2.0 * np.pi * np.arange(n) / (3.0 * RATE))
    pushed = screw_moves(seed, load_A, friction=1.1)
    force = sign * NEWTONS_PER_AMPERE * load_A
    return Recording(path=pushed.path, channels={**pushed.channels, "force.z": force})


def _cut(seed: int, force_N: float = CUT_N) -> Recording:
    """Return a feed towards the chuck from air; the chuck pushes the tool away."""
    n, into = int(9.0 * RATE), int(4.0 * RATE)
    velocity = np.full(n, -20.0)
    velocity[:50] = np.linspace(0.0, -20.0, 50)
    current = 1.1 * (VISCOUS_A * velocity - COULOMB_A * (velocity < 0))
    current[into:-50] -= force_N / NEWTONS_PER_AMPERE
    current += NOISE_A * np.random.default_rng(seed).standard_normal(n)
    channels = {
        "t": np.arange(n) / RATE,
        "z.position": np.cumsum(velocity) / RATE,
        "z.current": current,
    }
    return Recording(path=Path("cut.csv"), channels=channels)


@pytest.fixture(scope="module")
def model() -> DriveModel:
    """Return the axis as moves in air show it, in amperes."""
    return DriveModel.of(identify(screw_moves(70, moves=30)))


def test_a_measured_push_tells_the_scale_whatever_friction_does(model: DriveModel) -> None:
    """Of 20 pushes with 10 % more friction than in air, 13 at least lie within 1.96 sd: 95 % would
    give fewer in 1 case of 10⁴. The sd is no wider than 5 %.
    """
    held = 0
    for seed in range(100, 120):
        push = _push(seed)
        load = reconstruct(push, model, bandwidth_hz=10.0)
        found = by_force(load, push["force.z"], rate_hz=RATE)
        assert found is not None
        assert found.share < 0.05
        off = found.newtons_per_ampere / NEWTONS_PER_AMPERE - 1.0
        held += abs(off) < 1.96 * found.share
    assert held >= 13


def test_a_standard_cut_tells_the_scale(model: DriveModel) -> None:
    load = reconstruct(_cut(80), model, bandwidth_hz=10.0)
    found = by_step(load, CUT_N, 0.03, rate_hz=RATE)
    assert found is not None
    assert abs(found.newtons_per_ampere / NEWTONS_PER_AMPERE - 1.0) < 0.03
    assert 0.03 <= found.share < 0.04
    for seed in range(81, 91):
        air = reconstruct(screw_moves(seed), model, bandwidth_hz=10.0)
        assert by_step(air, CUT_N, 0.03, rate_hz=RATE) is None
    small = reconstruct(_cut(80, force_N=20.0), model, bandwidth_hz=10.0)
    assert by_step(small, 20.0, 0.03, rate_hz=RATE) is None, "no more than friction may differ by"


def test_a_force_while_the_axis_stands_tells_nothing(model: DriveModel) -> None:
    push = _push(90)
    still = {**push.channels, "z.position": np.zeros(len(push))}
    load = reconstruct(replace(push, channels=still), model, bandwidth_hz=10.0)
    assert by_force(load, push["force.z"], rate_hz=RATE) is None


def _told(out: str) -> tuple[float, float]:
    """Return newtons an ampere and percent of the first line that tells them."""
    said = " ".join(out.split())
    return float(said.split("force constant ")[1].split(" N")[0]), float(
        said.split("± ")[1].split(" %")[0]
    )


def test_the_machine_keeps_what_a_known_load_told_and_uses_the_surest(cli: Cli) -> None:
    machine = re.sub(r"0\.88|0\.8|0\.72", lambda m: CONSTANT[m[0]], MACHINE)
    Path("m.toml").write_text(machine, encoding="utf-8")
    write_moves(Path("light.csv"), screw_moves(70, moves=30))
    write_moves(Path("heavy.csv"), _with_mass(71, 60.0))
    write_moves(Path("hardly.csv"), _with_mass(72, 0.5))
    write_moves(Path("push.csv"), _push(73))
    write_moves(Path("turned.csv"), _push(74, sign=1.0))
    write_moves(Path("cut.csv"), _cut(75))
    assert cli("init").code == 0
    assert cli("machine", "add", "m", "--file", "m.toml").code == 0
    heavy = ("scale", "heavy.csv", "--machine", "m", "--added-mass", "60")
    early = cli(*heavy)
    assert early.code == 2
    assert "z.current has no version" in " ".join(early.err.split())
    assert cli("identify", "light.csv", "--machine", "m").code == 0
    for words, percent in (
        (heavy, 15.0),
        (("scale", "cut.csv", "--machine", "m", "--standard-cut", "turning-aluminium:published"),
         15.0),
        (("scale", "push.csv", "--machine", "m"), 5.0),
    ):  # fmt: skip
        done = cli(*words)
        assert done.code == 0, done.err
        found, told = _told(done.out)
        assert abs(found / NEWTONS_PER_AMPERE - 1.0) < 1.5 * told / 100.0
        assert told < percent
        assert "the machine's file agrees: 408.4 N" in " ".join(done.out.split())
    assert "scale 3 of machine 'm'" in done.out
    used = cli("reconstruct", "cut.csv", "--machine", "m")
    assert used.code == 0, used.err
    assert "scale 3: force.z of push.csv" in " ".join(used.out.split())
    assert "push.csv" in cli("trace", "scale", "3").out
    printed = json.loads(cli("scale", "push.csv", "--json").out)
    assert (printed["axis"], printed["version"], printed["already_there"]) == ("z", 3, True)
    again = cli("scale", "push.csv", "--machine", "m")
    assert "scale 3 of machine 'm', already there" in again.out
    for words, line in (
        (("scale", "hardly.csv", "--machine", "m", "--added-mass", "0.5"),
         "too little to determine the force constant"),
        (("scale", "turned.csv", "--machine", "m"), "a sign is reversed"),
        (("scale", "light.csv", "--machine", "m"), "'force.z' beside the current"),
        (("scale", "light.csv", "--machine", "m", "--standard-cut", "turning-aluminium:published"),
         "start the recording in air"),
        (("scale", "cut.csv", "--machine", "m", "--standard-cut", "turning-aluminium:light"),
         "'light' has no reference force of z; it has: none yet"),
        (("scale", "cut.csv", "--machine", "m", "--standard-cut", "turning-aluminium"),
         "names no cut"),
    ):  # fmt: skip
        refused = cli(*words)
        assert refused.code == 2
        assert line in " ".join(refused.err.split())
