"""Parts of a recorded cut, and what is searched for in them: the laws of each, on plain arrays."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb import signals
from autodb.files.channels import unit_of

RATE = 1000.0
T = np.arange(10_000) / RATE
TURNING = (signals.Turning(25.0, 40, 0.001),)


def test_a_cut_has_four_parts_in_a_row() -> None:
    noise = 0.01 * np.random.default_rng(1).standard_normal(T.size)
    parts = signals.air_and_cut(np.where((T > 2.5) & (T < 6.5), 2.0, 1.0) + noise, rate_hz=RATE)
    assert parts is not None
    edges = [(s.start, s.stop) for s in (parts.air, parts.entry, parts.cut, parts.exit)]
    assert_allclose(edges, [(500, 2000), (2000, 3000), (3000, 6000), (6000, 7000)], atol=2)


def test_errors_of_white_noise_are_at_most_a_third_too_large() -> None:
    found = [
        signals.standard_error(
            np.random.default_rng(seed).standard_normal(T.size), rate_hz=RATE, averaged_s=1e-3
        )
        for seed in range(200)
    ]
    assert 0.01 < np.sqrt(np.mean(np.square(np.array(found, dtype=float)))) < 0.0133


def test_an_error_scales_with_the_series_and_heeds_no_steady_rise() -> None:
    values = np.random.default_rng(2).standard_normal(T.size)
    error = signals.standard_error(values, rate_hz=RATE, averaged_s=0.1)
    other = signals.standard_error(5.0 - 3.0 * values + 7.0 * T, rate_hz=RATE, averaged_s=0.1)
    assert error is not None
    assert other is not None
    assert_allclose(other, 3.0 * error, rtol=1e-6)


def test_a_series_too_short_for_its_average_has_no_error() -> None:
    values = np.random.default_rng(3).standard_normal(T.size)
    assert signals.standard_error(values, rate_hz=RATE, averaged_s=2.1) is None
    assert signals.standard_error(values, rate_hz=RATE, averaged_s=1.9) is not None
    assert signals.standard_error(np.full(100, np.nan), rate_hz=RATE, averaged_s=0.1) is None


@pytest.mark.parametrize(
    ("hertz", "seen"), [(137.0, True), (150.0, False), (1075.0 - 1000.0, False), (863.0, True)]
)
def test_chatter_is_no_multiple_of_what_turns_folded_or_not(hertz: float, seen: bool) -> None:
    rng = np.random.default_rng(4)
    air, noise = 0.1 * rng.standard_normal((2, T.size))
    cut = noise + np.sin(2.0 * np.pi * hertz * T)
    found = signals.chatter(cut, air, rate_hz=RATE, turning=TURNING, least_rms=0.1)
    assert (found is not None) == seen
    if found is not None:
        assert_allclose([found.frequency_hz, found.rms], [137.0, np.sqrt(0.5)], rtol=0.05)


def test_a_line_that_is_there_in_air_is_no_chatter() -> None:
    rng = np.random.default_rng(5)
    air, cut = 0.1 * rng.standard_normal((2, T.size)) + np.sin(2.0 * np.pi * 137.0 * T)
    assert signals.chatter(cut, air, rate_hz=RATE, turning=TURNING, least_rms=0.1) is None


def test_constant_cutting_speed_is_no_braking() -> None:
    """Facing at 5 mm/s from 70 to 20 mm in diameter, the speed rises; then the spindle brakes."""
    diameter_mm = 70.0 - 2.0 * 2.5 * T
    speed_rpm = 1000.0 * 200.0 / (np.pi * diameter_mm)
    assert signals.slowing_from(speed_rpm, rate_hz=RATE) is None
    assert signals.slowing_from(speed_rpm[::-1], rate_hz=RATE) is None
    brakes = speed_rpm * np.clip(1.0 - (T - 8.0), 0.0, 1.0)
    begins = signals.slowing_from(brakes, rate_hz=RATE)
    assert begins is not None
    assert_allclose(begins, 8000, atol=100)


@pytest.mark.parametrize("period_s", [0.7, 2.0, 7.0])
def test_a_load_that_turns_slowly_is_at_no_limit_unless_it_is_cut_off(period_s: float) -> None:
    noise = 0.02 * np.random.default_rng(6).standard_normal(T.size)
    swing = 5.0 + np.sin(2.0 * np.pi * T / period_s)
    assert signals.held_at_top(swing + noise, noise_A=0.02) is None
    found = signals.held_at_top(np.minimum(swing, 5.5) + noise, noise_A=0.02)
    if period_s < 5.0:  # comes back to its top from two dips
        assert found is not None
        assert_allclose(found.level, 5.5, rtol=0.002)


def test_rises_at_random_moments_are_no_lubrication() -> None:
    def load(at_s: tuple[float, ...]) -> signals.Pulses | None:
        noise = 0.01 * np.random.default_rng(7).standard_normal(T.size)
        bumps = sum(np.exp(-0.5 * ((T - s) / 0.1) ** 2) for s in at_s)
        return signals.regular_pulses([(0, 3.0 + noise + bumps)], rate_hz=RATE, averaged_s=0.1)

    found = load((1.0, 3.5, 6.0, 8.5))
    assert found is not None
    assert_allclose(found.every_s, 2.5, rtol=0.01)
    assert load((1.0, 2.1, 5.8, 8.9)) is None
    assert load((1.0, 6.0)) is None


def test_standard_errors_are_channels_of_a_cut_table() -> None:
    assert unit_of("z.current.range.sd") == unit_of("spindle.current.air.sd") == "A"
    assert unit_of("z.current.u.sd") is None
    assert unit_of("z.current.sd") is None
