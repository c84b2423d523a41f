"""On which side of the axis, and of itself, a lathe's tool works.

On gang-type lathes, and with a tool in front of the work on some, X is below 0 in the cut. Such a
tool cuts the same, mirrored at the axis. A tool above it that goes past the axis cuts no more.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.contour import SQUARE_SHARE, TOUCH_MM
from autodb.cutting.working import Worked
from autodb.nc.reading import Arc, Move, Point, Rapid
from autodb.wording import phrase


def above_axis(moves: Sequence[Move]) -> tuple[Sequence[Move], tuple[str, ...]]:
    """Return moves with those of tools that work below the axis mirrored, and a note of them."""
    reach: dict[str | None, tuple[float, float]] = {}
    for move in moves:
        if not isinstance(move, Rapid):
            low, high = reach.get(move.tool, (0.0, 0.0))
            places = (move.start.x_mm, move.end.x_mm)
            reach[move.tool] = (min(low, *places), max(high, *places))
    below = {tool for tool, (low, high) in reach.items() if -low > high}
    if not below:
        return moves, ()
    names = ", ".join(f"{tool}" for tool in below if tool)
    note = phrase("X is below 0 where tools {names} cut: seen from above the axis", names=names)
    return tuple(_reflected(move) if move.tool in below else move for move in moves), (note,)


def _reflected(move: Move) -> Move:
    start, end = _above(move.start), _above(move.end)
    if isinstance(move, Arc):
        return replace(move, start=start, end=end, centre=_above(move.centre), left=not move.left)
    return replace(move, start=start, end=end)


def _above(place: Point) -> Point:
    return Point(-place.x_mm, place.z_mm)


def cut_sideways(found: Worked) -> tuple[str, ...]:
    """Return a note where a blade cuts with its side away from the chuck."""
    steps = found.steps
    away = np.flatnonzero((steps.along_z > SQUARE_SHARE) & (steps.depth_mm > TOUCH_MM))
    lines = np.unique(steps.line[away[found.grooves(away)]]).tolist()
    if not lines:
        return ()
    some = ", ".join(f"{line}" for line in lines[:6])
    some = phrase("{what} and more", what=some) if len(lines) > 6 else some
    said = phrase(
        "a blade cuts away from the chuck in lines {lines}: its z is that of a cut towards it",
        lines=some,
    )
    return (said,)


def inward_deg(found: Worked, rows: NDArray[np.intp]) -> NDArray[np.float64]:
    """Return how far inwards of the axis towards the chuck the feed points at steps, °.

    A blade has an edge on either side: away from the chuck it cuts as towards it.
    """
    along_z = found.steps.along_z[rows]
    towards = np.where(found.grooves(rows), -np.abs(along_z), along_z)
    return np.asarray(np.degrees(np.arctan2(-found.steps.along_x[rows], -towards)))
