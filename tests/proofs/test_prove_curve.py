"""How fast a pair is learnt: the readings, the ways to predict, and the plans that are compared."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.pairs.updating import posterior_of_readings
from autodb.proofs.machines.lathe.power_pairs import GAIN, TurnedCut
from autodb.proofs.runs.pairs import pair_ours
from autodb.proofs.runs.pairs.curve_case import JUDGED, draw_case, median_errors, some
from autodb.proofs.runs.pairs.curve_peers import (
    PEERS,
    RANGES,
    kienzle_line,
    kienzle_with_speed,
    nearest_by_section,
    nearest_cut,
)
from autodb.proofs.runs.pairs.curve_plans import (
    AT,
    CANDIDATES,
    CORNERS,
    FACTORIAL,
    PROPOSED,
    RANDOM,
    PlannedPair,
    judged_plan,
    proposed,
)
from autodb.proofs.runs.pairs.curve_run import LEARNT, OURS, LearningErrors
from autodb.proofs.runs.pairs.curve_summary import CurveSummary, curve_summary_of
from autodb.proofs.runs.pairs.pair_cuts import TURN, ReadCuts, draw_pair, made
from autodb.proofs.runs.run_file import Finished, Origin
from autodb.proofs.runs.score import Z

Array = NDArray[np.float64]
Way = Callable[[Array, Array, Array], Array]

SEEDS = range(6001, 6007)


def test_many_noisy_readings_under_one_gain_do_not_pull_the_force_down() -> None:
    # One cut read 100 times, 6 % scatter: the mean has a standard error of 0.6 %, tolerance 4 of it
    _, pair = draw_pair(6001)
    start = pair_ours.prior(pair.material)
    cut = TurnedCut(feed_mm=0.25, depth_mm=2.0, speed_m_min=150.0)
    expected, _ = pair_ours.predicted_next(start, pair, TURN.name, (cut,))
    rng = np.random.default_rng(1)
    read = expected[:, [1, 2]] * (1.0 + 0.06 * rng.standard_normal((100, 2)))
    posterior = posterior_of_readings(
        start, pair_ours.observed(pair, ReadCuts(TURN, (cut,) * 100, read))
    )
    after, _ = pair_ours.predicted_next(posterior, pair, TURN.name, (cut,))
    assert_allclose(after[0, [1, 2]], expected[0, [1, 2]], rtol=4 * 0.06 / np.sqrt(100))


def _kienzle(logs: Array, speed_power: float) -> Array:
    return np.asarray(np.exp(logs @ [0.8, 1.0, speed_power]) * 1500.0)


@pytest.mark.parametrize(("way", "power"), [(kienzle_line, 0.0), (kienzle_with_speed, -0.1)])
def test_a_line_of_kienzle_is_found_from_the_fewest_cuts(way: Way, power: float) -> None:
    needs = next(peer.needs for peer in PEERS if peer.predict is way)
    logs = np.random.default_rng(2).uniform(RANGES[:, 0], RANGES[:, 1], (needs + 5, 3))
    force_N = _kienzle(logs, power)
    found = way(logs[:needs], force_N[:needs], logs[needs:])
    assert_allclose(found, force_N[needs:], rtol=1e-9)


def test_the_nearest_cut_is_that_in_shares_of_the_ranges() -> None:
    middle = RANGES.mean(axis=1)
    width = RANGES[:, 1] - RANGES[:, 0]
    known = middle + width * [[0.3, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, -0.4]]
    force_N = np.array([100.0, 200.0, 300.0])
    assert_allclose(nearest_cut(known, force_N, middle[None]), 200.0)
    deeper = np.exp(-0.2 * width[1])  # the section of the middle over the nearest one's
    assert_allclose(nearest_by_section(known, force_N, middle[None]), 200.0 * deeper)
    assert_allclose(nearest_by_section(known, force_N, known), force_N)


def test_five_cuts_teach_pairs_of_another_law() -> None:
    # 6 pairs: the mean error is near 5 % with a standard error of 1.3 %
    errors = []
    for seed in SEEDS:
        case = draw_case(seed)
        start = pair_ours.prior(case.pair.material)
        posterior = posterior_of_readings(
            start, pair_ours.observed(case.pair, some(case.sensed, 0, 5))
        )
        mean, _ = pair_ours.predicted_next(posterior, case.pair, TURN.name, case.asked)
        errors.append(median_errors(mean[:, list(JUDGED)], case))
    assert np.all(np.mean(errors, axis=0) < 0.1)


def test_a_gain_is_no_part_of_what_lies_above_the_floor() -> None:
    case = draw_case(6001)
    start = pair_ours.prior(case.pair.material)
    posterior = posterior_of_readings(
        start, pair_ours.observed(case.pair, some(case.sensed, 0, 12))
    )
    before, after = judged_plan(start, case), judged_plan(posterior, case)
    assert after[0] < 0.5 * before[0]
    assert after[1] < 0.25 * before[1]
    assert after[1] < Z * GAIN < after[0], "no cuts tell the gain"


def test_plans_take_their_cuts_from_one_grid() -> None:
    assert len(set(CANDIDATES)) == 36
    assert set(CORNERS) < set(CANDIDATES)
    assert len(set(CORNERS)) == AT[FACTORIAL][-1]


def test_proposed_cuts_leave_less_open_than_as_many_at_random() -> None:
    # One pair; 3 proposed against the mean of 4 plans of 3 at random
    case = draw_case(6001)
    start = pair_ours.prior(case.pair.material)
    rng = np.random.default_rng(3)

    def left(cuts: tuple[TurnedCut, ...]) -> float:
        sensed = made(np.random.default_rng(4), case.pair, TURN, cuts)
        return judged_plan(
            posterior_of_readings(start, pair_ours.observed(case.pair, sensed)), case
        )[1]

    posterior = start
    cuts: tuple[TurnedCut, ...] = ()
    for _ in range(3):
        cuts = (*cuts, proposed(posterior, case, len(cuts)))
        sensed = made(np.random.default_rng(4), case.pair, TURN, cuts)
        posterior = posterior_of_readings(start, pair_ours.observed(case.pair, sensed))
    random = [tuple(CANDIDATES[k] for k in rng.integers(36, size=3)) for _ in range(4)]
    assert judged_plan(posterior, case)[1] < np.mean([left(plan) for plan in random])


def _run(
    seed: int, *, ours: float, peer: float, faster: float
) -> Finished[LearningErrors | PlannedPair]:
    """Errors that differ a little from pair to pair, and widths that fall as 1/√n."""
    little = 1.0 + 0.01 * np.random.default_rng(seed).standard_normal(len(LEARNT))
    errors = [LearningErrors(name, "force.y", tuple((v * little).tolist()))
              for name, v in ((OURS, ours), ("peer", peer))]  # fmt: skip
    plans = []
    for name, speed in ((PROPOSED, faster), (RANDOM, 1.0), (FACTORIAL, 1.0)):
        width = tuple((1.0 / np.sqrt(1.0 + speed * np.array(AT[name]))).tolist())
        plans.append(PlannedPair(name, width, width, width))
    return Finished(seed, (*errors, *plans))


def _found(*, ours: float = 0.05, peer: float = 0.06, faster: float = 2.0) -> CurveSummary:
    runs = [_run(seed, ours=ours, peer=peer, faster=faster) for seed in range(1, 9)]
    return curve_summary_of(runs, Origin("pair-curve", "0", "g", "p"))


def test_cuts_to_a_level_are_counted() -> None:
    found = _found()
    above_floor = found.reached[1]
    assert above_floor.width == "given_gain"
    assert_allclose(above_floor.level, 1.0 / np.sqrt(13.0))
    assert (above_floor.proposed, above_floor.like_factorial) == (6, 4)
    assert above_floor.proposed_se == 0.0
    assert found.passed
    assert CurveSummary.from_json(found.to_json()) == found
    slow = _found(faster=0.5).reached[1]
    assert (slow.proposed, slow.like_factorial) == (None, None)


def test_worse_curves_and_slower_plans_fail() -> None:
    assert not _found(ours=0.061).rows[1].passed
    assert not _found(ours=0.11, peer=0.2).rows[0].passed
    assert not _found(faster=1.9).reached[1].halved
    assert not _found(faster=1.0).reached[1].fewer
    assert not any(_found(**bad).passed for bad in ({"ours": 0.061}, {"faster": 1.9}))
