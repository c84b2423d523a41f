"""The information that a batch of cuts adds on a pair, to be added to another posterior or taken
back.

A normal posterior in information form is a sum: precision and precision times mean of the prior,
and of each batch as it was linearised. So two machines' posteriors from one prior merge by adding
the information of either's cuts, and a batch is undone by taking its information away. Exact for
what is linear in the state; what the law bends between is as close as the linearisation (a test
says how close).
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.fitting import Gaussian
from autodb.pairs.posterior import PairPosterior, Scatter, Shared

Array = NDArray[np.float64]


@dataclass(frozen=True)
class InformationGained:
    """``precision`` (p, p) and ``weighted`` (p,) over the law's coordinates and ``shared`` errors;
    ``scatter``: weight and weighted square gained (2, 2); ``cuts`` gained.
    """

    precision: Array
    weighted: Array
    shared: tuple[Shared, ...]
    scatter: Array
    cuts: int


def information_gained(before: PairPosterior, after: PairPosterior) -> InformationGained:
    """Return what made a posterior out of the one before."""
    start = before.also(after.shared)
    sure, pull = _information(start.state)
    surer, pulled = _information(after.state)
    return InformationGained(
        precision=surer - sure,
        weighted=pulled - pull,
        shared=after.shared,
        scatter=_sums(after.scatter) - _sums(before.scatter),
        cuts=after.cuts - before.cuts,
    )


def merged(posterior: PairPosterior, other: InformationGained) -> PairPosterior:
    """Return a posterior with the information of other cuts added."""
    return _changed(posterior, other, 1.0)


def without_batch(posterior: PairPosterior, batch: InformationGained) -> PairPosterior:
    """Return a posterior with the information of a batch of its cuts taken away."""
    return _changed(posterior, batch, -1.0)


def _changed(posterior: PairPosterior, batch: InformationGained, sign: float) -> PairPosterior:
    known = posterior.also(batch.shared)
    place = np.arange(len(known.state.mean) - sum(len(s.covariance) for s in known.shared))
    where = [place, *(np.r_[known.columns(one.key)] for one in batch.shared)]
    rows = np.concatenate(where)
    precision, weighted = _information(known.state)
    precision[np.ix_(rows, rows)] += sign * batch.precision
    weighted[rows] += sign * batch.weighted
    sums = _sums(known.scatter) + sign * batch.scatter
    return replace(
        known,
        state=_normal(precision, weighted, known.state),
        scatter=Scatter(np.sqrt(sums[1] / sums[0]), sums[0]),
        cuts=known.cuts + int(sign) * batch.cuts,
    )


def _sums(scatter: Scatter) -> Array:
    return np.stack([scatter.weight, scatter.weight * scatter.share**2])


def _information(state: Gaussian) -> tuple[Array, Array]:
    """Return precision and precision times mean; what is sure (variance 0) has none of either."""
    open_ = np.flatnonzero(np.diag(state.covariance) > 0.0)
    precision, weighted = np.zeros_like(state.covariance), np.zeros_like(state.mean)
    inside = np.linalg.inv(state.covariance[np.ix_(open_, open_)])
    precision[np.ix_(open_, open_)] = 0.5 * (inside + inside.T)
    weighted[open_] = precision[np.ix_(open_, open_)] @ state.mean[open_]
    return precision, weighted


def _normal(precision: Array, weighted: Array, was: Gaussian) -> Gaussian:
    """Return the normal posterior of an information; what was sure stays as it was."""
    open_ = np.flatnonzero(np.diag(was.covariance) > 0.0)
    mean, covariance = was.mean.copy(), np.zeros_like(was.covariance)
    inside = np.linalg.inv(precision[np.ix_(open_, open_)])
    covariance[np.ix_(open_, open_)] = 0.5 * (inside + inside.T)
    mean[open_] = covariance[np.ix_(open_, open_)] @ weighted[open_]
    return Gaussian(mean, covariance)
