"""A posterior about a pair becomes forces, torque and power of cuts not yet made."""

import math
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from pydantic import ValidationError

from autodb.errors import UnusableInput
from autodb.files.job_cut import KEYS, OPERATIONS, JobCut, Operation
from autodb.forward import job_cuts
from autodb.forward.prediction import Interval, PredictedCut, ToolOf
from autodb.pairs.engaged import BY_NAME
from autodb.pairs.posterior import OWN, PairPosterior
from autodb.pairs.prior import any_metal
from tests.helpers.known_pairs import INSERT, known

Array = NDArray[np.float64]

MILL = ToolOf(
    "mill",
    {
        "diameter_mm": 10.0, "teeth": 4, "helix_deg": 30.0, "corner_radius_mm": 0.0,
        "rake_deg": 8.0,
    },
)  # fmt: skip
DRILL = ToolOf("drill", {"diameter_mm": 8.0, "point_angle_deg": 140.0, "helix_deg": 30.0})
TURN = JobCut(name="a", diameter_mm=50, depth_mm=2.0, feed_mm_rev=0.2, speed_rpm=1000)
SLOT = JobCut(name="s", operation="slot", depth_mm=2.0, feed_mm_tooth=0.05, speed_m_min=100)


def one(posterior: PairPosterior, tool: ToolOf, cut: JobCut) -> PredictedCut:
    (found,) = job_cuts.predict(posterior, tool, [cut])
    return found


def test_torque_and_power_follow_from_the_tangential_force() -> None:
    """Both are at the mean radius over the depth, 26 mm, where the force acts."""
    done = one(known(), INSERT, TURN)
    assert_allclose(done.torque_N_m.value, done.force_y_N.value * 0.026)
    assert_allclose(done.speed_m_min, np.pi * 50)
    omega = 1000 * 2 * np.pi / 60
    assert_allclose(done.power_W.value, done.force_y_N.value * 0.026 * omega, rtol=1e-12)
    assert done.passive == "x"
    assert one(known(), INSERT, TURN.model_copy(update={"operation": "face"})).passive == "z"


def test_the_laws_speed_is_that_where_the_force_acts() -> None:
    """A speed stated for the work's diameter and the spindle's speed mean the same cut."""
    (asked,) = known_edges({"spindle.speed": 1000.0})
    (stated,) = known_edges({"cutting.speed": 10 * np.pi})
    (outer,) = known_edges({"spindle.speed": 1000.0, "cutting.speed": 14 * np.pi})
    assert_allclose([asked, stated, outer], 12 * np.pi, rtol=1e-12)


def known_edges(speed: dict[str, float]) -> Array:
    """Return the speed of the edge of a cut of D 10 mm and a_p 2 mm that states a speed."""
    row = {"cutting.feed": 0.2, "cutting.depth": 2.0, "work.diameter": 10.0} | speed
    made = BY_NAME["turn"].cuts(INSERT.numbers, [row], called="insert")
    return made.elements.edge.speed_m_min[:, 0]


def test_either_speed_gives_the_other() -> None:
    by_speed = TURN.model_copy(update={"speed_rpm": None, "speed_m_min": np.pi * 50})
    assert_allclose(one(known(), INSERT, by_speed).speed_rpm, 1000.0)
    assert_allclose(one(known(), MILL, SLOT).speed_rpm, 100e3 / (np.pi * 10.0))


def test_cuts_together_and_alone_are_the_same() -> None:
    """Whatever operations stand between them."""
    cuts = [TURN, TURN.model_copy(update={"operation": "face"}), replace_(TURN, depth_mm=1.0)]
    together = job_cuts.predict(known(), INSERT, cuts)
    for cut, found in zip(cuts, together, strict=True):
        assert found == one(known(), INSERT, cut)


def replace_(cut: JobCut, **changed: Any) -> JobCut:
    return cut.model_copy(update=changed)


def test_a_taper_turns_from_longitudinal_to_facing() -> None:
    """At 0° it is turning but for the law's own error; what is along the feed turns with it."""
    longitudinal = one(known(), INSERT, TURN)
    taper = replace_(TURN, operation="taper", direction_deg=0.0)
    assert_allclose(
        one(known(), INSERT, taper).force_z_N.value, longitudinal.force_z_N.value, rtol=1e-12
    )
    steep = one(known(), INSERT, replace_(taper, direction_deg=40.0))
    assert steep.force_x_N.value > longitudinal.force_x_N.value
    assert steep.force_z_N.value < longitudinal.force_z_N.value


def test_a_tapers_direction_follows_from_its_ends() -> None:
    sloped = JobCut(
        operation="taper", diameter_mm=60, end_diameter_mm=40, length_mm=10, depth_mm=1,
        feed_mm_rev=0.1, speed_rpm=900,
    )  # fmt: skip
    assert_allclose(sloped.conditions(None)["cutting.direction"], 45.0)


