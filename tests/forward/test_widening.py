"""Intervals are wider as past predictions were off, for older edges, and for excluded cuts."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy.stats import norm

from autodb.forward.limits import QUANTITIES
from autodb.forward.prediction import Interval, Moment, PredictedCut
from autodb.forward.widening import (
    GROWN,
    HALF_LIFE,
    LIFE_S,
    UndecidedCuts,
    chance_as_old,
    holding_too,
    mean_of_both,
    placed,
    wider,
    with_room_for_wear,
)
from autodb.pairs.engaged import CUTTING_TIME, SPEED

SD = 0.03
"""Share of a force that its prediction and its sensing are off by."""


def _around(value: float) -> Interval:
    return Interval(value, value * (1.0 - 1.96 * SD), value * (1.0 + 1.96 * SD))


FORCES = (_around(300.0), _around(900.0), _around(500.0), _around(25.0), _around(3000.0))


def _predicted(speed: float = 200.0, state: str | None = None) -> PredictedCut:
    return PredictedCut("cut", "turn", 1000.0, speed, *FORCES, state=state)


def _undecided(
    off: list[float], *, stated: list[dict[str, float]], excluded: list[bool]
) -> UndecidedCuts:
    """Return cuts that were off so along the cutting speed and along the feed; x is not sensed."""
    both = np.column_stack([np.full(len(off), np.nan), off, off])
    return UndecidedCuts(
        placed=np.array([placed(one) for one in stated]),
        excluded=np.array(excluded),
        off=both,
        sd=np.where(np.isnan(both), np.nan, SD),
        waiting=((1, "force.y", "tool_wear"),),
    )


def test_a_band_of_speed_widens_where_it_is() -> None:
    speeds = [200.0] * 20 + [95.0] * 6
    off = [0.0] * 20 + [-0.25] * 6
    cuts = _undecided(off, stated=[{SPEED: v} for v in speeds], excluded=[v < 100 for v in speeds])
    slow, fast = cuts.widened([_predicted(95.0), _predicted(200.0)], [{}, {}])
    for name in ("force_y_N", "force_z_N", "torque_N_m", "power_W"):
        own, was = getattr(slow, name), getattr(_predicted(), name)
        assert own.low < 0.76 * own.value < was.low
        assert own.high == pytest.approx(was.high)
        assert own.value == was.value
        elsewhere = getattr(fast, name)
        assert elsewhere.low > 0.80 * elsewhere.value
    assert slow.force_x_N == _predicted().force_x_N  # nobody sensed it


def test_wear_widens_cuts_whose_edge_is_as_old() -> None:
    used = [*range(0, 1000, 50)] * 6
    off = [0.3 if age > 900 else 0.0 for age in used]
    cuts = _undecided(
        off, stated=[{SPEED: 200.0, CUTTING_TIME: float(age)} for age in used],
        excluded=[age > 900 for age in used],
    )  # fmt: skip
    fresh, old = cuts.widened([_predicted()] * 2, [{CUTTING_TIME: 20.0}, {CUTTING_TIME: 950.0}])
    assert old.force_y_N.high > 1.3 * 900.0
    assert fresh.force_y_N.high < 1.15 * 900.0


def test_what_nobody_can_place_widens_everywhere_and_the_newest_tell_most() -> None:
    stated = [{SPEED: 200.0}] * 80
    shown = [0.3] * 10
    late = _undecided([0.0] * 70 + shown, stated=stated, excluded=[False] * 70 + [True] * 10)
    early = _undecided(shown + [0.0] * 70, stated=stated, excluded=[True] * 10 + [False] * 70)
    (now,), (then,) = (one.widened([_predicted()], [{}]) for one in (late, early))
    assert now.force_y_N.high > 1.3 * 900.0
    assert _predicted().force_y_N.high <= then.force_y_N.high < now.force_y_N.high


def test_cuts_of_either_kind_are_held_as_often_as_they_should_be() -> None:
    rng = np.random.default_rng(5)
    held = []
    for _ in range(40):
        other = rng.random(100) < 0.3
        made = 900.0 * np.where(other, rng.normal(1.25, 0.05, 100), rng.normal(1.0, SD, 100))
        seen = _undecided(
            (made / 900.0 - 1.0).tolist(), stated=[{SPEED: 200.0}] * 100, excluded=other.tolist()
        )
        (cut,) = seen.widened([_predicted()], [{}])
        again = rng.random(50) < 0.3
        to_come = 900.0 * np.where(again, rng.normal(1.25, 0.05, 50), rng.normal(1.0, SD, 50))
        held.append(np.mean((to_come >= cut.force_y_N.low) & (to_come <= cut.force_y_N.high)))
    assert 0.93 < np.mean(held) < 0.985


def test_ends_are_those_of_the_mixture() -> None:
    """By the formulas of the module's text: a share of 2.5 % is below the low one."""
    count, off = 40, -0.3
    cuts = _undecided(
        [0.0] * (count - 1) + [off], stated=[{SPEED: 200.0}] * count,
        excluded=[False] * (count - 1) + [True],
    )  # fmt: skip
    (cut,) = cuts.widened([_predicted()], [{}])
    weights = 2.0 ** (-np.arange(count)[::-1] / HALF_LIFE)
    total = np.sum(weights)
    chance = (weights[-1] + weights[-1] / total) / (total + 1.0)
    force, sd = cut.force_y_N, SD * 900.0
    own, other = norm.cdf(force.low, 900.0, sd), norm.cdf(force.low, (1.0 + off) * 900.0, sd)
    assert (1.0 - chance) * own + chance * other == pytest.approx(0.025, rel=1e-3)
    assert force.high == _predicted().force_y_N.high  # never inside of what was learnt


