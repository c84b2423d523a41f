"""An axis' effort in steady motion over place and velocity: measured, modelled, and what is left.

The friction field of P2, weight and ripple in it: means over cells of travel and speed.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.records.tables import Recording
from autodb.sensing.drives.fit.axis_model import IdentifiedTerm, predicted_effort
from autodb.sensing.drives.fit.discrepancy import FrictionDiscrepancy
from autodb.sensing.drives.fit.drive_errors import STEADY, states
from autodb.sensing.drives.moves.prepared import prepared
from autodb.sensing.drives.moves.protocol import FilterProtocol

Array = NDArray[np.float64]

PLACES, SPEEDS = 12, 8
"""Cells along the travel, and of speed in each direction, in equal ratios."""
FEWEST_ROWS = 3
NARROWEST = 2.0
"""Least ratio of the highest speed to the lowest that has a cell."""


@dataclass(frozen=True)
class EffortField:
    """Means over cells (velocities, places): NaN where an axis was hardly ever in steady motion.

    ``places`` and ``velocities``: the middle of each cell. ``left`` is measured less modelled.
    """

    places: Array
    velocities: Array
    measured: Array
    modelled: Array

    @property
    def left(self) -> Array:
        """What the model leaves."""
        return self.measured - self.modelled

    @property
    def error_share(self) -> float:
        """Mean absolute error over the mean absolute effort, of the cells that there are."""
        known = np.isfinite(self.measured)
        if not known.any():
            return np.nan
        return float(np.mean(np.abs(self.left[known])) / np.mean(np.abs(self.measured[known])))


def field(
    recording: Recording,
    axis: str,
    protocol: FilterProtocol,
    terms: Sequence[IdentifiedTerm],
    off_law: FrictionDiscrepancy | None = None,
) -> EffortField:
    """Return the field of an axis over a recording of its moves, modelled by identified terms.

    With ``off_law`` what friction is off their laws is in it.
    """
    rows = prepared(recording, axis=axis, protocol=protocol)
    inputs = {name: rows.sampled(name) for name in rows.inputs}
    modelled = rows.reduced(predicted_effort(terms, rows.inputs, off_law))
    highest = float(np.quantile(np.abs(inputs["acceleration"]), 0.999))
    steady = states(inputs, highest_mm_s2=highest) == STEADY
    place, velocity = inputs["position"][steady], inputs["velocity"][steady]
    edges = _speeds(np.abs(velocity))
    column = _cell(place, np.linspace(*_ends(place), PLACES + 1))
    row = np.where(
        velocity > 0, SPEEDS + _cell(velocity, edges), SPEEDS - 1 - _cell(-velocity, edges)
    )
    slow = np.abs(velocity) < edges[0]
    cell = np.where(slow, -1, row * PLACES + column)
    middle = np.sqrt(edges[1:] * edges[:-1])
    travel = np.linspace(*_ends(place), PLACES + 1)
    return EffortField(
        places=0.5 * (travel[1:] + travel[:-1]),
        velocities=np.concatenate([-middle[::-1], middle]),
        measured=_means(rows.effort[steady], cell),
        modelled=_means(modelled[steady], cell),
    )


def _speeds(speed: Array) -> Array:
    """Return the edges of the cells of speed, from the slowest steady motion to the fastest."""
    if not speed.size:
        return np.geomspace(1.0, NARROWEST, SPEEDS + 1)
    top = float(speed.max()) * (1.0 + 1e-9)
    low = min(float(np.quantile(speed, 0.01)), top / NARROWEST)
    return np.geomspace(max(low, 1e-6 * top), top, SPEEDS + 1)


def _ends(place: Array) -> tuple[float, float]:
    return (float(place.min()), float(place.max())) if place.size else (0.0, 1.0)


def _cell(values: Array, edges: Array) -> NDArray[np.intp]:
    found = np.searchsorted(edges, values, side="right") - 1
    return np.asarray(np.clip(found, 0, len(edges) - 2))


def _means(values: Array, cell: NDArray[np.intp]) -> Array:
    count = 2 * SPEEDS * PLACES
    known = cell >= 0
    rows = np.bincount(cell[known], minlength=count).astype(np.float64)
    total = np.bincount(cell[known], weights=values[known], minlength=count)
    means = np.where(rows >= FEWEST_ROWS, total / np.maximum(rows, 1.0), np.nan)
    return np.asarray(means.reshape(2 * SPEEDS, PLACES))