def test_what_nobody_stated_of_a_tool_widens_its_intervals() -> None:
    """Bare, the tool is the usual one: the interval holds the stated tool's values, wider."""
    bare = one(known(), ToolOf("x", {}), TURN)
    stated = one(known(), INSERT, TURN)
    for name in ("force_x_N", "force_z_N"):
        assert _half(getattr(bare, name)) > 1.1 * _half(getattr(stated, name))
        found, true = getattr(bare, name), getattr(stated, name).value
        assert found.low < true < found.high


def _half(interval: Interval) -> float:
    return 0.5 * (interval.high - interval.low)


def test_intervals_narrow_as_the_posterior_does() -> None:
    wide, narrow = one(known(1.0), INSERT, TURN), one(known(0.01), INSERT, TURN)
    for name in ("force_y_N", "torque_N_m", "power_W"):
        assert _half(getattr(wide, name)) > 5.0 * _half(getattr(narrow, name))


def test_a_mills_peak_is_no_less_than_its_mean_and_follows_its_teeth() -> None:
    """In a slot two of four straight teeth are engaged: sin φ + cos φ, mean 4/π, peak √2.

    What goes with a thin chip bends that by less than 1 %.
    """
    done = one(known(), MILL, SLOT)
    assert done.peaks is not None
    for name in ("force_x_N", "force_y_N", "torque_N_m"):
        assert abs(getattr(done.peaks, name).value) >= abs(getattr(done, name).value)
    straight = ToolOf("m", {**MILL.numbers, "helix_deg": 0.0})
    done = one(known(), straight, replace_(SLOT, depth_mm=0.5))
    assert done.peaks is not None
    ratio = done.peaks.torque_N_m.value / done.torque_N_m.value
    assert_allclose(ratio, math.sqrt(2.0) * math.pi / 4.0, rtol=0.01)


@pytest.mark.parametrize("operation", OPERATIONS)
def test_every_operation_is_predicted(operation: Operation) -> None:
    given = {
        "diameter_mm": 40.0, "depth_mm": 1.0, "feed_mm_rev": 0.1, "feed_mm_tooth": 0.05,
        "width_mm": 2.0, "ramp_deg": 3.0, "pocket_diameter_mm": 30.0, "direction_deg": 10.0,
    }  # fmt: skip
    keys = KEYS[operation]
    named = {name: given[name] for name in (*keys.needs, *keys.may) if name in given}
    cut = JobCut.model_validate({"operation": operation, "speed_rpm": 1500, **named})
    tool = {"turning_insert": INSERT, "end_mill": MILL, "drill": DRILL}[BY_NAME[operation].kind]
    done = one(known(), tool, cut)
    assert done.power_W.value > 0
    for end in ("value", "low", "high"):
        torque_N_m, power_W = getattr(done.torque_N_m, end), getattr(done.power_W, end)
        assert_allclose(power_W, torque_N_m * 1500 * np.pi / 30, rtol=1e-9)
    assert (done.peaks is not None) == (BY_NAME[operation].kind == "end_mill")
    assert set(BY_NAME) == {*KEYS, "mill"}  # the path of a program alone says how a mill cuts


def test_a_tool_that_cannot_make_a_cut_is_named() -> None:
    with pytest.raises(UnusableInput, match="mill's diameter is not known"):
        one(known(), ToolOf("m", {}), SLOT)
    with pytest.raises(UnusableInput, match="teeth is not known"):
        one(known(), ToolOf("m", {"diameter_mm": 10.0}), SLOT)
    with pytest.raises(UnusableInput, match="use one with 2"):
        three = ToolOf("d", {"diameter_mm": 8.0, "teeth": 3})
        one(known(), three, JobCut(operation="drill", feed_mm_rev=0.1, speed_rpm=900))


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"operation": "slot", "feed_mm_rev": 0.1, "depth_mm": 1}, "needs feed_mm_tooth"),
        ({"operation": "drill", "feed_mm_rev": 0.1, "width_mm": 1}, "has no width_mm"),
        ({"diameter_mm": 5, "depth_mm": 1}, "'turn' needs feed_mm_rev"),
        ({"operation": "contour", "diameter_mm": 5, "depth_mm": 1, "feed_mm_rev": 1},
         "needs direction_deg"),
    ],
)  # fmt: skip
def test_keys_that_an_operation_needs_or_has_not_are_named(
    given: dict[str, Any], says: str
) -> None:
    with pytest.raises(ValidationError, match=says):
        JobCut(speed_rpm=1000, **given)


def test_a_posterior_of_nothing_predicts_within_what_metals_may_have() -> None:
    """Specific cutting force of metals, N/mm²: 500 (aluminium) to 4000 (nickel alloys)."""
    done = one(any_metal(), INSERT, TURN)
    area = 2.0 * 0.2
    assert 0 < done.force_y_N.low / area < 500
    assert_allclose(done.force_y_N.high * done.force_y_N.low, done.force_y_N.value**2, rtol=1e-12)
    assert done.force_y_N.high / area > 4000
    assert any_metal().state.mean.shape == (OWN,)
