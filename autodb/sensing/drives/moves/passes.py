"""Passes at constant speed in a recording of an axis: found from where it was alone.

A pass is a straight line of position over time. Position and not velocity, because an axis that
sticks and slips halts and jumps within a pass, and yet keeps to the line that it is commanded.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from autodb.files.channels import place_channel
from autodb.fitting.linear import spread
from autodb.records.tables import Recording
from autodb.terms.friction import STANDSTILL_MM_S

Array = NDArray[np.float64]

OFF_LINE_MM = 0.1
"""Way by which a pass may be off its line: stick-slip of a feed axis jumps less. Chosen."""
NOISE_SDS = 6.0
"""The same in standard deviations of the position's noise, where that is more."""
BLOCK_ROWS = 4096
RUN_IN_MM, RUN_IN_S = 1.0, 0.1
"""Left out at both ends of a pass, the longer: friction has turned and the drive settled. Chosen,
as ``drive_errors`` has it."""
SHORTEST_MM, SHORTEST_S, FEWEST_ROWS = 1.0, 0.2, 8
"""What of a pass must be left. Chosen."""
STEADY = 0.02
"""Share by which the speeds of a pass' halves may differ, beside what its jumps make. Chosen."""
SAME_LEVEL = 1.04
"""Ratio of neighbouring speeds up to which they are one level: P2's nearest are 1.11. Chosen."""
MANY_LEVELS, WIDE_SPAN, MOSTLY = 6, 20.0, 0.5
"""Levels passed both ways, ratio of the fastest to the slower ones, and share of the passes' time
that those take, which make a sweep over speeds: time is no fair weight then. Chosen."""


@dataclass(frozen=True)
class SpeedPass:
    """One pass without its run-in: rows ``begin`` to ``end``, speed mm/s, direction ±1, travel mm.

    ``level``: the speed's number, slowest 0; ``repeat``: how often level and direction came before.
    """

    begin: int
    end: int
    speed_mm_s: float
    sense: int
    low_mm: float
    high_mm: float
    level: int = 0
    repeat: int = 0

    @property
    def rows(self) -> slice:
        """Its rows."""
        return slice(self.begin, self.end)


def passes_of(inputs: Mapping[str, Array]) -> tuple[SpeedPass, ...]:
    """Return the passes of a motion in time, from its `t` (s) and `position` (mm), (n,) each."""
    t, x = inputs["t"], inputs["position"]
    noise_mm = spread(np.diff(x, 3)) / np.sqrt(20.0)
    corners = _corners(t, x, off_mm=max(OFF_LINE_MM, NOISE_SDS * float(noise_mm)))
    found = [_within(t, x, a, b) for a, b in pairwise(corners)]
    return _numbered([one for one in found if one is not None])


def levels_of(passes: Sequence[SpeedPass]) -> dict[int, float]:
    """Return the mean speed mm/s of each level, slowest first."""
    numbers = sorted({one.level for one in passes})
    return {k: float(np.mean([p.speed_mm_s for p in passes if p.level == k])) for k in numbers}


def both_ways(passes: Sequence[SpeedPass]) -> dict[int, float]:
    """Return the levels that were passed in both directions with their mean speed mm/s."""
    seen = {(one.level, one.sense) for one in passes}
    return {k: v for k, v in levels_of(passes).items() if {(k, 1), (k, -1)} <= seen}


def sweeps_speeds(passes: Sequence[SpeedPass]) -> bool:
    """Say whether passes are a sweep over speeds that runs at creep for most of the time."""
    levels = both_ways(passes)
    if len(levels) < MANY_LEVELS:
        return False
    rows = {k: sum(p.end - p.begin for p in passes if p.level == k) for k in levels}
    slow = [k for k, speed in levels.items() if WIDE_SPAN * speed <= max(levels.values())]
    return sum(rows[k] for k in slow) > MOSTLY * sum(rows.values())


def is_sweep(recording: Recording, axis: str) -> bool:
    """Say whether a recording is a sweep of an axis over speeds; False without a position."""
    position = recording.get(place_channel(axis))
    if position is None or len(recording) < FEWEST_ROWS:
        return False
    return sweeps_speeds(passes_of({"t": recording.t_s, "position": position}))


