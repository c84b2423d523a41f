"""Axes drawn at random: the effort is the sum of its parts, and no part has an estimator's form."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from autodb.proofs.machines.axis import curves
from autodb.proofs.machines.axis.axes import DrawnAxis, draw_axis, draw_motion, draw_run, parts_A
from autodb.proofs.machines.axis.curves import FrictionCurve
from autodb.proofs.machines.axis.quantities import FRICTION_MM_S, NAMES, quantities
from autodb.proofs.machines.lathe.process import Array
from autodb.terms.friction import stribeck
from tests.helpers.campaigns import first

VISCOUS: tuple[FrictionCurve, ...] = (
    curves.TableCurve((0.0, 10.0, 30.0, 80.0, 250.0), (0.0, 1.0, 2.5, 5.0, 9.0)),
    curves.RationalCurve(400.0),
    curves.LogCurve(40.0),
    curves.PowerCurve(0.85),
)
DIPS: tuple[FrictionCurve, ...] = (
    curves.GaussianDip(7.0),
    curves.RationalDip(7.0),
    curves.ExponentialDip(7.0),
)


def test_effort_is_the_sum_of_its_parts_and_coloured_noise() -> None:
    z_sd, z_rho = [], []
    for seed in range(1, 21):
        run = draw_run(seed)
        axis = run.axis
        noise = run.channels["x.current"] - sum(parts_A(axis, run.motion).values())
        steps = (noise[1:] - axis.noise_rho * noise[:-1]) / np.sqrt(1.0 - axis.noise_rho**2)
        n = len(steps)
        z_sd.append((np.std(steps) / axis.noise_A - 1.0) * np.sqrt(2.0 * n))
        z_rho.append(np.corrcoef(steps, noise[:-1])[0, 1] * np.sqrt(n))
    assert np.max(np.abs([z_sd, z_rho])) < 4.0  # 40 standard normals: p = 0.0025
    assert 0.5 < np.std(z_sd) < 1.6


def test_the_same_seed_gives_the_same_bytes_and_another_another_axis() -> None:
    for name, values in draw_run(3).channels.items():
        assert values.tobytes() == draw_run(3).channels[name].tobytes()
    assert draw_axis(3) == draw_axis(3)
    assert draw_axis(3) != draw_axis(4)
    assert_array_equal(draw_motion(3).x, draw_run(3).channels["x.position"])


def test_every_law_and_every_optional_part_is_drawn() -> None:
    drawn = [draw_axis(seed) for seed in range(1, 101)]
    assert {type(axis.viscous_curve) for axis in drawn} == {type(c) for c in VISCOUS}
    assert {type(axis.dip_curve) for axis in drawn} == {type(c) for c in DIPS}
    for has in (
        [axis.weight_A != 0.0 for axis in drawn],
        [axis.cogging_A != 0.0 for axis in drawn],
        [axis.position_A_mm != 0.0 for axis in drawn],
    ):
        assert 30 < sum(has) < 70  # p of a miss: 4e-5 each
    assert min(axis.noise_rho for axis in drawn) < 0.2
    assert max(axis.noise_rho for axis in drawn) > 0.97


@pytest.mark.parametrize("seeds", first(1, [range(1, 11), range(11, 41)]))
def test_moves_cover_the_travel_and_the_speeds_that_are_asked_for(seeds: range) -> None:
    for seed in seeds:
        motion = draw_motion(seed)
        assert np.min(motion.x) < 150.0
        assert np.max(motion.x) > 320.0
        assert np.max(np.abs(motion.v)) > 150.0
        steps = np.diff(motion.x) * 250.0
        assert_allclose(steps, 0.5 * (motion.v[1:] + motion.v[:-1]), atol=0.5)


@pytest.mark.parametrize("curve", VISCOUS, ids=lambda c: type(c).__name__)
def test_viscous_curves_are_no_straight_line(curve: FrictionCurve) -> None:
    v = np.linspace(0.0, 200.0, 400)
    share = curve.share(v)
    assert share[0] == 0.0
    assert_allclose(curve.share(np.array([150.0])), 1.0)
    assert_allclose(curve.share(v[7:8])[0], share[7])
    assert np.all(np.diff(share) > 0.0)
    line = np.polyfit(v, share, 1)
    assert np.max(np.abs(share - np.polyval(line, v))) > 0.03


@pytest.mark.parametrize("curve", DIPS, ids=lambda c: type(c).__name__)
def test_dips_are_no_stribeck_law(curve: FrictionCurve) -> None:
    v = np.linspace(0.0, 60.0, 400)
    share = curve.share(v)
    assert share[0] == 1.0
    assert share[-1] < 0.02
    assert np.all(np.diff(share) < 0.0)
    laws = [
        stribeck(np.ones_like(v), v, speed_mm_s=speed, exponent=exponent)
        for speed in np.linspace(3.0, 15.0, 61)
        for exponent in np.linspace(0.4, 3.0, 53)
    ]
    assert min(np.max(np.abs(share - law)) for law in laws) > 0.015


def test_quantities_are_what_the_parts_say() -> None:
    seen: set[str] = set()
    for seed in range(1, 11):
        run = draw_run(seed)
        asked = {q.name: q for q in quantities(run.axis, run.motion)}
        seen |= asked.keys()
        assert asked["weight"].truth == run.axis.weight_A
        assert_allclose(asked["inertia"].truth, run.axis.inertia_A_s2_mm)
        for v in FRICTION_MM_S:
            truth = asked[f"friction at {v:+g} mm/s"].truth
            assert_allclose(truth, _friction(run.axis, run.motion.x, v), rtol=1e-9)
        both = [asked[f"current at 150 mm, {v:+g} mm/s"].truth for v in (30.0, -100.0)]
        assert both[0] - both[1] > 1.5 * run.axis.coulomb_A
        if run.axis.cogging_A:
            assert asked["cogging period"].truth == run.axis.cogging_mm
            assert_allclose(asked["cogging amplitude"].truth, run.axis.cogging_A)
    assert seen == set(NAMES)


def _friction(axis: DrawnAxis, x: Array, v: float) -> float:
    """Friction at a velocity, written out, averaged over the recorded travel."""
    d = v / np.hypot(v, axis.reversal_mm_s)
    speed = np.array([abs(v)])
    curve, dip = axis.viscous_curve.share(speed)[0], axis.dip_curve.share(speed)[0]
    travel = np.linspace(np.min(x), np.max(x), 101) - 250.0
    plus = axis.coulomb_A + axis.viscous_A * curve + axis.dip_A * dip
    plus += np.mean(axis.position_A_mm * travel)
    uneven = axis.coulomb_asymmetry_A + axis.viscous_asymmetry_A * curve
    return float(d * plus + d**2 * uneven)
