"""A band of cutting speeds, in which forces along and across the cutting speed change by a share:

    F_c (1 + c_c b(v)),  F_p (1 + c_p b(v)),    b(v) = exp(-½ (ln(v/v_c)/w)²)

with b the bell of the term `built_up_edge`; c stands in the posterior's state, as errors of the law
in an operation do, and is learnt with it.
"""

import numpy as np
from numpy.typing import NDArray

from autodb.pairs.observed import PairCuts
from autodb.pairs.posterior import SpeedBand
from autodb.terms.chip import built_up_edge

Array = NDArray[np.float64]


def mean_speed_m_min(cuts: PairCuts) -> Array:
    """Return the cutting speed of cuts (n,), the mean over their engaged edge, m/min."""
    elements = cuts.elements
    shape = np.broadcast_shapes(elements.edge.speed_m_min.shape, elements.width_mm.shape)
    speed = np.broadcast_to(elements.edge.speed_m_min, shape)
    width = np.broadcast_to(elements.width_mm, shape)
    if elements.of is not None:
        whole = np.bincount(elements.of, width, elements.count)
        moment = np.bincount(elements.of, width * speed, elements.count)
    else:
        whole, moment = width.sum(axis=1), (width * speed).sum(axis=1)
        whole, moment = (np.broadcast_to(one, elements.count) for one in (whole, moment))
    return np.asarray(moment / np.where(whole > 0.0, whole, 1.0))


def inside_band(cuts: PairCuts, band: SpeedBand) -> Array:
    """Return how far in a band cuts (n,) are: 1 in its middle, 0 far from it."""
    speed = mean_speed_m_min(cuts)
    whole = built_up_edge(speed, change=1.0, centre_m_min=band.centre_m_min, width=band.width)
    return whole - 1.0


def moved_band(cuts: PairCuts, band: SpeedBand) -> Array:
    """Return what ln centre and width change in how far in a band cuts are: (n, 2)."""
    off = np.log(np.maximum(mean_speed_m_min(cuts), 1e-9) / band.centre_m_min) / band.width
    inside = inside_band(cuts, band)
    return np.column_stack([inside * off / band.width, inside * off**2 / band.width])
