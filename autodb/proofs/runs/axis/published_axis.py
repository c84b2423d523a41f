"""The published way to the friction field of an axis: the gate that reference axes must pass.

P2's own: three repeats averaged over segments of a third of the screw's pitch; friction over speed
with seven parameters, for each direction; a straight line along the travel beside it; of a vertical
axis the weight is the mean of up and down at 500 mm/min and more. A segment's mean is the moving
average too. The parameters over speed are those of the mean over the segments around the middle of
the travel, which every level passes, not the mean of each segment's parameters: they are nearly
degenerate, and means of such parameters stand for no curve. P2 has no acceleration and
standstill: there its friction follows the velocity's sign, and is none at standstill.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from autodb.proofs.machines.axis.reference_moves import STROKES_MM
from autodb.proofs.runs.axis.axis_cells import Cells

Array = NDArray[np.float64]

PUBLISHED_ERROR = {"x": 0.032, "y": 0.024, "z": 0.10}
"""P2, section III: mean error of the friction field."""
PUBLISHED_CONTOUR = 0.15
"""P2, section IV: the contour's mean error is always below."""
PUBLISHED_HIGH = (0.10, 0.15)
"""P2, section V: the contour's current is predicted so much too high."""
WEIGHED_MM_S = 500.0 / 60.0
"""P2, section III B: slower passes determine no weight."""
STARTS = tuple((p3, p4, p6) for p3 in (0.3, 3.0) for p4 in (0.5, 2.0) for p6 in (1.0, 30.0))
"""mm/s, 1, mm/s."""


@dataclass(frozen=True)
class SevenParameters:
    """P2, equations 6 to 10: size of friction over speed, P1 to P7; mm/s and A."""

    p: Array

    @classmethod
    def fitted(cls, speed_mm_s: Array, friction_A: Array) -> "SevenParameters":
        """Fit the sizes (n,) at speeds (n,), from eight starts."""
        size, top = float(np.max(np.abs(friction_A))), float(np.max(speed_mm_s))
        low = np.array([-5.0 * size, -5.0 * size, 0.02, 0.2, 0.0, 0.02, -size / top])
        high = np.array([5.0 * size, 5.0 * size, top, 4.0, 5.0 * size, top, size / top])

        def error(p: Array) -> Array:
            return cls(p)(speed_mm_s) - friction_A

        found = [
            least_squares(
                error,
                np.array([size, size, p3, p4, 0.1 * size, p6, 0.0]),
                bounds=(low, high),
                x_scale=np.array([size, size, 1.0, 1.0, size, 1.0, size / top]),
            )
            for p3, p4, p6 in STARTS
        ]
        return cls(np.asarray(min(found, key=lambda one: float(one.cost)).x))

    def __call__(self, speed_mm_s: Array) -> Array:
        """Return the size (n,) at speeds (n,)."""
        p1, p2, p3, p4, p5, p6, p7 = self.p
        falls = (p2 - p1) * np.exp(-((speed_mm_s / p3) ** p4))
        return np.asarray(p1 + falls + p5 * np.log(speed_mm_s / p6 + 1.0) + p7 * speed_mm_s)


@dataclass(frozen=True)
class PublishedAxis:
    """P2's model: friction in + and - direction, a line along the travel, A and A/mm, weight A."""

    plus: SevenParameters
    minus: SevenParameters
    line: Array
    weight_A: float

    def current_A(self, x_mm: Array, v_mm_s: Array) -> Array:
        """Return the current (n,) at places and velocities (n,)."""
        speed = np.abs(v_mm_s)
        size = np.where(v_mm_s > 0.0, self.plus(speed), self.minus(speed))
        rubbing = np.sign(v_mm_s) * (size + np.polyval(self.line, x_mm))
        return np.asarray(rubbing + self.weight_A)


def published_axis(cells: Cells, *, vertical: bool) -> PublishedAxis:
    """Return P2's model of a friction field; a horizontal axis has no weight."""
    weight_A = published_weight(cells) if vertical else 0.0
    size = np.sign(cells.v_mm_s) * (cells.current_A - weight_A)
    plus, minus = (_over_speed(cells, size, sense) for sense in (1.0, -1.0))
    speed = np.abs(cells.v_mm_s)
    there = np.where(cells.v_mm_s > 0.0, plus(speed), minus(speed))
    line = np.polyfit(cells.x_mm, size - there, 1, w=np.sqrt(cells.weights))
    return PublishedAxis(plus, minus, np.asarray(line, dtype=np.float64), weight_A)


def _over_speed(cells: Cells, size: Array, sense: float) -> SevenParameters:
    low_mm, high_mm = STROKES_MM[1]
    near = (np.sign(cells.v_mm_s) == sense) & (cells.x_mm > low_mm) & (cells.x_mm < high_mm)
    speed = np.abs(cells.v_mm_s)
    levels = np.unique(speed[near])
    means = np.array([size[near & (speed == one)].mean() for one in levels])
    return SevenParameters.fitted(levels, means)


def published_weight(cells: Cells) -> float:
    """Return the mean of up and down over the speeds that determine the weight."""
    speed = np.abs(cells.v_mm_s)
    means = [
        0.5 * sum(float(cells.current_A[cells.v_mm_s == way * one].mean()) for way in (1.0, -1.0))
        for one in np.unique(speed)
        if one >= WEIGHED_MM_S * (1.0 - 1e-3)
    ]
    return float(np.mean(means))
