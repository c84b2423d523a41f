"""One channel of a file, block by block: its extremes, spread, gaps and plateaus."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from autodb.records.tables import Array

Index = NDArray[np.intp]
RUN = 5
"""Samples in a row that are exactly equal: a plateau."""
STEPS = 6.0
"""A plateau is run into where the sample before or after it is no further than this many typical
steps of the channel; a step into a standstill is further."""
QUANTA = 3.0
"""A plateau is cut off where its flanks would have met this many smallest steps beyond it; a top
that is drawn in few digits reaches about one and a half. Chosen."""
SAMPLE = 1 << 13
"""Samples of a block that typical steps and roughness are taken from."""
LEVELS = 20
"""Fewer different values than this are a counter or a switch, not a measured quantity."""


@dataclass
class Plateau:
    """What lies at one extreme of a channel: samples in runs of RUN or more that are run into."""

    value: float
    held: int = 0


@dataclass
class ChannelSummary:
    """One channel: rows, extremes, mean and spread over its finite numbers, and its gaps.

    ``stated``: whether side file or file say its unit. ``low`` and ``high`` are the plateaus at its
    extremes, ``elsewhere`` counts samples in runs of equal numbers that are neither zero nor at an
    extreme. ``roughness`` is the median over blocks of the median |second difference| that is not
    zero, over the block's range; ``levels`` the most different values seen in a block.
    """

    name: str
    unit: str
    stated: bool = False
    rows: int = 0
    finite: int = 0
    mean: float = 0.0
    first_gap: int | None = None
    low: Plateau = field(default_factory=lambda: Plateau(np.inf))
    high: Plateau = field(default_factory=lambda: Plateau(-np.inf))
    elsewhere: int = 0
    levels: int = 0
    _squares: float = 0.0
    _rough: list[float] = field(default_factory=list)

    @property
    def minimum(self) -> float:
        """Lowest finite number."""
        return self.low.value

    @property
    def maximum(self) -> float:
        """Highest finite number."""
        return self.high.value

    @property
    def sd(self) -> float:
        """Standard deviation over the finite numbers."""
        return float(np.sqrt(self._squares / self.finite)) if self.finite else np.nan

    @property
    def roughness(self) -> float:
        """See the class."""
        return float(np.median(self._rough)) if self._rough else 0.0

    def add(self, values: Array) -> None:
        """Take in the next block (n,)."""
        good = np.isfinite(values)
        if self.first_gap is None and not good.all():
            self.first_gap = self.rows + int(np.argmin(good)) + 1
        self.rows += len(values)
        finite = values[good]
        if finite.size:
            self._moments(finite)
            self._plateaus(finite)

    def _moments(self, values: Array) -> None:
        """Join mean and sum of squares (Chan, Golub, LeVeque 1983)."""
        n, mean = len(values), float(values.mean())
        shift, total = mean - self.mean, self.finite + n
        self._squares += float(((values - mean) ** 2).sum()) + shift**2 * self.finite * n / total
        self.mean += shift * n / total
        self.finite = total

    def _plateaus(self, values: Array) -> None:
        low, high = float(values.min()), float(values.max())
        steps = np.abs(np.diff(values))
        starts = np.flatnonzero(np.append(True, steps > 0))
        ends = np.append(starts[1:], len(values))
        long = ends - starts >= RUN
        level, held = values[starts[long]], (ends - starts)[long]
        some = steps[:SAMPLE][steps[:SAMPLE] > 0]
        typical = float(np.median(some)) if some.size else 0.0
        run_into = _run_into(values, starts[long], ends[long], STEPS * typical)
        quantum = float(some.min()) if some.size else 0.0
        run_into &= _beyond(values, starts[long], ends[long]) > QUANTA * quantum
        self.low = _further(self.low, low, int(held[(level == low) & run_into].sum()), sign=-1)
        self.high = _further(self.high, high, int(held[(level == high) & run_into].sum()), sign=1)
        self.elsewhere += int(held[(level != low) & (level != high) & (level != 0)].sum())
        if self.levels < LEVELS:
            self.levels = max(self.levels, min(LEVELS, len(np.unique(values))))
        bends = np.abs(np.diff(values[:SAMPLE], 2))
        bends = bends[bends > 0]
        if bends.size:
            self._rough.append(float(np.median(bends)) / (high - low))


def _run_into(values: Array, starts: Index, ends: Index, reach: float) -> NDArray[np.bool_]:
    """Return which runs [start, end) have a neighbour on both sides that is within reach."""
    before, after = values[np.maximum(starts - 1, 0)], values[np.minimum(ends, len(values) - 1)]
    level = values[starts]
    return (np.abs(before - level) <= reach) & (np.abs(after - level) <= reach)


def _beyond(values: Array, starts: Index, ends: Index) -> Array:
    """Return how far beyond runs [start, end) their flanks would have met, were it a parabola.

    With slope s at both ends of a run of L samples that is s·L/4.
    """
    length = ends - starts
    reach = np.maximum(length // 2, 1)
    level = values[starts]
    before = np.abs(level - values[np.maximum(starts - reach, 0)])
    after = np.abs(level - values[np.minimum(ends - 1 + reach, len(values) - 1)])
    return np.asarray(0.5 * (before + after) / reach * length / 4.0, dtype=np.float64)


def _further(plateau: Plateau, value: float, held: int, *, sign: int) -> Plateau:
    """Return the plateau at the further extreme of two blocks; of both where they are equal."""
    if value == plateau.value:
        return Plateau(value, plateau.held + held)
    return Plateau(value, held) if sign * (value - plateau.value) > 0 else plateau
