"""What nothing read: passive forces of tools nobody stated, tapers, chips thinner than any cut."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.cutting.elements import Elements, cut_forces
from autodb.forward.prediction import Interval, intervals, passive_known
from autodb.pairs import forecast as foreseeing
from autodb.pairs.averaging import learn_averaging
from autodb.pairs.engaged import BY_NAME
from autodb.pairs.forecast import Forecast, forecast
from autodb.pairs.observed import PairCuts, X, Y, Z, chip_bends
from autodb.pairs.posterior import BENDS_MM, LAW_BENDS, OWN, PairPosterior
from autodb.pairs.updating import posterior_of_readings
from tests.helpers.law_off import PRIOR, Array, sensed

SHARP = {"nose_radius_mm": 0.4, "rake_deg": 0.0, "inclination_deg": 0.0, "included_deg": 80.0}
FEEDS = (0.1, 0.15, 0.2, 0.3, 0.4)


def _cuts(
    tool: dict[str, float], operation: str = "turn", feeds: tuple[float, ...] = FEEDS
) -> PairCuts:
    rows = [
        {
            "cutting.feed": feed, "cutting.depth": depth, "cutting.speed": 100.0,
            "work.diameter": 40.0, "cutting.direction": 20.0,
        }
        for feed in feeds
        for depth in (1.0, 2.0, 3.0)
    ]  # fmt: skip
    return BY_NAME[operation].cuts(tool, rows, called="tool")


def _learnt(cuts: PairCuts, force_N: Array, components: tuple[int, ...]) -> PairPosterior:
    observed, rng = sensed(cuts, force_N), np.random.default_rng(3)
    noisy = replace(observed, value=observed.value + 5.0 * rng.standard_normal(len(observed.value)))
    kept = np.isin(noisy.quantity, components)
    some = {name: getattr(noisy, name)[kept] for name in ("cut", "quantity", "value", "sd")}
    return learn_averaging(PRIOR, replace(noisy, **some, common=noisy.common[kept]))


def _foreseen(posterior: PairPosterior, cuts: PairCuts) -> list[list[Interval]]:
    known = passive_known(posterior, cuts.operation)
    return intervals(forecast(posterior, cuts), operation=cuts.operation, known=known)


def _half(found: list[list[Interval]], quantity: int) -> Array:
    return np.array([0.5 * (one[quantity].high - one[quantity].low) for one in found])


def _held(found: list[list[Interval]], force_N: Array, quantity: int) -> float:
    inside = [
        one[quantity].low <= real <= one[quantity].high
        for one, real in zip(found, force_N[:, quantity], strict=True)
    ]
    return float(np.mean(inside))


@pytest.mark.parametrize("kappa_deg", [60.0, 75.0, 90.0, 95.0])
def test_a_holder_nobody_stated_may_be_any_and_is_learnt_by_its_passive_force(
    kappa_deg: float,
) -> None:
    """Tangential and feed forces say little of the entering angle, the passive force says it."""
    real = cut_forces(PRIOR.law.mean, _cuts({**SHARP, "kappa_deg": kappa_deg}).elements).force_N
    unstated = _cuts(SHARP)
    blind = _foreseen(_learnt(unstated, real, (Y, Z)), unstated)
    seen = _foreseen(_learnt(unstated, real, (X, Y, Z)), unstated)
    assert _held(blind, real, X) == 1.0
    assert _held(seen, real, X) > 0.9
    assert np.all(_half(seen, X) < 0.4 * _half(blind, X))


def test_tapers_have_the_direction_that_was_read_or_leave_it_open() -> None:
    """From cuts along the axis: without its passive force, more of force x is open in a taper."""
    tool = {**SHARP, "kappa_deg": 75.0}
    real = cut_forces(PRIOR.law.mean, _cuts(tool).elements).force_N
    tapers = _cuts(tool, "taper")
    blind, seen = (_learnt(_cuts(tool), real, read) for read in ((Y, Z), (X, Y, Z)))
    expected = forecast(blind, tapers)
    found = _foreseen(blind, tapers)
    assert np.all(_half(found, X) > 2.0 * 1.96 * expected.sd[:, X])
    assert_allclose(_half(found, X), np.hypot(1.96 * expected.sd[:, X], _open(expected)), rtol=1e-3)
    assert np.all(_half(_foreseen(seen, tapers), X) < 0.5 * _half(found, X))

    # Both slides feel a taper's forces, so that tapers that were cut tell the direction
    slopes = cut_forces(PRIOR.law.mean, tapers.elements).force_N
    both = posterior_of_readings(blind, sensed(tapers, slopes))
    assert both.passive["taper"].count == len(slopes)
    assert np.all(_half(_foreseen(both, tapers), X) < 0.5 * _half(found, X))


def _open(expected: Forecast) -> Array:
    """Return half of what 0.2 rad of the thrust's direction leave open of force x, 95 %."""
    turned, slope = expected.turned, np.radians(20.0)
    across = np.cos(slope) * turned[:, X] - np.sin(slope) * turned[:, Z]
    return np.asarray(1.96 * 0.2 * across * np.cos(slope))


