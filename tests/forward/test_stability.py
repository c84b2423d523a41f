"""Regenerative limits beside closed forms, and beside a tool that is let vibrate step by step."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.cutting import shear
from autodb.cutting.elements import cut_forces
from autodb.cutting.regenerating import directional_stiffness
from autodb.errors import UnusableInput
from autodb.files.job_cut import JobCut
from autodb.forward.prediction import ToolOf
from autodb.forward.stability.depths import StableDepth, stable_depth
from autodb.forward.stability.dynamics import ModeSection, ToolPoint, of_modes, read_tool_point
from autodb.forward.stability.lobes import limit_at, loop_of
from autodb.pairs.engaged import BY_NAME
from tests.helpers.known_pairs import INSERT, known

Array = NDArray[np.float64]

K_T, K_R, TEETH = 600.0, 0.07, 3
X = ModeSection(axis="x", frequency_Hz=603.0, damping_ratio=0.039, stiffness_N_m=5.59e6, share=0.0)
Y = ModeSection(axis="y", frequency_Hz=666.0, damping_ratio=0.035, stiffness_N_m=5.715e6, share=0.0)
MILL = ToolOf("mill", {"diameter_mm": 20.0, "teeth": 3, "helix_deg": 0.0, "rake_deg": 8.0,
                       "corner_radius_mm": 0.0})  # fmt: skip


def _at(phi: float) -> Array:
    """Return a mill's force by its motion (2, 2) with one tooth at an angle, N/mm a mm deep."""
    if not 0.0 <= phi % (2.0 * np.pi) <= 0.5 * np.pi:
        return np.zeros((2, 2))
    sin, cos = np.sin(phi), np.cos(phi)
    force = np.array([-cos - K_R * sin, sin - K_R * cos])
    return np.asarray(K_T * np.outer(force, [sin, cos]))


def _averaged(start: float, end: float, k_t: float = K_T, k_r: float = K_R) -> Array:
    """Return a K_t N/(4 pi) [alpha] a mm deep, as Altintas and Budak 1995 write it."""

    def alpha(p: float) -> Array:
        sin, cos = np.sin(2.0 * p), np.cos(2.0 * p)
        return 0.5 * np.array([
            [cos - 2.0 * k_r * p + k_r * sin, -sin - 2.0 * p + k_r * cos],
            [-sin + 2.0 * p + k_r * cos, -cos - 2.0 * k_r * p - k_r * sin],
        ])  # fmt: skip

    return np.asarray(k_t * TEETH / (4.0 * np.pi) * (alpha(end) - alpha(start)))


def _in_machine(stiffness: Array) -> Array:
    whole = np.zeros((3, 3))
    whole[:2, :2] = stiffness
    return whole


def test_one_mode_is_limited_as_tlusty_says() -> None:
    """Least depth 2 k z (1 + z)/K; at any speed s = -1/(2 K Re G) where its phase closes."""
    point = of_modes((X,), source="m")
    stiffness = np.diag([-1000.0, 0.0, 0.0])
    loop = loop_of(stiffness, point.frequency_Hz, point.receptance)
    zeta, k = X.damping_ratio, X.stiffness_N_m / 1000.0
    assert_allclose(loop.critical, 2.0 * k * zeta * (1.0 + zeta) / 1000.0, rtol=1e-4)
    for speed in (5000.0, 9000.0, 12000.0):
        (scale,), (frequency,) = limit_at(loop, np.array([60.0 / speed]))
        r = frequency / X.frequency_Hz
        g = 1.0 / k / (1.0 - r**2 + 2j * zeta * r)
        assert_allclose(scale, -1.0 / (2000.0 * g.real), rtol=2e-3)
        around = 1.0 + scale * 1000.0 * (1.0 - np.exp(-2j * np.pi * frequency * 60.0 / speed)) * g
        assert abs(around) < 5e-3


