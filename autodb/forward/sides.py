"""On which side of the axis a lathe's tools work: those below it are seen from above.

On gang-type lathes, and with a tool in front of the work on some, X is below 0 in the cut. Such a
tool cuts the same, mirrored at the axis. A tool above it that goes past the axis cuts no more.
"""

from collections.abc import Sequence
from dataclasses import replace

from autodb.nc.reading import Arc, Move, Point, Rapid


def above_axis(moves: Sequence[Move]) -> tuple[tuple[Move, ...], tuple[str, ...]]:
    """Return moves with those of tools that work below the axis mirrored, and a note of them."""
    reach: dict[str | None, tuple[float, float]] = {}
    for move in moves:
        if not isinstance(move, Rapid):
            low, high = reach.get(move.tool, (0.0, 0.0))
            places = (move.start.x_mm, move.end.x_mm)
            reach[move.tool] = (min(low, *places), max(high, *places))
    below = {tool for tool, (low, high) in reach.items() if -low > high}
    if not below:
        return tuple(moves), ()
    names = ", ".join(f"{tool}" for tool in below if tool)
    note = f"X is below 0 where tools {names} cut: seen from above the axis"
    return tuple(_reflected(move) if move.tool in below else move for move in moves), (note,)


def _reflected(move: Move) -> Move:
    start, end = _above(move.start), _above(move.end)
    if isinstance(move, Arc):
        return replace(move, start=start, end=end, centre=_above(move.centre), left=not move.left)
    return replace(move, start=start, end=end)


def _above(place: Point) -> Point:
    return Point(-place.x_mm, place.z_mm)
