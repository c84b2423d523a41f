"""Forces that autodb senses on a reference lathe, calibrated on its calibration cuts."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.prove.lathe_cuts import rows_of
from autodb.records import CutTable
from autodb.sensing import ranges
from autodb.virtual.reference_lathe import Campaign, Table

Array = NDArray[np.float64]
TEXTS = ("operation", "work.material", "tool")


def sensed(made: Campaign, axis: str) -> tuple[Array, Array]:
    """Return force and its standard deviation (n,) on an axis' test cuts, N.

    The deviation is that of one cut and that of the calibration together.
    """
    known, tested = rows_of(made, axis)
    found = ranges.calibrate(_table(made.calibration, known), axis)
    felt = ranges.sense(_table(made.test, tested), found)
    shared = np.einsum("ij,jk,ik->i", felt.common, found.shared_covariance, felt.common)
    return felt.force_N, np.sqrt(felt.sd_N**2 + shared)


def _table(table: Table, rows: NDArray[np.bool_]) -> CutTable:
    edges = np.unique(table["tool.edge"], return_inverse=True)[1].astype(np.float64)
    numbers = {name: values for name, values in table.items() if name not in TEXTS}
    channels = {**numbers, "tool.edge": edges}
    return CutTable(
        path=Path("lathe.csv"),
        channels={name: np.asarray(v, dtype=np.float64)[rows] for name, v in channels.items()},
        texts={name: table[name][rows].tolist() for name in TEXTS},
    )
