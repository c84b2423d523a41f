"""How far off a prediction is: of the friction field, and of a contour, as P2 counts."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.machines.axis.reference_axis import Traced
from autodb.proofs.machines.axis.reference_moves import CONTOUR_HZ
from autodb.proofs.runs.axis.axis_cells import Cells

Array = NDArray[np.float64]

MOVES_MM_S = 1.0 / 60.0
"""P2, section IV: what moves slower than 1 mm/min is no part of its model."""
AVERAGED_S = 0.2
"""Moving average of the contour's currents, predicted ones too. Chosen; P2 prints none."""


@dataclass(frozen=True)
class Contour:
    """Mean absolute error of a contour's current over that of the current, and over that of its
    friction; and by how much the friction is predicted too high, as a share of it.
    """

    error: float
    of_friction: float
    high: float


def field_error(cells: Cells, predicted_A: Array, weight_A: float) -> float:
    """Return the mean absolute error of a field (n,) over the mean friction; every speed alike."""
    rubbing = cells.weights @ np.abs(cells.current_A - weight_A)
    return float(cells.weights @ np.abs(predicted_A - cells.current_A) / rubbing)


def contour_errors(made: Traced, predicted_A: Array) -> list[Contour]:
    """Return the errors of a predicted current (n,) at each feed, where the axis moves."""
    run = made.contour
    real, predicted = (_averaged(one - made.axis.weight_A) for one in (run.current_A, predicted_A))
    found = []
    for feed in np.unique(made.feed[made.feed >= 0.0]):
        rows = (made.feed == feed) & (np.abs(run.motion.v) >= MOVES_MM_S)
        mean = float(np.mean(np.abs(real[rows])))
        whole = float(np.mean(np.abs(real[rows] + made.axis.weight_A)))
        off = float(np.mean(np.abs(predicted[rows] - real[rows])))
        sense = np.sign(run.motion.v[rows])
        found.append(
            Contour(
                error=off / whole,
                of_friction=off / mean,
                high=float(np.mean(sense * (predicted[rows] - real[rows]))) / mean,
            )
        )
    return found


def _averaged(values: Array) -> Array:
    count = round(AVERAGED_S * CONTOUR_HZ)
    return np.convolve(values, np.full(count, 1.0 / count), mode="same")
