"""What the grids of an axis' candidates are measured in: its own speeds, ways and step of time.

The same motion in degrees or in millimetres, at half or double the rate, has the same grids in its
own measure.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.sensing.drives.moves.motion import STILL_SHARE, noise_sd, top_speed
from autodb.terms.friction import STANDSTILL_MM_S

Array = NDArray[np.float64]

WIDTHS_OF_TOP = (0.0005, 0.0018, 0.0065)
"""Speeds over which friction may turn, as shares of the top speed: over a tenth of it is no dry
friction any more. Chosen."""
DIPS_OF_TOP = (0.0028, 0.0065, 0.015, 0.035, 0.08, 0.18, 0.4)
"""Speeds over which extra friction at creep may fall, as shares of the top speed. Chosen."""
STARTS_OF_TOP = (0.0035, 0.015)
"""Speeds over which friction may rise where a move starts, as shares of the top speed. Chosen."""
SOFT_OF_TRAVEL = tuple(4e-6 * 2.6**k for k in range(11))
"""Ways of pre-sliding as shares of the travel: 0.002 mm of 500 mm to 0.6 mm of 10 mm. Chosen."""
PLAY_OF_TRAVEL = tuple(8e-6 * 2.1**k for k in range(14))
"""Plays as shares of the travel: 0.004 mm of 500 mm to 1.2 mm of 10 mm. Chosen."""
TURNS_OF_TRAVEL = (8e-6, 5e-5, 2.5e-4, 8e-4, 2.5e-3, 8e-3)
"""Ways after a reversal over which friction may be otherwise, as shares of the travel. Chosen."""
OF_A_ROW = 0.25
"""Share of the way of a row after a reversal, and of a step in time, below which nothing differs
that rows show. Chosen."""
FEWEST_WAYS = 3
"""Ways that are tried where rows resolve none of a grid: its largest."""
PASSED = 20
"""Rows near a speed that show what friction does there. Chosen."""
USUAL_TRAVEL = 500.0
"""Travel of an axis that stands, mm or deg. Chosen."""


@dataclass(frozen=True)
class AxisScales:
    """Top speed and travel in the axis' unit; ``resolved``: the least way that rows show after a
    reversal; ``slow``: the speed below which none is passed slowly enough for rows to show what
    friction does there; ``step_s``: from row to row.
    """

    top: float
    travel: float
    resolved: float
    slow: float
    step_s: float

    def widths(self) -> list[float]:
        """Return speeds over which friction may turn."""
        return [share * self.top for share in WIDTHS_OF_TOP]

    def dips(self) -> list[float]:
        """Return speeds over which extra friction at creep may fall, that rows may show."""
        speeds = [share * self.top for share in DIPS_OF_TOP]
        shown = [speed for speed in speeds if speed >= self.slow]
        return shown if len(shown) >= FEWEST_WAYS else speeds[-FEWEST_WAYS:]

    def starts(self) -> list[float]:
        """Return speeds over which friction may rise where a move starts."""
        return [share * self.top for share in STARTS_OF_TOP]

    def softening(self) -> list[float]:
        """Return ways of pre-sliding that rows may show."""
        return self._shown(SOFT_OF_TRAVEL)

    def plays(self) -> list[float]:
        """Return plays that rows may show."""
        return self._shown(PLAY_OF_TRAVEL)

    def turns(self) -> list[float]:
        """Return ways after a reversal over which friction may be otherwise."""
        return self._shown(TURNS_OF_TRAVEL)

    def delays(self, grid_s: tuple[float, ...], *, rows: float = 2.0) -> list[float]:
        """Return the delays of a grid that rows show, up to so many rows at least [s].

        One of less than a quarter of a row differs from the least only in size.
        """
        shown = [delay for delay in grid_s if delay >= OF_A_ROW * self.step_s]
        shown = shown or [OF_A_ROW * self.step_s]
        while shown[-1] < rows * self.step_s:
            shown.append(1.5 * shown[-1])
        return shown

    def _shown(self, shares: tuple[float, ...]) -> list[float]:
        ways = [share * self.travel for share in shares]
        shown = [way for way in ways if way >= self.resolved]
        return shown if len(shown) >= FEWEST_WAYS else ways[-FEWEST_WAYS:]


def axis_scales(
    t_s: Array,
    position: Array,
    velocity: Array,
    last_sense: Array,
    way: Array,
    *,
    blur_s: float = 0.0,
) -> AxisScales:
    """Return the scales of an axis' motion, (n,) each.

    ``last_sense`` and ``way`` as ``since_reversal`` gives them; ``blur_s``: over what time the
    velocity is a mean. Of an axis that stands they are those of a usual one.
    """
    travel, top = float(np.ptp(position)), top_speed(velocity, noise_sd(velocity))
    turned = np.flatnonzero(np.diff(last_sense) != 0) + 2
    next_ways = way[turned[turned < len(way)]]
    row = float(np.median(next_ways)) if next_ways.size else 0.0
    step_s = float(np.median(np.diff(t_s)))
    top = top or STANDSTILL_MM_S / STILL_SHARE
    return AxisScales(
        top=top,
        travel=travel or USUAL_TRAVEL,
        resolved=max(OF_A_ROW * row, noise_sd(position)),
        slow=_slow(velocity, [share * top for share in DIPS_OF_TOP], step_s, blur_s),
        step_s=step_s,
    )


def _slow(velocity: Array, speeds: list[float], step_s: float, blur_s: float) -> float:
    """Return the lowest of some speeds from which on an axis stays near each, between half and
    twice of it, for longer than rows and the filter of its velocity blur.
    """
    speed, faster = np.abs(velocity), np.abs(np.gradient(velocity)) / step_s
    lowest = speeds[-1]
    for middle in reversed(speeds):
        near = (speed > 0.5 * middle) & (speed < 2.0 * middle)
        if np.count_nonzero(near) < PASSED:
            break
        if float(np.median(faster[near])) * max(step_s, blur_s) > middle:
            break
        lowest = middle
    return lowest
