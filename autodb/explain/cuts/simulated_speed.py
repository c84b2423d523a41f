"""The softening with speed that a simulation of a cut table has, read off its force."""

import numpy as np
from numpy.typing import NDArray

from autodb.explain.cuts.stack import Conditions
from autodb.terms.chip import SPEED_SOFTENING, speed_softening

Array = NDArray[np.float64]

CHIP_POWERS = (0.6, 0.8, 1.0)
"""Powers of the thickness whose sums follow a simulated chip. Chosen."""
SHARE = 0.02
"""A simulation has a softening where its force changes by this share from the slowest cut to the
fastest. Chosen: as of an edge force."""
MOST_CUTS = 2000
"""Cuts of a long table that are read, spread over all of it."""


def simulated_exponent(force: Array, known: Conditions, speed_m_min: Array) -> float:
    """Return e of a simulated force (n,) whose chip goes with v^−e, and its edge with the depth."""
    from scipy.optimize import minimize_scalar

    rows = slice(None, None, -(-len(force) // MOST_CUTS))
    speed, depth, thickness = speed_m_min[rows], known.depth_mm[rows], known.thickness_mm
    thick = np.ones_like(depth) if thickness is None else thickness[rows]
    chips = depth[:, None] * thick[:, None] ** np.array(CHIP_POWERS)

    def left(exponent: float) -> float:
        softened = chips * speed_softening(speed, exponent=exponent)[:, None]
        columns = np.column_stack([softened, depth])
        fitted = columns @ np.linalg.lstsq(columns, force[rows], rcond=None)[0]
        return float(np.sum((force[rows] - fitted) ** 2))

    (exponent,) = SPEED_SOFTENING.shape
    return float(minimize_scalar(left, bounds=(exponent.lower, exponent.upper)).x)


def softening_read_off(simulation: Array, known: Conditions) -> Array | None:
    """Return the exponents (C,) of the simulated components (C, n).

    None where the speed is not known or does not vary, or none of them has a softening.
    """
    speed = known.speed_m_min
    if speed is None or np.ptp(speed) == 0:
        return None
    found = np.array([simulated_exponent(force, known, speed) for force in simulation])
    shows = np.abs(found) * np.ptp(np.log(speed)) > SHARE
    return found if shows.any() else None


def softened(exponents: Array, known: Conditions) -> Array:
    """Return the factor on the chip of each component (C, n) by its speed."""
    assert known.speed_m_min is not None
    return np.stack([speed_softening(known.speed_m_min, exponent=e) for e in exponents])
