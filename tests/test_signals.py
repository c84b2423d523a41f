"""Signals: derivatives, demodulation, quasi-static force, segments."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb import signals

RATE = 1000.0
T = np.arange(0, 8, 1 / RATE)


def test_derivatives_of_a_parabola_are_exact_inside() -> None:
    position = 3.0 + 2.0 * T + 0.5 * 1.5 * T**2
    _, velocity, acceleration = signals.derivatives(T, position, cutoff_hz=100.0)
    inside = slice(500, -500)
    assert_allclose(velocity[inside], (2.0 + 1.5 * T)[inside], rtol=1e-6)
    assert_allclose(acceleration[inside], 1.5, rtol=1e-4)


def test_lowpass_shifts_nothing_in_time() -> None:
    slow = np.sin(2 * np.pi * 3.0 * T)
    out = signals.lowpass(slow, rate_hz=RATE, cutoff_hz=100.0)
    assert_allclose(out[1000:-1000], slow[1000:-1000], atol=1e-5)


def _phases(amplitude: np.ndarray, hz: float, offset: tuple[float, float, float]) -> list:  # type: ignore[type-arg]
    phase = 2 * np.pi * hz * T
    return [amplitude * np.cos(phase - k * 2 * np.pi / 3) + offset[k] for k in range(3)]


@pytest.mark.parametrize("hz", [0.5, 3.0, 16.0, 60.0, 184.0])
def test_range_is_twice_the_amplitude_at_any_drive_frequency(hz: float) -> None:
    u, v, w = _phases(np.full_like(T, 1.7), hz, (0.05, -0.08, 0.02))
    found = signals.three_phase_range(u, v, w, rate_hz=RATE)
    inside = slice(2000, -2000)
    assert_allclose(found.range_A[inside], 3.4, rtol=0.01)
    assert_allclose(found.frequency_hz[inside], hz, rtol=0.02)


def test_range_is_read_through_noise() -> None:
    """20 dB signal to noise: rms error at most 1 % over windows of 1 s, as the range is used."""
    rng = np.random.default_rng(7)
    phases = [p + rng.normal(0, 0.1 * 1.7 / np.sqrt(2), T.size)
              for p in _phases(np.full_like(T, 1.7), 3.0, (0, 0, 0))]  # fmt: skip
    found = signals.three_phase_range(*phases, rate_hz=RATE, smooth_s=1.0)
    error = found.range_A[1000:-1000] / 3.4 - 1.0
    assert np.sqrt(np.mean(error**2)) < 0.01


def test_a_standing_axis_gives_no_range() -> None:
    u, v, w = _phases(np.full_like(T, 1.7), 0.0, (0, 0, 0))
    assert np.isnan(signals.three_phase_range(u, v, w, rate_hz=RATE).range_A).all()


def test_quasi_static_keeps_the_level_and_drops_the_teeth() -> None:
    force = 300.0 + 80.0 * np.sin(2 * np.pi * 90.0 * T)
    out = signals.quasi_static(force, rate_hz=RATE)
    assert_allclose(out[1000:-1000], 300.0, atol=1.0)


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
