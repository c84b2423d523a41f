"""A move in short steps: straight moves whole, arcs in pieces that keep within 45° of direction."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from autodb.nc.reading import Arc, Move

Array = NDArray[np.float64]

SQUARE_MM = 1e-6
"""A piece that goes less than this along the axis is square to it: below any program's decimals."""


@dataclass(frozen=True)
class Piece:
    """A piece of a move, x and z each going one way only.

    ``x_mm`` and ``z_mm``, (n + 1,), at the ends of its steps, the others, (n,), in their middle;
    ``along_x`` and ``along_z`` are the unit direction.
    """

    move: Move
    x_mm: Array
    z_mm: Array
    middle_x_mm: Array
    middle_z_mm: Array
    along_x: Array
    along_z: Array
    step_mm: Array

    @property
    def square(self) -> bool:
        """It runs square to the axis, along a face."""
        return bool(abs(self.z_mm[-1] - self.z_mm[0]) < SQUARE_MM)

    @property
    def away(self) -> bool:
        """It goes away from the chuck."""
        return bool(self.z_mm[-1] > self.z_mm[0])

    def steeper_than(self, deg: float) -> bool:
        """Return whether it goes inwards at more than an angle to the axis."""
        inwards_mm, along_mm = self.x_mm[0] - self.x_mm[-1], abs(self.z_mm[-1] - self.z_mm[0])
        return bool(np.degrees(np.arctan2(inwards_mm, along_mm)) > deg)

    @property
    def steep_inwards(self) -> bool:
        """It goes inwards, more than along the axis."""
        inwards_mm = self.x_mm[0] - self.x_mm[-1]
        return bool(inwards_mm > abs(self.z_mm[-1] - self.z_mm[0]))


def pieces(move: Move, *, step_mm: float) -> Iterator[Piece]:
    """Yield the pieces of a move in steps of equal length, at most ``step_mm``."""
    inner = move.turning_shares() if isinstance(move, Arc) else np.empty(0)
    for start, end in pairwise([0.0, *inner.tolist(), 1.0]):
        steps = max(int(np.ceil((end - start) * move.length_mm / step_mm)), 1)
        yield _piece(move, np.linspace(start, end, 2 * steps + 1))


def _piece(move: Move, shares: Array) -> Piece:
    """Return a piece sampled at the ends and middles of its steps; moves meet to the last digit.

    Directions are those of the chords: of an arc exact to the second order in the step.
    """
    x_mm, z_mm = move.points(shares)
    if shares[0] == 0.0:
        x_mm[0], z_mm[0] = move.start
    if shares[-1] == 1.0:
        x_mm[-1], z_mm[-1] = move.end
    along_x, along_z = np.diff(x_mm[::2]), np.diff(z_mm[::2])
    chord_mm = np.hypot(along_x, along_z)
    step_mm = np.full(chord_mm.size, move.length_mm * (shares[-1] - shares[0]) / chord_mm.size)
    return Piece(
        move=move,
        x_mm=x_mm[::2],
        z_mm=z_mm[::2],
        middle_x_mm=x_mm[1::2],
        middle_z_mm=z_mm[1::2],
        along_x=along_x / chord_mm,
        along_z=along_z / chord_mm,
        step_mm=step_mm,
    )
