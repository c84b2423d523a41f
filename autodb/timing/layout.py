"""How the rows of a file became even rows, and the way back."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.intp]
Flags = NDArray[np.bool_]

FEWEST_SPLINE = 4
CREEP_ROWS = 6.5
"""Steps between two rows written on change, from which on a place rests, not creeps. Chosen."""


@dataclass(frozen=True)
class LaidPiece:
    """One piece of even rows.

    ``rows`` (n,): the file's rows that it is made of, in time · ``times_s`` (n,): when each of them
    was taken, as far as can be told, increasing · ``t_s`` (m,): the even times · ``held`` (m,):
    rows that repeat the last row written, since nothing had changed · ``resting`` (m,): rows
    written on change at which no place had changed, so that it may be anywhere in its dead band.
    ``exact``: whether every row keeps its numbers, each on a time of its own.
    """

    rows: Index
    times_s: Array
    t_s: Array
    held: Flags
    resting: Flags
    exact: bool

    def laid_out(self, values: Array, *, smooth: bool) -> Array:
        """Return a channel of the file (N,) at the even times (m,)."""
        from scipy.interpolate import CubicSpline

        own = values[self.rows]
        if self.exact:
            return own
        held = self.held.any()
        if smooth and not held and len(own) >= FEWEST_SPLINE:
            return np.asarray(CubicSpline(self.times_s, own)(self.t_s), dtype=np.float64)
        made = np.interp(self.t_s, self.times_s, own)
        if held:
            rests = self.held & self._rests() if smooth else self.held
            last = np.searchsorted(self.times_s, self.t_s[rests], side="right") - 1
            made[rests] = own[np.maximum(last, 0)]
        return np.asarray(made, dtype=np.float64)

    def _rests(self) -> Flags:
        """Return the even times (m,) that lie in a time too long to be a creep between two rows."""
        after = np.minimum(np.searchsorted(self.times_s, self.t_s), len(self.times_s) - 1)
        span = self.times_s[after] - self.times_s[np.maximum(after - 1, 0)]
        return np.asarray(span > CREEP_ROWS * (self.t_s[1] - self.t_s[0]), dtype=np.bool_)


@dataclass(frozen=True)
class Layout:
    """Pieces of even rows, one after the other.

    ``rows``: how many rows the file has.
    """

    parts: tuple[LaidPiece, ...]
    rows: int

    @property
    def t_s(self) -> Array:
        """The even times (m,), s."""
        return np.concatenate([part.t_s for part in self.parts])

    @property
    def measured(self) -> Flags:
        """Whether a row (m,) was measured, or only lies between rows that were."""
        return np.concatenate([_measured(part) for part in self.parts])

    @property
    def placed(self) -> Flags:
        """Whether a row (m,) was measured and its place is not within a dead band."""
        resting = np.concatenate([part.resting for part in self.parts])
        return np.asarray(self.measured & ~resting, dtype=np.bool_)

    def laid_out(self, values: Array, *, smooth: bool = False) -> Array:
        """Return a channel of the file (N,) at the even rows (m,).

        ``smooth``: places and speeds, by cubic splines where rows do not lie on the even times,
        others by straight lines. Where rows were written on change all hold their last value, but
        those by straight lines that creep.
        """
        return np.concatenate([part.laid_out(values, smooth=smooth) for part in self.parts])

    def of_file(self, values: Array) -> Array:
        """Return values of the even rows (m,) at the rows of the file (N,).

        NaN where a row of the file is in no piece.
        """
        found, begin = np.full(self.rows, np.nan), 0
        for part in self.parts:
            own = values[begin : begin + len(part.t_s)]
            begin += len(part.t_s)
            found[part.rows] = own if part.exact else np.interp(part.times_s, part.t_s, own)
        return found


def _measured(part: LaidPiece) -> Flags:
    """Return whether a time has a row of the file within a step of it on both sides, (m,)."""
    if part.exact:
        return np.ones(len(part.t_s), dtype=np.bool_)
    after = np.minimum(np.searchsorted(part.times_s, part.t_s), len(part.times_s) - 1)
    before = np.maximum(after - 1, 0)
    step_s = (part.t_s[-1] - part.t_s[0]) / max(len(part.t_s) - 1, 1)
    wide = part.times_s[after] - part.times_s[before] > 1.5 * step_s
    off = np.minimum(
        np.abs(part.times_s[after] - part.t_s), np.abs(part.t_s - part.times_s[before])
    )
    return np.asarray(~wide | (off < 0.25 * step_s), dtype=np.bool_)
