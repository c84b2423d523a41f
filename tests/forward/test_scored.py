"""Scores of predictions that are off by a known factor, and the width of the next ones."""

from dataclasses import replace

import numpy as np
import pytest

from autodb.fitting.gaussian import NORMAL_95
from autodb.forward.prediction import Interval, wider_interval
from autodb.forward.scored import (
    AS_STATED,
    Scored,
    score_of,
    width_of,
)

SD, SENSED = 0.04, 0.015
"""Of a force of 1000 N: what is stated of the prediction, and of what is sensed; shares."""


def _shop(
    seed: int, scatter: float, recordings: int, *, cuts: int = 5, widened: float = 1.0
) -> list[Scored]:
    """Draw cuts whose errors are ``scatter`` times what is stated, half of the variance a day's."""
    rng = np.random.default_rng(seed)
    found = []
    for recording in range(recordings):
        day = rng.standard_normal(3)
        for cut in range(cuts):
            both = np.sqrt(0.5) * (day + rng.standard_normal(3))
            made = 1000.0 * (1.0 + scatter * SD * both + SENSED * rng.standard_normal(3))
            half = 1000.0 * NORMAL_95 * SD * widened
            found += [
                Scored(
                    f"force.{c}", 100 * recording + cut, recording,
                    Interval(1000.0, 1000.0 - half, 1000.0 + half), float(value), 1000.0 * SENSED,
                    widened,
                )
                for c, value in zip("xyz", made, strict=True)
            ]  # fmt: skip
    return found


def test_a_shop_that_scatters_twice_as_much_gets_intervals_twice_as_wide() -> None:
    """1000 cuts of 200 recordings: the factor's sd is below 3 %, its limit at four of these."""
    width = width_of(_shop(1, 2.0, 200), [], upto=None)
    assert width.factor == pytest.approx(2.0, rel=0.12)
    assert (width.cuts, width.recordings) == (1000, 200)


def test_coverage_returns_with_the_factor() -> None:
    """Of 1000 further cuts 67 % are inside before; with it 95 % ± 3.3 %, beyond that once in 1000.

    1000 cuts of which each recording's five count as 2.5 are 500, with sd 1 % of a share of 95 %.
    """
    factor = width_of(_shop(1, 2.0, 200), [], upto=None).factor
    before = score_of("force.y", [s for s in _shop(2, 2.0, 200) if s.quantity == "force.y"])
    after = score_of(
        "force.y", [s for s in _shop(2, 2.0, 200, widened=factor) if s.quantity == "force.y"]
    )
    assert before.inside < 0.75
    assert before.rms_z == pytest.approx(1.9, rel=0.1)
    assert after.inside == pytest.approx(0.95, abs=0.033)
    assert after.inside_low < 0.95 < after.inside_high
    assert after.rms_z == pytest.approx(1.0, rel=0.15)


def test_what_was_widened_already_is_not_widened_once_more() -> None:
    once = width_of(_shop(1, 2.0, 40), [], upto=None)
    again = width_of(_shop(1, 2.0, 40, widened=1.7), [], upto=None)
    assert again.factor == pytest.approx(once.factor, rel=1e-6)


@pytest.mark.parametrize("scatter", [0.5, 1.0])
def test_intervals_that_hold_stay_as_they_are(scatter: float) -> None:
    assert width_of(_shop(3, scatter, 60), [], upto=None).factor == 1.0
    assert width_of([], [], upto=None) == AS_STATED


def test_few_cuts_change_little_and_those_of_one_recording_less_than_of_many() -> None:
    one = width_of(_shop(4, 3.0, 1, cuts=8), [], upto=None).factor
    many = width_of(_shop(4, 3.0, 8, cuts=1), [], upto=None).factor
    assert one < 1.6
    assert one < many < 3.0


def test_one_broken_edge_widens_little() -> None:
    """A force twenty times its standard deviation off, among forty that are as stated."""
    held = _shop(5, 1.0, 8)
    broken = replace(held[0], cut=9999, recording=9, made=1000.0 * (1.0 + 20.0 * SD))
    assert width_of([*held, broken], [], upto=None).factor < 1.3


def test_a_pair_begins_with_what_the_others_of_its_machine_say() -> None:
    others = _shop(6, 2.0, 100)
    assert width_of([], others, upto=None).factor == pytest.approx(2.0, rel=0.15)
    held = width_of(_shop(7, 1.0, 100), others, upto=None).factor
    assert held < 1.25


def test_what_has_no_stated_error_says_nothing_of_the_width() -> None:
    torque = [replace(one, quantity="torque.spindle", sd=None) for one in _shop(8, 3.0, 40)]
    assert width_of(torque, [], upto=None) == AS_STATED
    assert score_of("torque.spindle", torque).cuts == len(torque)


def test_error_and_bias_are_relative_to_what_was_made() -> None:
    cuts = [
        Scored("force.z", k, k, Interval(value, value - 50.0, value + 50.0), 100.0, 1.0)
        for k, value in enumerate((90.0, 110.0, 115.0))
    ]
    score = score_of("force.z", cuts)
    assert [score.error, score.bias] == pytest.approx([0.10, 0.10])
    assert score.inside == 1.0
    assert score.inside_high == 1.0
    assert score.inside_low == pytest.approx(0.025 ** (1 / 3))  # Clopper and Pearson, 3 of 3


@pytest.mark.parametrize(
    ("interval", "wide"),
    [
        (Interval(100.0, 90.0, 110.0), (70.0, 130.0)),
        (Interval(-100.0, -110.0, -90.0), (-130.0, -70.0)),
        (Interval(100.0, 80.0, 125.0), (51.2, 195.3125)),
        (Interval(-100.0, -125.0, -80.0), (-195.3125, -51.2)),
        (Interval(0.0, -1.0, 1.0), (-3.0, 3.0)),
        (Interval(0.0, 0.0, 0.0), (0.0, 0.0)),
    ],
)
def test_an_interval_gets_wider_as_it_was_made(
    interval: Interval, wide: tuple[float, float]
) -> None:
    """Normal ones on both sides alike, those of a logarithm by a power: none changes its sign."""
    found = wider_interval(interval, 3.0)
    assert (found.value, found.low, found.high) == pytest.approx((interval.value, *wide))
