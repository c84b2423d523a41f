"""The drift of a sensor that chips heat: with what it comes, and by how many time constants."""

import numpy as np
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy import signal

from autodb.sensing.table.heat import Heat, heat_of

Array = NDArray[np.float64]
Rows = NDArray[np.bool_]

RATE_HZ = 100.0
LEVEL_N = np.array([6.0, -5.0, 40.0])
FORCE_N = np.array([60.0, 90.0, 20.0])
T = np.arange(0.0, 240.0, 1.0 / RATE_HZ)
PASSES = [(10.0 + 14.0 * k, 20.0 + 14.0 * k, share) for k, share in enumerate([0.4, 1.6] * 6)]
"""Twelve passes of 10 s with 4 s between them, light ones and heavy ones in turn."""


def _cut() -> tuple[Rows, Array]:
    """Return where it cuts (n,), and by what share of FORCE_N (n,)."""
    share = sum(size * ((begin < T) & (end > T)) for begin, end, size in PASSES)
    return np.asarray(share) > 0.0, np.asarray(share, dtype=np.float64)


def _warmed(heat: Array, time_s: float) -> Array:
    """Return T du/dt = heat − u by small steps, written out."""
    u: Array = np.zeros(len(heat))
    for k in range(1, len(heat)):
        u[k] = u[k - 1] + (heat[k - 1] - u[k - 1]) / (RATE_HZ * time_s)
    return u


def _found(heated: Array) -> Heat:
    """Return what is found of a course of heating (n,), read with noise and a zero off by 3 N."""
    cutting, share = _cut()
    noise = np.random.default_rng(4).standard_normal((3, len(T)))
    tooth = 1.0 + 0.5 * np.sin(2.0 * np.pi * 17.0 * T)
    left = FORCE_N[:, None] * share * tooth + LEVEL_N[:, None] * heated + 0.5 * noise + 3.0
    return heat_of(left, cutting, T)


def _off_N(found: Heat, heated: Array) -> float:
    """Return the rms error of the drift in z where it cuts."""
    cutting, _ = _cut()
    off = found.drift_N[2] - 3.0 - LEVEL_N[2] * heated
    return float(np.sqrt(np.mean(off[cutting] ** 2)))


def test_heat_that_comes_with_the_force_is_found_as_such() -> None:
    """As long as it cuts would leave light and heavy passes alike: more than 1.5 N off."""
    _, share = _cut()
    heated = _warmed(share, 12.0)
    found = _found(heated)
    assert found.by_force
    assert_allclose(found.times_s, [12.0], rtol=0.15)
    assert _off_N(found, heated) < 0.4


def test_heat_that_comes_as_long_as_it_cuts_is_found_as_such() -> None:
    cutting, _ = _cut()
    heated = _warmed(cutting.astype(np.float64), 12.0)
    found = _found(heated)
    assert not found.by_force
    assert len(found.times_s) == 1
    assert _off_N(found, heated) < 0.4


def test_two_time_constants_are_found_where_there_are_two() -> None:
    """The top within 5 s, the whole within 60 s; one alone is off by 1 N and more."""
    _, share = _cut()
    heated = 0.6 * _warmed(share, 5.0) + 0.4 * _warmed(share, 60.0)
    found = _found(heated)
    quick, slow = found.times_s
    assert 3.0 <= quick <= 10.0
    assert 30.0 <= slow <= 200.0
    assert 0.4 <= found.share <= 0.8
    assert _off_N(found, heated) < 0.4


def test_what_is_not_known_of_a_drift_is_in_its_variance() -> None:
    _, share = _cut()
    heated = 0.6 * _warmed(share, 5.0) + 0.4 * _warmed(share, 60.0)
    found = _found(heated)
    cutting, _ = _cut()
    off = found.drift_N - 3.0 - LEVEL_N[:, None] * heated
    assert np.mean(np.abs(off[:, cutting]) < 1.96 * np.sqrt(found.variance[:, cutting])) > 0.95


def test_between_little_air_a_drift_is_not_taken_as_known() -> None:
    """A cut of 20 s between 1.5 s of air, whose heat grows faster than its force: the drift of z
    errs by 10 N, and its variance says so.
    """
    t = np.arange(0.0, 23.0, 1.0 / RATE_HZ)
    cutting = (t > 1.5) & (t < 21.5)
    keep = np.exp(-1.0 / (8.0 * RATE_HZ))
    held = []
    for seed in range(12):
        rng = np.random.default_rng([5, seed])
        fresh = rng.standard_normal((3, len(t))) * np.sqrt(1.0 - keep**2)
        wander = signal.lfilter([1.0], [1.0, -keep], fresh, axis=1)
        heavy = (t - 1.5) % 10.0 >= 5.0
        share = cutting * np.where(heavy, 1.5, 0.5)
        heated = LEVEL_N[:, None] * _warmed(np.where(cutting, np.where(heavy, 2.2, 0.3), 0.0), 6.0)
        noise = 0.5 * rng.standard_normal((3, len(t)))
        found = heat_of(FORCE_N[:, None] * share + heated + wander + noise, cutting, t)
        off = found.drift_N - heated
        held.append(np.abs(off[:, cutting]) < 1.96 * np.sqrt(found.variance[:, cutting]))
    assert np.mean(held) > 0.85


def test_without_air_no_drift_is_estimated_and_it_says_so() -> None:
    t = np.arange(0.0, 5.0, 0.01)
    found = heat_of(np.ones((3, len(t))), t > 0.2, t)
    assert found.times_s == ()
    assert "1 s of air before and after" in str(found.why)
    assert not found.drift_N.any()
    assert heat_of(np.ones((3, len(t))), t > 9.0, t).why == "nothing is cut"
