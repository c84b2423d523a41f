"""Drive models and a network put together as rows come.

What the drive models tell comes with the network, low-passed and late as it is. How far they are
off row by row only a whole recording says: here it is what it was where it was learnt.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from autodb.sensing.fusion import Fusion, fuse_rows
from autodb.sensing.network.drive_loads import AxisTables
from autodb.sensing.network.greybox import GreyBox
from autodb.sensing.network.stream import Channels, NetworkForces, Stream

Array = NDArray[np.float64]


class FusedStream:
    """As ``Stream``; force and standard deviation are those of both together."""

    def __init__(
        self, box: GreyBox, tables: Mapping[str, AxisTables], fusions: Mapping[str, Fusion]
    ) -> None:
        """Take how both go together, by component: drive model first, network second."""
        self._stream = Stream(box, tables)
        self._fusions = [fusions[c] for c in box.components]

    def step(self, channels: Channels) -> NetworkForces:
        """Return what can be told now that the next rows of all channels are there."""
        return self._fused(self._stream.step(channels))

    def finish(self) -> NetworkForces:
        """Return the rest, after the last row."""
        return self._fused(self._stream.finish())

    def _fused(self, told: NetworkForces) -> NetworkForces:
        if not len(told.force_N):
            return told
        made = [self._one(fusion, told, k) for k, fusion in enumerate(self._fusions)]
        return NetworkForces(
            np.column_stack([value for value, _ in made]),
            np.column_stack([sd for _, sd in made]),
            told.drive_N,
        )

    def _one(self, fusion: Fusion, told: NetworkForces, k: int) -> tuple[Array, Array]:
        kept = np.flatnonzero(fusion.counts)
        value_N, sd_N = np.empty((2, len(told.sd_N), 2))
        value_N[:, 0], value_N[:, 1] = told.drive_N[:, k], told.force_N[:, k]
        sd_N[:, 0], sd_N[:, 1] = fusion.size_N[0] / fusion.factor[0], told.sd_N[:, k]
        value, sd, _ = fuse_rows(fusion, value_N[:, kept], sd_N[:, kept], kept)
        return value, fusion.wider * sd
