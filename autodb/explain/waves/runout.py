"""How far the teeth of a mill stand out, fitted to a waveform as they cut: not a small change."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from autodb.explain.engine.normal import solved
from autodb.explain.waves.candidates import directions_standing_out, nudged
from autodb.explain.waves.teeth import StandsOut
from autodb.explain.waves.world import SimulatedWaves

Array = NDArray[np.float64]

ROWS = 3000
"""Rows of the middle of a cut that teeth are fitted to."""


def fitted_out(world: SimulatedWaves, difference: Array, columns: Array) -> StandsOut:
    """Return how far teeth stand out, beside columns (C, n, p) that are free.

    Where a tooth cuts nothing, the next one finds its chip or, as simulations have it, does not:
    what fits better.
    """
    some, rows = _middle(world)
    target, free = difference[:, rows].ravel(), columns[:, rows].reshape(-1, columns.shape[-1])
    tried = [_fitted_teeth(some, target, free, missed=missed) for missed in (True, False)]
    return min(tried, key=lambda one: one[1])[0]


def _fitted_teeth(
    world: SimulatedWaves, target: Array, free: Array, *, missed: bool
) -> tuple[StandsOut, float]:
    """Return how far teeth stand out, and the sum of squares that is left."""
    teeth = world.waves.teeth
    z = teeth.mill.teeth
    shape = directions_standing_out(z)
    base = teeth.forces(world.waves.law.whole)

    def out(values: Array) -> StandsOut:
        return StandsOut(tuple((shape @ values).tolist()), missed)

    def left(values: Array) -> Array:
        made = world.waves.seen(teeth.forces(world.waves.law.whole, out(values)) - base)
        rest = target - made.ravel()
        return np.asarray(rest - free @ solved(free, rest))

    def slopes(values: Array) -> Array:
        more = nudged(world, out(values)).reshape(-1, z) @ shape
        return np.asarray(free @ np.column_stack([solved(free, one) for one in more.T]) - more)

    start = np.zeros(z - 1) if world.out is None else shape.T @ np.array(world.out.mm)
    found = least_squares(left, start, jac=slopes, x_scale=teeth.mill.feed_mm, max_nfev=25)
    return out(found.x), float(2.0 * found.cost)


def _middle(world: SimulatedWaves) -> tuple[SimulatedWaves, NDArray[np.intp]]:
    """Return the world at ROWS rows in the middle of the work."""
    inside = np.flatnonzero(world.waves.teeth.engaged > 0.0)
    first = inside[max(0, (len(inside) - ROWS) // 2)]
    rows = np.arange(first, min(first + ROWS, inside[-1] + 1))
    waves, teeth = world.waves, world.waves.teeth
    cut = replace(
        teeth,
        angle_rad=teeth.angle_rad[rows],
        engaged=teeth.engaged[rows],
        reach=teeth.reach[rows],
    )
    some = replace(
        waves,
        t_s=waves.t_s[rows],
        teeth=cut,
        frames=waves.frames[:, :, rows],
        simulation=waves.simulation[:, rows],
    )
    return replace(world, waves=some, tilted=None), rows
