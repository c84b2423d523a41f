"""Moves in short steps: straight moves whole, arcs in pieces that keep within 45° of direction.

Straight moves that go on along the axis with one feed and speed, as of a profile in short lines,
are one piece: none of them meets what another has cut.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from autodb.nc.reading import Arc, Linear, Move

Array = NDArray[np.float64]

SQUARE_MM = 1e-6
"""A piece that goes less than this along the axis is square to it: below any program's decimals."""
MOST_STEPS = 4000
"""Steps of a piece from which on no further move is of it. Chosen: as rows they take 0.4 MB."""


@dataclass(frozen=True)
class Piece:
    """A piece of a move, x and z each going one way only; or moves that go on along the axis.

    ``x_mm`` and ``z_mm``, (n + 1,), at the ends of its steps, the others, (n,), in their middle;
    ``along_x`` and ``along_z`` are the unit direction, ``line`` that of the program, ``from_mm``
    where along the axis its move begins. ``move``: the first, whose feed and speed are of all.
    """

    move: Move
    x_mm: Array
    z_mm: Array
    middle_x_mm: Array
    middle_z_mm: Array
    along_x: Array
    along_z: Array
    step_mm: Array
    line: NDArray[np.int_]
    from_mm: Array

    @property
    def square(self) -> bool:
        """It runs square to the axis, along a face."""
        return bool(abs(self.z_mm[-1] - self.z_mm[0]) < SQUARE_MM)

    @property
    def away(self) -> bool:
        """It goes away from the chuck."""
        return bool(self.z_mm[-1] > self.z_mm[0])

    def goes_on_as(self, other: "Piece") -> bool:
        """Return whether another piece goes on from where this one ends, the same way along."""
        ends = (self.x_mm[-1], self.z_mm[-1]) == (other.x_mm[0], other.z_mm[0])
        return ends and self.away == other.away and not (self.square or other.square)

    def steeper_than(self, deg: float) -> bool:
        """Return whether it goes inwards at more than an angle to the axis."""
        inwards_mm, along_mm = self.x_mm[0] - self.x_mm[-1], abs(self.z_mm[-1] - self.z_mm[0])
        return bool(np.degrees(np.arctan2(inwards_mm, along_mm)) > deg)

    @property
    def steep_inwards(self) -> bool:
        """It goes inwards, more than along the axis."""
        inwards_mm = self.x_mm[0] - self.x_mm[-1]
        return bool(inwards_mm > abs(self.z_mm[-1] - self.z_mm[0]))


def pieces_of(moves: Iterable[Move], *, step_mm: float) -> Iterator[Piece]:
    """Yield the pieces of moves in their order, in steps of at most ``step_mm``."""
    run: list[Linear] = []
    steps = 0.0
    for move in moves:
        if run and (steps > MOST_STEPS or not _goes_on(run[-1], move)):
            yield _piece_of_several(run, step_mm=step_mm)
            run, steps = [], 0.0
        if isinstance(move, Linear) and _flat(move):
            run.append(move)
            steps += 1.0 + move.length_mm / step_mm
        else:
            yield from pieces(move, step_mm=step_mm)
    if run:
        yield _piece_of_several(run, step_mm=step_mm)


def _flat(move: Linear) -> bool:
    """Return whether a move goes along the axis at least as far as inwards."""
    along_mm = abs(move.end.z_mm - move.start.z_mm)
    return along_mm >= SQUARE_MM and move.start.x_mm - move.end.x_mm <= along_mm


def _goes_on(last: Linear, move: Move) -> bool:
    """Return whether a move goes on where the last one ends, the same way and as fast."""
    if not isinstance(move, Linear) or move.start != last.end or not _flat(move):
        return False
    away = last.end.z_mm > last.start.z_mm
    return (move.end.z_mm > move.start.z_mm) == away and (
        (move.feed, move.speed) == (last.feed, last.speed)
    )


def _piece_of_several(moves: Sequence[Linear], *, step_mm: float) -> Piece:
    """Return the piece that straight moves are which go on."""
    places = np.array([moves[0].start, *(move.end for move in moves)])
    change = np.diff(places, axis=0)
    length_mm = np.hypot(*change.T)
    steps = np.maximum(np.ceil(length_mm / step_mm), 1.0).astype(np.intp)
    which = np.repeat(np.arange(len(moves)), steps)
    begun = np.arange(which.size) - np.repeat(np.cumsum(steps) - steps, steps)
    share = (np.array([[0.0], [0.5]]) + begun) / steps[which]
    (x_mm, z_mm), (middle_x_mm, middle_z_mm) = (
        (places[which] + one[:, None] * change[which]).T for one in share
    )
    direction = change / length_mm[:, None]
    return Piece(
        move=moves[0],
        x_mm=np.append(x_mm, places[-1, 0]),
        z_mm=np.append(z_mm, places[-1, 1]),
        middle_x_mm=middle_x_mm,
        middle_z_mm=middle_z_mm,
        along_x=direction[which, 0],
        along_z=direction[which, 1],
        step_mm=(length_mm / steps)[which],
        line=np.array([move.line for move in moves])[which],
        from_mm=places[which, 1],
    )


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
        line=np.full(step_mm.size, move.line),
        from_mm=np.full(step_mm.size, z_mm[0]),
    )
