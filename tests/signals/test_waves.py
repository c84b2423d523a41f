"""The strongest sine over places that are not evenly spaced."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.signals.waves import strongest_wave


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
