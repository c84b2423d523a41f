"""Currents with an error of their own: slopes are not flattened, and intervals hold."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy.stats import binom

from autodb.fitting.linear import Undetermined
from autodb.records.tables import CutTable
from autodb.sensing.ranges import calibration
from autodb.sensing.ranges.forms import LINE, LINE_OF_SPEED, POWER, CurrentForm, MeasuredCuts
from autodb.sensing.ranges.sensed_force import sense
from tests.helpers.campaigns import first

Array = NDArray[np.float64]
CUTS = 80
TRUTH: tuple[tuple[CurrentForm, Array, int], ...] = (
    (LINE, np.array([30.0, 200.0]), 1),
    (LINE_OF_SPEED, np.array([30.0, 200.0, -15.0]), 1),
    (POWER, np.array([0.4, 0.93, np.log(1570.0)]), 1),
)


def _sensed(rng: np.random.Generator, n: int) -> MeasuredCuts:
    current, feed_mm_s = rng.uniform(2.0, 20.0, n), rng.uniform(1.0, 15.0, n)
    rpm, some = rng.uniform(800.0, 2400.0, n), np.ones(n)
    return MeasuredCuts(current, feed_mm_s, rpm, some, some, 30.0 * some)


def _read(rng: np.random.Generator, sensed: MeasuredCuts, share: float) -> MeasuredCuts:
    """Currents read with an error, of each cut another, ``share`` of their spread on average."""
    sd = share * float(np.std(sensed.current)) * rng.uniform(0.4, 1.5, len(sensed.current))
    off = sd * rng.standard_normal(len(sd))
    return replace(sensed, current=sensed.current + off, stated_sd=sd)


def _exact(sensed: MeasuredCuts) -> MeasuredCuts:
    return replace(sensed, stated_sd=None)


@pytest.mark.parametrize(("form", "truth", "which"), TRUTH)
def test_slope_and_exponent_are_not_flattened(form: CurrentForm, truth: Array, which: int) -> None:
    """n = 200 tables of 80 cuts: least squares is off by many standard errors of the mean, this by
    less than 3.3 (99.9 %), and its own standard deviation is true to 20 %.
    """
    rng, plain, ours, z = np.random.default_rng(5), [], [], []
    for _ in range(200):
        true = _sensed(rng, CUTS)
        force = form.value(truth, true)
        target = force + 0.1 * np.std(force) * rng.standard_normal(CUTS)
        read = _read(rng, true, 0.15)
        law = form.fit(read, target)
        plain.append(form.fit(_exact(read), target).coefficients[which])
        ours.append(law.coefficients[which])
        z.append((ours[-1] - truth[which]) / np.sqrt(law.covariance[which, which]))
    error = float(np.std(ours)) / np.sqrt(200.0)
    assert abs(np.mean(ours) - truth[which]) < 3.3 * error
    assert truth[which] - np.mean(plain) > 6.0 * error
    assert 0.8 < np.sqrt(np.mean(np.square(z))) < 1.2


@pytest.mark.parametrize(("form", "truth", "which"), TRUTH)
def test_without_errors_it_is_least_squares(form: CurrentForm, truth: Array, which: int) -> None:
    del which
    rng = np.random.default_rng(6)
    sensed = _sensed(rng, CUTS)
    target = form.value(truth, sensed) * rng.normal(1.0, 0.05, CUTS)
    least = form.fit(sensed, target)
    for sd in (0.0, 1e-7, np.nan):
        stated = MeasuredCuts(
            sensed.current, sensed.feed_mm_s, sensed.speed_rpm, sensed.feed_mm, sensed.depth_mm,
            np.full(CUTS, sd),
        )  # fmt: skip
        law = form.fit(stated, target)
        assert_allclose(law.coefficients, least.coefficients, rtol=1e-3)
        assert_allclose(law.covariance, least.covariance, rtol=1e-2, atol=1e-12)


def test_currents_that_are_all_error_hold_no_line() -> None:
    rng = np.random.default_rng(7)
    current = 5.0 + rng.standard_normal(CUTS)
    some = np.ones(CUTS)
    sensed = MeasuredCuts(current, some, some, some, some, some, np.full(CUTS, 0.95))
    with pytest.raises(Undetermined):
        LINE.fit(sensed, 30.0 + 200.0 * current + rng.standard_normal(CUTS))


def test_a_cut_without_an_error_of_its_own_has_the_others() -> None:
    some = np.ones(3)
    sensed = MeasuredCuts(some, some, some, some, some, some, np.array([0.3, np.nan, 0.4]))
    assert_allclose(sensed.current_sd, [0.3, np.sqrt(0.125), 0.4])


@pytest.mark.parametrize("n", first(1, [60, 200]))
def test_intervals_of_cuts_hold_whatever_their_currents_errors(n: int) -> None:
    """n calibrations, two cuts of each: one read well, one badly. 99.9 % binomial limits."""
    rng, held = np.random.default_rng(11), np.zeros(2)
    for _ in range(n):
        known = _table(rng, np.tile([0.02, 0.05, 0.1], 9))
        found = calibration.calibrate(known, "z")
        new = _table(rng, np.array([0.02, 2.0]))
        sensed = sense(new, found)
        shared = np.einsum("ij,jk,ik->i", sensed.common, found.shared_covariance, sensed.common)
        held += np.abs(sensed.force_N - new["force.z"]) < 1.96 * np.sqrt(sensed.sd_N**2 + shared)
        assert sensed.sd_N[1] > 100.0
    low, high = (int(binom.ppf(p, n, 0.95)) for p in (0.0005, 0.9995))
    assert np.all((low <= held) & (held <= high)), held


def _table(rng: np.random.Generator, sd_A: Array) -> CutTable:
    """Cuts of a z drive of 100 N/A, range and air each read with 1/√2 of an error."""
    n = len(sd_A)
    rise_A = rng.uniform(2.0, 9.0, n)
    part = np.asarray(sd_A / np.sqrt(2.0), dtype=np.float64)
    return CutTable(
        path=Path("cuts.csv"),
        channels={
            "cut": np.arange(1.0, n + 1.0),
            "z.current.range": 4.0 + rise_A + part * rng.standard_normal(n),
            "z.current.range.sd": part,
            "z.current.air": 4.0 + part * rng.standard_normal(n),
            "z.current.air.sd": part,
            "tool.edge": (np.arange(n) // 4).astype(np.float64),
            "force.z": 20.0 + 100.0 * rise_A + 12.0 * rng.standard_normal(n),
        },
        texts={},
    )