def _corners(t: Array, x: Array, *, off_mm: float) -> list[int]:
    """Return the rows between which position is straight within ``off_mm``, first and last too.

    Block by block, so that many short moves take no longer a row than few long ones; a border
    between blocks is dropped again where position goes straight on.
    """
    borders = [*range(0, len(t) - 1, BLOCK_ROWS), len(t) - 1]
    found = [0]
    for a, b in pairwise(borders):
        inside = _split(t, x, a, b, off_mm=off_mm)
        if len(found) > 1 and _off(t, x, found[-2], inside[0])[1] <= off_mm:
            found.pop()
        found += inside
    return found


def _split(t: Array, x: Array, begin: int, end: int, *, off_mm: float) -> list[int]:
    """Return the corners after ``begin``, up to ``end``.

    Douglas and Peucker 1973: a chord is split where position is farthest off it, a corner.
    """
    open_, done = [(begin, end)], []
    while open_:
        a, b = open_.pop()
        far, off = _off(t, x, a, b)
        if off <= off_mm or b - a < 2:
            done.append(b)
        else:
            open_ += [(far, b), (a, far)]
    return done


def _off(t: Array, x: Array, a: int, b: int) -> tuple[int, float]:
    """Return the row where position is farthest off the chord from row a to b, and how far."""
    slope = (x[b] - x[a]) / (t[b] - t[a])
    off = np.abs(x[a : b + 1] - x[a] - slope * (t[a : b + 1] - t[a]))
    far = int(np.argmax(off))
    return a + far, float(off[far])


def _within(t: Array, x: Array, begin: int, end: int) -> SpeedPass | None:
    """Return the pass between two corners, its run-in left out; None where there is none."""
    way, span_s = abs(x[end] - x[begin]), t[end] - t[begin]
    if way < STANDSTILL_MM_S * span_s:
        return None
    since, left = np.abs(x[begin:end] - x[begin]), np.abs(x[end] - x[begin:end])
    clock = t[begin:end] - t[begin]
    inside = np.minimum(since, left) >= RUN_IN_MM
    inside &= np.minimum(clock, span_s - clock) >= RUN_IN_S
    rows = begin + np.flatnonzero(inside)
    if len(rows) < FEWEST_ROWS:
        return None
    a, b = int(rows[0]), int(rows[-1]) + 1
    long_enough = abs(x[b - 1] - x[a]) >= SHORTEST_MM and t[b - 1] - t[a] >= SHORTEST_S
    if not long_enough or not _steady(t[a:b], x[a:b]):
        return None
    slope = _slope(t[a:b], x[a:b])
    low, high = sorted((float(x[a]), float(x[b - 1])))
    return SpeedPass(a, b, abs(slope), 1 if slope > 0 else -1, low, high)


def _steady(t: Array, x: Array) -> bool:
    """Say whether a stretch keeps its speed: its halves are as fast as each other."""
    line = np.polyfit(t - t[0], x, 1)
    rms_mm = float(np.sqrt(np.mean((x - np.polyval(line, t - t[0])) ** 2)))
    middle = len(t) // 2
    first, last = _slope(t[:middle], x[:middle]), _slope(t[middle:], x[middle:])
    leeway = STEADY * abs(line[0]) + 8.0 * rms_mm / (t[-1] - t[0])
    return bool(abs(first - last) <= leeway)


def _slope(t: Array, x: Array) -> float:
    return float(np.polyfit(t - t[0], x, 1)[0])


def _numbered(found: list[SpeedPass]) -> tuple[SpeedPass, ...]:
    """Return the passes with their levels and repeats."""
    speeds = np.sort([one.speed_mm_s for one in found])
    edges = speeds[1:][speeds[1:] > SAME_LEVEL * speeds[:-1]]
    seen: dict[tuple[int, int], int] = {}
    made = []
    for one in found:
        level = int(np.searchsorted(edges, one.speed_mm_s, side="right"))
        repeat = seen.get((level, one.sense), 0)
        seen[level, one.sense] = repeat + 1
        made.append(replace(one, level=level, repeat=repeat))
    return tuple(made)