def test_the_law_may_bend_where_chips_are_thinner_than_any_cut() -> None:
    """A truth whose exponent is 0.15 less below 0.1 mm is held where it was not cut."""
    tool = {**SHARP, "nose_radius_mm": 0.0, "kappa_deg": 90.0}
    cuts, thin = _cuts(tool), _cuts(tool, feeds=(0.04, 0.05))

    def bent(some: PairCuts) -> Array:
        whole = cut_forces(PRIOR.law.mean, some.elements).force_N
        thinner = np.log(0.1 / np.minimum(some.elements.edge.thickness_mm[:, -1], 0.1))
        return np.asarray(whole * np.exp(-0.15 * thinner)[:, None])

    found = _learnt(cuts, bent(cuts), (X, Y, Z))
    told = _foreseen(found, thin)
    for quantity in (Y, Z):
        assert _held(told, bent(thin), quantity) == 1.0
    place, stiff_state = found.columns(LAW_BENDS.key), found.state.covariance.copy()
    stiff_state[place], stiff_state[:, place] = 0.0, 0.0
    stiff = replace(found, state=replace(found.state, covariance=stiff_state))
    assert _held(_foreseen(stiff, thin), bent(thin), Y) < 1.0


def test_how_much_is_open_grows_below_the_chips_that_were_cut() -> None:
    tool = {**SHARP, "nose_radius_mm": 0.0, "kappa_deg": 90.0}
    real = cut_forces(PRIOR.law.mean, _cuts(tool).elements).force_N
    found = _learnt(_cuts(tool), real, (X, Y, Z))
    shares = []
    for feed in (0.1, 0.05, 0.025):
        expected = forecast(found, _cuts(tool, feeds=(feed,)))
        open_N = np.sqrt(expected.sd[:, Y] ** 2 - expected.own[:, Y])
        shares.append(float(np.mean(open_N / expected.mean[:, Y])))
    assert shares[1] > 1.5 * shares[0]
    assert shares[2] > 1.5 * shares[1]


def test_a_chip_thins_by_its_logarithm_below_each_bend() -> None:
    straight = {**SHARP, "nose_radius_mm": 0.0, "kappa_deg": 90.0}
    found = chip_bends(_cuts(straight, feeds=(0.4, 0.1)).elements)[[0, -1]]
    assert_allclose(found, np.maximum(np.log(BENDS_MM / np.array([[0.4], [0.1]])), 0.0), atol=1e-12)


def test_a_force_that_is_none_here_and_not_beside_bends_without_a_warning(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As across an edge that cuts straight in, where the chip may flow to either side."""
    cuts, middle = _cuts({**SHARP, "kappa_deg": 90.0}), PRIOR.state.mean[0]

    def to_either_side(theta: Array, elements: Elements) -> Array:
        del elements
        return np.repeat((theta[0] - middle)[:, None] ** 2, 5, axis=1)

    monkeypatch.setattr(foreseeing, "forces_by_laws", to_either_side)
    towards = np.zeros((1, cuts.elements.count, OWN))
    towards[..., 0] = 0.5
    bent, in_log = foreseeing._bends(PRIOR, cuts, towards, None)
    assert_allclose(bent, 2.0 * 0.5**2)
    assert_allclose(in_log, 0.0)
