"""Repeats of one cut: process and sensing apart, P1's table 2, and what moved over a run."""

from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.sensing.ranges.repeated_cut import moved_between, pooled_sd
from autodb.sensing.ranges.repeats import (
    Repeats,
    Sample,
    equal_means,
    equal_variances,
    repeats,
    sample,
    variance_interval,
)

N = 12
REFERENCE = {"y": Sample(N, 485.78, 84.0), "z": Sample(N, 325.78, 320.0)}
ESTIMATE = {"y": Sample(N, 465.21, 425.0), "z": Sample(N, 326.87, 580.0)}
"""P1 table 2, rows 1 and 2."""
RUNS = 2000
BAND = (0.935, 0.965)
"""95 % of 2000 runs, at 99.9 %: ± 1.6 percentage points, and rounded."""


def test_published_verdicts_at_5_percent() -> None:
    """P1 section 12: the means of Fz agree, those of Fy differ."""
    assert not equal_means(REFERENCE["z"], ESTIMATE["z"]).differ
    found = equal_means(REFERENCE["y"], ESTIMATE["y"])
    assert found.differ
    # by hand: −20.57 / √((84 + 425)/12)
    assert_allclose(found.statistic, -3.158, atol=0.001)


def test_published_variances() -> None:
    """F 1.81 for z and 5.06 for y, by hand; only y's estimate scatters beyond the process."""
    z, y = (equal_variances(REFERENCE[c], ESTIMATE[c]) for c in "zy")
    assert_allclose((z.statistic, y.statistic), (1.8125, 5.0595), atol=1e-4)
    assert z.dof == (11.0, 11.0)
    assert (z.differ, y.differ) == (False, True)


def test_published_difference_of_variances() -> None:
    """Row 3 is row 2 less row 1: 260 N² as printed for z; for y 341 N², where 383 is printed."""
    left = {c: ESTIMATE[c].variance - REFERENCE[c].variance for c in "yz"}
    assert left == {"z": 260.0, "y": 341.0}


def _run(rng: np.random.Generator, *, bias: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Return P1's tangential force: process sd 9.2 N, sensing 18.5 N."""
    force = 486.0 + 9.2 * rng.standard_normal(N)
    return force, force + bias + 18.5 * rng.standard_normal(N)


@cache
def _unbiased() -> list[Repeats]:
    """Return what is found of RUNS runs without a bias; once for all tests."""
    rng = np.random.default_rng(51)
    return [repeats(*_run(rng)) for _ in range(RUNS)]


def test_intervals_hold_and_pairs_scatter_less_than_a_subtraction() -> None:
    found = _unbiased()
    for part, sd in (("process", 9.2), ("sensing", 18.5)):
        held = np.mean([v.low <= sd**2 <= v.high for v in (getattr(r, part) for r in found)])
        assert BAND[0] < held < BAND[1], part
    paired = [r.sensing.value for r in found]
    subtracted = [r.by_subtraction for r in found]
    assert_allclose(np.mean(paired), 18.5**2, rtol=0.03)
    assert_allclose(np.mean(subtracted), 18.5**2, rtol=0.03)
    assert np.std(subtracted) > 1.2 * np.std(paired)
    assert min(paired) > 0 > min(subtracted)


def test_a_bias_is_seen_in_pairs_first() -> None:
    rng = np.random.default_rng(52)
    assert_allclose(np.mean([r.bias.differ for r in _unbiased()]), 0.05, atol=0.016)
    shifted = [repeats(*_run(rng, bias=-20.6)) for _ in range(RUNS)]
    assert np.mean([r.bias.differ for r in shifted]) > np.mean([r.means.differ for r in shifted])


def test_repeats_are_described_in_sentences() -> None:
    found = repeats(*_run(np.random.default_rng(53), bias=-60.0))
    first, split, tests, shift = found.lines("N")
    assert first.startswith("12 repeats: reference and estimate 4")
    assert f"process sd {np.sqrt(found.process.value):.3g} N (" in split
    assert "means differ (t -" in tests
    assert shift.startswith("estimate less reference -")
    assert "in pairs differ" in shift


def test_what_is_no_repeat_is_refused() -> None:
    with pytest.raises(ValueError, match="1 repeats; 2 or more"):
        sample(np.array([3.0]))
    with pytest.raises(ValueError, match="3 references and 2 estimates"):
        repeats(np.zeros(3), np.zeros(2))
    assert variance_interval(Sample(2, 0.0, 1.0)).high > 1.0


def _plan(rng: np.random.Generator, *, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Five conditions three times, the first once more at the end, ``step`` A higher."""
    conditions = np.array([*np.tile(np.arange(5), 3), 0])
    current = 2.0 + 0.5 * conditions + 0.05 * rng.standard_normal(16)
    current[-1] += step
    return current, conditions


def test_what_moved_is_said_with_an_interval_that_holds() -> None:
    rng = np.random.default_rng(54)
    made = [moved_between(*_plan(rng, step=0.4), first=[0], last=[15]) for _ in range(RUNS)]
    held = np.mean([m.low <= 0.4 <= m.high for m in made])
    assert BAND[0] < held < BAND[1]
    assert np.mean([m.beyond for m in made]) > 0.95
    still = [moved_between(*_plan(rng, step=0.0), first=[0], last=[15]) for _ in range(RUNS)]
    assert_allclose(np.mean([m.beyond for m in still]), 0.05, atol=0.016)
    assert "more than repeats scatter" in made[0].sentence("z.current.range", "A")


def test_what_cannot_be_compared_is_refused() -> None:
    current, conditions = _plan(np.random.default_rng(55), step=0.0)
    with pytest.raises(ValueError, match="several conditions"):
        moved_between(current, conditions, first=[0], last=[14])
    with pytest.raises(ValueError, match="no condition was repeated"):
        moved_between(current[:6], np.array([0, 1, 2, 3, 4, 0]), first=[0], last=[5])
    assert pooled_sd(np.array([1.0, 3.0]), np.array([0, 0])) == (np.sqrt(2.0), 1)
