"""Limits of a machine that a predicted cut may exceed, and how probably."""

from dataclasses import replace

import pytest
from numpy.testing import assert_allclose

from autodb.files.machine import AxisLimits
from autodb.forward.limits import exceeding
from autodb.forward.prediction import Interval, Peaks, PredictedCut, chance_beyond

CUT = PredictedCut(
    name="rough",
    operation="turn",
    speed_rpm=1200.0,
    speed_m_min=150.0,
    force_x_N=Interval(0.0, -50.0, 50.0),
    force_y_N=Interval(900.0, 900.0 - 196.0, 900.0 + 196.0),
    force_z_N=Interval(-400.0, -400.0 - 98.0, -400.0 + 98.0),
    torque_N_m=Interval(25.0, 20.0, 30.0),
    power_W=Interval(2000.0, 1900.0, 2100.0),
)


def test_the_probability_is_the_normals() -> None:
    """Half at the limit, 2.5 % where the interval ends, in either direction."""
    assert_allclose(chance_beyond(CUT.force_y_N, 900.0), 0.5, atol=1e-12)
    assert_allclose(chance_beyond(CUT.force_y_N, 1096.0), 0.025, atol=1e-6)
    assert_allclose(chance_beyond(CUT.force_z_N, 498.0), 0.025, atol=1e-6)
    assert_allclose(chance_beyond(Interval(10.0, -2.0, 22.0), 0.0), 1.0)
    assert chance_beyond(Interval(5.0, 5.0, 5.0), 4.0) == 1.0


def test_limits_are_named_by_axis_in_the_order_of_cuts() -> None:
    limits = {
        "x": AxisLimits(force_N=1000.0),
        "z": AxisLimits(force_N=450.0),
        "spindle": AxisLimits(torque_N_m=26.0, speed_rpm=1000.0),
    }
    light = replace(CUT, name="light", force_z_N=Interval(10.0, 8.0, 12.0), speed_rpm=900.0)
    found = exceeding([light, CUT], limits)
    assert [(one.cut, one.axis, one.unit) for one in found] == [
        (1, "spindle", "N·m"),
        (2, "z", "N"),
        (2, "spindle", "N·m"),
        (2, "spindle", "rpm"),
    ]
    assert found[1].statement == "16 % chance to exceed z's 450 N"
    assert found[3].statement == "faster than spindle's 1000 rpm"
    assert exceeding([light, CUT], {"z": AxisLimits()}) == ()


@pytest.mark.parametrize(
    ("limit", "said"), [(500.0, "over 99.9 %"), (1150.0, "0.62 %"), (650.0, "99 %")]
)
def test_percentages_are_readable(limit: float, said: str) -> None:
    (one,) = exceeding([CUT], {"y": AxisLimits(force_N=limit)})
    assert one.statement.startswith(said)


def test_a_mills_peak_counts_not_its_mean() -> None:
    """The mean is well below the limit, the peak of a turn half as often above as below."""
    most = Interval(500.0, 402.0, 598.0)
    peaks = Peaks(most, most, most, most, most)
    milled = replace(CUT, force_x_N=Interval(100.0, 90.0, 110.0), peaks=peaks)
    limits = {"x": AxisLimits(force_N=500.0)}
    (one,) = exceeding([milled], limits)
    assert_allclose(one.probability, 0.5, atol=1e-9)
    assert exceeding([replace(milled, peaks=None)], limits) == ()
