"""A file of cuts that are all harder by one share is found, and no day, sensor or wear is one."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.pairs.changes.harder_work import harder_work
from autodb.pairs.observed import Observed
from autodb.pairs.posterior import PairPosterior, Shared
from autodb.pairs.updating import posterior_of_readings
from tests.helpers.turned_pairs import cuts_of, prior, sensed, truth
from tests.helpers.worn_pairs import week, worn_posterior

DAY_SD = 0.05
"""Share by which a day's readings along the cutting speed are off together."""


@cache
def learnt() -> PairPosterior:
    return posterior_of_readings(prior(), sensed(truth(1), cuts_of(2, 40), seed=3)).past()


def _file(seed: int, count: int = 10) -> Observed:
    """Return a file's readings of fresh edges, the tangential ones off by an error of its day."""
    cuts = replace(cuts_of(seed, count), worn_s=np.zeros(count))
    plain = sensed(truth(1), cuts, seed)
    day = (plain.quantity == 1).astype(np.float64)
    own = DAY_SD * np.random.default_rng(seed).standard_normal()
    return replace(
        plain,
        value=plain.value * (1.0 + own * day),
        shared=(*plain.shared, Shared("day of a test", np.array([[DAY_SD**2]]))),
        common=np.column_stack([plain.common, day]),
        shift=None if plain.shift is None else np.column_stack([plain.shift, 0.0 * day]),
    )


def _harder(observed: Observed, which: NDArray[np.bool_], by: float) -> Observed:
    """Return readings of which some are larger by a share."""
    return replace(observed, value=np.where(which, 1.0 + by, 1.0) * observed.value)


def test_a_file_of_harder_work_is_found_in_all_of_its_cuts() -> None:
    for seed in range(40, 48):
        observed = _file(seed)
        found = harder_work(learnt(), _harder(observed, observed.cut >= 0, 0.25))
        assert found is not None
        assert_allclose(found.share, 0.25, atol=3.0 * found.sd)


def test_usual_files_are_none() -> None:
    """One in 1000 is expected to be."""
    assert sum(harder_work(learnt(), _file(seed)) is not None for seed in range(60, 160)) <= 2


@pytest.mark.parametrize("quantity", [1, 2])
def test_what_raises_one_component_alone_is_its_sensor(quantity: int) -> None:
    for seed in range(60, 66):
        observed = _file(seed)
        assert harder_work(learnt(), _harder(observed, observed.quantity == quantity, 0.3)) is None


def test_lower_forces_and_few_cuts_are_none() -> None:
    observed = _file(70)
    assert harder_work(learnt(), _harder(observed, observed.cut >= 0, -0.25)) is None
    few = _file(71, 4)
    assert harder_work(learnt(), _harder(few, few.cut >= 0, 0.4)) is None
    little = _file(73)
    assert harder_work(learnt(), _harder(little, little.cut >= 0, 0.04)) is None


def test_nothing_is_said_where_nobody_knows_the_wear() -> None:
    """Of edges that have cut, and of a pair that has learnt no wear."""
    _, worn = week(5, wear=None)
    assert harder_work(learnt(), _harder(worn, worn.cut >= 0, 0.3)) is None
    known = worn_posterior()
    assert harder_work(known, _harder(worn, worn.cut >= 0, 3.0)) is not None
