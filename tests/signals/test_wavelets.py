"""Daubechies-5 de-noising: what it keeps, and how low it reads near its edges."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb import signals
from autodb.signals import wavelets

RATE = 1000.0
T = np.arange(20_000) / RATE
INSIDE = slice(3000, -3000)
PERCENT = 0.01


def _low_by(hertz: float, *, window_s: float, details: int) -> tuple[float, str | None]:
    """Return how much too low the range of a sinusoid of range 2 reads, and the note with it."""
    wave = np.sin(2.0 * np.pi * hertz * T + 0.4)
    found = signals.wavelet_range(
        wave, rate_hz=RATE, frequency_hz=hertz, window_s=window_s, level=6, details=details
    )
    return 1.0 - float(np.mean(found.range_A[INSIDE])) / 2.0, found.note


def test_lowest_sub_band_reads_76_percent_low_at_10_Hz() -> None:
    low, note = _low_by(10.0, window_s=0.1, details=0)
    assert low == pytest.approx(0.76, abs=PERCENT)
    assert note is not None
    assert "band that ends at 7.81 Hz" in note


def test_with_its_coarsest_detail_it_reads_15_to_38_percent_low_at_16_Hz() -> None:
    """Largest less smallest over one period, or over 0.5 s, in which the sub-band beats."""
    one_period, note = _low_by(16.0, window_s=1.0 / 16.0, details=1)
    half_second, _ = _low_by(16.0, window_s=0.5, details=1)
    assert one_period == pytest.approx(0.38, abs=PERCENT)
    assert half_second == pytest.approx(0.15, abs=PERCENT)
    assert note is not None
    assert "15.6 Hz" in note


def test_the_demodulator_reads_both_within_half_a_percent() -> None:
    for hertz in (10.0, 16.0):
        wave = np.sin(2.0 * np.pi * hertz * T + 0.4)
        found = signals.one_phase_range(wave, rate_hz=RATE)
        assert_allclose(found.range_A[INSIDE], 2.0, rtol=0.005)


def test_far_below_the_edge_it_reads_right_and_there_is_no_note() -> None:
    low, note = _low_by(2.0, window_s=0.5, details=0)
    assert abs(low) < 0.005
    assert note is None


@pytest.mark.parametrize(
    ("level", "details", "end_hz"), [(6, 0, 7.8125), (6, 1, 15.625), (10, 0, 0.48828125)]
)
def test_a_band_ends_at_the_rate_over_a_power_of_two(
    level: int, details: int, end_hz: float
) -> None:
    assert wavelets.ends_hz(rate_hz=RATE, level=level, details=details) == end_hz
    for hertz, kept in ((0.25 * end_hz, 1.0), (4.0 * end_hz, 0.0)):
        share = wavelets.passed(hertz, rate_hz=RATE, level=level, details=details)
        assert share == pytest.approx(kept, abs=0.02)


def test_white_noise_leaves_its_share_of_the_band() -> None:
    """A6 holds 1/64 of the noise's power."""
    noise = np.random.default_rng(11).standard_normal(200_000)
    assert_allclose(np.var(wavelets.denoised(noise, level=6)), 1 / 64, rtol=0.1)
