"""How much rows of a sweep scatter by what the axis does: stick-slip at creep, turns, rapids."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from autodb.sensing.drives.fit.drive_errors import STEADY, states
from autodb.sensing.drives.fit.linearised import Linearised
from autodb.sensing.drives.moves.prepared import Prepared

Array = NDArray[np.float64]

CLASSES_A_DECADE = 2.0
"""Classes of speed in steady motion."""
FEWEST_ROWS = 20
"""Rows that tell a class' scatter; fewer go with the others."""


def row_scatter(inputs: Mapping[str, Array], left: Array) -> Array:
    """Return the scatter (n,) of each row: the rms of what a fit leaves of rows of its class.

    Classes: standing, turned, speeding up; in steady motion the speed and the direction.
    ``left`` (n,): what a fit leaves.
    """
    highest = float(np.quantile(np.abs(inputs["acceleration"]), 0.999))
    state = states(inputs, highest_mm_s2=highest)
    decade = np.log10(np.maximum(np.abs(inputs["velocity"]), 1e-3))
    speed = np.floor(CLASSES_A_DECADE * decade) * 2.0 + (inputs["velocity"] > 0.0)
    label = np.where(state == STEADY, 100.0 + speed, state)
    _, at, count = np.unique(label, return_inverse=True, return_counts=True)
    whole = float(np.sqrt(np.mean(left**2)))
    rms = np.sqrt(np.bincount(at, left**2) / count)
    return np.asarray(np.where(count >= FEWEST_ROWS, rms, whole)[at])


def row_roots(rows: Prepared, problem: Linearised, groups: list[Array]) -> Array:
    """Return by what each row (m,) counts: 1 over its scatter, found in two rounds.

    Signed as the motion: friction that differs from run to run turns with it, and is noise that
    goes on through a turn only so.
    """
    columns = np.column_stack([problem.columns, *groups])
    inputs = {name: rows.sampled(name) for name in rows.inputs}
    root = np.ones(len(problem.target))
    for _ in range(2):
        weights = np.linalg.lstsq(columns * root[:, None], problem.target * root, rcond=1e-8)[0]
        root = 1.0 / row_scatter(inputs, problem.target - columns @ weights)
    sense = np.where(np.abs(inputs["direction"]) >= 1.0, np.sign(inputs["direction"]), 0.0)
    last = np.maximum.accumulate(np.where(sense != 0, np.arange(len(sense)), 0))
    return root * np.where(sense[last] < 0, -1.0, 1.0)
