"""Recordings as networks take them: motion of axes, known forces, pieces, and their errors."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.fitting.gaussian import NORMAL_95
from autodb.records.tables import Recording
from autodb.sensing.drives.moves.motion import axis_motion, protocol_of
from autodb.sensing.network.drive_loads import LoadedDrive
from autodb.sensing.network.greybox import SPINDLE, GreyBox, KnownForceRecording, loads_of
from autodb.sensing.network.learning import held_out_recordings
from autodb.sensing.network.stream import network_forces

Array = NDArray[np.float64]

PIECES, GAP_S = 8, 1.0
"""Fewer recordings are cut into so many pieces together, with a gap between them."""
SHORTEST_S = 2.0
"""Length of a piece below which it tells too little."""
SAME_RATE = 0.01
"""Share by which rates of recordings may differ."""


@dataclass(frozen=True)
class ComponentErrors:
    """Errors of a component in recordings that were left out, N: the network's and the drive
    model's; the share of rows within 95 % intervals; up to which frequency it is told.
    """

    component: str
    rmse_N: float
    drive_rmse_N: float
    held: float
    cutoff_hz: float


def channels_of(recording: Recording, drives: Mapping[str, LoadedDrive]) -> dict[str, Array]:
    """Return what networks and drive models take; motion that was not recorded is derived."""
    found: dict[str, Array] = {}
    for axis, drive in drives.items():
        cutoff_hz = protocol_of(recording, axis).cutoff_hz
        moved = axis_motion(recording, axis, cutoff_hz=cutoff_hz)
        found |= {
            f"{axis}.position": moved.position,
            f"{axis}.velocity": moved.velocity,
            f"{axis}.acceleration": moved.acceleration,
            drive.model.channel: recording[drive.model.channel],
        }
    return found | {name: recording[name] for name in SPINDLE if name in recording}


def pieces_with_forces(
    recordings: Sequence[Recording], drives: Mapping[str, LoadedDrive]
) -> tuple[list[KnownForceRecording], bool]:
    """Return pieces of recordings with their known forces, and whether they are of air.

    Where no recording has a force of one of the axes, they are moves in air and it is 0.

    Raises UnusableInput where some have a force that others lack, or a recording is too short.
    """
    has = {axis: [f"force.{axis}" in one for one in recordings] for axis in drives}
    told = [axis for axis, those in has.items() if any(those)]
    for axis in told:
        if not all(has[axis]):
            lacks = recordings[has[axis].index(False)]
            raise UnusableInput(
                f"{lacks.path}: no channel 'force.{axis}', which others have; use recordings "
                "with the same forces"
            )
    found = []
    count = -(-PIECES // len(recordings))
    for one in recordings:
        channels = channels_of(one, drives)
        zero = np.zeros(len(one))
        known = {a: one[f"force.{a}"] if told else zero for a in told or drives}
        found += [_cut(channels, known, rows) for rows in _pieces(one, count)]
    return found, not told


def _cut(
    channels: Mapping[str, Array], known: Mapping[str, Array], rows: slice
) -> KnownForceRecording:
    return KnownForceRecording(
        {name: values[rows] for name, values in channels.items()},
        {name: values[rows] for name, values in known.items()},
    )


def _pieces(recording: Recording, count: int) -> list[slice]:
    """Return rows of pieces of a recording, with a gap between them; none reaches over a gap of
    its time, of which the shortest parts are left out.
    """
    rate_hz = recording.timing.rate_hz
    shortest = SHORTEST_S * rate_hz
    even = [p for p in recording.pieces if p.stop - p.start >= shortest] or [slice(0, 0)]
    total = sum(p.stop - p.start for p in even)
    found = []
    for piece in even:
        rows = piece.stop - piece.start
        share = max(1, round(count * rows / max(total, 1)))
        gap = round(GAP_S * rate_hz) if share > 1 else 0
        long = (rows - (share - 1) * gap) // share
        if long < shortest:
            raise UnusableInput(
                f"{recording.path}: {len(recording) / rate_hz:.3g} s are too short to train on; "
                f"record {count * SHORTEST_S + (count - 1) * GAP_S:g} s, or {PIECES} recordings"
            )
        starts = [piece.start + k * (long + gap) for k in range(share)]
        found += [slice(start, start + long) for start in starts]
    return found


def rate_of(recordings: Sequence[Recording]) -> float:
    """Return the rate of all recordings; raises UnusableInput naming one of another."""
    first = recordings[0].timing.rate_hz
    for one in recordings:
        rate_hz = one.timing.rate_hz
        if abs(rate_hz / first - 1.0) > SAME_RATE:
            raise UnusableInput(
                f"{one.path}: {rate_hz:g} Hz, and {recordings[0].path.name} has {first:g} Hz; use "
                "recordings of one rate"
            )
    return first


def scored_components(
    box: GreyBox, drives: Mapping[str, LoadedDrive], known: Sequence[KnownForceRecording]
) -> tuple[ComponentErrors, ...]:
    """Return how near a grey box and its drive models come in what was left out in training."""
    tables = box.tables(drives)
    off: list[Array] = []
    drive: list[Array] = []
    held: list[Array] = []
    for one in (known[k] for k in held_out_recordings(len(known))):
        told, loads = network_forces(box, tables, one.channels), loads_of(tables, one.channels)
        true = np.column_stack([one.force_N[c] for c in box.components])
        load = np.column_stack([loads[c] for c in box.components])
        off.append(np.mean((told.force_N - true) ** 2, axis=0))
        drive.append(np.mean((-load - true) ** 2, axis=0))
        held.append(np.mean(np.abs(told.force_N - true) <= NORMAL_95 * told.sd_N, axis=0))
    errors, drives_, shares = (np.mean(one, axis=0) for one in (off, drive, held))
    return tuple(
        ComponentErrors(
            component,
            float(np.sqrt(errors[k])),
            float(np.sqrt(drives_[k])),
            float(shares[k]),
            float(box.cutoff_hz[k]),
        )
        for k, component in enumerate(box.components)
    )
