"""Another tool on a material that several tools of a machine have cut: what theirs told of it."""

from functools import cache

import numpy as np
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.cutting.elements import cut_forces
from autodb.pairs.forecast import forecast
from autodb.pairs.hierarchy import ACTIVE, EDGES, METALS, information_of_cuts, of_relatives
from autodb.pairs.posterior import CALIBRATION, GAIN, OWN, REFERENCES, PairPosterior
from autodb.pairs.prior import RELATIVE, of_relative
from autodb.pairs.updating import posterior_of_readings
from tests.helpers.turned_pairs import GAIN as GAINS
from tests.helpers.turned_pairs import cuts_of, prior, sensed, truth

Array = NDArray[np.float64]

SENSING = (CALIBRATION, REFERENCES, GAIN)
TOOLS, CUTS, SEEDS = 3, 12, 8


def _tool(material: Array, rng: np.random.Generator) -> Array:
    """Return the law of a tool on a material: a fifth of what metals differ by, another edge."""
    law = material.copy()
    share = np.where(EDGES, 0.5, RELATIVE)
    law[ACTIVE] += share * np.sqrt(METALS) * rng.standard_normal(len(ACTIVE))
    return law


@cache
def _shop(seed: int) -> tuple[tuple[PairPosterior, ...], Array]:
    """Return a shop's pairs of one material, and the law of a tool that it has not cut with."""
    rng = np.random.default_rng(seed)
    material = truth(seed)
    gains = tuple((1.0 + 0.05 * rng.standard_normal(2)).tolist())
    learnt = []
    for k in range(TOOLS):
        readings = sensed(_tool(material, rng), cuts_of(10 * seed + k, CUTS), seed + k, gains)
        learnt.append(posterior_of_readings(prior(), readings))
    return tuple(learnt), _tool(material, rng)


def _from_all(learnt: tuple[PairPosterior, ...]) -> PairPosterior:
    start = prior()
    told = {
        f"tool {k}": information_of_cuts(one.given(SENSING), start.law)
        for k, one in enumerate(learnt)
    }
    return of_relatives(learnt[0], start.law, told, "new")


def test_several_tools_tell_more_of_the_next_than_one_and_their_intervals_hold() -> None:
    """Of 8 shops: force y and z of five cuts of a fourth tool, as if sensed by nothing."""
    errors, held = [], []
    for seed in range(SEEDS):
        learnt, law = _shop(seed)
        ahead = cuts_of(900 + seed, 5)
        real = cut_forces(law, ahead.elements).force_N[:, 1:]
        all_, one = (forecast(some, ahead) for some in (_from_all(learnt), of_relative(learnt[0])))
        off = [np.abs(some.mean[:, 1:3] - real) / real for some in (all_, one)]
        errors.append([float(np.median(each)) for each in off])
        held.append(np.mean(np.abs(all_.mean[:, 1:3] - real) < 1.96 * all_.sd[:, 1:3]))
    from_all, from_one = np.mean(errors, axis=0)
    assert from_all < from_one
    assert np.mean(held) >= 0.93


def test_a_gain_that_all_share_is_not_averaged_away() -> None:
    """No number of tools makes the level surer than the machine's gain, 5 %."""
    learnt, _ = _shop(0)
    found = _from_all(learnt)
    ahead = cuts_of(900, 5)
    expected = forecast(found, ahead)
    assert np.all(expected.sd[:, 1] > 0.05 * expected.mean[:, 1])
    assert {one.key for one in GAINS} <= {one.key for one in found.shared}
    place = found.columns(GAINS[0].key)
    assert_allclose(
        found.state.covariance[place, place], learnt[0].state.covariance[place, place], rtol=1e-9
    )
    assert np.all(np.linalg.eigvalsh(found.state.covariance) > -1e-12)
    assert np.any(np.abs(found.state.covariance[:OWN, place]) > 0.0)