def test_a_mills_stiffness_is_altintas_and_budaks() -> None:
    """Of a law with one coefficient: the mean over a turn of a plain edge, by their formula."""
    theta = known().law.mean.copy()
    for name in ("chip_ratio_thickness", "shear_stress_thickness", "friction_thickness",
                 "shear_stress_speed"):  # fmt: skip
        theta[shear.NAMES.index(name)] = 0.0
    theta[shear.EDGE_H] = -20.0
    row = {"cutting.feed": 0.1, "cutting.depth": 2.0, "spindle.speed": 3000.0}
    speed = np.pi * 20.0 * 3.0
    edge = shear.Edge(np.full(1, 0.1), np.full(1, speed), np.radians([8.0]), np.zeros(1))
    k_t, k_n, _ = (float(one[0]) for one in shear.chip_coefficients(theta, edge))
    for name, start, end in (("side-up", 0.0, np.pi / 2), ("side-down", np.pi / 2, np.pi)):
        cuts = BY_NAME[name].cuts(MILL.numbers, [{**row, "cutting.width": 10.0}], called="m")
        (found,) = directional_stiffness(theta, cuts.elements)
        expected = 2.0 * _averaged(start, end, k_t, k_n / k_t)
        assert_allclose(found[:2, :2], expected, atol=2e-3 * np.max(np.abs(expected)))


@pytest.mark.parametrize("speed_rpm", [8000.0, 10500.0, 15000.0])
def test_a_tool_that_is_let_vibrate_settles_below_the_limit_and_not_above(speed_rpm: float) -> None:
    """Teeth that come and go, half the mill engaged: within 15 % of the mean over a turn."""
    point = of_modes((X, Y), source="m")
    stiffness = _in_machine(_averaged(0.0, np.pi / 2))
    loop = loop_of(stiffness, point.frequency_Hz, point.receptance)
    (scale,), _ = limit_at(loop, np.array([60.0 / (TEETH * speed_rpm)]))
    assert _grows(0.85 * scale, speed_rpm) < 1.0 < _grows(1.15 * scale, speed_rpm)


def _grows(depth_mm: float, speed_rpm: float) -> float:
    """Return by what motion after 60 teeth is larger than after 30, with a force that is cut.

    Equal steps of velocity, then place; the force by what a tooth finds of the one before.
    """
    steps, teeth = 200, 60
    dt = 60.0 / (TEETH * speed_rpm) / steps
    omega = 2.0 * np.pi * np.array([X.frequency_Hz, Y.frequency_Hz])
    damping = 2.0 * np.array([X.damping_ratio, Y.damping_ratio]) * omega
    per_mass = 1000.0 * omega**2 / np.array([X.stiffness_N_m, Y.stiffness_N_m])
    pitch = 2.0 * np.pi / TEETH
    forces = [depth_mm * _at(pitch * k / steps) for k in range(steps)]
    place, speed = np.zeros((teeth * steps + 1, 2)), np.zeros(2)
    place[0] = 1e-3
    for k in range(teeth * steps):
        before = place[k - steps] if k >= steps else np.zeros(2)
        force = forces[k % steps] @ (place[k] - before)
        speed = speed + dt * (per_mass * force - damping * speed - omega**2 * place[k])
        place[k + 1] = place[k] + dt * speed
    size = [np.abs(place[end - 10 * steps : end]).max() for end in (30 * steps, 60 * steps)]
    return float(size[1] / size[0])


def _stable(point: ToolPoint, share: float = 0.05, **cut: float | str) -> StableDepth:
    asked = {"operation": "side-up", "depth_mm": 2.0, "width_mm": 10.0, "feed_mm_tooth": 0.08}
    return stable_depth(known(share), MILL, JobCut.model_validate({**asked, **cut}), point)


def test_what_gives_way_by_half_cuts_twice_as_deep() -> None:
    """And what is less known of it, or of the pair, makes the interval wider."""
    soft = of_modes((X, Y), source="m")
    stiff = ToolPoint("m", soft.frequency_Hz, 0.5 * soft.receptance, soft.share)
    unsure = ToolPoint("m", soft.frequency_Hz, soft.receptance, np.full(3, 0.3))
    one, two, three = (_stable(point, speed_rpm=8000.0) for point in (soft, stiff, unsure))
    assert one.depth_mm is not None
    assert two.depth_mm is not None
    assert three.depth_mm is not None
    assert_allclose(two.depth_mm.value, 2.0 * one.depth_mm.value)
    assert_allclose(two.any_speed_mm.value, 2.0 * one.any_speed_mm.value)
    assert three.depth_mm.high / three.depth_mm.low > 1.5 * one.depth_mm.high / one.depth_mm.low
    wide = _stable(soft, 0.3, speed_rpm=8000.0)
    assert wide.any_speed_mm.high / wide.any_speed_mm.low > (
        one.any_speed_mm.high / one.any_speed_mm.low
    )
    assert all(b.depth_mm.value > one.depth_mm.value for b in one.better)
    assert all(6000.0 <= b.speed_rpm <= 1.33 * 8000.0 for b in one.better)


