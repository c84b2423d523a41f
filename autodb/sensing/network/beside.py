"""A network beside the drive models that it sees loads of: how both go together."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.records.tables import Recording
from autodb.sensing.drives.reconstruct import reconstruct
from autodb.sensing.fusion import DRIVE, NETWORK, Fusion, SensedTogether, fuse, learn_fusion
from autodb.sensing.network.drive_loads import AxisTables, LoadedDrive
from autodb.sensing.network.greybox import GreyBox, KnownForceRecording
from autodb.sensing.network.learning import held_out_recordings
from autodb.sensing.network.stream import network_forces

Array = NDArray[np.float64]

NAMES = (DRIVE, NETWORK)
PIECES, GAP_S = 4, 0.5
"""Each recording that was left out is looked at in so many pieces, with a gap between them."""
SLOWEST = 0.25
"""Share of the rate up to which drive models tell loads."""


def bandwidth_hz(box: GreyBox, component: int) -> float:
    """Return the frequency up to which drive models are looked at beside a network's component."""
    return min(float(box.cutoff_hz[component]), SLOWEST * box.rate_hz)


@dataclass(frozen=True)
class NetworkBeside:
    """How a drive model and a network go together, and the error of both together, N."""

    fusion: Fusion
    rmse_N: float


def networks_beside(
    box: GreyBox, drives: Mapping[str, LoadedDrive], known: Sequence[KnownForceRecording]
) -> dict[str, NetworkBeside]:
    """Return how drive models and networks go together, by component, from what was left out."""
    tables = box.tables(drives)
    heard: dict[str, list[SensedTogether]] = {c: [] for c in box.components}
    truth: dict[str, list[Array]] = {c: [] for c in box.components}
    for one in (known[k] for k in held_out_recordings(len(known))):
        both = _heard(box, tables, drives, one)
        for rows in _pieces(len(next(iter(one.force_N.values()))), box.rate_hz):
            for c in box.components:
                heard[c].append(SensedTogether(both[c].value_N[rows], both[c].sd_N[rows]))
                truth[c].append(one.force_N[c][rows])
    found = {}
    for c in box.components:
        fusion = learn_fusion(NAMES, heard[c], truth[c])
        off = [fuse(fusion, h).value_N - true for h, true in zip(heard[c], truth[c], strict=True)]
        found[c] = NetworkBeside(fusion, float(np.sqrt(np.mean(np.concatenate(off) ** 2))))
    return found


def _heard(
    box: GreyBox,
    tables: Mapping[str, AxisTables],
    drives: Mapping[str, LoadedDrive],
    one: KnownForceRecording,
) -> dict[str, SensedTogether]:
    told = network_forces(box, tables, one.channels)
    rows = len(told.force_N)
    recording = Recording(Path("left-out"), {"t": np.arange(rows) / box.rate_hz, **one.channels})
    found = {}
    for k, c in enumerate(box.components):
        load = reconstruct(recording, drives[c].model, bandwidth_hz=bandwidth_hz(box, k))
        scale = drives[c].newtons_per_unit
        found[c] = SensedTogether(
            np.column_stack([-scale * load.value, told.force_N[:, k]]),
            np.column_stack([scale * load.sd, told.sd_N[:, k]]),
        )
    return found


def _pieces(rows: int, rate_hz: float) -> list[slice]:
    gap = round(GAP_S * rate_hz)
    long = (rows - (PIECES - 1) * gap) // PIECES
    if long < rate_hz * GAP_S:
        return [slice(0, rows)]
    return [slice(k * (long + gap), k * (long + gap) + long) for k in range(PIECES)]
