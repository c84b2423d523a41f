"""Wear of edges in the posterior of a pair: what it adds, and that it is distinguished from the
law."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.cutting import shear
from autodb.cutting.elements import cut_forces, edge_parts
from autodb.fitting.gaussian import Gaussian
from autodb.pairs.averaging import log_evidence
from autodb.pairs.engaged import BY_NAME, Conditions
from autodb.pairs.forecast import forecast, worn
from autodb.pairs.observed import PairCuts
from autodb.pairs.posterior import LAW_BENDS, OWN, WEAR, PairPosterior, PairTerms
from autodb.pairs.prior import of_relative
from autodb.pairs.updating import log_evidence_near, posterior_of_readings
from autodb.pairs.worn import learn_worn, wear_after, with_wear
from tests.helpers.turned_pairs import prior, truth, turn
from tests.helpers.worn_pairs import WEARS, week, worn_posterior

Array = NDArray[np.float64]
CUTS: tuple[tuple[str, Mapping[str, float], Conditions], ...] = (
    ("turn", {}, {"cutting.feed": 0.2, "cutting.depth": 2.0, "cutting.speed": 150.0,
                  "work.diameter": 60.0}),
    ("face", {}, {"cutting.feed": 0.2, "cutting.depth": 2.0, "cutting.speed": 150.0,
                  "work.diameter": 60.0}),
    ("slot", {"diameter_mm": 10.0, "teeth": 4.0, "helix_deg": 30.0},
     {"cutting.feed": 0.1, "cutting.depth": 3.0, "spindle.speed": 3000.0}),
    ("drill", {"diameter_mm": 8.0}, {"cutting.feed": 0.2, "spindle.speed": 2000.0}),
)  # fmt: skip


def made(name: str, tool: Mapping[str, float], cut: Conditions, **more: float) -> PairCuts:
    return BY_NAME[name].cuts(tool, [{**cut, **more}], called="tool")


@pytest.mark.parametrize("name,tool,cut", CUTS)
def test_wear_adds_as_more_force_of_the_edge(
    name: str, tool: Mapping[str, float], cut: Conditions
) -> None:
    """In every operation, of all forces, torque and power; the fading of thin chips taken out."""
    values = {**shear.law_values(prior().law.mean), "edge_mm": 1e-6}
    elements = made(name, tool, cut).elements
    plain = cut_forces(shear.law_coordinates(values), elements).all
    for k, key in enumerate(("K_te", "K_re")):
        more = (
            cut_forces(shear.law_coordinates({**values, key: values[key] + 1.0}), elements).all
            - plain
        )
        assert_allclose(more, edge_parts(elements)[..., k], atol=1e-9 * np.abs(plain).max())


def test_a_fresh_edge_takes_what_it_took_and_starts_again() -> None:
    operation, tool, cut = CUTS[0]
    posterior = worn_posterior()
    plain = forecast(prior(), made(operation, tool, cut))
    for fresh in (
        made(operation, tool, cut),
        made(operation, tool, cut, **{"tool.cutting_time": 0}),
    ):
        assert_allclose(forecast(posterior, fresh).mean, plain.mean, rtol=1e-12)
        assert_allclose(forecast(posterior, fresh).sd, plain.sd, rtol=1e-12)
    late = forecast(posterior, made(operation, tool, cut, **{"tool.cutting_time": 1200.0}))
    assert (
        late.mean[0, [1, 3, 4]] > plain.mean[0, [1, 3, 4]] + 10.0 * np.array([1, 0.01, 1])
    ).all()


def test_what_wear_adds_goes_with_time_and_what_edges_differ_by_is_in_the_interval() -> None:
    operation, tool, cut = CUTS[0]
    half, whole = (
        worn(worn_posterior(), made(operation, tool, cut, **{"tool.cutting_time": t}))
        for t in (600.0, 1200.0)
    )
    assert_allclose(half.mean, 0.25 * whole.mean, rtol=1e-12)
    assert_allclose(np.sqrt(whole.own), 0.2 * np.abs(whole.mean), rtol=1e-9)
    late = made(operation, tool, cut, **{"tool.cutting_time": 1200.0})
    alike, differ = (
        forecast(worn_posterior(replace(WEARS, between=share)), late) for share in (0.0, 0.2)
    )
    assert_allclose(differ.sd**2 - alike.sd**2, whole.own, rtol=1e-6, atol=1e-9)


def test_wear_is_distinguished_from_the_law() -> None:
    """Of edges alike: five numbers within 4 sd, by chance not in 1 of 3000."""
    alike = replace(WEARS, between=0.0)
    _, fresh = week(11, wear=None)
    near = posterior_of_readings(prior(), fresh)
    _, observed = week(12, wear=alike)
    found = learn_worn(prior(), observed, near=near)
    assert found.wear is not None
    place = found.columns(WEAR)
    sd = np.sqrt(np.diag(found.state.covariance)[place])
    assert (np.abs(found.state.mean[place] - WEARS.size) < 4.0 * sd).all()
    assert (sd < 0.3 * np.array(WEARS.size)).all()
    assert 1.5 <= found.wear.power <= 3.0

    # The next edge, never seen, half worn
    ahead = replace(turn(np.array([0.2]), np.array([2.0])), worn_s=np.array([800.0]))
    real = cut_forces(truth(1), ahead.elements).all + worn(worn_posterior(alike), ahead).mean
    expected = forecast(found.past(), ahead)
    assert (np.abs(real - expected.mean) < 4.0 * expected.sd)[0, 1:].all()
    blind = forecast(
        posterior_of_readings(prior(), observed, near=near), replace(ahead, worn_s=None)
    )
    assert (np.abs(expected.mean - real) < np.abs(blind.mean - real))[0, 1:3].all()


def test_later_cuts_bend_wear_otherwise() -> None:
    """What the first confirmation found of young edges is not the last word."""
    _, observed = week(12, wear=replace(WEARS, between=0.0))
    early = replace(WEARS, power=0.6, reference_s=500.0, between=0.2)
    terms = PairTerms(early)
    near = posterior_of_readings(replace(prior(), terms=terms), with_wear(observed, early))
    found = wear_after(prior(), observed, near=near, wear=early)
    assert 1.5 <= found.power <= 3.0
    assert found.reference_s == 1200.0
    assert found.between < 0.1
    fresh = tuple(replace(one, worn_s=None) for one in observed.cuts)
    unworn = replace(observed, cuts=fresh)
    assert wear_after(prior(), unworn, near=near, wear=early) == early
    again = posterior_of_readings(
        replace(prior(), terms=PairTerms(found)), with_wear(observed, found)
    )
    place = again.columns(WEAR)
    sd = np.sqrt(np.diag(again.state.covariance)[place])
    assert (np.abs(again.state.mean[place] - WEARS.size) < 4.0 * sd).all()


def test_evidence_near_a_posterior_is_that_of_learning_but_for_a_constant() -> None:
    """Of two powers, where the law is known so well that it is as good as linear."""
    _, observed = week(12, wear=replace(WEARS, between=0.0))
    whole, near = [], posterior_of_readings(
        replace(prior(), terms=PairTerms(WEARS)), with_wear(observed, WEARS)
    )  # fmt: skip
    for power in (1.5, 2.5):
        wear = replace(WEARS, power=power)
        before, readings = replace(prior(), terms=PairTerms(wear)), with_wear(observed, wear)
        learnt = posterior_of_readings(before, readings, near=near)
        near_by = log_evidence_near(before, readings, near)
        whole.append((log_evidence(before, learnt, readings), near_by))
    exact, linear = np.array(whole).T
    assert_allclose(np.diff(linear), np.diff(exact), atol=1.0)
    assert np.isfinite(log_evidence_near(replace(before, state=_wide(before)), readings, near))


def _wide(posterior: PairPosterior) -> Gaussian:
    """Return a state of which next to nothing is known."""
    return Gaussian(posterior.state.mean, 1e12 * posterior.state.covariance)


def test_what_the_power_leaves_open_is_in_the_interval() -> None:
    operation, tool, cut = CUTS[0]
    open_ = worn_posterior(replace(WEARS, power_sd=0.3))
    for used_s, share in ((600.0, 0.6 * np.log(2.0)), (1200.0, 0.0), (2400.0, 0.6 * np.log(2.0))):
        aged = made(operation, tool, cut, **{"tool.cutting_time": used_s})
        alike, wider = forecast(worn_posterior(), aged), forecast(open_, aged)
        more = share * np.abs(worn(open_, aged).mean)
        assert_allclose(wider.mean, alike.mean, rtol=1e-12)
        assert_allclose(np.sqrt(wider.sd**2 - alike.sd**2), more, rtol=1e-6, atol=1e-3)


def test_edges_that_differ_are_known_to_and_forgotten() -> None:
    _, observed = week(13, wear=WEARS)
    readings = with_wear(observed, WEARS)
    assert [one.key for one in readings.shared[-4:]] == [
        "tool_wear", "wear of edge A", "wear of edge B", "wear of edge C",
    ]  # fmt: skip
    posterior = posterior_of_readings(replace(prior(), terms=PairTerms(WEARS)), readings)
    assert [one.key for one in posterior.past().shared][-4:] == [
        "tool_wear", "law, turn", "law in thickness and speed, turn", LAW_BENDS.key,
    ]  # fmt: skip
    assert posterior.past().columns(WEAR).stop <= OWN + 4


def test_without_wear_readings_are_as_they_were() -> None:
    _, observed = week(14, wear=None)
    assert with_wear(observed, None) is observed


def test_another_tool_begins_without_wear() -> None:
    relative = of_relative(worn_posterior())
    assert relative.wear is None
    assert WEAR not in {one.key for one in relative.shared}
