"""A run of cuts that all take more force by one share, in every component: a bar of harder work.

Of the readings of a pair's cuts in one recording the posterior expects e with the covariance C,
which holds what they share: the day of each sensor, the calibrations, the law, the wear. A run of
cuts S that is harder by a share g has g e_S more, so that by least squares

    g = e_S' C⁻¹ r / (e_S' C⁻¹ e_S),    sd = 1 / √(e_S' C⁻¹ e_S)

of what is left, r. Each cut alone may be no surprise, since each alone may be the day's error; that
all components rise, by more than the days differ, is one. The whole recording has half of the
probability of a false alarm, all shorter runs the other. Where one component rises by less than
half of what another does, a sensor may be why, and it is not called hard.

Nothing is said where edges may wear and nobody knows how: wear raises forces, too. So cuts have to
say how long their edge has cut, and where that is not nothing, the posterior has to have wear.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from autodb.pairs.observed import CHIP, Observed
from autodb.pairs.outlying import IMPLAUSIBLE
from autodb.pairs.posterior import PairPosterior
from autodb.pairs.updating import expected_of

Array = NDArray[np.float64]

FEWEST, SHORTEST = 5, 10
"""Cuts of a whole recording, and of a run within one, at least. Chosen: fewer are outliers, each by
itself, and the last cuts of an edge may rise by less than ten more steeply than wear was learnt."""
HALF, APART = 0.5, 2.0
"""Share of the most that a component rises by, which all must rise by, within so many standard
deviations. Chosen: a feed force and a cutting force go with hardness, but not quite alike."""


@dataclass(frozen=True)
class HarderRun:
    """The ``first`` and ``last`` cut of a run, by place, and by what share its forces are larger.

    ``chance``: of a run as far off where there is none.
    """

    first: int
    last: int
    share: float
    sd: float
    chance: float


def harder_run(posterior: PairPosterior, observed: Observed) -> HarderRun | None:
    """Return the run of one recording's cuts that is harder than expected; None: there is none.

    ``observed``: readings, in the order of time, of cuts that say how long their edges have cut.
    """
    cuts = np.unique(observed.cut)
    if len(cuts) < FEWEST or (posterior.wear is None and not _are_fresh(observed)):
        return None
    expected, covariance = expected_of(posterior, observed)
    each = _Shares.of(observed, expected, covariance, observed.value - expected)
    run = each.surest()
    if run is None or not _alike(observed, each, run):
        return None
    return run


def _are_fresh(observed: Observed) -> bool:
    """Say whether no edge of the cuts had cut before, as far as they say."""
    return not any(one.worn_s is not None and np.any(one.worn_s > 0.0) for one in observed.cuts)


@dataclass(frozen=True)
class _Shares:
    """Of cuts (n,): e_i' C⁻¹ r (n,), and e_i' C⁻¹ e_k (n, n)."""

    moment: Array
    precision: Array
    inner: Array
    cut: NDArray[np.intp]
    expected: Array
    left: Array

    @classmethod
    def of(cls, observed: Observed, expected: Array, covariance: Array, left: Array) -> "_Shares":
        """Return them of readings, with what is expected of each and what is left."""
        inner = np.asarray(np.linalg.inv(covariance))
        place = np.unique(observed.cut, return_inverse=True)[1]
        own = np.zeros((len(expected), int(place.max()) + 1))
        own[np.arange(len(expected)), place] = expected * (observed.quantity != CHIP)
        weighed = own.T @ inner
        return cls(weighed @ left, weighed @ own, inner, place, expected, left)

    def surest(self) -> HarderRun | None:
        """Return the run of which a false alarm is least probable; None: all may be one."""
        n = len(self.moment)
        total = np.concatenate([[0.0], np.cumsum(self.moment)])
        square = np.zeros((n + 1, n + 1))
        square[1:, 1:] = np.cumsum(np.cumsum(self.precision, axis=0), axis=1)
        first, last = np.triu_indices(n, k=min(n, SHORTEST) - 1)
        end = last + 1
        precision = np.maximum(
            square[end, end] - square[first, end] - square[end, first] + square[first, first],
            np.finfo(np.float64).tiny,
        )
        z = (total[end] - total[first]) / np.sqrt(precision)
        whole = end - first == n
        tries = np.where(whole, 1.0, max(len(z) - 1, 1))
        chance = 2.0 * tries * ndtr(-z)
        best = int(np.argmin(np.log(tries) - 0.5 * np.maximum(z, 0.0) ** 2))
        if z[best] < -ndtri(0.5 * IMPLAUSIBLE / tries[best]):
            return None
        sd = float(1.0 / np.sqrt(precision[best]))
        at = int(first[best]), int(last[best])
        return HarderRun(*at, float(z[best]) * sd, sd, float(chance[best]))

    def of_each(self, columns: Array) -> tuple[Array, Array]:
        """Return by what share each of several parts of the readings is larger, and covariance.

        ``columns`` (m, k): which readings are of which part.
        """
        some = columns * self.expected[:, None]
        covariance = np.asarray(np.linalg.inv(some.T @ self.inner @ some))
        return covariance @ (some.T @ self.inner @ self.left), covariance


def _alike(observed: Observed, each: _Shares, run: HarderRun) -> bool:
    """Say whether every component, and two at least, rise in a run by about one share."""
    inside = (each.cut >= run.first) & (each.cut <= run.last) & (observed.quantity != CHIP)
    kinds = np.unique(observed.quantity[inside])
    if len(kinds) < 2:
        return False
    shares, covariance = each.of_each(inside[:, None] & (observed.quantity[:, None] == kinds))
    low, high = int(np.argmin(shares)), int(np.argmax(shares))
    between = np.zeros(len(kinds))
    between[[low, high]] = -1.0, HALF
    apart = between @ shares / np.sqrt(between @ covariance @ between)
    return bool(shares[low] > 0.0) and bool(apart < APART)
