"""All cuts of a pair in one recording take more force by one share: a bar of harder work.

Of the readings of these cuts the posterior expects e with the covariance C, which holds what they
share: the day of each sensor, the calibrations, the law, the wear. Cuts that are harder by a share
g take g e more, so that by least squares

    g = e' C⁻¹ r / (e' C⁻¹ e),    sd = 1 / √(e' C⁻¹ e)

of what is left, r. Each cut alone may be no surprise, since each alone may be the day's error; that
all components rise, by more than the days differ, is one. Where one component rises by less than
half of what another does, a sensor may be why, and it is not called hard.

Nothing is said where edges may wear and nobody knows how: wear raises forces, too. So cuts have to
say how long their edge has cut, and where that is not nothing, the posterior has to have wear.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from autodb.pairs.observed import CHIP, Observed
from autodb.pairs.outlying import IMPLAUSIBLE
from autodb.pairs.posterior import PairPosterior
from autodb.pairs.updating import expected_of

Array = NDArray[np.float64]

FEWEST = 5
"""Cuts at least. Chosen: fewer are outliers, each by itself."""
LEAST = 0.08
"""Share by which forces are larger, at least. Chosen: less is an edge that wears otherwise, or the
law under conditions that it was not learnt from."""
HALF, APART = 0.5, 2.0
"""Share of the most that a component rises by, which all must rise by, within so many standard
deviations. Chosen: a feed force and a cutting force go with hardness, but not quite alike."""


@dataclass(frozen=True)
class HarderWork:
    """By what share forces are larger, with its sd; ``chance`` of as much where none are."""

    share: float
    sd: float
    chance: float


def harder_work(posterior: PairPosterior, observed: Observed) -> HarderWork | None:
    """Return by how much one recording's cuts are harder than expected; None: they are not.

    ``observed``: readings of cuts that say how long their edges have cut.
    """
    if len(np.unique(observed.cut)) < FEWEST:
        return None
    if posterior.wear is None and not _are_fresh(observed):
        return None
    expected, covariance = expected_of(posterior, observed)
    force = observed.quantity != CHIP
    inner, left = np.linalg.inv(covariance), observed.value - expected
    some = np.where(force, expected, 0.0)
    precision = float(some @ inner @ some)
    share, sd = float(some @ inner @ left) / precision, 1.0 / float(np.sqrt(precision))
    found = HarderWork(share, sd, 2.0 * float(ndtr(-share / sd)))
    if found.chance > IMPLAUSIBLE or share < LEAST:
        return None
    kinds = np.unique(observed.quantity[force])
    each = some[:, None] * (observed.quantity[:, None] == kinds)
    apart = np.asarray(np.linalg.inv(each.T @ inner @ each))
    return found if _rise(apart @ (each.T @ inner @ left), apart) else None


def _are_fresh(observed: Observed) -> bool:
    """Say whether no edge of the cuts had cut before, as far as they say."""
    return not any(one.worn_s is not None and np.any(one.worn_s > 0.0) for one in observed.cuts)


def _rise(shares: Array, covariance: Array) -> bool:
    """Say whether components, two at least, that are larger by shares (k,) rise by about one."""
    low, high = int(np.argmin(shares)), int(np.argmax(shares))
    if low == high:
        return False
    between = np.zeros(len(shares))
    between[[low, high]] = -1.0, HALF
    apart = between @ shares / np.sqrt(between @ covariance @ between)
    return bool(shares[low] > 0.0) and bool(apart < APART)
