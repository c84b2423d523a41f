"""Moves of a reference mill: its sweep of one axis in air, and paths of cuts with their approach.

P0 (LSTM and model-based force reconstruction, five-axis mill) parametrises its model on passes at
constant velocity in both directions and on accelerated moves, and cuts slots, ramps, pockets and
sides. It prints no speed of its passes and no place of a cut: they are *chosen*. Position mm, speed
mm/s, time s, angle rad.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from autodb.proofs.machines.axis.motion import PlannedMove, TrueMotion, moves_motion
from autodb.proofs.machines.lathe.process import Array

AXES = ("x", "y", "z")
RATE_HZ = 250.0  # P0 section 2.1
ENDS_MM = (0.0, 330.0)  # of the travel; chosen
PITCH_MM = 23.0  # P0 section 3.1, pole width
# Speed mm/s and stroke mm of the passes: whole poles, the whole travel from 6 mm/s on; chosen
PASSES = (
    (0.5, 11.5), (1.0, 23.0), (2.0, 46.0), (4.0, 92.0), (6.0, 299.0), (8.0, 184.0), (10.0, 299.0),
    (13.0, 299.0), (20.0, 299.0), (40.0, 299.0), (80.0, 299.0), (160.0, 299.0),
)  # fmt: skip
LOW_MM, MIDDLE_MM = 10.0, 160.0  # where long passes begin, and the middle of short ones; chosen
POSITIONING_MM_S, SOFT_MM_S2 = 60.0, 500.0  # between passes; chosen
HARD_MM_S2 = (1500.0, 3000.0, 5000.0)  # peaks of the accelerated moves; chosen
HARD_MM, HARD_MM_S, HARD_TIMES = 120.0, 250.0, 4  # their way, speed and number; chosen
DWELL_S, SHORTEST_RAMP_S = 0.4, 0.04  # chosen
RAPID_MM_S, RAPID_MM_S2 = 150.0, 2000.0  # approach of a cut; chosen
CUT_MM_S2 = 1000.0  # a feed sets in; chosen
OVER_MM, BACK_MM_S = 0.1, 1.0  # a rapid goes over its target and back; chosen
RUNNING_UP_S = 1.5  # before a cut; chosen


def sweep_move(
    origin_mm: float, way_mm: float, speed_mm_s: float, peak_mm_s2: float
) -> PlannedMove:
    """One move; its peak speed is lowered where the way is too short for it."""
    size = abs(way_mm)
    reach = min(math.sqrt(size * peak_mm_s2 / 1.5), size / SHORTEST_RAMP_S)
    peak = min(speed_mm_s, reach)
    ramp_s = max(1.5 * peak / peak_mm_s2, SHORTEST_RAMP_S)
    return PlannedMove(0.0, origin_mm, math.copysign(peak, way_mm), ramp_s, size / peak + ramp_s)


def _rows(one: PlannedMove, dwell_s: float) -> TrueMotion:
    """The rows of a move and of the dwell after it, from 0 s."""
    t = np.arange(1, max(round((one.duration_s + dwell_s) * RATE_HZ), 1) + 1) / RATE_HZ
    return moves_motion([one], t)


@lru_cache(maxsize=1)
def mill_sweep_motion() -> TrueMotion:
    """The sweep of one axis: passes there and back at each speed, then accelerated moves."""
    parts = [TrueMotion(np.zeros(0), np.full(250, LOW_MM), np.zeros(250), np.zeros(250))]

    def go(target_mm: float, speed_mm_s: float, peak_mm_s2: float = SOFT_MM_S2) -> None:
        at_mm = float(parts[-1].x[-1])
        if abs(target_mm - at_mm) > 1e-6:
            parts.append(
                _rows(sweep_move(at_mm, target_mm - at_mm, speed_mm_s, peak_mm_s2), DWELL_S)
            )

    for speed_mm_s, stroke_mm in PASSES:
        low_mm = LOW_MM if stroke_mm > 200.0 else MIDDLE_MM - 0.5 * stroke_mm
        go(low_mm, POSITIONING_MM_S)
        go(low_mm + stroke_mm, speed_mm_s)
        go(low_mm, speed_mm_s)
    for peak_mm_s2 in HARD_MM_S2:
        go(MIDDLE_MM - 0.5 * HARD_MM, POSITIONING_MM_S)
        for _ in range(HARD_TIMES):
            go(MIDDLE_MM + 0.5 * HARD_MM, HARD_MM_S, peak_mm_s2)
            go(MIDDLE_MM - 0.5 * HARD_MM, HARD_MM_S, peak_mm_s2)
    return _joined(parts)


def _joined(parts: list[TrueMotion]) -> TrueMotion:
    whole = [np.concatenate([getattr(one, name) for one in parts]) for name in ("x", "v", "a")]
    return TrueMotion(np.arange(len(whole[0])) / RATE_HZ, *whole)


@dataclass(frozen=True)
class Leg:
    """A straight way from where the last ended, or an arc in the plane where ``turn_rad`` is not 0.

    ``way_mm`` (x, y, z) from begin to end, of an arc from its begin to its centre; ``depth``: share
    of the cut's depth at shares of the leg, as pairs.
    """

    way_mm: tuple[float, float, float]
    speed_mm_s: float
    depth: tuple[tuple[float, float], ...] = ((0.0, 0.0),)
    turn_rad: float = 0.0
    peak_mm_s2: float = CUT_MM_S2
    dwell_s: float = 0.05

    @property
    def length_mm(self) -> float:
        """Way along the leg."""
        size = math.hypot(*self.way_mm)
        return size * (abs(self.turn_rad) or 1.0)


@dataclass(frozen=True)
class MillPath:
    """Motion of each axis over t (n,), share of the cut's depth (n,), angle of the feed from +x
    towards +y (n,).
    """

    t: Array
    axes: dict[str, TrueMotion]
    depth: Array
    feed_rad: Array


def travelled(begin_mm: tuple[float, float, float], legs: list[Leg]) -> MillPath:
    """The legs one after the other, each from standstill to standstill."""
    at, angle = np.array(begin_mm), 0.0
    x = [np.tile(at, (round(0.5 * RATE_HZ), 1))]
    v, a = [np.zeros_like(x[0])], [np.zeros_like(x[0])]
    depth, feed = [np.zeros(len(x[0]))], [np.zeros(len(x[0]))]
    for leg in legs:
        along = _rows(sweep_move(0.0, leg.length_mm, leg.speed_mm_s, leg.peak_mm_s2), leg.dwell_s)
        place, speed, peak, turned = _on(leg, at, along, angle)
        x, v, a = [*x, place], [*v, speed], [*a, peak]
        knots, shares = np.array(leg.depth).T
        depth.append(np.interp(along.x / leg.length_mm, knots, shares))
        feed.append(turned)
        at, angle = place[-1], float(turned[-1])
    t = np.arange(sum(len(one) for one in x)) / RATE_HZ
    three = [np.concatenate(one) for one in (x, v, a)]
    return MillPath(
        t=t,
        axes={name: TrueMotion(t, *(one[:, k] for one in three)) for k, name in enumerate(AXES)},
        depth=np.concatenate(depth),
        feed_rad=np.concatenate(feed),
    )


def _on(leg: Leg, at: Array, along: TrueMotion, before: float) -> tuple[Array, Array, Array, Array]:
    """Place, speed, acceleration (n, 3) and feed angle (n,) on a leg that begins ``at``."""
    way = np.array(leg.way_mm)
    if not leg.turn_rad:
        unit = way / leg.length_mm
        level = math.hypot(way[0], way[1]) > 1e-9
        angle = math.atan2(way[1], way[0]) if level else before
        rows = [np.multiply.outer(one, unit) for one in (along.x, along.v, along.a)]
        return at + rows[0], rows[1], rows[2], np.full(len(along.x), angle)
    radius, sense = math.hypot(*leg.way_mm), math.copysign(1.0, leg.turn_rad)
    turned = math.atan2(-way[1], -way[0]) + sense * along.x / radius
    out = np.column_stack([np.cos(turned), np.sin(turned), np.zeros_like(turned)])
    ahead = sense * np.column_stack([-out[:, 1], out[:, 0], np.zeros_like(turned)])
    inward = -out * (along.v**2 / radius)[:, None]
    return (
        at + way + radius * out,
        ahead * along.v[:, None],
        ahead * along.a[:, None] + inward,
        turned + sense * 0.5 * math.pi,
    )


def approach(way_mm: tuple[float, float, float]) -> list[Leg]:
    """A rapid that goes over its target and back, and the spindle's running up."""
    size = math.hypot(*way_mm)
    over = tuple(OVER_MM * one / size for one in way_mm)
    there = tuple(one + more for one, more in zip(way_mm, over, strict=True))
    back = tuple(-one for one in over)
    return [
        Leg((there[0], there[1], there[2]), RAPID_MM_S, peak_mm_s2=RAPID_MM_S2),
        Leg((back[0], back[1], back[2]), BACK_MM_S, dwell_s=RUNNING_UP_S),
    ]
