"""The published way to forces from linear drives: the gate that reference mills must pass.

P0's own, section 2.2, in four steps: (1) the mean of a pass there and back at one speed, over the
travel, has a straight line: k and s_r; (2) what is left is periodic over a pole: a look-up table;
(3) what the passes' means over speed leave is Stribeck's law with exponent 2, by bounded nonlinear
least squares; (4) what accelerated moves leave is mass times acceleration. The force is what a
cut's current leaves. The speed of the pass in (1), the table's step and which rows count as
accelerated are not printed; they were set once, on seeds 101 to 140.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from autodb.proofs.machines.mill.reference_mill import Logged
from autodb.proofs.machines.mill.reference_mill_moves import LOW_MM, PASSES, PITCH_MM

Array = NDArray[np.float64]

SLOT_N = {"x": 33.0, "y": 21.0}
"""P0, section 3.1: RMSE of a slot across the axes."""
POCKET_N = {"x": 104.0, "y": 149.0}
"""P0, section 3.1: RMSE of a circular pocket."""
MEAN_N = 63.0
"""P0, section 3.2: the LSTM's mean of 50.2 N is 20.8 % lower."""
LINE_MM_S = 10.0
"""Speed of the passes that determine line and table."""
STEP_MM = 0.5
"""Step along the travel, and of the table."""
AT_SPEED_MM_S = 0.06
"""How far off its pass' speed a row may be: a step of the log."""
ACCELERATED_MM_S2 = 200.0


@dataclass(frozen=True)
class PublishedStribeck:
    """P0, equation 4 with exponent 2: Coulomb, breakaway, speed, viscous; N and mm/s."""

    p: Array

    def __call__(self, v_mm_s: Array) -> Array:
        """Return the friction (n,) at velocities (n,), 0 at standstill."""
        coulomb, breakaway, speed, viscous = self.p
        size = coulomb + (breakaway - coulomb) * np.exp(-((v_mm_s / speed) ** 2))
        return np.asarray(np.sign(v_mm_s) * size + viscous * v_mm_s)


@dataclass(frozen=True)
class PublishedFourSteps:
    """P0's model of an axis: slope N/mm and place s_r mm of the line, the table N of a pole,
    friction, mass N s^2/mm.
    """

    slope: float
    rest_mm: float
    table: Array
    friction: PublishedStribeck
    mass: float

    def placed_N(self, x_mm: Array) -> Array:
        """Return line and table (n,)."""
        return _placed(self.slope, self.rest_mm, self.table, x_mm)

    def air_N(self, x_mm: Array, v_mm_s: Array, a_mm_s2: Array) -> Array:
        """Return what moving takes (n,)."""
        return self.placed_N(x_mm) + self.friction(v_mm_s) + self.mass * a_mm_s2


def published_four_steps(logged: Logged, newtons_per_ampere: float) -> PublishedFourSteps:
    """Return P0's model of an axis from its sweep."""
    effort_N, motion = logged.current_A * newtons_per_ampere, logged.motion
    slope, rest_mm, left_N, place_mm = _line(motion.x, motion.v, effort_N)
    table = _table(place_mm, left_N)
    rubbing_N = effort_N - _placed(slope, rest_mm, table, motion.x)
    friction = _stribeck(motion.v, motion.a, rubbing_N)
    sped = np.abs(motion.a) > ACCELERATED_MM_S2
    left = rubbing_N[sped] - friction(motion.v[sped])
    mass = float(left @ motion.a[sped] / (motion.a[sped] @ motion.a[sped]))
    return PublishedFourSteps(slope, rest_mm, table, friction, mass)


def _placed(slope: float, rest_mm: float, table: Array, x_mm: Array) -> Array:
    nodes = (np.arange(len(table)) + 0.5) * PITCH_MM / len(table)
    cogging = np.interp(x_mm % PITCH_MM, nodes, table, period=PITCH_MM)
    return np.asarray(slope * (x_mm - rest_mm) + cogging)


def _line(x: Array, v: Array, effort_N: Array) -> tuple[float, float, Array, Array]:
    """Step 1: slope, rest, and what the line leaves at places."""
    edges = np.arange(LOW_MM + 5.0, float(x.max()) - 5.0, STEP_MM)
    middle = 0.5 * (edges[1:] + edges[:-1])
    both = []
    for way in (LINE_MM_S, -LINE_MM_S):
        there = np.abs(v - way) < AT_SPEED_MM_S
        cell = np.digitize(x[there], edges) - 1
        inside = (cell >= 0) & (cell < len(middle))
        count = np.bincount(cell[inside], minlength=len(middle))
        both.append(np.bincount(cell[inside], effort_N[there][inside], len(middle)) / count)
    mean = 0.5 * (both[0] + both[1])
    slope, level = np.polyfit(middle, mean, 1)
    return float(slope), float(-level / slope), mean - slope * middle - level, middle


def _table(place_mm: Array, left_N: Array) -> Array:
    """Step 2: means over the steps of a pole."""
    count = round(PITCH_MM / STEP_MM)
    cell = np.minimum((place_mm % PITCH_MM) / PITCH_MM * count, count - 1).astype(np.intp)
    return np.bincount(cell, left_N, count) / np.bincount(cell, minlength=count)


def _stribeck(v: Array, a: Array, rubbing_N: Array) -> PublishedStribeck:
    """Step 3: the law through the means of the passes."""
    speeds = np.array([way * one for one, _ in PASSES for way in (1.0, -1.0)])
    steady = np.abs(a) < 50.0
    means = np.array(
        [rubbing_N[steady & (np.abs(v - one) < AT_SPEED_MM_S)].mean() for one in speeds]
    )
    size, top = float(np.max(np.abs(means))), float(np.max(speeds))
    low = np.array([0.0, 0.0, 0.1, -size / top])
    high = np.array([3.0 * size, 3.0 * size, top, 3.0 * size / top])
    starts = [np.array([0.7 * size, size, speed, 0.1 * size / top]) for speed in (1.0, 5.0, 20.0)]

    def error(p: Array) -> Array:
        off: Array = PublishedStribeck(p)(speeds) - means
        return off

    found = [
        least_squares(
            error,
            start,
            bounds=(low, high),
            x_scale=np.array([size, size, 1.0, size / top]),
        )
        for start in starts
    ]
    return PublishedStribeck(np.asarray(min(found, key=lambda one: float(one.cost)).x))
