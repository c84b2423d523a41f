"""Calibration cuts on both sides of a fold: weight helps the feed, and a force takes it up."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.errors import UnusableInput
from autodb.records.tables import CutTable
from autodb.sensing.ranges import calibration
from autodb.sensing.ranges.chosen import sense_each
from autodb.sensing.ranges.folding import fold_of
from autodb.sensing.ranges.forms import MeasuredCuts

GAIN, BALANCE, NOISE_N, MAGNETISING = 200.0, 150.0, 10.0, 0.3
"""N per ampere of range; the force that takes the weight up, N; a cut's own error; A."""


def _faces(force: list[float], seed: int, *, air: bool = True) -> CutTable:
    """Return faces of forces on an axis that folds at ``BALANCE``."""
    rng = np.random.default_rng(seed)
    true = np.array(force)
    load = true - BALANCE + NOISE_N * rng.standard_normal(true.size)
    channels = {
        "cut": np.arange(1.0, 1.0 + true.size),
        "t": 60.0 * np.arange(true.size),
        "cutting.feed": 0.1 + 0.001 * np.arange(true.size),
        "cutting.depth": np.ones(true.size),
        "spindle.speed": np.full(true.size, 1000.0),
        "x.current.range": np.hypot(MAGNETISING, load / GAIN),
        "force.x": true,
    }
    if air:
        channels["x.current.air"] = np.full(true.size, np.hypot(MAGNETISING, BALANCE / GAIN))
    return CutTable(
        path=Path("faces.csv"), channels=channels, texts={"operation": ["face"] * true.size}
    )


WIDE = [*np.linspace(20.0, 1300.0, 33).tolist()]


@pytest.mark.parametrize("air", [True, False])
def test_forces_beyond_a_fold_are_read_and_those_within_refused(air: bool) -> None:
    """A line through all of them reads 1300 N as about 1000: now within 4 of its own errors."""
    found = calibration.calibrate(_faces(WIDE, 1, air=air), "x")
    assert found.domain is not None
    assert found.domain.fold is not None
    assert_allclose(found.domain.fold.force, 2.0 * BALANCE, rtol=0.1)
    asked = _faces([100.0, 150.0, 250.0, 500.0, 900.0, 1250.0], 2, air=air)
    sensed = sense_each(asked, [found])
    for one in sensed[:3]:
        assert one.force_N is None
        assert re.search(r"x's range folds .* two forces show one range", str(one.reason))
    for one, true in zip(sensed[3:], asked["force.x"][3:], strict=True):
        assert one.force_N is not None
        assert one.sd_N is not None
        assert abs(one.force_N - true) < 4.0 * NOISE_N
        assert one.sd_N < 2.0 * NOISE_N


def test_cuts_that_all_lie_within_the_fold_calibrate_nothing() -> None:
    within = np.linspace(10.0, 280.0, 16).tolist()
    with pytest.raises(UnusableInput, match="range folds where the force takes up the weight"):
        calibration.calibrate(_faces(within, 3), "x")


def test_one_side_of_a_fold_is_no_fold() -> None:
    """Falling alone, or rising alone: each is one force to one range."""
    for low, high in ((10.0, 140.0), (160.0, 900.0)):
        table = _faces(np.linspace(low, high, 20).tolist(), 4)
        current = table["x.current.range"] - table["x.current.air"]
        some = np.ones(20)
        sensed = MeasuredCuts(current, some, some, some, some, some, air=table["x.current.air"])
        assert fold_of(sensed, table["force.x"]) is None
        assert fold_of(replace(sensed, air=None), table["force.x"]) is None
