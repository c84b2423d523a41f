"""A contour that a cycle cuts towards: its places in order, moved by allowances, cut at a level.

The contour is a chain of short lines (n, 2): along the cut and across it, so that roughing along
the axis and facing are the same. A level is a straight pass: it cuts where the contour lies beyond.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from autodb.nc.reading.travels import ProgramMove

Array = NDArray[np.float64]

CHORD_MM = 0.05
"""Length of the lines that stand for an arc. Chosen: on a radius of 2 mm they are off by 0.2 µm."""
_SAME_MM = 1e-7
_BACK = -1.0 + 1e-9
"""Cosine between two lines of a contour below which the second goes back on the first."""


def chain(moves: Sequence[ProgramMove], *, along: int, across: int) -> Array:
    """Return the places (n, 2) of moves in order, by the axes of a place: 0 is x, 2 is z."""
    found: list[Array] = [np.array([[moves[0].start[along], moves[0].start[across]]])]
    for move in moves:
        steps = 1
        if move.circle is not None:
            steps = max(int(np.ceil(move.length_mm / CHORD_MM)), 2)
        places = move.places(np.arange(1, steps + 1) / steps)
        found.append(places[:, [along, across]])
    return np.vstack(found)


def moved(places: Array, *, by: tuple[float, float], off_mm: float, side: float) -> Array:
    """Return a chain moved by an allowance in each axis, and by one square to it.

    ``side``: 1 moves it away from the axis, -1 towards it.
    """
    shifted = places + np.asarray(by)
    if off_mm == 0.0:
        return np.asarray(shifted)
    steps = np.diff(shifted, axis=0)
    length = np.hypot(steps[:, 0], steps[:, 1])
    kept = length > _SAME_MM
    normals = np.column_stack([-steps[kept, 1], steps[kept, 0]]) / length[kept, None]
    normals *= np.where(side * normals.sum(axis=0)[1] < 0, -1.0, 1.0)
    ends = np.concatenate([shifted[:-1][kept], shifted[-1:]])
    before, after = np.vstack([normals[:1], normals]), np.vstack([normals, normals[-1:]])
    back = np.sum(before * after, axis=1) < _BACK  # it turns round: no place is beside both
    mean = np.where(back[:, None], 2.0 * after, before + after)
    return np.asarray(ends + off_mm * 2.0 * mean / np.sum(mean * mean, axis=1)[:, None])


def without_pockets(places: Array, side: float) -> Array:
    """Return a contour bridged where it falls back behind what it has reached before.

    ``side``: as of `runs_beyond`.
    """
    kept, top = [places[0]], float(places[0, 1])
    for k, (along, across) in enumerate(places[1:].tolist()):
        if side * (across - top) <= 0:
            kept.append(np.array([along, top]))
            continue
        if side * (places[k, 1] - top) < 0:
            kept.append(np.array([_crossing(places, k, top), top]))
        kept.append(places[k + 1])
        top = across
    return np.array(kept)


def runs_beyond(
    places: Array, level: float, side: float, *, above: float
) -> Iterator[tuple[list[tuple[float, float]], float]]:
    """Yield where along the cut the contour lies beyond a level: the way into it, and its end.

    The way in is along the contour, from a level ``above`` down to this one; it is empty where the
    contour lies beyond from its very start. ``side``: 1 where the material lies above the contour
    (turning outside), -1 below it.
    """
    beyond = side * (level - places[:, 1]) > _SAME_MM
    k, count = 0, len(places)
    while k < count:
        if not beyond[k]:
            k += 1
            continue
        first = k
        while k + 1 < count and beyond[k + 1]:
            k += 1
        way = [] if first == 0 else _way_in(places, first - 1, (above, level), side)
        begin = way[-1][0] if way else float(places[0, 0])
        end = float(places[k, 0]) if k == count - 1 else _crossing(places, k, level)
        if abs(end - begin) > _SAME_MM:
            yield way, end
        k += 1


def _way_in(
    places: Array, k: int, levels: tuple[float, float], side: float
) -> list[tuple[float, float]]:
    """Return the places of a contour between two levels, the lower one met by the line from k on.

    Where it falls from below the upper one, its first line goes on up to that.
    """
    above, level = levels
    way = [(_crossing(places, k, level), level)]
    while side * (places[k, 1] - above) < 0:
        way.append((float(places[k, 0]), float(places[k, 1])))
        if k == 0 or side * (places[k - 1, 1] - places[k, 1]) <= _SAME_MM:
            break
        k -= 1
    way.append((_crossing(places, k, above), above))
    return way[::-1]


def _crossing(places: Array, k: int, level: float) -> float:
    """Return where the line from place k on meets a level."""
    (a0, d0), (a1, d1) = places[k], places[k + 1]
    share = 0.0 if d1 == d0 else (level - d0) / (d1 - d0)
    return float(a0 + share * (a1 - a0))
