"""The working rate of a search: means of rows, piece by piece, and which of them noise links."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from autodb.signals import by_piece
from autodb.timing import Timing

Array = NDArray[np.float64]
Index = NDArray[np.intp]

HALF = 0.5
"""Share of the rows of a mean that must have been measured. Chosen."""
EDGE_S = 0.02
"""Time at a gap over which motion that is derived has but one side to go by: two periods of the
default cutoff. Chosen."""


@dataclass(frozen=True)
class WorkingRate:
    """Means of ``factor`` rows each, within the pieces of a recording; None: all rows are one.

    ``edge_s``: time at a gap over which what is derived of the rows has but one side to go by.
    """

    factor: int
    timing: Timing | None = None
    edge_s: float = EDGE_S

    def reduced(self, values: Array) -> Array:
        """Return values (n,) or (n, p) at the working rate, (m,) or (m, p)."""
        if self.timing is None:
            return reduced(values, self.factor)
        return by_piece(lambda own: reduced(own, self.factor), values, self.timing.pieces)

    def linked(self, order: int) -> Index | None:
        """Return which white rows (k,) of a filter of this order lie within one piece, and were
        measured; None where all do.
        """
        broken = self._broken
        if broken is None:
            return None
        total = np.concatenate([[0], np.cumsum(broken)])
        return np.flatnonzero(total[order + 1 :] - total[: -order - 1] == 0)

    @cached_property
    def _broken(self) -> Array | None:
        """Return where a row (m,) does not follow the one before: 1, else 0; None where all do."""
        if self.timing is None or (len(self.timing.pieces) == 1 and self.timing.placed is None):
            return None
        rows = [(piece.stop - piece.start) // self.factor for piece in self.timing.pieces]
        broken = np.zeros(sum(rows))
        edge = int(np.ceil(self.edge_s * self.timing.rate_hz / self.factor))
        for seam in np.cumsum(rows[:-1]):
            broken[max(0, seam - edge) : seam + max(edge, 1)] = 1.0
        known = self.timing.known_within(EDGE_S)
        if known is not None:
            broken[self.reduced(known.astype(np.float64)) < HALF] = 1.0
        return broken


def reduced(values: Array, factor: int) -> Array:
    """Return means of ``factor`` rows each: columns alike, so that sums of them stay exact.

    Rows that do not fill a mean are left out.
    """
    if factor == 1:
        return values
    rows = len(values) // factor
    whole = values[: rows * factor]
    total = whole[::factor].copy()
    for row in range(1, factor):
        total += whole[row::factor]
    return np.asarray(total / factor)
