"""`python -m benchmarks.mechanics`: what cutting mechanics cost, beside plain loops, on one core.

The loops are as scripts write them: over cuts and elements, or over time, teeth and slices, floats
and `math`. They may use constant coefficients, which a law with no powers has; ours works the whole
law out at every element all the same. The forces must agree to 1e-6 of the largest one. Loops are
timed on a short stretch and scaled. Set OPENBLAS_NUM_THREADS=1 and OMP_NUM_THREADS=1.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from autodb.cutting import endmill, insert, shear
from autodb.cutting.elements import cut_forces
from benchmarks.timing import median_s

Array = NDArray[np.float64]

TOOL = insert.Insert(nose_radius_mm=0.8, kappa_deg=95.0)
CUTS, FEW_CUTS = 100_000, 500
CUTS_A_S, ELEMENTS_A_S = 1e5, 5e6
MILL = endmill.EndMill(diameter_mm=10.0, teeth=4, helix_deg=30.0)
RATE_HZ, SPEED_RPM, FEED_MM = 5000.0, 3000.0, 0.05
WAVEFORM_S = 0.1
"""Target for 1 s of milling."""
SHORT = 50
"""Moments of the plain loop."""
DEPTHS_MM = (2.0, 4.0)
AGREE = 1e-6


def no_powers() -> Array:
    """Return coordinates of a law whose coefficients are the same at every chip and speed."""
    values = dict.fromkeys(shear.NAMES, 0.0)
    values |= {"shear_stress": 600.0, "friction_angle": 25.0, "chip_ratio": 0.4, "K_te": 25.0}
    values |= {"K_re": 40.0, "flow_angle": 1.0, "edge_mm": 1e-12}
    return shear.law_coordinates(values)


@dataclass(frozen=True)
class Constants:
    """Coefficients of an edge, N/mm² and N/mm."""

    tc: float
    rc: float
    ac: float
    te: float
    re: float


def constants(theta: Array, helix_deg: float) -> Constants:
    """Return the constant coefficients of an edge."""
    one = np.ones(1)
    edge = shear.Edge(0.1 * one, 100.0 * one, 0.0 * one, np.radians(helix_deg) * one)
    cut, rub = shear.chip_coefficients(theta, edge), shear.edge_coefficients(theta, edge)
    return Constants(*(float(v[0]) for v in (*cut, rub[0], rub[1])))


def turned_plainly(k: Constants, feeds: Array, depths: Array) -> Array:
    """Return force x, y, z of cuts by a loop over cuts and the elements of the nose."""
    nose, entering = TOOL.nose_radius_mm, math.radians(TOOL.kappa_deg)
    height = nose * (1.0 - math.cos(entering))
    found = []
    for feed, depth in zip(feeds.tolist(), depths.tolist(), strict=True):
        end = entering if depth >= height else math.acos(1.0 - depth / nose)
        step = end / insert.ON_NOSE
        x = y = z = 0.0
        for element in range(insert.ON_NOSE + 1):
            if element < insert.ON_NOSE:
                angle, width = (element + 0.5) * step, nose * step
                h = feed * math.sin(angle) * math.sin(0.5 * step) / (0.5 * step)
            elif depth >= height:
                angle, width = entering, (depth - height) / math.sin(entering)
                h = feed * math.sin(angle)
            else:
                continue
            thrust = (k.rc * h + k.re) * width
            x += math.cos(angle) * thrust
            y += (k.tc * h + k.te) * width
            z += math.sin(angle) * thrust
        found.append((x, y, z))
    return np.array(found)


def milled_plainly(k: Constants, angles_rad: Array, depth_mm: float) -> Array:
    """Return force x, y, z at moments of a slot by a loop over time, teeth and slices."""
    radius, slices = MILL.radius_mm, round(depth_mm / endmill.SLICE_MM)
    dz, twist = depth_mm / slices, math.tan(math.radians(30.0)) / radius
    found = []
    for angle in angles_rad.tolist():
        x = y = z = 0.0
        for tooth in range(MILL.teeth):
            for level in range(slices):
                lag = 2.0 * math.pi * tooth / MILL.teeth + (level + 0.5) * dz * twist
                phi = (angle - lag) % (2.0 * math.pi)
                if phi > math.pi:
                    continue
                h = FEED_MM * math.sin(phi)
                tangential, radial = (k.tc * h + k.te) * dz, (k.rc * h + k.re) * dz
                x += -tangential * math.cos(phi) - radial * math.sin(phi)
                y += tangential * math.sin(phi) - radial * math.cos(phi)
                z += k.ac * h * dz
        found.append((x, y, z))
    return np.array(found)


def agreed(ours: Array, plain: Array) -> None:
    """Raise ValueError where the loop's forces are not ours."""
    off = float(np.max(np.abs(ours - plain)) / np.max(np.abs(plain)))
    if not off < AGREE:
        raise ValueError(f"the plain loop is off by {off:.1g} of the largest force")


