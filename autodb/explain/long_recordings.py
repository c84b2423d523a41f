"""A long recording as means of its rows, so that hours of it fit into a small computer.

A law that is linear in what moves holds of means as it does of rows. Motion that is not recorded is
derived at every row, and then a mean; friction's sign and what else bends is that of a mean, which
is as far off as a mean holds a reversal.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.working import WorkingRate, reduced
from autodb.files.channels import LINEAR_AXES, axis_of, place_channel
from autodb.records.tables import Recording
from autodb.sensing.drives.moves.motion import DROWNED, axis_motion, protocol_of
from autodb.sensing.drives.moves.protocol import FilterProtocol
from autodb.wording import stored_msgid

Array = NDArray[np.float64]

MEANS = 240_000
"""Means that a long recording is searched in: a search works with 60 000. Chosen."""
LEAST_HZ = 16.0
"""Means a second at least, however long it is: three of a ripple of 20 mm at 100 mm/s. Chosen."""
MOST_KEPT = 0.9
"""Share of the rows that means must hold: many short pieces would lose their ends. Chosen."""
CHUNK = 1_000_000
"""Rows of which motion is derived at a time, so that it takes a fixed memory."""
SEARCHED = stored_msgid(
    "{file}: {rows} rows are searched, and their errors counted, as means of {count} each: {rate} "
    "a second; corrections are written at every row"
)
BESIDE_S = 2.0
"""Time on either side of a chunk that its filter sees: 50 periods of the default cutoff."""


@dataclass(frozen=True)
class LongRecording:
    """A recording, and the same as ``means`` of ``rate.factor`` rows each.

    ``derived_with``: by axis the filter that its motion was derived with, where it was.
    """

    recording: Recording
    means: Recording
    rate: WorkingRate
    derived_with: Mapping[str, FilterProtocol]

    @property
    def note(self) -> str:
        """Say what was searched."""
        return SEARCHED.format(
            file=self.recording.path, rows=len(self.recording), count=self.rate.factor,
            rate=f"{self.means.timing.rate_hz:.4g}",
        )  # fmt: skip

    def at_every_row(self, correction: Array) -> Array:
        """Return a correction of means (m,) at every row (n,), straight between their middles."""
        return np.interp(self.recording.t_s, self.means.t_s, correction)


def long_recording(recording: Recording, efforts: Collection[str]) -> LongRecording | None:
    """Return a recording as means of its rows with the motion of the axes of some efforts; None
    where it is short, in many short pieces, or not all of its rows were measured.
    """
    timing = recording.timing
    factor = min(len(recording) // MEANS, int(timing.rate_hz / LEAST_HZ))
    if factor < 2 or timing.measured is not None or timing.placed is not None:
        return None
    rate = WorkingRate(factor, timing)
    lengths = [(one.stop - one.start) // factor for one in _bounded(recording)]
    if sum(lengths) * factor < MOST_KEPT * len(recording):
        return None
    ends = np.cumsum(lengths)
    pieces = tuple(slice(int(end - n), int(end)) for end, n in zip(ends, lengths, strict=True) if n)
    channels = {
        name: rate.reduced(values)
        for name, values in recording.channels.items()
        if name not in recording.unusable
    }
    derived_with = {}
    for axis in dict.fromkeys((*(axis_of(name) for name in efforts), *LINEAR_AXES)):
        if (protocol := _protocol(recording, axis, rate)) is not None:
            derived_with[axis] = protocol
            channels |= _derived_means(recording, axis, rate, protocol.cutoff_hz)
    even = replace(
        timing, step_s=factor * timing.step_s, pieces=pieces, rows=len(channels["t"]), layout=None
    )
    means = Recording(
        recording.path, channels, units=recording.units, side=recording.side,
        unusable=recording.unusable, ignored=recording.ignored, examined_as=even,
    )  # fmt: skip
    return LongRecording(recording, means, rate, derived_with)


def _bounded(recording: Recording) -> list[slice]:
    """Return the pieces of a recording with their ends as numbers."""
    return [slice(*one.indices(len(recording))) for one in recording.timing.pieces]


def _protocol(recording: Recording, axis: str, rate: WorkingRate) -> FilterProtocol | None:
    """Return what an axis' motion is derived with, by the chunk in which it goes farthest; None
    where nothing has to be derived.
    """
    if place_channel(axis) not in recording or not _missing(recording, axis):
        return None
    chunks = [rows for rows, _ in _chunks(recording, rate.factor)]
    place = recording[place_channel(axis)]
    widest = max(chunks, key=lambda rows: float(np.ptp(place[rows])))
    return protocol_of(_part(recording, axis, widest), axis, noise_share=DROWNED)


def _missing(recording: Recording, axis: str) -> list[str]:
    """Return what of an axis' motion was not recorded."""
    return [one for one in ("velocity", "acceleration") if f"{axis}.{one}" not in recording]


def _derived_means(
    recording: Recording, axis: str, rate: WorkingRate, cutoff_hz: float
) -> dict[str, Array]:
    """Return means of what was not recorded of an axis' motion, by channel."""
    found: dict[str, list[Array]] = {name: [] for name in _missing(recording, axis)}
    for rows, inner in _chunks(recording, rate.factor):
        part = _part(recording, axis, rows)
        moved = axis_motion(part, axis, cutoff_hz=cutoff_hz, own_speeds=True)
        for name, means in found.items():
            means.append(reduced(getattr(moved, name)[inner], rate.factor))
    return {f"{axis}.{name}": np.concatenate(means) for name, means in found.items()}


def _chunks(recording: Recording, factor: int) -> Iterator[tuple[slice, slice]]:
    """Yield the rows of each chunk with those beside it, and where its own lie in them: whole
    means, within one piece.
    """
    beside = int(np.ceil(BESIDE_S * recording.timing.rate_hz))
    length = max(CHUNK // factor, 1) * factor
    for piece in _bounded(recording):
        end = piece.start + (piece.stop - piece.start) // factor * factor
        for start in range(piece.start, end, length):
            stop = min(start + length, end)
            low, high = max(piece.start, start - beside), min(piece.stop, stop + beside)
            yield slice(low, high), slice(start - low, stop - low)


def _part(recording: Recording, axis: str, rows: slice) -> Recording:
    """Return an axis' motion, as far as it was recorded, in some rows of one piece."""
    count = rows.stop - rows.start
    even = replace(recording.timing, pieces=(slice(0, count),), rows=count, layout=None)
    names = (place_channel(axis), f"{axis}.velocity", f"{axis}.acceleration")
    channels = {name: recording[name][rows] for name in ("t", *names) if name in recording}
    return Recording(recording.path, channels, units=recording.units, examined_as=even)