def test_what_was_learnt_from_the_others_is_bent_too() -> None:
    stated = [{SPEED: 200.0}] * 31
    cuts = _undecided([0.08] * 30 + [0.1], stated=stated, excluded=[False] * 30 + [True])
    (cut,) = cuts.widened([_predicted()], [{}])
    assert cut.force_y_N.high > 900.0 * (1.08 + 1.5 * SD)
    assert cut.force_y_N.low == pytest.approx(_predicted().force_y_N.low)


def test_a_decided_state_stays_as_it_is_and_ends_go_along() -> None:
    cuts = _undecided([0.4] * 8, stated=[{SPEED: 200.0}] * 8, excluded=[True] * 8)
    own = _predicted(state="hard_spot")
    facing = replace(_predicted(), start=Moment(60.0, 1000.0, 188.0, *FORCES))
    same, widened = cuts.widened([own, facing], [{}, {}])
    assert same == own
    assert widened.start is not None
    assert_allclose(widened.start.force_y_N.high, widened.force_y_N.high)


def test_an_older_edge_than_any_seen_leaves_room_upwards() -> None:
    cut = _predicted()
    same = with_room_for_wear(cut, cut_s=300.0, seen_s=400.0)
    assert same == cut
    older = with_room_for_wear(cut, cut_s=400.0 + LIFE_S, seen_s=400.0)
    feed = older.force_z_N
    assert feed.high == pytest.approx(cut.force_z_N.high + GROWN["Ff"] * 500.0)
    assert feed.low == pytest.approx(cut.force_z_N.low)
    assert older.torque_N_m.high > cut.torque_N_m.high
    mill = replace(cut, operation="slot")
    assert with_room_for_wear(mill, cut_s=1000.0, seen_s=0.0) == mill


def test_two_accounts_are_held_at_each_moment() -> None:
    worn = replace(_predicted(), start=Moment(60.0, 1000.0, 188.0, *FORCES))
    new = _scaled(worn, 0.6)
    both = holding_too(worn, new)
    for one, other, held in (
        (worn, new, both), (worn.start, new.start, both.start)
    ):  # fmt: skip
        assert one is not None
        assert other is not None
        assert held is not None
        assert held.force_y_N.value == one.force_y_N.value
        assert held.force_y_N.low == other.force_y_N.low
        assert held.force_y_N.high == one.force_y_N.high
        assert held.power_W.low == other.power_W.low
    assert holding_too(worn, worn) == worn
    assert holding_too(worn, _predicted()).start == worn.start


def test_values_are_the_mean_of_both_accounts_by_their_probability() -> None:
    worn = replace(_predicted(), start=Moment(60.0, 1000.0, 188.0, *FORCES))
    new = _scaled(worn, 0.6)
    both = mean_of_both(holding_too(worn, new), new, 0.25)
    assert both.start is not None
    for one, own in ((both, worn), (both.start, worn)):
        assert one.force_y_N.value == pytest.approx(0.7 * own.force_y_N.value)
        assert one.power_W.value == pytest.approx(0.7 * own.power_W.value)
        assert one.force_y_N.high == own.force_y_N.high
    assert mean_of_both(worn, new, 1.0) == worn


def test_an_edge_far_beyond_the_oldest_was_hardly_never_changed() -> None:
    assert chance_as_old(900.0, seen_s=900.0) == 1.0
    assert chance_as_old(500.0, seen_s=900.0) == 1.0
    assert chance_as_old(1800.0, seen_s=900.0) == pytest.approx(1.0 / 16.0)


def _scaled(cut: PredictedCut, by: float) -> PredictedCut:
    """Return a cut with all that it takes, and its start, so many times as large."""

    def less(one: PredictedCut | Moment) -> dict[str, Any]:
        every = {each.field: getattr(one, each.field) for each in QUANTITIES}
        return {n: Interval(by * i.value, by * i.low, by * i.high) for n, i in every.items()}

    start = None if cut.start is None else replace(cut.start, **less(cut.start))
    return replace(cut, start=start, **less(cut))


def _intervals(found: PredictedCut | Moment) -> NDArray[np.float64]:
    every = [getattr(found, one.field) for one in QUANTITIES]
    return np.array([[one.value, one.high] for one in every])


def test_all_of_a_predicted_cut_gets_wider_and_none_of_it_where_nothing_is_known() -> None:
    one = Interval(100.0, 80.0, 120.0)
    ends = Moment(50.0, 1000.0, 150.0, one, one, one, one, one)
    cut = PredictedCut("face", "face", 1000.0, 150.0, one, one, one, one, one, start=ends)
    assert wider(cut, 1.0) is cut
    found = wider(cut, 2.0)
    assert found.start is not None
    for some in (found, found.start):
        assert np.array_equal(_intervals(some), np.tile([100.0, 140.0], (5, 1)))
