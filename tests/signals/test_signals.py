"""Signals: derivatives, quasi-static force, segments. Phase currents: test_phases.py."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb import signals
from autodb.timing import examined

RATE = 1000.0
T = np.arange(0, 8, 1 / RATE)


def test_derivatives_of_a_parabola_are_exact_inside() -> None:
    position = 3.0 + 2.0 * T + 0.5 * 1.5 * T**2
    _, velocity, acceleration = signals.derivatives(
        T, position, cutoff_hz=100.0, timing=examined(T, {}, where="T")
    )
    inside = slice(500, -500)
    assert_allclose(velocity[inside], (2.0 + 1.5 * T)[inside], rtol=1e-6)
    assert_allclose(acceleration[inside], 1.5, rtol=1e-4)


def test_lowpass_shifts_nothing_in_time() -> None:
    slow = np.sin(2 * np.pi * 3.0 * T)
    out = signals.lowpass(slow, rate_hz=RATE, cutoff_hz=100.0)
    assert_allclose(out[1000:-1000], slow[1000:-1000], atol=1e-5)


def test_quasi_static_keeps_the_level_and_drops_the_teeth() -> None:
    force = 300.0 + 80.0 * np.sin(2 * np.pi * 90.0 * T)
    out = signals.quasi_static(force, rate_hz=RATE)
    assert_allclose(out[1000:-1000], 300.0, atol=1.0)


def test_quasi_static_holds_only_the_band_below_8_Hz() -> None:
    """Level 6 at 1000 Hz ends at 7.8 Hz; with level 5, 11 Hz would come through the average."""
    swinging = signals.quasi_static(100.0 * np.sin(2 * np.pi * 11.0 * T), rate_hz=RATE)
    assert np.abs(swinging[1000:-1000]).max() < 3.0


def test_quasi_static_is_off_by_a_sixteenth_of_the_slope_at_the_ends() -> None:
    slope_N_s = 200.0
    out = signals.quasi_static(slope_N_s * T, rate_hz=RATE)
    assert_allclose(out[500:-500], (slope_N_s * T)[500:-500], atol=0.6)
    assert np.abs(out - slope_N_s * T).max() < 1.1 * slope_N_s / 16.0


def test_air_and_cut_are_told_apart() -> None:
    load = np.where((T > 2.5) & (T < 6.5), 5.0, 2.0)
    load = load + np.random.default_rng(1).normal(0, 0.05, T.size)
    found = signals.air_and_cut(load, rate_hz=RATE)
    assert found is not None
    assert found.air.stop == pytest.approx(2000, abs=5)
    assert found.cut.start == pytest.approx(3000, abs=5)
    assert found.cut.stop == pytest.approx(6000, abs=5)


def test_a_falling_load_is_a_cut_too() -> None:
    """On an axis that weight helps, the range falls in the cut (P1 section 8)."""
    found = signals.air_and_cut(np.where((T > 2.5) & (T < 6.5), 1.0, 2.0), rate_hz=RATE)
    assert found is not None
    assert found.cut.start == pytest.approx(3000, abs=5)


def test_noise_alone_holds_no_cut() -> None:
    load = np.random.default_rng(2).normal(2.0, 0.3, T.size)
    assert signals.air_and_cut(load, rate_hz=RATE) is None


def test_decimation_keeps_a_linear_relation() -> None:
    rng = np.random.default_rng(3)
    columns = rng.normal(size=(T.size, 2))
    both = np.column_stack([columns, columns @ [2.0, -3.0]])
    out = signals.decimate(both, 10)
    assert_allclose(out[:, 2], out[:, :2] @ [2.0, -3.0], atol=1e-12)
