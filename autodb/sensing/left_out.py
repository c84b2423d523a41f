"""What an axis' terms leave of motion that they were not fitted to."""

import numpy as np
from numpy.typing import NDArray

from autodb import fitting
from autodb.sensing.linearised import Linearised
from autodb.sensing.motion import motion_blocks
from autodb.sensing.prepared import Prepared

Array = NDArray[np.float64]

GAP_S = 0.25
"""Rows this near to a block left out are not fitted on."""


def held_out(rows: Prepared, problem: Linearised) -> Array:
    """Return what terms leave (m,) of blocks of motion that they were not fitted to.

    A coefficient is believed to add no more than the effort's rms: that of a term which only the
    few rows of a reversal tell from another would be anything, and wrong elsewhere.
    """
    blocks = motion_blocks(rows.sampled("t"), rows.sampled("direction"))
    gap = round(GAP_S * rows.rate_hz / rows.protocol.decimate)
    adds = [p not in part.term.shape for part, p in problem.names]
    weights, _ = fitting.solve(fitting.triangle(problem.columns, problem.target))
    noise = float(np.std(problem.target - problem.columns @ weights))
    effort_rms = float(np.sqrt(np.mean(rows.effort**2)))
    size = np.sqrt(np.mean(problem.columns**2, axis=0))
    pull = np.where(adds, noise * size / effort_rms, 0.0)
    return fitting.held_out(problem.columns, problem.target, blocks, gap=gap, pull=pull)
