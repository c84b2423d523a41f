"""What a reference lathe recorded of one axis, as every way to calibrate it sees it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.machines.lathe.reference_lathe import Campaign, Table

Array = NDArray[np.float64]

MOVING = {"x": ("face",), "z": ("turn", "taper")}
"""Cuts that a feed axis is calibrated and tested with: in the others it stands, or has few (X)."""
COMPONENT = {"x": "x", "spindle": "y", "z": "z"}
"""Force that an axis senses."""


@dataclass(frozen=True)
class LatheCuts:
    """Cuts (n,) of one axis: range in the cut and its rise over air, A, conditions, and the force
    that the dynamometer read, N.
    """

    range_A: Array
    rise_A: Array
    speed_rpm: Array
    feed_mm_s: Array
    radius_mm: Array
    clock_s: Array
    force_N: Array

    @property
    def torque_Nm(self) -> Array:
        """Torque of the tangential force about the spindle."""
        return self.force_N * self.radius_mm / 1000.0


def cuts_of(made: Campaign, axis: str) -> tuple[LatheCuts, LatheCuts]:
    """Return the cuts to calibrate an axis with, and those to test it on."""
    known, tested = rows_in_tables(made, axis)
    return _cuts(made.calibration, axis, known), _cuts(made.test, axis, tested)


def rows_in_tables(made: Campaign, axis: str) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which rows of the two tables those are."""
    if axis not in MOVING:
        return made.spindle_calibration, made.spindle_test
    known, tested = (
        np.isin(table["operation"], MOVING[axis]) for table in (made.calibration, made.test)
    )
    return known, tested


def _cuts(table: Table, axis: str, rows: NDArray[np.bool_]) -> LatheCuts:
    """Return some rows; the radius is r_w + a_p/2 (P1, section 9)."""

    def of(name: str) -> Array:
        return np.asarray(table[name], dtype=np.float64)[rows]

    return LatheCuts(
        range_A=of(f"{axis}.current.range"),
        rise_A=of(f"{axis}.current.range") - of(f"{axis}.current.air"),
        speed_rpm=of("spindle.speed"),
        feed_mm_s=of("cutting.feed") * of("spindle.speed") / 60.0,
        radius_mm=0.5 * (of("work.diameter") + of("cutting.depth")),
        clock_s=of("t"),
        force_N=of(f"force.{COMPONENT[axis]}"),
    )
