"""A shop's weeks: what is drawn happens, other ways predict, and the score counts rightly."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.proofs.machines.lathe import noses
from autodb.proofs.machines.lathe.jobs import REPEATED, cut_at
from autodb.proofs.machines.lathe.noses import with_nose
from autodb.proofs.machines.lathe.process import STEEL, mean_forces_N
from autodb.proofs.machines.lathe.weeks import (
    BATCHES,
    DRIFT,
    IN_BATCH,
    WeekCut,
    Weeks,
    draw_weeks,
)
from autodb.proofs.runs.run_file import Finished, Origin
from autodb.proofs.runs.weeks.weeks_events import Named
from autodb.proofs.runs.weeks.weeks_peers import by_neighbours, by_squares, by_trees
from autodb.proofs.runs.weeks.weeks_run import Foreseen
from autodb.proofs.runs.weeks.weeks_summary import WeeksSummary, weeks_summary_of

ORIGIN = Origin("weeks", "0", "0", "0")


@pytest.fixture(scope="module")
def weeks() -> Weeks:
    """Return the weeks of a seed."""
    return draw_weeks(11)


def test_the_same_seed_draws_the_same_weeks(weeks: Weeks) -> None:
    again = draw_weeks(11)
    for one, other in zip(weeks.batches, again.batches, strict=True):
        for name in one.table:
            assert np.array_equal(one.table[name], other.table[name])
    assert draw_weeks(12).drifts != weeks.drifts or draw_weeks(12).hard != weeks.hard


def test_what_is_said_to_happen_happens(weeks: Weeks) -> None:
    cuts = [cut for batch in weeks.batches for cut in batch.cuts]
    assert len(cuts) == BATCHES * IN_BATCH
    assert sum(cut.condition == "built-up edge" for cut in cuts) >= 12
    pair, batch = weeks.hard
    hard = [cut for cut in weeks.batches[batch].cuts if cut.pair == pair]
    assert {cut.condition for cut in hard} <= {"hard batch", "built-up edge"}
    assert abs(weeks.drifts[2]) == DRIFT

    # The one change that nobody wrote down: the counter goes on, the true edge is another
    pair, number = weeks.unrecorded
    own = [cut for cut in cuts if cut.pair == pair]
    before, after = own[number - 2], own[number - 1]
    assert before.true.tool_edge != after.true.tool_edge
    assert before.edge == after.edge
    assert after.true.cutting_time_s == 0.0 < before.cutting_time_s < after.cutting_time_s


def test_what_files_before_show_is_all_that_can_be_foreseen(weeks: Weeks) -> None:
    """Beside it a hard bar, a first built-up edge and an unwritten new edge stand out, once."""
    pair, batch = weeks.hard
    own = [cut for cut in weeks.batches[batch].cuts if cut.pair == pair]
    assert min(_beside(cut) for cut in own if cut.condition == "hard batch") > 1.1
    first, later = (
        [_beside(cut) for cut in weeks.batches[k].cuts if cut.condition == "built-up edge"]
        for k in (2, 3)
    )
    assert max(first) < 0.87
    assert min(later) > 0.9
    pair, number = weeks.unrecorded
    cuts = [(k, c) for k, b in enumerate(weeks.batches) for c in b.cuts if c.pair == pair]
    at = cuts[number - 1][0]
    same = [cut for k, cut in cuts[number - 1 :] if k == at]
    assert np.mean([_beside(cut) for cut in same]) < 0.9
    after = [_beside(cut) for k, cut in cuts if k == at + 1 and cut.condition != "hard batch"]
    assert abs(np.mean(after) - 1.0) < 0.05


def _beside(cut: WeekCut) -> float:
    return cut.force_N[1] / cut.foreseeable_N[1]


def test_a_nose_cuts_thin_depths_at_a_smaller_angle() -> None:
    """The reference cut keeps its forces; per mm less depth takes more along, less of the feed."""
    reference, thin, deep = (cut_at((depth, *REPEATED[1:])) for depth in (REPEATED[0], 0.5, 2.5))
    same = mean_forces_N(with_nose(STEEL, reference), reference)
    assert_allclose(same, mean_forces_N(STEEL, reference), rtol=1e-3)
    of_thin, of_deep = (
        mean_forces_N(with_nose(STEEL, cut), cut) / cut.depth_mm for cut in (thin, deep)
    )
    assert of_thin[1] > 1.05 * of_deep[1]
    assert of_thin[2] < 0.9 * of_deep[2]


def test_the_places_of_a_nose_are_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    cuts = [cut_at((depth, *REPEATED[1:])) for depth in (0.5, 1.0, 2.5)]
    coarse = [mean_forces_N(with_nose(STEEL, cut), cut) for cut in cuts]
    monkeypatch.setattr(noses, "NOSE_PLACES", 2 * noses.NOSE_PLACES)
    assert_allclose([mean_forces_N(with_nose(STEEL, cut), cut) for cut in cuts], coarse, rtol=1e-3)


def test_other_ways_find_a_power_law() -> None:
    rng = np.random.default_rng(1)
    cuts = np.column_stack([rng.uniform(-2.0, -1.0, 80), rng.uniform(0.0, 1.0, 80),
                            rng.uniform(4.6, 5.5, 80), rng.uniform(0.0, 900.0, 80)])  # fmt: skip
    force = np.exp(7.0 + cuts[:, 1] + 0.8 * cuts[:, 0] - 0.1 * cuts[:, 2])
    assert_allclose(by_squares(cuts[:60], force[:60], cuts[60:]), force[60:], rtol=1e-6)
    for way in (by_neighbours, by_trees):
        off = way(cuts[:60], force[:60], cuts[60:]) / force[60:] - 1.0
        plain = np.exp(np.mean(np.log(force[:60]) - cuts[:60, 1]) + cuts[60:, 1]) / force[60:] - 1
        assert np.sqrt(np.mean(off**2)) < 0.8 * np.sqrt(np.mean(plain**2))


def _shop(held: float, error: float) -> tuple[Foreseen | Named, ...]:
    """Return a shop of forces of 100 N: a share is held, all are off by a share."""
    found: list[Foreseen | Named] = []
    conditions = ("fresh edge", "worn edge", "built-up edge", "hard batch", "drifted axis")
    for batch in range(1, BATCHES + 1):
        for k in range(IN_BATCH):
            for name in "yz":
                value = 100.0 * (1.0 + error)
                half = 101.0 * error if k < held * IN_BATCH else 0.5 * error
                found.append(
                    Foreseen(batch, k % 3, name, conditions[k % 5], 100.0, value, value - half,
                             value + half, (110.0, 90.0, 105.0), 0.03, 99.0)
                )  # fmt: skip
    return (*found, Named("wear", "tool_wear", 1, 3, 30), Named("", "depth_error", 2, 2, None))


def test_the_score_counts_shops_files_and_names() -> None:
    runs = [Finished(1, _shop(1.0, 0.02)), Finished(2, _shop(0.6, 0.02))]
    found = weeks_summary_of(runs, ORIGIN)
    assert found.pooled.share == pytest.approx(0.8)
    assert found.pooled.se == pytest.approx(0.2)
    assert (found.fewest, found.below, found.files) == ((18, 30), (20, 0), 40)
    assert found.pooled.oracle == 1.0
    for one in found.errors:
        assert one.late == pytest.approx(0.02)
        assert one.peers == pytest.approx((0.1, 0.1, 0.05))
        assert one.soft == pytest.approx(0.02)
        assert one.oracle == pytest.approx(0.99 * 1.03 - 1.0)
        assert one.oracle_soft == pytest.approx(one.oracle)
    wear = next(one for one in found.events if one.name == "wear")
    assert (wear.events, wear.named, wear.cuts) == (2, 2, 30.0)
    assert found.invented == (("depth_error", 2, 2),)
    assert not found.passed
    assert WeeksSummary.from_json(found.to_json()) == found
