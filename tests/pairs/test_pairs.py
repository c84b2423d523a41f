"""The posterior of a work-tool pair: learnt, predicted, planned."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy.stats import binom

from autodb.cutting import shear
from autodb.cutting.elements import cut_forces
from autodb.cutting.insert import Insert, TurnedCuts, insert_elements
from autodb.pairs.determined import chip_thickness, undetermined
from autodb.pairs.forecast import forecast
from autodb.pairs.next_cut import PlanLimits, SensedComponent, gain_error, propose
from autodb.pairs.observed import CHIP, Observed, PairCuts, Y, Z
from autodb.pairs.outlying import outlier_test
from autodb.pairs.posterior import OWN, PairPosterior
from autodb.pairs.prior import CardForces, any_metal, of_card, of_relative
from autodb.pairs.updating import posterior_of_readings
from autodb.proofs.machines.lathe.power_pairs import scattered
from autodb.proofs.runs.pairs import pair_ours
from autodb.proofs.runs.pairs.pair_cuts import (
    FAMILIES,
    KNOWN,
    draw_pair,
    draw_read_cuts,
    true_forces,
)
from autodb.proofs.runs.score import Z as NORMAL_95
from tests.helpers.turned_pairs import GAIN, SD_N, Array, cuts_of, prior, sensed, truth, turn


def some(observed: Observed, keep: NDArray[np.intp]) -> Observed:
    """Return readings of some of the cuts."""
    rows = np.isin(observed.cut, keep)
    return replace(
        observed, cut=observed.cut[rows], quantity=observed.quantity[rows],
        value=observed.value[rows], sd=observed.sd[rows], common=observed.common[rows],
    )  # fmt: skip


@pytest.fixture(scope="module")
def learnt() -> tuple[PairPosterior, Observed, PairPosterior]:
    """Return prior, readings of 16 cuts, posterior."""
    observed = sensed(truth(1), cuts_of(2, 16), seed=3)
    return prior(), observed, posterior_of_readings(prior(), observed)


def test_a_law_that_is_the_truth_is_found() -> None:
    """Of 40 pairs the 95 % interval of an unseen cut's mean holds in all but a chance's."""
    held = 0
    ahead = cuts_of(99, 1)
    for seed in range(40):
        theta = truth(100 + seed)
        gains = 1.0 + 0.05 * np.random.default_rng(500 + seed).standard_normal(2)
        posterior = posterior_of_readings(
            prior(), sensed(theta, cuts_of(seed, 8), seed, (gains[0], gains[1]))
        )
        expected = forecast(posterior, ahead)
        real = cut_forces(theta, ahead.elements).force_N[0]
        inside = np.abs(real - expected.mean[0, :3]) <= NORMAL_95 * expected.sd[0, :3]
        held += int(inside[1])
    assert held >= binom.ppf(0.0005, 40, 0.95)


def test_more_cuts_never_make_the_force_surer_than_the_gain(
    learnt: tuple[PairPosterior, Observed, PairPosterior],
) -> None:
    """Forty cuts: what is open of the tangential force is the calibration's 5 %."""
    many = posterior_of_readings(prior(), sensed(truth(1), cuts_of(4, 40), seed=5))
    ahead = cuts_of(6, 5)
    for posterior, most in ((many, 1.4), (learnt[2], 2.0)):
        expected = forecast(posterior, ahead)
        open_ = np.sqrt(expected.sd**2 - expected.own)[:, 1] / expected.mean[:, 1]
        assert np.all(open_ > 0.9 * 0.05)
        assert np.all(open_ < most * 0.05)


def test_one_after_the_other_is_all_at_once(
    learnt: tuple[PairPosterior, Observed, PairPosterior],
) -> None:
    """Predictions within half of their sd: the law bends between what is linearised."""
    begun, observed, batch = learnt
    posterior = begun
    for cut in range(16):
        posterior = posterior_of_readings(posterior, some(observed, np.array([cut])))
    ahead = cuts_of(7, 6)
    one, all_ = forecast(posterior, ahead), forecast(batch, ahead)
    assert np.all(np.abs(one.mean - all_.mean)[:, :3] < all_.sd[:, :3] / 2.0)
    assert_allclose(one.sd[:, :3], all_.sd[:, :3], rtol=0.15)
    assert posterior.cuts == batch.cuts == 16
    assert posterior.state.mean.shape == batch.state.mean.shape, "a cut adds nothing to its size"


