"""The two kinds of error are told apart, and outliers and lonely cuts are named."""

import numpy as np
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.sensing.error_kinds import ErrorKinds, apart, slow_share
from autodb.sensing.forms import LINE, Felt
from autodb.sensing.outliers import Outlier, outliers, sentences

Array = NDArray[np.float64]
CUTS = 400
FORCE_N = 500.0


def _wandering(seed: int, share: float, own_N: float) -> tuple[Array, Array]:
    """Estimates, and errors of a gain that wanders over 60 cuts and of cuts by themselves."""
    rng = np.random.default_rng(seed)
    estimate_N = rng.uniform(0.5, 1.5, CUTS) * FORCE_N
    phase = rng.uniform(0.0, 2.0 * np.pi)
    gain = share * np.sqrt(2.0) * np.sin(2.0 * np.pi * np.arange(CUTS) / 60.0 + phase)
    return estimate_N, gain * estimate_N + own_N * rng.standard_normal(CUTS)


def _kinds(seed: int, share: float, own_N: float, day_share: float) -> ErrorKinds:
    estimate_N, error_N = _wandering(seed, share, own_N)
    rmse = float(np.sqrt(np.mean(error_N**2)))
    return apart(estimate_N, error_N, rmse=rmse, day_share=day_share, reference_share=0.0)


def test_a_wandering_gain_and_a_cuts_own_error_come_apart() -> None:
    for seed in range(20):
        kinds = _kinds(seed, 0.05, 20.0, 0.0)
        assert_allclose(kinds.gain_share, 0.05, rtol=0.25)
        assert_allclose(kinds.cut_sd, 20.0, rtol=0.2)


def test_errors_of_cuts_by_themselves_show_no_wander() -> None:
    """n = 400 tables; each shows one by chance with a probability of 2.3 %, two sigma."""
    shown = sum(slow_share(*_wandering(seed, 0.0, 20.0)) > 0 for seed in range(400))
    assert shown <= 22


def test_a_day_that_showed_nothing_has_its_share_twice() -> None:
    kinds = _kinds(4, 0.0, 20.0, 0.042)
    assert_allclose(kinds.gain_share, np.sqrt(2.0) * 0.042)
    assert_allclose(kinds.cut_sd, 20.0, rtol=0.1)


def test_a_long_session_that_showed_it_all_has_it_once() -> None:
    kinds = _kinds(5, 0.06, 5.0, 0.042)
    shown = slow_share(*_wandering(5, 0.06, 5.0))
    assert_allclose(kinds.gain_share, shown)


def test_what_is_shared_scales_the_whole_force() -> None:
    shared = ErrorKinds(cut_sd=1.0, gain_share=0.03, reference_share=0.04).shared(
        np.array([10.0, 200.0])
    )
    assert_allclose(np.sqrt(np.diag(shared)), [0.5, 10.0])
    assert_allclose(shared[0, 1], 0.05**2 * 2000.0)


def _named(seed: int, *, off_N: float, lone_A: float | None) -> tuple[Outlier, ...]:
    rng = np.random.default_rng(seed)
    current = rng.uniform(1.0, 5.0, 40)
    if lone_A is not None:
        current[7] = lone_A
    nothing = np.full(40, np.nan)
    felt = Felt(current, nothing, nothing, nothing, nothing, nothing)
    target = 30.0 + 200.0 * current + 10.0 * rng.standard_normal(40)
    target[7] += off_N
    law = LINE.fit(felt, target)
    error = target - LINE.value(law.coefficients, felt)
    return outliers(law, LINE.slopes(law.coefficients, felt), error, np.arange(1.0, 41.0))


def test_a_cut_off_the_law_is_named_with_its_residual() -> None:
    for seed in range(20):
        named = [one for one in _named(seed, off_N=70.0, lone_A=None) if one.off]
        assert [one.cut for one in named] == [8.0]
        assert named[0].studentised > 4.0
        assert sentences(named)[0].startswith("1 cut (8) more than chance off")


def test_a_cut_that_holds_the_slope_alone_is_named_though_it_fits() -> None:
    lone = [one for one in _named(3, off_N=0.0, lone_A=25.0) if one.alone]
    assert [one.cut for one in lone] == [8.0]
    assert lone[0].leverage > 0.5
    assert not lone[0].off


def test_sound_cuts_are_rarely_named_for_their_residual() -> None:
    """n = 300 tables, 5 % each: 15 expected, and 31 has a chance below 0.01 %."""
    wrong = sum(any(one.off for one in _named(seed, off_N=0.0, lone_A=None)) for seed in range(300))
    assert wrong <= 30
