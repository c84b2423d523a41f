"""Two hundred drawn cuts of ten kinds, predicted and by a text book's formulas (a helper's)."""

from collections.abc import Callable
from dataclasses import replace
from math import acos, hypot, pi, radians

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.cutting import shear
from autodb.files.job_cut import JobCut
from autodb.fitting.gaussian import Gaussian
from autodb.forward.job_cuts import predict
from autodb.forward.prediction import ToolOf
from autodb.pairs.posterior import PairPosterior
from autodb.pairs.prior import any_metal
from tests.helpers import hand_calculation as hand
from tests.helpers.plain_law import PLAIN

Numbers = dict[str, float]
Drawn = tuple[str, Numbers, Numbers, Callable[[Numbers], hand.Four]]
EACH = 20
WITHIN = 0.02
"""Of the resultant, and of the torque."""
RNG = np.random.default_rng


def _law(rng: np.random.Generator) -> Numbers:
    """Return numbers of a material, from soft to tough, with a chip that flows as its edge does."""
    return PLAIN | {
        "shear_stress": rng.uniform(200.0, 900.0),
        "friction_angle": rng.uniform(18.0, 32.0),
        "chip_ratio": rng.uniform(0.25, 0.55),
        "chip_ratio_thickness": rng.uniform(0.0, 0.2),
        "friction_speed": rng.uniform(-0.1, 0.1),
        "K_te": rng.uniform(5.0, 40.0),
        "K_re": rng.uniform(5.0, 60.0),
    }


def _insert(rng: np.random.Generator) -> Numbers:
    return {
        "nose_radius_mm": rng.uniform(0.2, 1.2), "kappa_deg": rng.uniform(75.0, 95.0),
        "rake_deg": rng.uniform(-8.0, 10.0), "inclination_deg": rng.uniform(-6.0, 6.0),
        "included_deg": rng.uniform(55.0, 80.0),
    }  # fmt: skip


def _turned(rng: np.random.Generator) -> Numbers:
    return {
        "diameter_mm": rng.uniform(20.0, 120.0), "depth_mm": rng.uniform(0.3, 4.0),
        "feed_mm_rev": rng.uniform(0.05, 0.5), "speed_rpm": rng.uniform(300.0, 2500.0),
    }  # fmt: skip


def _along(rng: np.random.Generator, operation: str) -> Drawn:
    tool, cut = _insert(rng), _turned(rng)
    inward = {"turn": 0.0, "face": 90.0, "taper": rng.uniform(3.0, 35.0)}[operation]
    asked = cut | ({"direction_deg": inward} if operation == "taper" else {})
    return operation, tool, asked, lambda of: hand.path(of, tool, cut, radians(inward))


def _inside(rng: np.random.Generator, operation: str) -> Drawn:
    tool, cut = _insert(rng), _turned(rng)
    return operation, tool, cut, lambda of: hand.bore(of, tool, cut)


def _bladed(rng: np.random.Generator, operation: str) -> Drawn:
    """Return a groove, or a cut that parts: one at a small diameter."""
    tool, cut = _insert(rng), _turned(rng)
    cut = {k: cut[k] for k in ("diameter_mm", "feed_mm_rev", "speed_rpm")}
    cut["width_mm"] = rng.uniform(1.5, 5.0)
    if operation == "part":
        cut["diameter_mm"] = rng.uniform(2.0, 10.0)
    return "groove", tool, cut, lambda of: hand.groove(of, tool, cut)


def _threaded(rng: np.random.Generator, operation: str) -> Drawn:
    tool, cut = _insert(rng), _turned(rng)
    cut |= {"depth_mm": rng.uniform(0.05, 0.3), "width_mm": rng.uniform(0.4, 1.8)}
    return operation, tool, cut, lambda of: hand.thread(of, tool, cut)


def _milled(rng: np.random.Generator, operation: str) -> Drawn:
    tool = {
        "diameter_mm": rng.uniform(6.0, 25.0), "teeth": float(rng.integers(2, 6)),
        "helix_deg": rng.uniform(0.0, 45.0), "rake_deg": rng.uniform(0.0, 14.0),
        "corner_radius_mm": 0.0,
    }  # fmt: skip
    cut = {
        "depth_mm": rng.uniform(0.5, 10.0), "feed_mm_tooth": rng.uniform(0.02, 0.15),
        "speed_rpm": rng.uniform(1000.0, 8000.0),
    }  # fmt: skip
    if operation == "slot":
        return operation, tool, cut, lambda of: hand.milled(of, tool, cut, 0.0, pi)
    cut["width_mm"] = rng.uniform(0.05, 0.9) * tool["diameter_mm"]
    reach = acos(1.0 - 2.0 * cut["width_mm"] / tool["diameter_mm"])
    up = bool(rng.integers(2))
    ends = (0.0, reach) if up else (pi - reach, pi)
    called = "side-up" if up else "side-down"
    return called, tool, cut, lambda of: hand.milled(of, tool, cut, *ends)


def _drilled(rng: np.random.Generator, operation: str) -> Drawn:
    tool = {
        "diameter_mm": rng.uniform(3.0, 20.0), "point_angle_deg": rng.uniform(115.0, 142.0),
        "helix_deg": rng.uniform(20.0, 35.0), "web_share": rng.uniform(0.1, 0.2), "teeth": 2.0,
    }  # fmt: skip
    cut = {"feed_mm_rev": rng.uniform(0.05, 0.3), "speed_rpm": rng.uniform(500.0, 4000.0)}
    return operation, tool, cut, lambda of: hand.drilled(of, tool, cut)


KINDS: dict[str, Callable[[np.random.Generator, str], Drawn]] = {
    "turn": _along, "face": _along, "taper": _along, "bore": _inside, "groove": _bladed,
    "part": _bladed, "thread": _threaded, "slot": _milled, "side": _milled, "drill": _drilled,
}  # fmt: skip


def _posterior(law: Numbers) -> PairPosterior:
    known = any_metal()
    covariance = 1e-4 * known.state.covariance
    return replace(known, state=Gaussian(shear.law_coordinates(law), covariance))


@pytest.mark.parametrize("kind", KINDS)
def test_drawn_cuts_are_as_by_hand(kind: str) -> None:
    """Forces within 2 % of the resultant, torque within 2 %, power torque times angular speed.

    Of a mill the mean over a turn, with helices up to 45°.
    """
    rng = RNG(4000 + list(KINDS).index(kind))
    for _ in range(EACH):
        law = _law(rng)
        operation, tool, cut, by_hand = KINDS[kind](rng, kind)
        asked = JobCut.model_validate({"operation": operation, **cut})
        (made,) = predict(_posterior(law), ToolOf("tool", tool), [asked])
        *forces, torque = by_hand(law)
        found = [made.force_x_N.value, made.force_y_N.value, made.force_z_N.value]
        assert_allclose(found, forces, rtol=0, atol=WITHIN * hypot(*forces))
        assert_allclose(made.torque_N_m.value, torque, rtol=WITHIN)
        turns = 2.0 * pi * made.speed_rpm / 60.0
        assert_allclose(made.power_W.value, made.torque_N_m.value * turns, rtol=1e-12)
