"""The two kinds of error are separated, and outliers and lonely cuts are named."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy.stats import binom

from autodb.fitting import optimum
from autodb.fitting.groups import components, small_sample
from autodb.fitting.linear import least_squares
from autodb.sensing.ranges.error_kinds import ErrorKinds, FittedCuts, error_kinds_of, slow
from autodb.sensing.ranges.forms import LINE, MeasuredCuts
from autodb.sensing.ranges.outliers import Outlier, outlier_sentences, outliers
from tests.helpers.campaigns import first

Array = NDArray[np.float64]
CUTS = 400
FORCE_N = 500.0
OWN_N = 25.0
ALIKE = np.array([[20.0**2, 0.0], [0.0, 0.0]])
OPPOSED = np.array([[150.0**2, -0.97 * 150.0 * 0.35], [-0.97 * 150.0 * 0.35, 0.35**2]])


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
    columns = np.column_stack([np.ones(CUTS), estimate_N])
    none = np.zeros((2, 2))
    cuts = FittedCuts(estimate_N, error_N, columns, none, None, np.zeros(CUTS), np.zeros(CUTS))
    return error_kinds_of(cuts, rmse=rmse, day_share=day_share, reference_share=0.0)[0]


def _wander(kinds: ErrorKinds) -> float:
    """Return the relative standard deviation of what wanders at the mean force."""
    assert kinds.group is not None
    return float(np.sqrt(kinds.gain_share**2 + kinds.group[0, 0] / FORCE_N**2))


def test_a_wandering_gain_and_a_cuts_own_error_come_apart() -> None:
    for seed in range(20):
        kinds = _kinds(seed, 0.05, 20.0, 0.0)
        assert_allclose(_wander(kinds), 0.05, rtol=0.25)
        assert_allclose(kinds.cut_sd, 20.0, rtol=0.2)


def test_a_wandering_offset_is_no_gain() -> None:
    rng = np.random.default_rng(3)
    estimate_N = rng.uniform(0.1, 3.0, 4000) * FORCE_N
    phase = 2.0 * np.pi * np.arange(4000) / 60.0
    offset_N = 30.0 * np.sqrt(2.0) * np.sin(phase)
    for wander, truth in (
        (offset_N, (30.0**2, 0.0)),
        (offset_N / 600.0 * estimate_N, (0, 0.05**2)),
    ):
        found = slow(estimate_N, wander + 10.0 * rng.standard_normal(4000))
        assert_allclose(found * [1.0, 600.0**2], np.array(truth) * [1.0, 600.0**2], atol=250.0)


def test_errors_of_cuts_by_themselves_show_no_wander() -> None:
    """n = 400 tables; each shows one by chance with a probability of 2.3 %, two sigma."""
    shown = sum(slow(*_wandering(seed, 0.0, 20.0)).any() for seed in range(400))
    assert shown <= 22


def test_a_day_that_showed_nothing_counts_with_the_difference_that_is_known() -> None:
    kinds = _kinds(4, 0.0, 20.0, 0.042)
    assert_allclose(kinds.gain_share, 0.042)
    assert_allclose(kinds.cut_sd, 20.0, rtol=0.1)


def test_a_long_session_that_showed_it_all_has_it_once() -> None:
    shown, known = _kinds(5, 0.06, 5.0, 0.0), _kinds(5, 0.06, 5.0, 0.042)
    assert _wander(shown) > 0.05
    assert_allclose(known.gain_share, shown.gain_share)


def test_what_is_shared_scales_the_whole_force() -> None:
    shared = ErrorKinds(cut_sd=1.0, gain_share=0.03, reference_share=0.04).shared(
        np.array([10.0, 200.0])
    )
    assert_allclose(np.sqrt(np.diag(shared)), [0.5, 10.0])
    assert_allclose(shared[0, 1], 0.05**2 * 2000.0)


def test_an_offset_is_a_column_of_its_own_and_a_groups_gain_scales() -> None:
    group = np.array([[16.0, -0.6], [-0.6, 0.09]])
    scaling = np.array([10.0, 200.0])
    shared = ErrorKinds(1.0, 0.0, 0.0, group).shared(scaling)
    assert_allclose(shared[:2, :2], 0.09 * np.outer(scaling, scaling))
    assert_allclose(shared[2], [-6.0, -120.0, 16.0])


@pytest.mark.parametrize(("groups", "between"), first(1, [(5, OPPOSED), (5, ALIKE), (20, OPPOSED)]))
def test_intervals_hold_the_cuts_of_a_new_group(groups: int, between: Array) -> None:
    """n = 200 tables; one cut of a new group each. 99.9 % binomial limits around 95 %.

    Without what groups share, cuts of a few groups that differ clearly are held too rarely.
    """
    rng, root = np.random.default_rng(groups), np.linalg.cholesky(between + 1e-9 * np.eye(2))
    held = alone = 0
    for _ in range(200):
        cuts, new = _grouped(rng, root, groups), _grouped(rng, root, 1)
        law = least_squares(_columns(cuts[0]), cuts[1])
        error, none = law.residual, np.zeros_like(law.residual)
        fitted = FittedCuts(
            cuts[1] - error, error, _columns(cuts[0]), law.covariance, cuts[2], none, none
        )
        rmse = float(np.sqrt(error @ error / (len(error) - 2)))
        kinds, covariance = error_kinds_of(fitted, rmse=rmse, day_share=0.0, reference_share=0.0)
        shared = kinds.shared(law.coefficients)
        shared[:2, :2] += covariance
        at = np.append(_columns(new[0])[0], 1.0)
        off = abs(float(new[1][0] - at[:2] @ law.coefficients))
        held += off < 1.96 * np.sqrt(kinds.cut_sd**2 + at @ shared @ at)
        alone += off < 1.96 * np.sqrt(rmse**2 + at[:2] @ law.covariance @ at[:2])
    low, high = (int(binom.ppf(p, 200, 0.95)) for p in (0.0005, 0.9995))
    assert low <= held <= high
    if between is OPPOSED and groups == 5:
        assert alone < low


def _grouped(
    rng: np.random.Generator, root: NDArray[np.floating], groups: int
) -> tuple[Array, Array, Array]:
    """Twelve cuts of each group: current, force, and the group, which has its offset and gain."""
    of = np.repeat(np.arange(groups), 12)
    current = rng.uniform(1.0, 4.0, len(of))
    offset_N, gain = root @ rng.standard_normal((2, groups))
    force_N = 200.0 * current * (1.0 + gain[of]) + offset_N[of]
    return current, force_N + OWN_N * rng.standard_normal(len(of)), of.astype(np.float64)


def _columns(current: Array) -> Array:
    return np.column_stack([np.ones_like(current), current])


def test_components_of_variance_are_recovered() -> None:
    rng, root = np.random.default_rng(8), np.linalg.cholesky(OPPOSED)
    current, force_N, groups = _grouped(rng, root, 300)
    columns, shared = _columns(current), _columns(200.0 * current)
    found = components(columns, shared, force_N, groups, known=np.zeros(len(groups)))
    assert_allclose(np.sqrt(found.own), OWN_N, rtol=0.04)
    assert_allclose(found.between, OPPOSED, rtol=0.2)
    assert_allclose(found.widened, found.between * small_sample(299))


def test_a_variance_that_is_known_is_not_counted_again() -> None:
    rng, root = np.random.default_rng(9), np.linalg.cholesky(OPPOSED)
    current, force_N, groups = _grouped(rng, root, 300)
    known = rng.uniform(0.0, 60.0, len(groups)) ** 2
    noisy_N = force_N + np.sqrt(known) * rng.standard_normal(len(groups))
    columns, shared = _columns(current), _columns(200.0 * current)
    found = components(columns, shared, noisy_N, groups, known=known)
    assert_allclose(np.sqrt(found.own), OWN_N, rtol=0.1)


def test_groups_of_one_row_tell_nothing_of_what_they_share() -> None:
    rng = np.random.default_rng(10)
    columns, force_N = _columns(rng.uniform(1.0, 4.0, 30)), rng.standard_normal(30)
    found = components(columns, columns, force_N, np.arange(30.0), known=np.zeros(30))
    assert not found.between.any()
    assert_allclose(found.own, least_squares(columns, force_N).residual @ force_N / 28.0)


def _named(seed: int, *, off_N: float, lone_A: float | None) -> tuple[Outlier, ...]:
    rng = np.random.default_rng(seed)
    current = rng.uniform(1.0, 5.0, 40)
    if lone_A is not None:
        current[7] = lone_A
    nothing = np.full(40, np.nan)
    sensed = MeasuredCuts(current, nothing, nothing, nothing, nothing, nothing)
    target = 30.0 + 200.0 * current + 10.0 * rng.standard_normal(40)
    target[7] += off_N
    law = LINE.fit(sensed, target)
    error = target - LINE.value(law.coefficients, sensed)
    return outliers(law, LINE.slopes(law.coefficients, sensed), error, np.arange(1.0, 41.0))


def test_a_cut_off_the_law_is_named_with_its_residual() -> None:
    for seed in range(20):
        named = [one for one in _named(seed, off_N=70.0, lone_A=None) if one.off]
        assert [one.cut for one in named] == [8.0]
        assert named[0].studentised > 4.0
        assert outlier_sentences(named)[0].startswith("1 cut (8) deviates from the fit")


def test_a_cut_that_holds_the_slope_alone_is_named_though_it_fits() -> None:
    lone = [one for one in _named(3, off_N=0.0, lone_A=25.0) if one.alone]
    assert [one.cut for one in lone] == [8.0]
    assert lone[0].leverage > 0.5
    assert not lone[0].off


def test_sound_cuts_are_rarely_named_for_their_residual() -> None:
    """n = 200 tables, 5 % each: 15 expected, and 31 has a chance below 0.01 %."""
    wrong = sum(any(one.off for one in _named(seed, off_N=0.0, lone_A=None)) for seed in range(300))
    assert wrong <= 30


@pytest.mark.parametrize("seed", [7, 24, 25, 28, 41])
def test_what_groups_do_not_share_leaves_the_rest_single(
    monkeypatch: pytest.MonkeyPatch, seed: int
) -> None:
    """Groups differ in slope alone: with a triangular root climbs went along a circle on which the
    likelihood is one, and these five of sixty took from 21 to over 50 steps to end."""
    monkeypatch.setattr(optimum, "MOST_STEPS", 8)
    rng = np.random.default_rng(seed)
    groups = np.repeat(np.arange(22), 11)
    x = rng.uniform(0.0, 1.0, groups.size)
    slopes = 0.95 * rng.normal(size=22)
    columns = np.column_stack([np.ones_like(x), x])
    force_N = columns @ [1.0, 2.0] + slopes[groups] * (x - x.mean()) + rng.normal(size=x.size)
    found = components(columns, columns, force_N, groups, known=np.zeros(groups.size))
    at_mean = np.array([1.0, x.mean()])
    assert found.own == pytest.approx(1.0, rel=0.3)
    assert at_mean @ found.between @ at_mean < 0.02 * found.own
    assert found.between[1, 1] < 3.0 * 0.95**2
