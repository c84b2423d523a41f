"""Whether a cut is one of the same pair: how far its readings are from what was expected of them.

The same inputs can cut in another state: a built-up edge, an inclusion, a worn edge. Readings that
are farther off than the posterior, the law's error, scatter and sensing leave room for are not to
be averaged into the pair. Of a batch the statistic is Mahalanobis' distance of its readings, whose
square is chi-squared with as many degrees of freedom (what the posterior leaves open they share,
and the distance includes it); a single cut's is that of its own readings.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from autodb.pairs.observed import Observed
from autodb.pairs.posterior import PairPosterior
from autodb.pairs.updating import expected_of

Array = NDArray[np.float64]

IMPLAUSIBLE = 1e-3
"""Probability below which a cut is not of the pair's state: 1 in 1000 of those that are."""


@dataclass(frozen=True)
class OutlierTest:
    """Of readings (m,): how many standard deviations each is off, and how probable it is, or a
    farther one, of each cut (n,) and of all together.
    """

    off: Array
    cuts: Array
    together: float

    @property
    def outlying(self) -> NDArray[np.bool_]:
        """Which cuts (n,) are not of the state that the posterior is of."""
        return self.cuts < IMPLAUSIBLE


def outlier_test(posterior: PairPosterior, observed: Observed) -> OutlierTest:
    """Return how improbable readings are."""
    expected, covariance = expected_of(posterior, observed)
    left = observed.value - expected
    cuts = np.unique(observed.cut)
    rows = [np.flatnonzero(observed.cut == cut) for cut in cuts]
    return OutlierTest(
        off=left / np.sqrt(np.diag(covariance)),
        cuts=np.array([_probability(left[r], covariance[np.ix_(r, r)]) for r in rows]),
        together=_probability(left, covariance),
    )


def _probability(left: Array, covariance: Array) -> float:
    return float(chdtrc(len(left), left @ np.linalg.solve(covariance, left)))
