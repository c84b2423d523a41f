"""Point-to-point moves of one axis, in closed form: what it did at any instant.

A velocity ramp is a straight line (trapezoid) or has its corners rounded (S-curve), so position is
made of quadratic or cubic pieces and is evaluated where it is sampled. All ranges are *chosen*:
speeds and accelerations of small machine tools, as in `shared/failures/logs/ms.csv` (up to 232 mm/s
and 1040 mm/s²).
"""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.cases.base.moves import log_uniform

Array = NDArray[np.float64]

SLOWEST_MM_S = 8.0
FASTEST_MM_S = (150.0, 250.0)
SPEEDS = 6
ACCELERATIONS_MM_S2 = (300.0, 1500.0)
SHORTEST_RAMP_S = 0.06
CORNERS_S = (0.04, 0.1)
CRUISE_S = (0.15, 0.5)
PAUSE_S = (0.05, 0.35)
LAST_REST_S = 0.4
INNER = 0.85
"""Share of the travel that all moves but the last stay in; the last one goes to the far end."""


@dataclass(frozen=True)
class PieceMotion:
    """What the axis did at n instants: x mm, v mm/s, a mm/s² (deg on a rotary axis)."""

    x: Array
    v: Array
    a: Array


@dataclass(frozen=True)
class Programme:
    """Pieces of constant jerk: their starts (s) and the state there; the last one is a rest."""

    start_s: Array
    x: Array
    v: Array
    a: Array
    jerk: Array
    seconds: float

    def motion(self, t_s: Array) -> PieceMotion:
        """Return the motion at the instants ``t_s`` (n,)."""
        piece = np.clip(np.searchsorted(self.start_s, t_s, side="right") - 1, 0, None)
        since, v, a = t_s - self.start_s[piece], self.v[piece], self.a[piece]
        jerk = self.jerk[piece]
        return PieceMotion(
            self.x[piece] + since * (v + since * (a / 2.0 + since * jerk / 6.0)),
            v + since * (a + since * jerk / 2.0),
            a + since * jerk,
        )


@dataclass
class _Pieces:
    """Pieces on their way: states are carried from one to the next."""

    x: float
    now_s: float = 0.0
    rows: list[tuple[float, float, float, float, float]] = field(default_factory=list)

    def rest(self, seconds: float) -> None:
        """Stand still."""
        self.rows.append((self.now_s, self.x, 0.0, 0.0, 0.0))
        self.now_s += seconds

    def move(self, way: float, speed: float, acceleration: float, corner_s: float) -> None:
        """Move by a signed ``way``; the speed is lowered where the way is too short for it."""
        most = acceleration / 2.0 * (math.hypot(corner_s, 2 * math.sqrt(abs(way) / acceleration))
                                     - corner_s)  # fmt: skip
        peak = min(speed, most)
        ramp_s = peak / acceleration
        corner_s = min(corner_s, ramp_s)
        cruise_s = max(abs(way) / peak - ramp_s - corner_s, 0.0)
        sign, v = math.copysign(1.0, way), 0.0
        for upwards in (1.0, -1.0):
            v = self._ramp(v, sign * upwards * acceleration, ramp_s, corner_s)
            if upwards > 0.0:
                v = self._piece(v, 0.0, 0.0, cruise_s)

    def _ramp(self, v: float, a: float, ramp_s: float, corner_s: float) -> float:
        if corner_s <= 0.0:
            return self._piece(v, a, 0.0, ramp_s)
        v = self._piece(v, 0.0, a / corner_s, corner_s)
        v = self._piece(v, a, 0.0, ramp_s - corner_s)
        return self._piece(v, a, -a / corner_s, corner_s)

    def _piece(self, v: float, a: float, jerk: float, seconds: float) -> float:
        """Add a piece and return the velocity at its end."""
        if seconds <= 0.0:
            return v
        self.rows.append((self.now_s, self.x, v, a, jerk))
        self.x += seconds * (v + seconds * (a / 2.0 + seconds * jerk / 6.0))
        self.now_s += seconds
        return v + seconds * (a + seconds * jerk / 2.0)


def draw_programme(
    rng: np.random.Generator, seconds: float, *, travel: float, corner_s: float
) -> Programme:
    """Draw moves of ``seconds`` or a little more: every speed in turn there and back, rests."""
    speeds = np.geomspace(SLOWEST_MM_S, rng.uniform(*FASTEST_MM_S), SPEEDS)
    pieces = _Pieces(x=float(rng.uniform(0.3, 0.6)) * travel)
    pieces.rest(rng.uniform(*PAUSE_S) + LAST_REST_S)
    while pieces.now_s < seconds:
        for speed in rng.permutation(speeds):
            stroke = min(speed * rng.uniform(*CRUISE_S) + 10.0, 0.4 * travel)
            up = pieces.x + stroke < INNER * travel and (pieces.x < stroke or rng.random() < 0.5)
            for way in (stroke, -stroke) if up else (-stroke, stroke * rng.uniform(0.7, 1.0)):
                acceleration = min(log_uniform(rng, *ACCELERATIONS_MM_S2), speed / SHORTEST_RAMP_S)
                pieces.move(way, float(speed), acceleration, corner_s)
                pieces.rest(rng.uniform(*PAUSE_S))
    pieces.move(travel - pieces.x, float(speeds[-1]), ACCELERATIONS_MM_S2[0], corner_s)
    pieces.rest(LAST_REST_S)
    start, x, v, a, jerk = np.array(pieces.rows).T
    return Programme(start, x, v, a, jerk, pieces.now_s)
