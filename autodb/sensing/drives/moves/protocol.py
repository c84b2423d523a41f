"""How a recording is filtered before an axis is fitted."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb import signals
from autodb.timing import Timing
from autodb.wording import stored_msgid

Array = NDArray[np.float64]
BUTTERWORTH = stored_msgid("Butterworth 4th order, {cutoff}{lowered}, forwards and backwards")
AFTER_FILTER = stored_msgid("one row in {count} after an anti-alias filter")
WITHOUT_FILTER = stored_msgid("one row in {count} without anti-alias filter")
CROPPED = stored_msgid("{time} cropped at each end")


@dataclass(frozen=True)
class FilterProtocol:
    """How a recording is filtered before the fit; results are comparable only at one protocol.

    Published methods low-pass the effort and keep one row in ``decimate``. ``lowered``: why the
    cutoff is below the default.
    """

    cutoff_hz: float
    decimate: int
    crop_s: float = 0.5
    anti_alias: bool = True
    lowered: str = ""

    def __str__(self) -> str:
        how = AFTER_FILTER if self.anti_alias else WITHOUT_FILTER
        every = (
            BUTTERWORTH.format(cutoff=f"{self.cutoff_hz:g} Hz", lowered=self.lowered),
            how.format(count=self.decimate),
            CROPPED.format(time=f"{self.crop_s:g} s"),
        )
        return "; ".join(every)

    def smoothed(self, effort: Array, *, timing: Timing) -> Array:
        """Return the effort (n,) low-passed, piece by piece."""
        return signals.lowpass_pieces(effort, timing, cutoff_hz=self.cutoff_hz)

    def reduced(self, values: Array, *, timing: Timing) -> Array:
        """Return rows (m,) or (m, k) of ``values`` decimated and cropped, piece by piece.

        Effort and columns reduced alike keep a linear relation between them exactly. Rows that were
        not measured are left out.
        """
        return self._kept(self._by_piece(self._decimated, values, timing), timing)

    def sampled(self, values: Array, *, timing: Timing) -> Array:
        """Return the values (m,) at the rows that are kept, unfiltered: where the axis was then."""
        return self._kept(self._by_piece(self._picked, values, timing), timing)

    def _decimated(self, values: Array) -> Array:
        if not self.anti_alias:
            return self._picked(values)
        return signals.decimate(values, self.decimate)

    def _picked(self, values: Array) -> Array:
        return values[:: self.decimate]

    def _by_piece(self, function: Callable[[Array], Array], values: Array, timing: Timing) -> Array:
        crop = round(self.crop_s * timing.rate_hz / self.decimate)

        def cropped(own: Array) -> Array:
            rows = function(own)
            return rows[crop : len(rows) - crop]

        return signals.by_piece(cropped, values, timing.pieces)

    def _kept(self, rows: Array, timing: Timing) -> Array:
        """Return the rows, less those that were not measured, as far as the cutoff reaches."""
        known = timing.known_within(1.0 / self.cutoff_hz)
        if known is None:
            return rows
        return rows[self._by_piece(self._picked, known.astype(np.float64), timing) > 0]


@dataclass(frozen=True)
class MeansProtocol(FilterProtocol):
    """Means of ``decimate`` rows each, of effort and columns alike, and no other filter on them.

    What an anti-alias filter leaves of noise falls off so steeply that no short autoregression
    follows it, and intervals come out too narrow; means keep noise simple and what is slow whole.
    """

    def smoothed(self, effort: Array, *, timing: Timing) -> Array:  # noqa: ARG002
        """Return the effort as it is."""
        return effort

    def _decimated(self, values: Array) -> Array:
        """Return means (m,) or (m, k) of ``values``."""
        count = len(values) // self.decimate
        whole = values[: count * self.decimate]
        means = whole.reshape(count, self.decimate, *values.shape[1:]).mean(axis=1)
        return np.asarray(means, dtype=np.float64)

    def _picked(self, values: Array) -> Array:
        """Return the values (m,) in the middle of what a mean is over."""
        count = len(values) // self.decimate
        return values[self.decimate // 2 :: self.decimate][:count]


@dataclass(frozen=True)
class WayProtocol(MeansProtocol):
    """Means between ``edges``, rows at which a mean begins: as ``means_by_way`` sets them.

    Nothing is cropped.
    """

    edges: tuple[int, ...] = (0,)

    def reduced(self, values: Array, *, timing: Timing) -> Array:  # noqa: ARG002
        """Return means (m,) or (m, k) of ``values``."""
        count = np.diff([*self.edges, len(values)]).reshape(-1, *[1] * (values.ndim - 1))
        return np.asarray(np.add.reduceat(values, self.edges, axis=0) / count)

    def sampled(self, values: Array, *, timing: Timing) -> Array:  # noqa: ARG002
        """Return the values (m,) in the middle of what a mean is over."""
        middle = (np.array(self.edges) + np.array([*self.edges[1:], len(values)])) // 2
        return np.asarray(values[middle], dtype=np.float64)


WAY_MM = 5.0
"""Way of a mean in motion that goes on: friction of real axes wanders over longer ways. Chosen."""
TURN_MM = 0.1
"""Way after a turn over which means are as short as the protocol's: friction turns. Chosen."""


def means_by_way(
    protocol: FilterProtocol, velocity: Array, *, timing: Timing, way_mm: float = WAY_MM
) -> WayProtocol:
    """Return means of the protocol's rows, longer where motion is slow: over ``way_mm`` at least,
    and over a whole standstill.

    For a sweep over speeds: a pass at creep lasts so long that means over time would give it nearly
    all rows, though friction, which wanders along the way, shows itself there but once.
    """
    begins = np.concatenate(
        [np.arange(own.start, own.stop, protocol.decimate) for own in timing.pieces]
    )
    gone_mm = np.concatenate([[0.0], np.cumsum(np.abs(velocity))])[begins] / timing.rate_hz
    sense = np.sign(velocity[begins])
    piece = np.searchsorted([own.start for own in timing.pieces], begins, side="right")
    edges, turned_mm, begun_mm = [0], 0.0, 0.0
    for k in range(1, len(begins)):
        turn = sense[k] != sense[k - 1] or piece[k] != piece[k - 1]
        turned_mm = gone_mm[k] if turn else turned_mm
        short = sense[k] != 0 and gone_mm[k] - turned_mm < TURN_MM
        if turn or short or gone_mm[k] - begun_mm >= way_mm:
            edges.append(int(begins[k]))
            begun_mm = gone_mm[k]
    return WayProtocol(protocol.cutoff_hz, protocol.decimate, protocol.crop_s, edges=tuple(edges))


def default_protocol(rate_hz: float) -> FilterProtocol:
    """Return 100 Hz and 100 samples per second, or less where the recording is slower."""
    return FilterProtocol(
        cutoff_hz=min(100.0, 0.4 * rate_hz), decimate=max(1, int(rate_hz / 100.0))
    )


def decimated_means(protocol: FilterProtocol) -> MeansProtocol:
    """Return the means of as many rows as the protocol keeps one of."""
    return MeansProtocol(protocol.cutoff_hz, protocol.decimate, protocol.crop_s)
