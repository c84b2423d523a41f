"""The step of a clock, for terms that remember."""

import numpy as np
from numpy.typing import NDArray

LONE_STEP_S = 1.0
"""Step of a clock of one row: nothing is remembered from one row, so that any would do."""


def step_s(t_s: NDArray[np.float64]) -> float:
    """Return the step of an evenly sampled clock (n,), ascending, in s."""
    return float(np.median(np.diff(t_s))) if len(t_s) > 1 else LONE_STEP_S
