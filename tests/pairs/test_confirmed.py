"""A band of speeds and a hard lot in the posterior of a pair: learnt, predicted, and told apart."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.cutting.elements import cut_forces, mean_speed_m_min
from autodb.pairs.confirmed import band_after, learn_banded, with_terms
from autodb.pairs.forecast import Forecast, expected_means, forecast
from autodb.pairs.modelled import Modelled, inside_band, moved_band
from autodb.pairs.observed import Observed, PairCuts
from autodb.pairs.posterior import BAND, NO_TERMS, PairPosterior, PairTerms, SpeedBand, lot_key
from autodb.pairs.updating import met, posterior_of_readings
from tests.helpers.turned_pairs import cuts_of, prior, sensed, truth, turn

Array = NDArray[np.float64]
CENTRE, HALF, CHANGE = 150.0, 0.22, np.array([-0.18, -0.3])
"""The truth: forces fall by so much in a window of speeds that is no bell."""


def change_at(speed: Array) -> Array:
    """Return by which shares forces along and across change (n, 2), a cosine that ends."""
    off = np.clip(np.abs(np.log(speed / CENTRE)) / (2.0 * HALF), 0.0, 1.0)
    return np.asarray(0.5 * (1.0 + np.cos(np.pi * off))[:, None] * CHANGE)


def parts(cuts: PairCuts) -> Array:
    """Return by what share each of the five quantities of turned cuts changes (n, 5)."""
    along, across = change_at(mean_speed_m_min(cuts.elements)).T
    return np.column_stack([across, along, across, along, along])


def banded_week(seed: int) -> Observed:
    cuts = cuts_of(seed, 40)
    observed = sensed(truth(1), cuts, seed)
    more = 1.0 + parts(cuts)[observed.cut, observed.quantity]
    return replace(observed, value=observed.value * more)


@pytest.fixture(scope="module")
def banded() -> PairPosterior:
    near = posterior_of_readings(prior(), sensed(truth(1), cuts_of(21, 40), 21))
    return learn_banded(prior(), banded_week(22), near=near).past()


def off(posterior: PairPosterior, cuts: PairCuts, real: Array) -> tuple[Array, Array, Forecast]:
    found = forecast(posterior, cuts)
    return found.mean[:, 1:3] - real[:, 1:3], found.sd[:, 1:3], found


def test_a_band_is_found_where_it_is_and_predicted_inside_and_outside(
    banded: PairPosterior,
) -> None:
    band = banded.terms.band
    assert band is not None
    sd = np.sqrt(band.covariance[0][0])
    assert 0.0 < sd < 0.2
    assert abs(np.log(band.centre_m_min / CENTRE)) < 0.1 + 3.0 * sd
    inside = turn(np.full(3, 0.2), np.full(3, 2.0), speed=np.array([140.0, 150.0, 165.0]))
    outside = turn(np.full(2, 0.2), np.full(2, 2.0), speed=np.array([80.0, 260.0]))
    blind = posterior_of_readings(prior(), banded_week(22))
    for cuts in (inside, outside):
        real = cut_forces(truth(1), cuts.elements).all * (1.0 + parts(cuts))
        error, spread, _ = off(banded, cuts, real)
        assert (np.abs(error) < 3.0 * spread).all()
        assert np.abs(error).mean() < 0.5 * np.abs(off(blind, cuts, real)[0]).mean()


def test_later_cuts_move_a_band(banded: PairPosterior) -> None:
    """To where learning finds it, from a shape that few cuts had said."""
    was = SpeedBand(1.08 * CENTRE, 0.14)
    terms = replace(prior(), terms=PairTerms(band=was))
    near = posterior_of_readings(terms, banded_week(22))
    found, there = band_after(prior(), banded_week(22), near=near, band=was), banded.terms.band
    assert there is not None
    sd = np.sqrt(np.diag(np.array(there.covariance)))
    assert abs(np.log(found.centre_m_min / there.centre_m_min)) < 2.0 * sd[0]
    assert abs(np.log(found.centre_m_min / CENTRE)) < 0.1


def test_a_band_stays_where_readings_do_not_tell_it() -> None:
    """Of cuts at one speed, or of readings that hold no band and would have it anywhere."""
    was = SpeedBand(CENTRE, 0.2)
    start = replace(prior(), terms=PairTerms(band=was))
    one_speed = turn(np.linspace(0.1, 0.4, 12), np.full(12, 2.0), speed=np.full(12, 150.0))
    for cuts in (one_speed, cuts_of(31, 40)):
        plain = sensed(truth(1), cuts, 31)
        near = posterior_of_readings(start, plain)
        found = band_after(prior(), plain, near=near, band=was)
        speeds = mean_speed_m_min(cuts.elements)
        assert found == was or speeds.min() <= found.centre_m_min <= speeds.max()
        sd = np.sqrt(np.diag(np.array(found.covariance)))
        assert (sd < 0.25 * found.width).all()


def test_means_alone_are_those_of_the_forecast(banded: PairPosterior) -> None:
    cuts = cuts_of(3, 6)
    assert_allclose(expected_means(banded, cuts), forecast(banded, cuts).mean, rtol=1e-9)


def test_where_a_band_lies_is_in_the_interval(banded: PairPosterior) -> None:
    band = banded.terms.band
    assert band is not None
    sure = replace(
        banded, terms=replace(banded.terms, band=replace(band, covariance=((0, 0), (0, 0))))
    )
    flank = turn(
        np.array([0.2]), np.array([2.0]), speed=np.array([band.centre_m_min * np.exp(band.width)])
    )
    wide, narrow = forecast(banded, flank), forecast(sure, flank)
    by = (narrow.mean - forecast(replace(sure, terms=NO_TERMS), flank).mean) / inside_band(
        flank, band
    )
    own = np.einsum(
        "i,ij,j->",
        moved_band(flank, band)[0],
        np.array(band.covariance),
        moved_band(flank, band)[0],
    )
    assert_allclose(wide.sd**2 - narrow.sd**2, by**2 * own, rtol=1e-6)


def test_derivatives_of_readings_in_a_band_are_those_of_differences() -> None:
    observed = banded_week(5)
    terms = PairTerms(band=SpeedBand(CENTRE, HALF))
    known, _ = met(replace(prior(), terms=terms), observed)
    model, state = Modelled(known, observed), known.state.mean.copy()
    state[known.columns(BAND)] = [-0.2, -0.3]
    _, slopes = model.steep(state)
    for k in (0, 3, known.columns(BAND).start, known.columns(BAND).start + 1):
        step = np.zeros(len(state))
        step[k] = 1e-6
        by = (model.seen(state + step).expected - model.seen(state - step).expected) / 2e-6
        assert_allclose(slopes[:, k], by, rtol=1e-4, atol=1e-3)


def test_a_hard_lot_is_learnt_and_counts_only_where_it_is_named() -> None:
    cuts = replace(cuts_of(31, 30), lots=("soft",) * 20 + ("hard",) * 10)
    observed = sensed(truth(1), cuts, 31)
    of_lot = np.array([lot == "hard" for lot in cuts.lots])[observed.cut]
    observed = replace(observed, value=observed.value * np.where(of_lot, 1.25, 1.0))
    terms = PairTerms(lots=("hard",))
    learnt = posterior_of_readings(
        replace(prior(), terms=terms), with_terms(observed, terms)
    ).past()
    place = learnt.columns(lot_key("hard"))
    more, sd = (
        learnt.state.mean[place][0],
        float(np.sqrt(learnt.state.covariance[place, place][0, 0])),
    )
    assert abs(more - 0.25) < 3.0 * sd < 0.1
    ahead = turn(np.full(2, 0.2), np.array([1.0, 3.0]))
    real = cut_forces(truth(1), ahead.elements).all
    usual, hard = forecast(learnt, ahead), forecast(replace(learnt, lot="hard"), ahead)
    assert (np.abs(usual.mean - real) < 3.0 * usual.sd)[:, 1:3].all()
    assert (np.abs(hard.mean - 1.25 * real) < 3.0 * hard.sd)[:, 1:3].all()
    assert_allclose(forecast(replace(learnt, lot="other"), ahead).mean, usual.mean)
    assert_allclose(expected_means(replace(learnt, lot="hard"), ahead), hard.mean, rtol=1e-9)