def test_forces_alone_leave_shear_stress_and_chip_ratio_open(
    learnt: tuple[PairPosterior, Observed, PairPosterior],
) -> None:
    begun, observed, posterior = learnt
    cuts = observed.cuts[0]
    trial = chip_thickness(
        posterior, PairCuts("turn", turn(np.array([0.2]), np.array([2.0])).elements)
    )
    open_ = {name: one for one in undetermined(begun, posterior, [trial]) for name in one.names}
    assert "chip_flow" not in open_ or open_["chip_flow"].helps == ()
    assert "chip_ratio_rake" in open_, "one rake tells no slope in rake"
    ratio_sd = [
        float(np.sqrt(one.law.covariance[shear.RATIO, shear.RATIO]))
        for one in (posterior, posterior_of_readings(posterior, _chips(truth(1), cuts)))
    ]
    assert ratio_sd[1] < 0.5 * ratio_sd[0]
    stress = [
        float(np.sqrt(one.law.covariance[shear.TAU, shear.TAU]))
        for one in (posterior, posterior_of_readings(posterior, _chips(truth(1), cuts)))
    ]
    assert stress[1] < stress[0], "what the ratio was taken for is the shear stress"


def _chips(theta: Array, cuts: PairCuts) -> Observed:
    """Return the chips of four cuts, measured to 3 %."""
    bare = Observed(
        (cuts,), np.arange(4), np.full(4, CHIP), np.zeros(4), np.ones(4), np.zeros((4, 0))
    )
    thick = bare.parts(theta)[:, 2]
    return replace(bare, value=thick, sd=0.03 * thick)


def test_what_was_not_determined_is_said_by_name() -> None:
    """One cut at one thickness: shear stress and its partners are named, a chip helps."""
    begun = any_metal()
    posterior = posterior_of_readings(
        begun, sensed(truth(1), turn(np.array([0.2]), np.array([2.0])), seed=1)
    )
    chip = chip_thickness(posterior, turn(np.array([0.2]), np.array([2.0])))
    said = [one.statement for one in undetermined(begun, posterior, [chip])]
    helped = [line for line in said if "a measured chip thickness" in line]
    assert any("chip_ratio" in line for line in helped)
    assert all("; add " in line or "; nothing that was tried" in line for line in said)


def test_the_cut_proposed_is_the_best_and_within_limits() -> None:
    """The cut that is proposed leaves less open than any other, and none beyond a limit is."""
    posterior = posterior_of_readings(prior(), sensed(truth(1), cuts_of(2, 2), seed=3))
    grid = np.stack(np.meshgrid([0.1, 0.2, 0.4], [1.0, 3.0], [80.0, 250.0]), -1).reshape(-1, 3)
    candidates = turn(grid[:, 0], grid[:, 1], grid[:, 2])
    targets = cuts_of(9, 3)
    components = tuple(
        SensedComponent(q, SD_N, (gain_error(g),)) for q, g in zip((Y, Z), GAIN, strict=True)
    )
    best = propose(posterior, candidates, targets, sensed=components, quantities=(Y, Z))
    assert best is not None
    left = []
    for k in range(len(grid)):
        cut = turn(*(grid[k : k + 1, i] for i in range(3)))
        after = forecast(posterior_of_readings(posterior, _exact(posterior, cut)), targets)
        left.append(float(np.mean((after.sd / after.mean)[:, [Y, Z]] ** 2)))
    assert_allclose(left[best.candidate], min(left), rtol=0.05)
    deep = forecast(posterior, candidates).mean[:, Y].max()
    limits = PlanLimits(np.array([1e9, 0.5 * deep, 1e9, 1e9, 1e9]))
    light = propose(
        posterior, candidates, targets, sensed=components, quantities=(Y,), limits=limits
    )
    assert light is not None
    assert limits.exceeded(forecast(posterior, candidates))[light.candidate, Y] <= 0.05
    none = PlanLimits(np.full(5, 1.0))
    assert (
        propose(posterior, candidates, targets, sensed=components, quantities=(Y,), limits=none)
        is None
    )


