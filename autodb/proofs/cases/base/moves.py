"""Moves of two axes as a control makes them: jerk-limited passes, dwells, waves, circular contours.

A velocity in straight pieces runs through a moving average, as set-points do in a control, so
acceleration rises and falls along straight lines. All ranges are *chosen*.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RATE_HZ = 250.0
SLOWEST_MM_S = 1.0
PASS_S = (1.2, 3.0)  # how long a pass at constant speed may take
SHORTEST_RAMP_S = 0.02


@dataclass(frozen=True)
class Moves:
    """What two axes did, each (n,): t s, x and y mm, velocities mm/s, accelerations mm/s^2."""

    t: Array
    x: Array
    v: Array
    a: Array
    y: Array
    y_v: Array
    y_a: Array


@dataclass(frozen=True)
class _Turns:
    """Turns of a circle: x goes span/2 (1 - cos), y span/2 sin of an angle that starts softly."""

    start_s: float
    seconds: float
    span_mm: float
    turns: int

    def velocities(self, t: Array) -> tuple[Array, Array]:
        """Velocities along x and y, mm/s: the angle is 2 pi turns (3 u^2 - 2 u^3), u in 0..1."""
        u = np.clip((t - self.start_s) / self.seconds, 0.0, 1.0)
        angle = 2.0 * np.pi * self.turns * (3.0 * u**2 - 2.0 * u**3)
        pace = 2.0 * np.pi * self.turns * 6.0 * u * (1.0 - u) / self.seconds
        half = 0.5 * self.span_mm * pace
        return half * np.sin(angle), half * np.cos(angle)


@dataclass
class _Program:
    """Set-points of one axis: corners (s, mm/s) of its velocity, and its turns."""

    low_mm: float
    high_mm: float
    ramp_mm_s2: float
    at_mm: float
    now_s: float = 0.4
    corners: list[tuple[float, float]] = field(default_factory=lambda: [(0.0, 0.0)])
    turns: list[_Turns] = field(default_factory=list)

    def go(self, target_mm: float, speed_mm_s: float) -> None:
        """Move with straight ramps; the peak speed is lowered where the way is too short."""
        way = abs(target_mm - self.at_mm)
        if way < 0.01:
            return
        peak = min(speed_mm_s, float(np.sqrt(way * self.ramp_mm_s2)))
        ramp = max(peak / self.ramp_mm_s2, SHORTEST_RAMP_S)
        peak = min(peak, way / ramp)
        whole = way / peak + ramp
        signed = peak if target_mm > self.at_mm else -peak
        for after, v in ((0.0, 0.0), (ramp, signed), (whole - ramp, signed), (whole, 0.0)):
            self.corners.append((self.now_s + after, v))
        self.now_s += whole
        self.at_mm = target_mm

    def circle(self, span_mm: float, turns: int, speed_mm_s: float) -> None:
        """Turn around a circle; ``span_mm`` is signed, its start is where the axis is."""
        seconds = 1.5 * np.pi * turns * abs(span_mm) / speed_mm_s
        self.turns.append(_Turns(self.now_s, seconds, span_mm, turns))
        self.now_s += seconds

    def velocity(self, t: Array, smooth: int) -> Array:
        """Velocity (n,) of the straight moves, corners rounded over ``smooth`` samples."""
        times, values = np.array(self.corners).T
        straight = np.interp(t, times, values, right=0.0)
        padded = np.pad(straight, (smooth - 1, 0))
        return np.convolve(padded, np.ones(smooth) / smooth, mode="valid")


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    """Draw evenly over the logarithm."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def draw_moves(rng: np.random.Generator, seconds: float) -> Moves:
    """Moves of ``seconds`` at RATE_HZ: every speed, both directions, dwells, ramps, contours."""
    t = np.arange(round(seconds * RATE_HZ)) / RATE_HZ
    x, y = _drawn(rng, seconds, contours=True), _drawn(rng, seconds, contours=False)
    smooth = [int(rng.integers(2, 20)) for _ in range(2)]
    v, y_v = (axis.velocity(t, width) for axis, width in zip((x, y), smooth, strict=True))
    for turns in x.turns:
        along, across = turns.velocities(t)
        v, y_v = v + along, y_v + across
    start, y_start = rng.uniform(x.low_mm, x.high_mm), rng.uniform(y.low_mm, y.high_mm)
    position, acceleration = _integrated(v, start), np.gradient(v, 1.0 / RATE_HZ)
    shift = 0.5 * (x.low_mm + x.high_mm) - 0.5 * (position.min() + position.max())
    return Moves(
        t, position + shift, v, acceleration, _integrated(y_v, y_start),
        y_v, np.gradient(y_v, 1.0 / RATE_HZ),
    )  # fmt: skip


def _integrated(v: Array, start: float) -> Array:
    middle = 0.5 * (v[1:] + v[:-1]) / RATE_HZ
    return np.asarray(start + np.concatenate([[0.0], np.cumsum(middle)]), dtype=np.float64)


def _drawn(rng: np.random.Generator, seconds: float, *, contours: bool) -> _Program:
    """Passes at every speed of the logarithm in turn, rapids between, now and then a contour."""
    low, travel = rng.uniform(10.0, 60.0), log_uniform(rng, 180.0, 600.0)
    program = _Program(low, low + travel, log_uniform(rng, 300.0, 4000.0), low + 0.3 * travel)
    rapid = log_uniform(rng, 120.0, 400.0)
    count = int(np.clip(seconds / 7.0, 3, 16))
    edges = np.geomspace(SLOWEST_MM_S, rapid, count + 1)
    while program.now_s < seconds:
        for part in rng.permutation(count):
            speed = log_uniform(rng, float(edges[part]), float(edges[part + 1]))
            if contours and rng.random() < 0.2:
                _contour(rng, program, rapid)
            _there_and_back(rng, program, speed, rapid)
    return program


def _there_and_back(
    rng: np.random.Generator, program: _Program, speed_mm_s: float, rapid_mm_s: float
) -> None:
    travel = program.high_mm - program.low_mm
    stroke = min(rng.uniform(*PASS_S) * speed_mm_s, 0.9 * travel)
    program.go(rng.uniform(program.low_mm, program.high_mm - stroke), rapid_mm_s)
    program.now_s += _pause_s(rng)
    program.go(program.at_mm + stroke, speed_mm_s)
    program.now_s += _pause_s(rng)
    program.go(program.at_mm - stroke, speed_mm_s)
    program.now_s += _pause_s(rng)


def _contour(rng: np.random.Generator, program: _Program, rapid_mm_s: float) -> None:
    """One to three turns of a circle that fits into the travel, or short waves."""
    span = min(log_uniform(rng, 8.0, 150.0), 0.8 * (program.high_mm - program.low_mm))
    speed = min(log_uniform(rng, 15.0, 200.0), rapid_mm_s, np.sqrt(0.5 * span * 2000.0))
    up = program.at_mm + span <= program.high_mm
    if up or program.at_mm - span >= program.low_mm:
        program.circle(span if up else -span, int(rng.integers(1, 4)), float(speed))
        program.now_s += _pause_s(rng)


def _pause_s(rng: np.random.Generator) -> float:
    """None, short, or long enough to settle."""
    return float(rng.choice([0.0, 0.1, rng.uniform(0.2, 0.8)]))
