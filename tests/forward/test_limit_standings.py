"""Each limit of a machine is within, exceeded, or not entered: none is kept by silence."""

import tomllib
from dataclasses import replace

import pytest
from numpy.testing import assert_allclose
from pydantic import ValidationError

from autodb.files.machine import AxisLimits
from autodb.forward.limits import (
    fastest_rpm,
    limit_standings,
    load_limit,
    standings_in_words,
)
from autodb.forward.line_parts import feed_spans_mm
from autodb.forward.prediction import Interval, Moment, PredictedCut

FORCE = Interval(500.0, 402.0, 598.0)
CUT = PredictedCut(
    name="rough", operation="turn", speed_rpm=1200.0, speed_m_min=150.0,
    force_x_N=FORCE, force_y_N=FORCE, force_z_N=FORCE,
    torque_N_m=Interval(25.0, 20.0, 31.25), power_W=Interval(3141.6, 2513.3, 3927.0),
    feed_mm_min=300.0,
)  # fmt: skip
CURVES = AxisLimits(
    torque_curve=((500.0, 60.0), (1000.0, 60.0), (4000.0, 15.0)),
    power_curve=((1000.0, 6283.2), (4000.0, 6283.2)),
    efficiency=0.8,
)


def test_what_nobody_entered_is_said() -> None:
    """Of a lathe without limits: force and feed of its axes, torque, power and speed."""
    found = limit_standings([CUT], {"x": AxisLimits(), "z": AxisLimits()})
    assert {one.standing for one in found} == {"not entered"}
    assert [f"{one.axis} {one.quantity}" for one in found] == [
        "x force", "z force", "z feed", "spindle torque", "spindle power", "spindle speed",
    ]  # fmt: skip
    (said,) = standings_in_words(found)
    assert said.startswith("limits not entered: x force, z force")


def test_within_is_where_the_interval_ends_within() -> None:
    limits = {
        "x": AxisLimits(force_N=599.0),
        "z": AxisLimits(force_N=597.0, speed_mm_min=299.0),
        "spindle": AxisLimits(power_W=4000.0, speed_rpm=1200.0),
    }
    stands = {(o.axis, o.quantity): o.standing for o in limit_standings([CUT], limits)}
    assert stands == {
        ("x", "force"): "within", ("z", "force"): "exceeded", ("z", "feed"): "exceeded",
        ("spindle", "torque"): "not entered", ("spindle", "power"): "within",
        ("spindle", "speed"): "within",
    }  # fmt: skip


@pytest.mark.parametrize(
    ("rpm", "torque", "power"),
    [
        (200.0, 48.0, 0.8 * 1256.6), (750.0, 48.0, 0.8 * 4712.4), (2000.0, 24.0, 0.8 * 6283.2),
        (4001.0, None, None),
    ],
)  # fmt: skip
def test_a_curve_is_of_constant_torque_and_then_of_constant_power(
    rpm: float, torque: float | None, power: float | None
) -> None:
    """Between its points and below the first; where it ends, nothing is given."""
    cut = replace(CUT, speed_rpm=rpm)
    for key, expected in (("torque_N_m", torque), ("power_W", power)):
        found = load_limit(CURVES, key, cut)
        assert (found is None) == (expected is None)
        if found is not None and expected is not None:
            assert_allclose(found, expected, rtol=1e-4)


def test_where_a_curve_ends_so_does_the_speed() -> None:
    assert fastest_rpm(CURVES) == 4000.0
    assert fastest_rpm(CURVES.model_copy(update={"speed_rpm": 3000.0})) == 3000.0
    fast = replace(CUT, speed_rpm=4500.0)
    stands = {one.quantity: one.standing for one in limit_standings([fast], {"spindle": CURVES})}
    assert stands == {"torque": "not entered", "power": "not entered", "speed": "exceeded"}


def test_a_cut_that_gets_faster_has_the_torque_of_its_fastest_moment() -> None:
    ends = [Moment(40.0, rpm, 100.0, *[FORCE] * 5) for rpm in (1000.0, 3000.0)]
    cut = replace(CUT, speed_rpm=1000.0, start=ends[0], end=ends[1])
    found = load_limit(CURVES, "torque_N_m", cut)
    assert found is not None
    assert_allclose(found, 0.8 * 20.0, rtol=1e-4)


def test_what_reaches_further_than_a_travel_fits_nowhere() -> None:
    limits = {
        "x": AxisLimits(travel_low_mm=-10.0, travel_high_mm=150.0),
        "z": AxisLimits(travel_low_mm=0.0, travel_high_mm=100.0),
        "y": AxisLimits(),
    }
    found = limit_standings([CUT], limits, {"x": 40.0, "z": 100.1, "y": 5.0, "w": 3.0})
    stands = {one.axis: one.standing for one in found if one.quantity == "travel"}
    assert stands == {"x": "within", "z": "exceeded", "y": "not entered"}


def test_a_tool_s_feeds_span_its_own_places() -> None:
    """Offsets of another tool do not count: the widest of each is what has to fit."""
    fed: list[tuple[str | None, dict[str, float], dict[str, float]]] = [
        ("1", {"z": 0.0}, {"z": -40.0}), ("2", {"z": 200.0}, {"z": 180.0}),
    ]  # fmt: skip
    assert feed_spans_mm(fed) == {"z": 40.0}


@pytest.mark.parametrize(
    ("stated", "said"),
    [
        ("torque_curve = [[2000, 10], [1000, 20]]", "with speeds that rise"),
        ("power_curve = [[2000, 10]]", "power_curve"),
        ("efficiency = 0.9", "goes with torque_curve"),
        ("efficiency = 1.2\npower_curve = [[1, 2], [3, 4]]", "efficiency"),
    ],
)
def test_a_curve_that_is_none_is_refused(stated: str, said: str) -> None:
    with pytest.raises(ValidationError, match=said):
        AxisLimits.model_validate(tomllib.loads(stated))
