"""Long waveforms are searched in some of their turns.

What a waveform holds comes round with every turn, or lasts: tens of thousands of rows, of turns
spread over all of the time, show it as well as all do.
"""

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.noise import ORDER
from autodb.explain.waves.plain_rows import GOLDEN
from autodb.explain.waves.world import SimulatedWaves

MOST_ROWS = 12_000
"""Rows that are searched at most: some 400 columns of them take about 1 s. Chosen."""
TURNS = 4
"""Turns that stay together. Chosen."""
SHORTEST = 40 * ORDER
"""Rows that stay together at least: of each stretch a filter loses the first ``ORDER``."""
STRETCHES = 20
"""Stretches at least, however slowly the spindle turns. Chosen."""


def rows_searched(world: SimulatedWaves, most: int = MOST_ROWS) -> NDArray[np.intp] | None:
    """Return the rows of stretches of some turns, spread over all of the time, of a long waveform.

    The first and the last stretch are among them. None: it has no more rows than ``most``.
    """
    count = len(world.waves.t_s)
    if count <= most:
        return None
    turns = TURNS * world.timing.rate_hz / max(world.turns_a_s, 1e-9)
    together = int(min(max(SHORTEST, turns), most / STRETCHES))
    stretch = np.arange(count) // together
    searched = np.mod(np.arange(stretch[-1] + 1) * GOLDEN, 1.0) < most / count
    searched[[0, -1]] = True
    rows = searched[stretch]
    if world.timing.measured is not None:
        rows &= world.timing.measured
    return np.flatnonzero(rows)
