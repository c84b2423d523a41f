"""Faults of a calibration's data, named before anything is fitted: a checklist is data."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from autodb.records.tables import CutTable
from autodb.sensing.ranges.faults.air_moves import faults_of_moves
from autodb.sensing.ranges.faults.check import DataCheck, refuse
from autodb.sensing.ranges.faults.exchanged import exchanged
from autodb.sensing.ranges.faults.relations import KnownOfCuts
from autodb.sensing.ranges.faults.signs import signs
from autodb.sensing.ranges.faults.silent import responses, silent_axes
from autodb.sensing.ranges.faults.travel import x_over_diameter, x_travels
from autodb.sensing.ranges.faults.wrong_units import units

__all__ = [
    "DataCheck",
    "KnownOfCuts",
    "checks_of_signs",
    "checks_of_units",
    "exchanged",
    "faults_of_moves",
    "refuse",
    "silent",
    "silent_axes",
    "units",
    "x_over_diameter",
    "x_travels",
]

Array = NDArray[np.float64]


def silent(
    table: CutTable, forces: Mapping[str, Array], axes: Sequence[str]
) -> dict[str, DataCheck]:
    """Return the axes whose current gives nothing, each with the check that failed."""
    checks = silent_axes(table, forces, axes)
    return {axis: check for axis, check in checks.items() if not check.passed}


def checks_of_units(
    table: CutTable, axes: Sequence[str], known: KnownOfCuts | None = None
) -> list[DataCheck]:
    """Return whether a table's channels are in their units, X as a radius among them.

    Newtons per ampere are asked of axes whose current responds only: noise has no unit.
    """
    forces = {
        name.removeprefix("force."): table[name] for name in table.channels if "force." in name
    }
    found = responses(table, forces, axes)
    heard = [axis for axis, (t, limit) in found.items() if t > limit]
    return [units(table, axes, heard, known), *x_over_diameter(table)]


def checks_of_signs(table: CutTable, known: KnownOfCuts | None = None) -> list[DataCheck]:
    """Return whether forces, torque and power of a table have the signs that every cut gives them.

    But of channels whose sign its side file, or that of what it was gathered from, states.
    """
    stated = {name for name, spec in table.side.channels.items() if spec.sign == 1}
    return [signs(table, stated | (known.signs if known else set()))]
