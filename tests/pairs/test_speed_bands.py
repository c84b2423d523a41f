"""A band of speeds with lower forces is found in all cuts of a pair, and in nothing else."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.pairs.changes.speed_bands import CutsAtSpeeds, speed_band

BAND_M_MIN = (85.0, 110.0)


def _cuts(
    seed: int, *, change: float = -0.25, law: float = 0.0, both: bool = True, days: int = 4
) -> CutsAtSpeeds:
    """Return ten cuts of each day, two of them in a band of speeds in which forces ``change``.

    Faster ones are at 120 to 270 m/min; forces grow with the edge's time, a day is off by 4 %.
    ``law``: the exponent in speed that a law is off by; ``both``: whether both components change.
    """
    rng = np.random.default_rng(seed)
    day = np.repeat(np.arange(days), 10)
    slow = np.tile(np.arange(10) < 2, days)
    speed = np.where(slow, rng.uniform(*BAND_M_MIN, len(day)), rng.uniform(120.0, 270.0, len(day)))
    beside = rng.uniform(0.0, 1.0, (len(day), 3))
    off = rng.normal(0.0, 0.04, (len(day), 2)) + 0.04 * rng.standard_normal((days, 2))[day]
    off += 0.2 * beside[:, 2:] + law * np.log(speed / 150.0)[:, None]
    off[slow, 0] += np.log1p(change)
    off[slow, 1] += np.log1p(change if both else -change)
    return CutsAtSpeeds(off, np.full_like(off, 0.04), day, day, speed, beside)


def test_a_band_is_found_though_no_slower_cut_is_there() -> None:
    for seed in range(8):
        found = speed_band(_cuts(seed))
        assert found is not None
        assert 75.0 < found.centre_m_min < 115.0
        assert_allclose(found.change, -0.25, atol=0.12)
        assert found.inside.sum() >= 3


@pytest.mark.parametrize("what", [{"change": 0.0}, {"change": 0.0, "law": 0.3}, {"both": False}])
def test_a_law_of_the_speed_is_no_band_nor_is_what_is_not_lower_in_all(
    what: dict[str, float],
) -> None:
    found = [speed_band(_cuts(seed, **what)) for seed in range(12)]  # type: ignore[arg-type]
    assert found == [None] * 12


def test_slow_cuts_that_take_more_are_seldom_a_band() -> None:
    assert sum(speed_band(_cuts(seed, change=0.25)) is not None for seed in range(12)) <= 2


def test_what_one_day_has_is_its_own() -> None:
    cuts = _cuts(3)
    assert speed_band(replace(cuts, recording=np.zeros_like(cuts.recording))) is None


def test_a_component_that_is_not_sensed_is_not_asked() -> None:
    cuts = _cuts(1, change=-0.35)
    cuts.off[:, 1] = np.nan
    found = speed_band(cuts)
    assert found is not None
    assert found.change[0] < -0.2
    assert np.isnan(found.change[1])


def test_where_nothing_is_sensed_or_no_speed_differs_there_is_none() -> None:
    cuts = _cuts(1)
    assert speed_band(replace(cuts, off=np.full_like(cuts.off, np.nan))) is None
    assert speed_band(replace(cuts, speed_m_min=np.full_like(cuts.speed_m_min, 90.0))) is None
