"""What friction is off its laws: found by a sweep, and kept with the model."""

import json
from pathlib import Path

import numpy as np
from numpy.testing import assert_allclose

from autodb.records.tables import Recording
from autodb.sensing.drives.feed_axis import identify, predict_effort
from autodb.sensing.drives.fit.axis_model import Identified
from autodb.sensing.drives.fit.discrepancy import FrictionDiscrepancy
from autodb.sensing.drives.moves.protocol import FilterProtocol
from tests.conftest import Cli
from tests.helpers.bent_sweep import SPEEDS, WAVE_A, WAVE_MM, _friction, bent_sweep
from tests.helpers.screw_axis import TWO_AXES, bare, write_moves


def _identified(moves: Recording, *terms: str) -> Identified:
    names = ("inertia", "viscous", "coulomb", "gravity", *terms)
    return identify(moves, terms=names, protocol=FilterProtocol(20.0, 5), by_way=True)


def test_friction_off_its_laws_is_kept_and_comes_back_from_the_database() -> None:
    """Friction bends by 0.5 A over the speeds; at every speed it is known within 2 %, by the laws
    alone it is off by 0.1 A at creep.
    """
    moves = bent_sweep(1, bent_A=0.1)
    found = _identified(moves)
    assert found.off_law is not None
    again = FrictionDiscrepancy.of(json.loads(json.dumps(found.off_law.kept())))
    whole, alone = (predict_effort(moves, "z", found.terms, off_law) for off_law in (again, None))
    v = moves["z.velocity"]
    for speed in SPEEDS:
        rows = np.isclose(v, speed, rtol=1e-6)
        truth = float(_friction(np.array([speed]), 0.1)[0])
        assert_allclose(float(whole[rows].mean()), truth, rtol=0.02)
    slow = np.isclose(v, SPEEDS[0], rtol=1e-6)
    assert abs(float(alone[slow].mean()) - float(_friction(SPEEDS[:1], 0.1)[0])) > 0.1


def test_a_machine_keeps_it_and_feels_loads_with_it(cli: Cli) -> None:
    """At creep the laws alone would leave 0.1 A and more of the sweep itself."""
    moves = bent_sweep(3, bent_A=0.1)
    Path("m.toml").write_text(TWO_AXES, encoding="utf-8")
    write_moves(Path("sweep.csv"), moves)
    assert cli("init").code == 0
    assert cli("machine", "add", "m", "--file", "m.toml").code == 0
    assert cli("identify", "sweep.csv", "--machine", "m").code == 0
    done = cli("reconstruct", "sweep.csv", "--machine", "m", "--newtons-per-ampere", "1")
    assert done.code == 0, done.err
    load = np.loadtxt("sweep-load.csv", delimiter=",", skiprows=1, usecols=1, converters=bare)
    slow = np.isclose(np.abs(moves["z.velocity"]), SPEEDS[0], rtol=1e-6)
    assert float(np.abs(np.mean(load[slow] * np.sign(moves["z.velocity"][slow])))) < 0.02


def test_laws_that_are_right_are_all_of_a_model() -> None:
    """Over 12 sweeps friction comes out within 1 %, whether passes left out were nearer with a
    deviation by chance or not.
    """
    truth = _friction(SPEEDS, 0.0)
    for seed in range(20, 32):
        moves = bent_sweep(seed, bent_A=0.0)
        found = _identified(moves)
        effort = predict_effort(moves, "z", found.terms, found.off_law)
        for speed, friction in zip(SPEEDS.tolist(), truth.tolist(), strict=True):
            rows = np.isclose(moves["z.velocity"], speed, rtol=1e-6)
            assert_allclose(float(effort[rows].mean()), friction, rtol=0.01)


def test_means_by_way_show_the_ripple_of_a_screw() -> None:
    """Its wave of 10 mm is twice the way that means are over otherwise: cosine or sine was lost."""
    found = _identified(bent_sweep(2, bent_A=0.0, wave_A=WAVE_A), "cogging")
    known = {(t.term, t.parameter): t for t in found.terms}
    period = known["position_friction", "period"]
    assert abs(period.value - WAVE_MM) < 0.02
    size = np.hypot(known["position_friction", "cosine"].value,
                    known["position_friction", "sine"].value)  # fmt: skip
    assert_allclose(size, WAVE_A, rtol=0.1)
