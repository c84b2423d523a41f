"""A load that comes and goes at one level is one load, not a constant and something unknown."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb.explain import explain
from autodb.explain.answer import ChannelAnswer
from autodb.explain.axis.loads import loaded_rows, pulsed_loads
from autodb.explain.axis.signals import AxisSignals, axis_signals
from autodb.proofs.cases.real.real_case import RealSpec
from autodb.proofs.cases.real.real_cases import made_case
from autodb.proofs.runs.real.real_answers import explained_real
from autodb.records.tables import Recording
from tests.conftest import shared

Array = NDArray[np.float64]

T_S = np.arange(0.0, 20.0, 0.01)
STRETCHES = ((2.0, 3.1), (4.0, 4.7), (7.2, 9.9), (13.0, 13.6), (15.5, 17.0))
"""From when to when [s] the load is there: no period."""
FRICTION_A, LOAD_A, NOISE_A = 2.0, -3.0, 0.1


def _recordings(load: Array) -> tuple[Recording, Recording]:
    """Return an axis that goes to and fro with friction and a load, and its simulated friction."""
    rng = np.random.default_rng(20261129)
    friction = FRICTION_A * np.sign(np.cos(2.0 * np.pi * T_S / 7.0))
    effort = friction + load + rng.normal(0.0, NOISE_A, len(T_S))
    place = 50.0 + 40.0 * np.sin(2.0 * np.pi * T_S / 7.0)
    measured = Recording(Path("a.csv"), {"t": T_S, "x.position": place, "x.current": effort})
    return measured, Recording(Path("b.csv"), {"t": T_S, "x.current": friction})


def _pulses() -> Array:
    since, until = (np.array(edges)[:, None] for edges in zip(*STRETCHES, strict=True))
    return np.asarray(LOAD_A * np.sum((since <= T_S) & (until >= T_S), axis=0))


def _answer(load: Array, includes: list[str]) -> ChannelAnswer:
    measured, simulated = _recordings(load)
    return explain(measured, simulated, includes=includes).explanation.channels["x.current"]


def _signals(load: Array) -> tuple[AxisSignals, Array]:
    measured, simulated = _recordings(load)
    signals = axis_signals(measured, simulated["x.current"], "x.current")
    return signals, measured["x.current"] - simulated["x.current"]


def test_a_load_that_comes_and_goes_is_named_with_its_stretches() -> None:
    answer = _answer(_pulses(), ["coulomb"])
    (load,) = answer.missing
    assert (load.term, load.kind) == ("external_load", "missing")
    assert load.confidence > 0.9
    level = load.parameters["level"]
    assert level.low < LOAD_A < level.high
    assert np.array(answer.where.intervals) == pytest.approx(np.array(STRETCHES), abs=0.02)
    assert answer.fit.heldout_after < 1.1 * NOISE_A


def test_what_comes_and_goes_with_the_motion_is_a_law_of_the_motion() -> None:
    """Friction that is left out has two levels too."""
    going = np.where(np.cos(2.0 * np.pi * T_S / 7.0) > 0.0, 1.0, -1.0)
    signals, difference = _signals(1.5 * going)
    assert loaded_rows(difference) is not None
    assert not pulsed_loads(signals, difference)
    assert pulsed_loads(*_signals(_pulses()))


@pytest.mark.parametrize("load", ["none", "waves", "buried", "once"])
def test_other_differences_have_no_load_that_comes_and_goes(load: str) -> None:
    loads: dict[str, Array] = {
        "none": 0.0 * T_S,
        "waves": 3.0 * np.sin(2.0 * np.pi * T_S / 1.3),
        "buried": 0.1 * _pulses(),
        "once": np.where((T_S > 5.0) & (T_S < 9.0), LOAD_A, 0.0),
    }
    assert not pulsed_loads(*_signals(loads[load]))


def test_the_level_nearer_to_zero_is_the_one_without_the_load() -> None:
    """Between two levels nothing changes: a wave of half the step switches no load on."""
    on = (T_S % 4.0) < 1.0
    ripple = 0.2 * np.sin(2.0 * np.pi * T_S / 0.3)
    for values in (5.0 * on + ripple, -5.0 * on + ripple, 5.0 * on + ripple + 1.0):
        found = loaded_rows(values)
        assert found is not None
        assert np.array_equal(found, on)


def test_strokes_of_another_motor_on_a_real_axis_are_one_load(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A second motor pushes with 178 N for half of each second; left out of the simulation, it was
    a constant load of 87 N and something unknown over time of 100 N, with an error of 26.7 N."""
    shared("data", "emps", "DATA_EMPS_PULSES.mat")
    monkeypatch.setenv("AUTODB_SHARED", str(shared("data").parent))
    case = made_case(RealSpec("left out", "emps-loaded", "external_load", "", "kept"))
    answer = explained_real(case)
    assert answer.after is not None
    assert answer.after < case.rms_full
    first = max(answer.entries, key=lambda one: one.size)
    assert (first.term, first.confidence > 0.9) == ("external_load", True)
    assert first.size == pytest.approx(case.true_size, rel=0.1)
    assert {one.term for one in answer.entries} <= {"external_load", "lag"}
