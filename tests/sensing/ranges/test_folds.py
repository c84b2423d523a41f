"""Folds: a load that weight helps, as currents of the virtual machine's sensors, unfolded."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb import signals
from autodb.proofs.machines.lathe.phases import phases

Array = NDArray[np.float64]

RATE = 1000.0
T = np.arange(30_000) / RATE
MAGNETISING_A = 0.15
INSIDE = slice(2000, -2000)


def _load_A(*turns: tuple[float, float]) -> Array:
    """Return a load, A of range, through the given (s, A)."""
    s, load_A = zip(*turns, strict=True)
    return np.asarray(np.interp(T, s, load_A), dtype=np.float64)


DOWN_UP = _load_A((0, -3), (5, -3), (20, 4), (30, 4))
THERE_AND_BACK = _load_A((0, -3), (3, -3), (12, 3), (18, 3), (27, -3), (30, -3))


def _range_A(load_A: Array) -> Array:
    """Return what the demodulator reads of 2·sqrt(I_mag² + load²) at 16 Hz and 30 dB."""
    true_A = np.sqrt(MAGNETISING_A**2 + load_A**2)
    made = phases(np.random.default_rng(23), true_A, np.full(T.size, 16.0), RATE, 0.02)
    return signals.three_phase_range(*made.values(), rate_hz=RATE).range_A


def _power(load_A: Array) -> Array:
    return load_A + 0.3 * np.random.default_rng(29).standard_normal(load_A.size)


@pytest.mark.parametrize(
    ("load_A", "crossings_s"), [(DOWN_UP, (5 + 15 * 3 / 7,)), (THERE_AND_BACK, (7.5, 22.5))]
)
def test_power_unfolds_the_range_and_says_where(
    load_A: Array, crossings_s: tuple[float, ...]
) -> None:
    found = signals.unfolded(_range_A(load_A), power=_power(load_A), magnetising_A=MAGNETISING_A)
    assert found.reason is None
    assert_allclose([T[row] for row in found.folds], crossings_s, atol=0.2)
    assert_allclose(found.load_A[INSIDE], load_A[INSIDE], atol=0.12)


def test_without_power_the_sign_is_refused_beyond_the_fold() -> None:
    found = signals.unfolded(_range_A(DOWN_UP), begins=-1, magnetising_A=MAGNETISING_A)
    (fold,) = found.folds
    assert_allclose(found.load_A[2000 : fold - 200], DOWN_UP[2000 : fold - 200], atol=0.12)
    assert np.isnan(found.load_A[fold:]).all()
    assert found.reason is not None
    assert f"row {fold}" in found.reason
    assert "the drive's power" in found.reason


def test_a_load_that_keeps_its_sign_has_no_fold() -> None:
    """It falls to 40 %, which is no touch; and power agrees."""
    load_A = _load_A((0, 4), (10, 4), (15, 1.6), (20, 4), (30, 4))
    for power in (None, _power(load_A)):
        found = signals.unfolded(_range_A(load_A), power=power, magnetising_A=MAGNETISING_A)
        assert found.folds == ()
        assert found.reason is None
        assert_allclose(found.load_A[INSIDE], load_A[INSIDE], atol=0.12)


def test_a_touch_with_power_of_one_sign_is_no_fold() -> None:
    load_A = np.abs(DOWN_UP)
    found = signals.unfolded(_range_A(load_A), power=_power(load_A), magnetising_A=MAGNETISING_A)
    assert signals.touches(_range_A(load_A), magnetising_A=MAGNETISING_A)
    assert found.folds == ()
    assert_allclose(found.load_A[INSIDE], load_A[INSIDE], atol=0.12)


def test_power_that_changes_sign_elsewhere_is_refused() -> None:
    power = np.where(T > 25.0, -1.0, 1.0) * _power(DOWN_UP)
    found = signals.unfolded(_range_A(DOWN_UP), power=power, magnetising_A=MAGNETISING_A)
    assert np.isnan(found.load_A).all()
    assert found.reason is not None
    assert "both signs" in found.reason


def test_standing_before_and_after_is_no_fold() -> None:
    moving = (T > 4.0) & (T < 26.0)
    made = phases(np.random.default_rng(31), np.full(T.size, 3.0), np.where(moving, 8.0, 0.0), RATE)
    assert signals.touches(signals.three_phase_range(*made.values(), rate_hz=RATE).range_A) == ()
