"""Moves of a reference feed axis: P2's sweep of 27 speeds, its cycles at 10 000 mm/min, a contour.

P2 (friction and weight of feed axes) passes its whole travel at every speed, three times: at
10 mm/min more than a day for 500 mm. Here the stroke depends on the level, chosen so that a sweep
lasts three quarters of an hour: one screw turn at level 1, four at level 2, nearly the whole travel
at level 3. Every axis makes the same moves; position mm, speed mm/s, time s.
"""

import math
from functools import lru_cache

import numpy as np

from autodb.proofs.machines.axis.motion import PlannedMove, TrueMotion, move, moves_motion
from autodb.proofs.machines.lathe.process import Array

PITCH_MM = 10.0  # of the screw; chosen
LEVELS_MM_MIN = (10.0, 100.0, 1000.0)  # P2 table I: 1 to 9 times each
STROKES_MM = ((250.0, 260.0), (235.0, 275.0), (10.0, 490.0))  # of the levels; chosen
REPEATS = 3  # P2 section III A
POSITIONING_MM_S = 55.0  # between the levels, none of the 27 speeds; chosen
DWELL_S = 0.5  # after a pass; chosen
REST_S = 120.0  # before each repeat and the cycles: the axis cools; chosen
CYCLE_MM_S = 10_000.0 / 60.0  # P2 section IV, figure 12
CYCLES_S = 50.0  # P2: ten cycles
CYCLE_DWELL_S = 0.05  # chosen
SLOW_MM_MIN, SLOW_PASSES = 1000.0, 6  # after the cycles: friction comes back; chosen
SWEEP_HZ, CONTOUR_HZ = 50.0, 250.0  # chosen: passes are slow and long, a contour has reversals
FEEDS_MM_MIN = (5000.0, 1000.0, 500.0, 200.0)  # P2 section IV
SIDE_MM = 40.0  # of the contour's square; chosen
SLOPE_DEG = 3.0  # of the contour's inclined sides; ISO 10791-7
CONTOUR_AT_MM = 240.0  # where it begins; chosen
WORKED_S = 20.0  # rapids before each feed of the contour, as between cuts; chosen


def speeds_mm_s() -> Array:
    """The 27 speeds of P2's table I, rising."""
    return np.concatenate([level / 60.0 * np.arange(1, 10) for level in LEVELS_MM_MIN])


class _Plan:
    """Moves one after the other."""

    def __init__(self, at_mm: float) -> None:
        self.moves: list[PlannedMove] = []
        self.now_s, self.at_mm = 1.0, at_mm

    def go(self, target_mm: float, speed_mm_s: float, dwell_s: float = DWELL_S) -> None:
        """Move to a target and dwell; nothing where the axis is there."""
        if target_mm == self.at_mm:
            return
        self.moves.append(move(self.now_s, self.at_mm, target_mm, speed_mm_s))
        self.now_s += self.moves[-1].duration_s + dwell_s
        self.at_mm = target_mm

    def cycle(self, seconds: float) -> None:
        """Go to and fro over the whole stroke at 10 000 mm/min for so long."""
        low_mm, high_mm = STROKES_MM[2]
        self.go(low_mm, POSITIONING_MM_S)
        until_s = self.now_s + seconds
        while self.now_s < until_s:
            self.go(high_mm, CYCLE_MM_S, CYCLE_DWELL_S)
            self.go(low_mm, CYCLE_MM_S, CYCLE_DWELL_S)

    def motion(self, rate_hz: float) -> TrueMotion:
        """Motion up to a second after the last move."""
        t = np.arange(round((self.now_s + 1.0) * rate_hz)) / rate_hz
        return _joined(self.moves, t)


def _joined(moves: list[PlannedMove], t: Array) -> TrueMotion:
    """``moves_motion`` of many moves, each computed only while it lasts."""
    edges = np.searchsorted(t, [*(one.start_s for one in moves[1:]), np.inf])
    begins = np.concatenate([[0], edges[:-1]])
    parts = [moves_motion([m], t[a:b]) for m, a, b in zip(moves, begins, edges, strict=True)]
    return TrueMotion(
        t, *(np.concatenate([getattr(part, name) for part in parts]) for name in ("x", "v", "a"))
    )


