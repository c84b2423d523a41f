"""Air moves of a feed axis: smooth-step velocity ramps, several speeds, both directions, dwells.

Noise of a recorded channel.
"""

import math
from dataclasses import dataclass

import numpy as np

from autodb.proofs.machines.lathe.process import Array

LOW_MM, HIGH_MM = 20.0, 480.0  # travel that the moves use; chosen
ACCELERATION_MM_S2 = 800.0  # peak of a ramp; chosen
SHORTEST_RAMP_S = 0.06  # of slow moves: jerk is limited; chosen
SPEEDS_MM_S = (3.0, 8.0, 20.0, 45.0, 80.0, 120.0, 180.0)  # chosen
RAPID_MM_S = 160.0  # positioning between the speeds; chosen
CRUISE_S = 2.2  # of a move, at most; chosen


@dataclass(frozen=True)
class TrueMotion:
    """What the axis did: t s, x mm, v mm/s, a mm/s^2."""

    t: Array
    x: Array
    v: Array
    a: Array


@dataclass(frozen=True)
class PlannedMove:
    """One move: start s, from where mm, signed peak speed mm/s, ramp and total duration s."""

    start_s: float
    origin_mm: float
    speed_mm_s: float
    ramp_s: float
    duration_s: float


def move(start_s: float, origin_mm: float, target_mm: float, speed_mm_s: float) -> PlannedMove:
    """The move to a target; the peak speed is lowered where the way is too short for it.

    A smooth-step ramp of T s to V peaks at 1.5 V/T and covers V T/2, so a ramp pair covers V T.
    """
    way_mm = abs(target_mm - origin_mm)
    reach_mm_s = math.sqrt(way_mm * ACCELERATION_MM_S2 / 1.5)
    peak_mm_s = min(speed_mm_s, reach_mm_s, way_mm / SHORTEST_RAMP_S)
    ramp_s = max(1.5 * peak_mm_s / ACCELERATION_MM_S2, SHORTEST_RAMP_S)
    sign = 1.0 if target_mm > origin_mm else -1.0
    return PlannedMove(start_s, origin_mm, sign * peak_mm_s, ramp_s, way_mm / peak_mm_s + ramp_s)


def plan_moves(
    rng: np.random.Generator,
    seconds: float,
    *,
    speeds_mm_s: tuple[float, ...] = SPEEDS_MM_S,
    rapid_mm_s: float = RAPID_MM_S,
) -> list[PlannedMove]:
    """Moves until `seconds` are full: position at rapid, one speed out and back, dwells."""
    moves: list[PlannedMove] = []
    now_s, at_mm = 0.8, 60.0

    def go(target_mm: float, speed_mm_s: float) -> None:
        nonlocal now_s, at_mm
        moves.append(move(now_s, at_mm, target_mm, speed_mm_s))
        now_s += moves[-1].duration_s + rng.uniform(0.25, 0.55)
        at_mm = target_mm

    while now_s < seconds:
        for speed_mm_s in rng.permutation(speeds_mm_s):
            stroke_mm = min(CRUISE_S * speed_mm_s, HIGH_MM - LOW_MM - 40.0)
            go(rng.uniform(LOW_MM, HIGH_MM - stroke_mm), rapid_mm_s)
            go(at_mm + stroke_mm, speed_mm_s)
            go(at_mm - stroke_mm, speed_mm_s)
    return moves


def moves_motion(moves: list[PlannedMove], t: Array) -> TrueMotion:
    """Position, velocity and acceleration of the moves at the times t, in closed form.

    Velocity on a ramp: V s(u), s = 3u^2 - 2u^3, integral u^3 - u^4/2, u = time/ramp in 0..1.
    """
    x = np.full_like(t, moves[0].origin_mm)
    v, a = np.zeros_like(t), np.zeros_like(t)
    for one in moves:
        since = t - one.start_s
        x = np.where(since >= 0.0, one.origin_mm, x)
        for begins_s, sign in ((0.0, 1.0), (one.duration_s - one.ramp_s, -1.0)):
            u = np.clip((since - begins_s) / one.ramp_s, 0.0, 1.0)
            after_s = np.maximum(since - begins_s - one.ramp_s, 0.0)
            peak = sign * one.speed_mm_s
            x = x + peak * (one.ramp_s * (u**3 - u**4 / 2.0) + after_s)
            v = v + peak * (3.0 * u**2 - 2.0 * u**3)
            a = a + peak / one.ramp_s * 6.0 * u * (1.0 - u)
    return TrueMotion(t, x, v, a)


def coloured(rng: np.random.Generator, size: int, sd: float, rho: float) -> Array:
    """First-order autoregressive noise of the stated standard deviation, stationary."""
    noise = rng.standard_normal(size) * sd
    fresh = np.sqrt(1.0 - rho**2)
    for i in range(1, size):
        noise[i] = rho * noise[i - 1] + fresh * noise[i]
    return noise
