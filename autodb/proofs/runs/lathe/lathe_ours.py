"""Forces that autodb senses on a reference lathe, calibrated on its calibration cuts."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.machines.lathe.reference_lathe import Campaign, Table
from autodb.proofs.runs.lathe.lathe_cuts import rows_in_tables
from autodb.records.tables import CutTable
from autodb.sensing.ranges import calibration as ranges
from autodb.sensing.ranges.forms import OF_CURRENT_FEED, OF_CURRENT_SPEED
from autodb.sensing.ranges.points import calibration_points
from autodb.sensing.ranges.sensed_force import sense

Array = NDArray[np.float64]
TEXTS = ("operation", "work.material", "tool")


@dataclass(frozen=True)
class SensedTestForces:
    """Force (n,) on an axis' test cuts and its standard deviation, N, of one cut and of the
    calibration together; and the force that rules over current and speed give, taken or not, None
    where the calibration cuts are too few for their parameters.
    """

    force_N: Array
    sd_N: Array
    by_rules_N: Array | None


def sensed(made: Campaign, axis: str) -> SensedTestForces:
    """Return what an axis senses on its test cuts."""
    calibration, test = calibration_table(made, axis), tested_table(made, axis)
    found = ranges.calibrate(calibration, axis)
    sensed = sense(test, found)
    shared = np.einsum("ij,jk,ik->i", sensed.common, found.shared_covariance, sensed.common)
    sd_N = np.sqrt(sensed.sd_N**2 + shared)
    points = calibration_points(calibration, axis)
    rules = OF_CURRENT_SPEED if axis == "spindle" else OF_CURRENT_FEED
    if not rules.fits(points.sensed):
        return SensedTestForces(sensed.force_N, sd_N, None)
    law = rules.fit(points.sensed, points.target)
    by_rules = sense(test, replace(found, **vars(law)))
    return SensedTestForces(sensed.force_N, sd_N, by_rules.force_N)


def calibration_table(made: Campaign, axis: str) -> CutTable:
    """Return the cuts that an axis is calibrated with."""
    return _table(made.calibration, rows_in_tables(made, axis)[0])


def tested_table(made: Campaign, axis: str) -> CutTable:
    """Return the cuts that an axis is tested on."""
    return _table(made.test, rows_in_tables(made, axis)[1])


def _table(table: Table, rows: NDArray[np.bool_]) -> CutTable:
    edges = np.unique(table["tool.edge"], return_inverse=True)[1].astype(np.float64)
    numbers = {name: values for name, values in table.items() if name not in TEXTS}
    channels = {**numbers, "tool.edge": edges}
    return CutTable(
        path=Path("lathe.csv"),
        channels={name: np.asarray(v, dtype=np.float64)[rows] for name, v in channels.items()},
        texts={name: table[name][rows].tolist() for name in TEXTS},
    )