def turning(theta: Array) -> None:
    """Time elements and forces of cuts with 20 elements, and the forces alone."""
    rng = np.random.default_rng(1)
    feeds, depths = rng.uniform(0.1, 0.4, CUTS), rng.uniform(0.5, 3.0, CUTS)
    none = np.zeros(CUTS)
    cuts = insert.TurnedCuts(feeds, depths, none + 150.0, none + 30.0, none)

    def both() -> Array:
        return cut_forces(theta, insert.insert_elements(TOOL, cuts)).force_N

    coefficients = constants(theta, 0.0)
    few = feeds[:FEW_CUTS], depths[:FEW_CUTS]
    agreed(both()[:FEW_CUTS], turned_plainly(coefficients, *few))
    plain_s = median_s(lambda: turned_plainly(coefficients, *few)) * CUTS / FEW_CUTS
    elements = insert.insert_elements(TOOL, cuts)
    count = CUTS * (insert.ON_NOSE + 1)
    _rate("turning, cuts of 20 elements", CUTS, both, plain_s, CUTS_A_S)
    _rate("forces of elements", count, lambda: cut_forces(theta, elements), plain_s, ELEMENTS_A_S)


def milling(theta: Array) -> None:
    """Time 1 s of a four-tooth mill in a slot at 5 kHz."""
    turn_rad = 2.0 * math.pi * SPEED_RPM / 60.0 * np.arange(RATE_HZ) / RATE_HZ
    angles_rad = turn_rad + 0.01
    coefficients = constants(theta, 30.0)
    for depth_mm in DEPTHS_MM:
        one = np.ones(1)
        cut = endmill.Milled(
            FEED_MM * one, depth_mm * one, SPEED_RPM * one,
            -MILL.radius_mm * one, MILL.radius_mm * one, 0.0 * one, 0.0 * one,
        )  # fmt: skip
        short = angles_rad[:SHORT]
        ours = endmill.waveform(theta, MILL, cut, short).force_N
        agreed(ours, milled_plainly(coefficients, short, depth_mm))
        took_s = median_s(partial(endmill.waveform, theta, MILL, cut, angles_rad))
        plain_s = median_s(partial(milled_plainly, coefficients, short, depth_mm))
        print(
            f"milling 1 s at 5 kHz, 4 teeth, {depth_mm:g} mm deep: {1e3 * took_s:.0f} ms, "
            f"{plain_s * RATE_HZ / SHORT / took_s:.1f} x faster than the loop, target < "
            f"{1e3 * WAVEFORM_S:.0f} ms: {_said(took_s < WAVEFORM_S)}"
        )


def _rate(
    name: str, count: int, function: Callable[[], object], plain_s: float, target: float
) -> None:
    took_s = median_s(function)
    print(
        f"{name}: {count / took_s:.3g}/s, {plain_s / took_s:.1f} x faster than the loop, target "
        f">= {target:.0e}/s: {_said(count / took_s >= target)}"
    )


def _said(passed: bool) -> str:
    return "passed" if passed else "missed"


if __name__ == "__main__":
    law = no_powers()
    turning(law)
    milling(law)