def test_a_bar_that_gives_way_along_its_feed_limits_turning() -> None:
    """An entering edge at 90°: the chip is as thick as it moves along z, and the limit Tlusty's."""
    z = ModeSection(axis="z", frequency_Hz=300.0, damping_ratio=0.03, stiffness_N_m=2e7, share=0.0)
    tool = ToolOf("t", {**INSERT.numbers, "nose_radius_mm": 0.0, "kappa_deg": 90.0,
                        "inclination_deg": 0.0, "rake_deg": 0.0})  # fmt: skip
    cut = JobCut(operation="turn", diameter_mm=50.0, depth_mm=2.0, feed_mm_rev=0.2, speed_rpm=900.0)
    found = stable_depth(known(), tool, cut, of_modes((z,), source="m"))
    row = cut.conditions(None)
    theta = known().law.mean
    low, high = (
        BY_NAME["turn"].cuts(tool.numbers, [{**row, "cutting.feed": f}], called="t")
        for f in (0.1999, 0.2001)
    )
    slope = cut_forces(theta, high.elements).all[0, 2] - cut_forces(theta, low.elements).all[0, 2]
    per_mm = abs(slope) / 0.0002 / 2.0
    expected = 2.0 * 2e4 * 0.03 * 1.03 / per_mm
    assert_allclose(found.any_speed_mm.value, expected, rtol=2e-3)
    x_alone = of_modes((X,), source="bar.toml")
    with pytest.raises(UnusableInput, match=r"bar\.toml: no axis that it states moves the chip"):
        stable_depth(known(), tool, cut, x_alone)
    with pytest.raises(UnusableInput, match="operation 'drill' has no depth"):
        drill = JobCut(operation="drill", feed_mm_rev=0.1, speed_rpm=900.0)
        stable_depth(known(), ToolOf("d", {"diameter_mm": 8.0}), drill, x_alone)


def test_a_measured_receptance_says_what_its_modes_say(tmp_path: Path) -> None:
    every = np.arange(100.0, 2000.0, 2.0)
    rows = ["frequency_Hz,x_real_m_N,x_imag_m_N,y_real_m_N,y_imag_m_N"]
    for f in every:
        g = [1.0 / m.stiffness_N_m / (1.0 - (f / m.frequency_Hz) ** 2
             + 2j * m.damping_ratio * f / m.frequency_Hz) for m in (X, Y)]  # fmt: skip
        rows.append(",".join(f"{v:.8g}" for v in (f, g[0].real, g[0].imag, g[1].real, g[1].imag)))
    path = tmp_path / "frf.csv"
    path.write_text("\n".join(rows), "utf-8")
    read = _stable(read_tool_point(path), speed_rpm=8000.0)
    told = _stable(of_modes((X, Y), source="m"), speed_rpm=8000.0)
    assert read.depth_mm is not None
    assert told.depth_mm is not None
    assert_allclose(read.depth_mm.value, told.depth_mm.value, rtol=5e-3)


HEAD = "frequency_Hz,x_real_m_N,x_imag_m_N\n"
GOOD = "".join(f"{100 + k},1e-8,-1e-8\n" for k in range(12))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("f,x\n1,2\n", "column 'f' is none of ours"),
        ("frequency_Hz,x_real_m_N\n" + GOOD, "needs the columns"),
        (HEAD + "100,1e-8,-1e-8\n", "1 rows; give 10 lines at least"),
        (HEAD + GOOD + "120,a,-1e-8\n", "row 14: x_real_m_N 'a' is no number"),
        (HEAD + GOOD + "90,1e-8,-1e-8\n", "row 14: frequency_Hz has to rise"),
        (HEAD + GOOD + "120,1e-8\n", "row 14: 2 cells, not 3"),
        (HEAD + GOOD.replace("-1e-8\n", "1e-8\n"), "imaginary parts are mostly positive"),
        ("", "needs the columns"),
    ],
)
def test_what_is_no_receptance_is_refused(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "frf.csv"
    path.write_text(text, "utf-8")
    with pytest.raises(UnusableInput, match=said):
        read_tool_point(path)