def _exact(posterior: PairPosterior, cut: PairCuts) -> Observed:
    """Return the readings of a cut as the posterior expects them."""
    made = sensed(posterior.law.mean, cut, seed=1)
    value = forecast(posterior, cut).mean[0, [Y, Z]]
    return replace(made, value=value, common=np.eye(2))


def test_a_card_is_believed_as_far_as_it_says() -> None:
    """Its forces come back within 8 %, drawn to what any metal has, and are open by its level."""
    chips = np.array([0.05, 0.1, 0.2, 0.4])
    card = CardForces(chips, 2000.0 * chips**0.8, 1000.0 * chips**0.7, level=0.25, shape=0.05)
    posterior = of_card(card)
    one = np.ones_like(chips)
    edge = TurnedCuts(chips, one, 100.0 * one, one, 0.0 * one)
    cuts = PairCuts("orthogonal", insert_elements(Insert(0.0, 90.0), edge))
    expected = forecast(posterior, cuts)
    assert_allclose(expected.mean[:, 1], card.tangential, rtol=0.08)
    assert_allclose(expected.sd[:, 1] / expected.mean[:, 1], 0.25, rtol=0.15)
    assert posterior.cuts == 0
    assert len(posterior.state.mean) == OWN


def test_a_cut_of_another_state_is_surprising_and_one_of_this_is_not() -> None:
    """Of 300 cuts of the same state at most 4 are called outliers, where chance alone gives more
    once in 60 000; a cut whose forces are half again as large is. Errors are a little smaller than
    expected, because this truth is the law itself.
    """
    theta = truth(1)
    posterior = posterior_of_readings(prior(), sensed(theta, cuts_of(2, 16), seed=3))
    same = sensed(theta, cuts_of(31, 300), seed=32)
    found = outlier_test(posterior, same)
    assert found.outlying.sum() <= 4
    assert 0.6 < np.std(found.off) < 1.1
    worn = replace(some(same, np.arange(1)), value=1.5 * same.value[[0, 300]])
    assert outlier_test(posterior, worn).outlying.all()
    assert outlier_test(posterior, some(same, np.arange(5))).together > 1e-4


def test_another_tool_of_the_material_is_believed_less() -> None:
    """Nearer the truth than what any metal has, wider than the pair itself."""
    theta = truth(1)
    known = posterior_of_readings(prior(), sensed(theta, cuts_of(2, 16), seed=3))
    ahead = cuts_of(41, 5)
    own, relative, any_ = (
        forecast(posterior, ahead) for posterior in (known, of_relative(known), any_metal())
    )
    assert np.all(relative.sd[:, 1] > own.sd[:, 1])
    assert np.all(relative.sd[:, 1] / relative.mean[:, 1] < any_.sd[:, 1] / any_.mean[:, 1])
    assert of_relative(known).cuts == 0


def test_pairs_of_another_law_in_their_operation_and_in_others() -> None:
    """25 pairs, turned and milled: force y of the next cut of each of six operations.

    Each within the band that 95 % intervals leave in 1 of 10 000.
    """
    held = {operation.name: 0 for family in FAMILIES for operation in family.predicted}
    pairs = 25
    for seed in range(7001, 7001 + pairs):
        rng, pair = draw_pair(seed)
        for family in FAMILIES:
            posterior = posterior_of_readings(
                pair_ours.prior(pair.material),
                pair_ours.observed(pair, draw_read_cuts(rng, pair, family.known, KNOWN)),
            )
            for operation in family.predicted:
                cut = operation.draw(rng, pair)
                real = true_forces(pair, cut, scattered(rng))
                mean, sd = pair_ours.predicted_next(posterior, pair, operation.name, (cut,))
                held[operation.name] += int(abs(real[1] - mean[0, 1]) <= NORMAL_95 * sd[0, 1])
    for name, count in held.items():
        assert count >= binom.ppf(0.0001, pairs, 0.95), name
