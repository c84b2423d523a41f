"""Sines over places that are not evenly spaced: the strongest, and others beside it."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.signals.waves import WhiteSines, strongest_wave, waves_beside


@pytest.mark.parametrize("waves", [1.3, 7.0, 23.45, 180.2])
def test_waves_over_a_range_run_to_and_fro(waves: float) -> None:
    """Of 4000 places at random and noise of the sine's own size, to a twentieth of a wave."""
    rng = np.random.default_rng(round(waves))
    place = rng.uniform(-30.0, 50.0, 4000)
    phase = 2.0 * np.pi * waves * (place - place.min()) / np.ptp(place)
    found = strongest_wave(
        place, np.cos(phase + 1.0) + rng.normal(size=4000), np.ones_like, fewest=1.0
    )
    assert found is not None
    assert_allclose(found[0], waves, atol=0.05)


def test_waves_that_differ_by_little_are_found_to_differ_by_as_little() -> None:
    place = np.random.default_rng(5).uniform(0.0, 1.0, 4000)
    found = []
    for waves in (23.456, 23.459):
        sine = np.cos(2.0 * np.pi * waves * (place - place.min()) / np.ptp(place))
        one = strongest_wave(place, sine, np.ones_like, fewest=1.0)
        assert one is not None
        found.append(one[0])
    assert_allclose(found[1] - found[0], 0.003, atol=2e-4)


def test_a_wave_of_little_more_than_two_rows_is_found() -> None:
    """One speed, 930 rows: 360 waves, as a motor's slots pass."""
    place = np.linspace(0.0, 300.0, 930)
    found = strongest_wave(place, np.cos(2.0 * np.pi * 1.2 * place), np.ones_like, fewest=2.5)
    assert found is not None
    assert_allclose(found[0], 360.0, atol=0.05)


def test_fewer_waves_than_asked_are_not_looked_for_and_nothing_where_nothing_moves() -> None:
    place = np.linspace(0.0, 1.0, 2000)
    found = strongest_wave(place, np.cos(2.0 * np.pi * 1.5 * place), np.ones_like, fewest=2.5)
    assert found is not None
    assert found[0] > 2.0
    assert strongest_wave(np.ones(2000), place, np.ones_like, fewest=2.5) is None


@pytest.mark.parametrize("heights", [{14.0: 1.0}, {14.0: 1.0, 7.0: 0.6, 28.3: 0.4, 84.0: 0.2}])
def test_waves_that_stand_out_are_all_found_and_no_others(heights: dict[float, float]) -> None:
    """In noise of half the first one's height, whose sums stand out by 30 once in a million."""
    rng = np.random.default_rng(11)
    place = rng.uniform(2.0, 9.0, 4000)
    along = (place - place.min()) / np.ptp(place)
    rows = 0.5 * rng.normal(size=4000) + sum(
        height * np.cos(2.0 * np.pi * waves * along + waves) for waves, height in heights.items()
    )
    white = WhiteSines(lambda r: r, lambda r: r, lambda waves: np.full(len(waves), 2000.0))
    found = waves_beside(place, rows, 14.0, white, asked=30.0, fewest=5.0, most=12)
    assert_allclose(found, list(heights), atol=0.05)
