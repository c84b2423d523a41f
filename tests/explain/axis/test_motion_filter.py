"""Of a derived motion as much is used as the effort follows: the rest is the encoder's noise."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid

from autodb.explain import explain
from autodb.explain.axis.loads import swings_behind
from autodb.explain.axis.signals import NO_EFFORT_ABOVE, AxisSignals, axis_signals
from autodb.records.tables import Recording

Array = NDArray[np.float64]

RATE_HZ, SECONDS = 2.5, 1500.0
SLOWEST_HZ, FASTEST_HZ = 0.05, 0.12
"""Waves of the speed: of one frequency they would be ripples along the travel as well."""
TURNING_S, MASS_A_S2_MM, FRICTION_A = 20.0, 26.0, 0.05
"""Of a slow axis whose acceleration reaches 0.0045 mm/s²: 0.12 A against 0.05 A of friction."""
EFFORT_NOISE_A = 0.01


def _slow_axis(encoder_mm: float) -> tuple[Recording, Recording]:
    """Return a slow move to and fro with waves of speed, and its simulation without the mass."""
    rng = np.random.default_rng(20261128)
    t = np.arange(0.0, SECONDS, 1.0 / RATE_HZ)
    faster_Hz = SLOWEST_HZ + (FASTEST_HZ - SLOWEST_HZ) * t / SECONDS
    phase = 2.0 * np.pi * np.cumsum(faster_Hz) / RATE_HZ
    speed = 0.012 * np.tanh((SECONDS / 2.0 - t) / TURNING_S) + 0.006 * np.sin(phase)
    mass = MASS_A_S2_MM * np.gradient(speed, t)
    way = cumulative_trapezoid(speed, t, initial=0)
    place = way + rng.normal(0.0, encoder_mm, len(t))
    friction = FRICTION_A * np.tanh(speed / 0.0005)
    effort = friction + mass + rng.normal(0.0, EFFORT_NOISE_A, len(t))
    measured = Recording(Path("a.csv"), {"t": t, "x.position": place, "x.current": effort})
    simulated = Recording(Path("b.csv"), {"t": t, "x.current": friction})
    return measured, simulated


def _signals(measured: Recording, simulated: Recording) -> AxisSignals:
    return axis_signals(measured, simulated["x.current"], "x.current", includes=("coulomb",))


def test_motion_is_derived_below_what_no_effort_follows() -> None:
    # 2e-4 mm of noise are an acceleration of 0.003 mm/s² at the highest cutoff, 1 Hz.
    signals = _signals(*_slow_axis(encoder_mm=2e-4))
    assert FASTEST_HZ < signals.cutoff_hz <= 0.5
    assert signals.lowered == NO_EFFORT_ABOVE


def test_a_motion_without_noise_keeps_its_cutoff() -> None:
    signals = _signals(*_slow_axis(encoder_mm=1e-7))
    assert signals.cutoff_hz == pytest.approx(1.0)
    assert signals.lowered == ""


def test_mass_that_noise_hides_is_named_with_its_size() -> None:
    measured, simulated = _slow_axis(encoder_mm=2e-4)
    answer = explain(measured, simulated, includes=["coulomb"])
    named = answer.explanation.channels["x.current"].missing
    assert [one.term for one in named if one.confidence >= 0.5] == ["inertia"]
    assert named[0].parameters["coefficient"].value == pytest.approx(MASS_A_S2_MM, rel=0.02)
    assert any(NO_EFFORT_ABOVE in note for note in answer.notes)


def test_an_acceleration_that_drowns_far_above_the_motion_is_found_far_below() -> None:
    """Places that an arm's controller says at 50 Hz, logged at 200 Hz: the noise is not white, and
    with half of the highest cutoff the acceleration drowns as before."""
    rng = np.random.default_rng(20261129)
    t = np.arange(0.0, 30.0, 0.005)
    waves = [(15.0, 0.1, 0.3), (4.0, 0.35, 1.0), (2.0, 0.6, 2.0)]
    place = sum(size * np.sin(2.0 * np.pi * hz * t + phase) for size, hz, phase in waves)
    speed = np.gradient(place, t)
    mass = 0.0025 * np.gradient(speed, t)
    friction = 0.1 * np.tanh(speed / 0.3)
    said = np.round(np.arange(0.0, 30.0, 0.02), 3)
    measured = np.interp(t, said, np.interp(said, t, place) + rng.normal(0.0, 0.3, len(said)))
    effort = friction + mass + rng.normal(0.0, 0.02, len(t))
    arm = Recording(Path("a.csv"), {"t": t, "x.position": measured, "x.current": effort})
    known = Recording(Path("b.csv"), {"t": t, "x.current": friction})
    signals = axis_signals(arm, friction, "x.current", includes=("coulomb",))
    assert 0.6 < signals.cutoff_hz < 10.0
    (answer,) = explain(arm, known, includes=["coulomb"]).explanation.channels.values()
    assert answer.missing[0].term == "inertia"
    assert answer.missing[0].confidence >= 0.9
    assert answer.missing[0].parameters["coefficient"].value == pytest.approx(0.0025, rel=0.1)


def test_nothing_swings_above_the_cutoff_of_an_acceleration_that_was_derived() -> None:
    """There a springy drive train is what the filter took of a mass, at any frequency."""
    signals = _signals(*_slow_axis(encoder_mm=1e-7))
    fast = replace(signals, t_s=signals.t_s * RATE_HZ / 250.0)

    def highest_hz(cutoff_hz: float) -> float:
        (swings,) = swings_behind(replace(fast, cutoff_hz=cutoff_hz))
        return max(form.shape["frequency"] for form in swings.forms)

    assert highest_hz(10.0) < 10.0
    assert highest_hz(1000.0) > 50.0