@lru_cache(maxsize=1)
def axis_sweep_motion() -> tuple[TrueMotion, tuple[float, ...]]:
    """The sweep, and when each of its repeats and the cycles begin, s.

    Each repeat passes all speeds, slowest first, there and back; at the end are the cycles, and
    slow passes while friction comes back.
    """
    plan, began = _Plan(STROKES_MM[0][0]), []
    for _ in range(REPEATS):
        began.append(plan.now_s)
        for speed_mm_s, (low_mm, high_mm) in zip(
            speeds_mm_s(), np.repeat(STROKES_MM, 9, axis=0).tolist(), strict=True
        ):
            plan.go(low_mm, POSITIONING_MM_S)
            plan.go(high_mm, speed_mm_s)
            plan.go(low_mm, speed_mm_s)
        plan.now_s += REST_S
    began.append(plan.now_s)
    plan.cycle(CYCLES_S)
    low_mm, high_mm = STROKES_MM[2]
    for number in range(SLOW_PASSES):
        plan.go(low_mm if number % 2 else high_mm, SLOW_MM_MIN / 60.0)
    return plan.motion(SWEEP_HZ), tuple(began)


@lru_cache(maxsize=1)
def contour_motion() -> tuple[TrueMotion, Array]:
    """The contour at each of its feeds after rapids, and which feed a row is of, -1 in the rapids.

    A square on its edge, a circle and sides inclined by 3 degrees, as in ISO 10791-7; the axis sees
    its component, and stands while the other axis moves alone.
    """
    elements = _elements()
    ends = np.cumsum([0.0, *(length for length, _, _ in elements)])
    parts: list[tuple[TrueMotion, float]] = []
    for number, feed_mm_min in enumerate(FEEDS_MM_MIN):
        rapids = _Plan(CONTOUR_AT_MM)
        rapids.cycle(WORKED_S)
        rapids.go(CONTOUR_AT_MM, POSITIONING_MM_S)
        path = _Plan(0.0)
        for end in ends[1:].tolist():
            path.go(end, feed_mm_min / 60.0, 0.1)
        parts += [(rapids.motion(CONTOUR_HZ), -1.0)]
        parts += [(_along(path.motion(CONTOUR_HZ), ends, elements), float(number))]
    size = [len(motion.t) for motion, _ in parts]
    whole = (np.concatenate([getattr(motion, k) for motion, _ in parts]) for k in ("x", "v", "a"))
    t = np.arange(sum(size)) / CONTOUR_HZ
    return TrueMotion(t, *whole), np.repeat([number for _, number in parts], size)


def _elements() -> list[tuple[float, float, float]]:
    """Length mm, angle of the direction rad at its begin, and curvature 1/mm of each element."""
    slope, radius_mm = math.radians(SLOPE_DEG), 0.5 * SIDE_MM
    diamond = [(SIDE_MM / math.sqrt(2.0), math.radians(45.0 + 90.0 * k), 0.0) for k in range(4)]
    circle = [(2.0 * math.pi * radius_mm, 0.0, 1.0 / radius_mm)]
    inclined = [(SIDE_MM, slope + 0.5 * math.pi * k, 0.0) for k in range(4)]
    square = [(SIDE_MM, 0.5 * math.pi * k, 0.0) for k in range(4)]
    return [*square, *diamond, *circle, *inclined]


def _along(path: TrueMotion, ends: Array, elements: list[tuple[float, float, float]]) -> TrueMotion:
    """Motion of the axis along a path: direction cosines of its elements, which close."""
    at = np.clip(np.searchsorted(ends, path.x, side="right") - 1, 0, len(elements) - 1)
    _, angle, curvature = np.array(elements)[at].T
    turned = angle + curvature * (path.x - ends[at])
    x = np.concatenate([[0.0], np.cumsum([_way(*one) for one in elements])])[at]
    chord = np.where(
        curvature == 0.0,
        (path.x - ends[at]) * np.cos(angle),
        (np.sin(turned) - np.sin(angle)) / np.where(curvature == 0.0, 1.0, curvature),
    )
    return TrueMotion(
        path.t,
        CONTOUR_AT_MM + x + chord,
        np.cos(turned) * path.v,
        np.cos(turned) * path.a - curvature * np.sin(turned) * path.v**2,
    )


def _way(length_mm: float, angle: float, curvature: float) -> float:
    """Way of the axis over an element."""
    if curvature == 0.0:
        return length_mm * math.cos(angle)
    return (math.sin(angle + curvature * length_mm) - math.sin(angle)) / curvature
