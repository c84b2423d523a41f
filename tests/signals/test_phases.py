"""Phase currents to range: made by the virtual machine's sensors, read by the demodulator.

Every current has Hall offsets, a fifth harmonic of 2 %, unequal gains of the three sensors and
white noise 20 dB below it, unless a test says otherwise.
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray

from autodb import signals
from autodb.proofs.machines.lathe.phases import phases
from autodb.signals import PhaseRange, PhaseStream

Array = NDArray[np.float64]

RATE = 1000.0
GAINS = (1.03, 0.98, 1.0)
NOISE_20_DB = 0.1
HERTZ = (0.1, 0.15, 0.7, 1.6, 3.0, 10.0, 16.0, 60.0, 130.0, 200.0)


def _made(range_A: Array, hertz: Array | float, *, noise: float = NOISE_20_DB) -> list[Array]:
    made = phases(
        np.random.default_rng(41), range_A, np.broadcast_to(hertz, range_A.shape), RATE, 0.02,
        gains=GAINS, noise_share=noise,
    )  # fmt: skip
    return list(made.values())


def _read(currents: list[Array], rate_hz: float = RATE) -> tuple[PhaseRange, PhaseRange]:
    """Return what the first phase says, and what all three say."""
    u, v, w = currents
    one = signals.one_phase_range(u, rate_hz=rate_hz)
    return one, signals.three_phase_range(u, v, w, rate_hz=rate_hz)


def _error(found: PhaseRange, true_A: Array, gain: float, inside: slice) -> float:
    """Return the rms error of a range whose sensors multiply it by ``gain``."""
    relative = found.range_A[inside] / (gain * true_A[inside]) - 1.0
    return float(np.sqrt(np.mean(relative**2)))


@pytest.mark.parametrize("hertz", HERTZ)
def test_range_at_20_dB_errs_by_less_than_1_percent(hertz: float) -> None:
    true_A = np.full(round(max(12.0, 6.0 / hertz) * RATE), 3.4)
    inside = slice(round(max(2.0, 2.0 / hertz) * RATE), -round(max(2.0, 2.0 / hertz) * RATE))
    one, three = _read(_made(true_A, hertz))
    assert _error(one, true_A, GAINS[0], inside) < 0.01
    assert _error(three, true_A, float(np.mean(GAINS)), inside) < 0.01
    assert_allclose(np.abs(one.frequency_hz[inside]), hertz, rtol=0.03)
    assert_allclose(three.frequency_hz[inside], hertz, rtol=0.03)


def test_frequency_ramps_are_followed_within_3_percent() -> None:
    t = np.arange(60_000) / RATE
    for hertz in (0.2 * 1000.0 ** (t / 60.0), 1.0 + 199.0 * t / 60.0, 16.0 - 15.8 * t / 60.0):
        true_A = np.full(t.size, 3.4)
        inside = slice(12_000, -12_000)
        one, three = _read(_made(true_A, hertz))
        assert _error(one, true_A, GAINS[0], inside) < 0.03
        assert _error(three, true_A, float(np.mean(GAINS)), inside) < 0.03
        assert_allclose(one.frequency_hz[inside], hertz[inside], rtol=0.05)


@pytest.mark.parametrize("hertz", [0.5, 1.6, 16.0, 150.0])
def test_amplitude_ramps_are_followed_within_3_percent(hertz: float) -> None:
    true_A = np.interp(np.arange(40_000) / RATE, [10.0, 30.0], [2.0, 6.0])
    one, three = _read(_made(true_A, hertz))
    assert _error(one, true_A, GAINS[0], slice(8000, -8000)) < 0.03
    assert _error(three, true_A, float(np.mean(GAINS)), slice(8000, -8000)) < 0.03


@pytest.mark.parametrize("hertz", [2.0, 150.0])
def test_the_power_of_noise_is_taken_off(hertz: float) -> None:
    """At 10 dB the noise at 150 Hz is 6 % of one phase's power and 3.3 % of three phases'."""
    true_A = np.full(60_000, 3.4)
    found = _read(_made(true_A, hertz, noise=np.sqrt(0.1)))
    for one, gain in zip(found, (GAINS[0], float(np.mean(GAINS))), strict=True):
        assert_allclose(np.mean(one.range_A[3000:-3000]), gain * 3.4, rtol=0.004)


def test_an_offset_of_five_times_the_amplitude_changes_nothing() -> None:
    u, v, w = _made(np.full(12_000, 3.4), 7.0)
    plain, moved = _read([u, v, w]), _read([u + 8.5, v - 8.5, w])
    for before, after in zip(plain, moved, strict=True):
        assert_allclose(after.range_A, before.range_A, rtol=1e-9)


def test_unequal_gains_make_a_ripple_that_three_phases_average_out() -> None:
    """A gain of 1.06 beside 0.94 is a turning back of 3.5 %: 7 % of ripple in the plain length."""
    t = np.arange(20_000) / RATE
    currents = [g * np.cos(2 * np.pi * (16.3 * t - k / 3)) for k, g in enumerate((1.06, 0.94, 1.0))]
    length = 2.0 * np.abs(signals.space_vector(*currents))
    found = signals.three_phase_range(*currents, rate_hz=RATE)
    assert np.ptp(length) > 0.13
    assert_allclose(found.range_A[2000:-2000], 2.0, rtol=4e-3)


def test_the_sign_of_the_frequency_is_the_phase_order() -> None:
    _, three = _read(_made(np.full(8000, 3.4), -12.0))
    assert_allclose(three.frequency_hz, -12.0, rtol=0.02)


@pytest.mark.parametrize("hertz", [0.0, 0.005, 0.01, 0.03, 0.04])
def test_a_standing_axis_gives_no_range(hertz: float) -> None:
    for found in _read(_made(np.full(120_000, 3.4), hertz)):
        assert np.isnan(found.range_A).all()


def test_neither_noise_nor_a_step_of_a_standing_current_is_a_range() -> None:
    noise = 0.01 * np.random.default_rng(5).standard_normal((3, 30_000))
    step = np.where(np.arange(30_000) > 14_000, 2.0, 1.0)
    for found in _read(list(noise)):
        assert np.isnan(found.range_A).all()
    one, three = _read([step + noise[0], noise[1] - 0.5 * step, noise[2] - 0.5 * step])
    assert np.isnan(three.range_A).all()
    assert np.nan_to_num(one.range_A).max() < 0.05


def test_a_reading_is_kept_for_one_period_at_the_ends_and_not_longer() -> None:
    """At 0.2 Hz the filters of one phase reach back further than the 5 s of a period."""
    u, _, _ = _made(np.full(120_000, 3.4), 0.2)
    known = np.isfinite(signals.one_phase_range(u, rate_hz=RATE).range_A)
    begins, ends = np.flatnonzero(np.diff(known.astype(int)))
    assert known[begins + 1 : ends].all()
    assert 1000 < begins < 10_000
    assert 1000 < 120_000 - ends < 15_000


def test_a_recording_shorter_than_the_filters_gives_no_range() -> None:
    for length in (1, 7, 40, 54, 55, 56, 57, 200):
        for found in _read([np.ones(length)] * 3):
            assert found.range_A.shape == (length,)
            assert np.isnan(found.range_A).all()


@pytest.mark.parametrize("rate_hz", [100.0, 1000.0, 4096.0])
def test_blocks_of_any_size_give_what_the_whole_recording_gives(rate_hz: float) -> None:
    """To 1e-9, standstill included, and never later than the stated latency."""
    rng = np.random.default_rng(17)
    t = np.arange(70_000) / rate_hz
    hertz = rate_hz * np.interp(t, t[-1] * np.array([0, 0.4, 0.45, 0.6, 1]), [0, 0.1, 0, 0, 0.25])
    made = phases(rng, 2.0 + np.sin(0.3 * t), hertz, rate_hz, 0.02, noise_share=NOISE_20_DB)
    u, v, w = made.values()
    one, three = _read([u, v, w], rate_hz)
    assert np.isnan(three.range_A).any()
    for whole, form, samples in (
        (one, signals.one_phase(1.0), u),
        (three, signals.three_phases(0.5), signals.space_vector(u, v, w)),
    ):
        stream, parts, begin = PhaseStream.start(form, rate_hz=rate_hz), [], 0
        while begin < t.size:
            size = int(10.0 ** rng.uniform(0.0, 4.0))
            parts.append(stream.push(samples[begin : begin + size]))
            begin += size
            assert stream.taken - stream.given <= stream.latency_samples
        parts.append(stream.finish())
        range_A = np.concatenate([p.range_A for p in parts])
        assert_array_equal(np.isnan(range_A), np.isnan(whole.range_A))
        assert_allclose(range_A, whole.range_A, rtol=1e-9)
        frequency_hz = np.concatenate([p.frequency_hz for p in parts])
        assert_allclose(frequency_hz, whole.frequency_hz, rtol=1e-9)


def test_latency_in_seconds_at_1000_Hz() -> None:
    """What 0.1 Hz asks for; the docs say it."""
    one = PhaseStream.start(signals.one_phase(1.0), rate_hz=RATE).latency_samples
    three = PhaseStream.start(signals.three_phases(0.5), rate_hz=RATE).latency_samples
    assert one / RATE == pytest.approx(33.9, abs=0.1)
    assert three / RATE == pytest.approx(20.5, abs=0.1)
