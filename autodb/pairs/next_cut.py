"""Which cut to make next: the one that leaves least open of what is to be predicted.

Of each cut that may be made it is known beforehand by how much its readings will narrow the
posterior (the linearised update does not need their values): P⁺ = P - P Hᵀ (H P Hᵀ + R)⁻¹ H P, with
R of sensing, of the law from chip to chip, of what repeats scatter by, and H also by the errors
that its calibrations share with the cuts before. Cuts that may go beyond a limit are left out.
Source: Bayesian experimental design for a linear model (Chaloner and Verdinelli 1995, Stat. Sci.
10:273), the I-optimal cut one at a time.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from autodb.pairs.forecast import Forecast, forecast
from autodb.pairs.observed import PairCuts
from autodb.pairs.posterior import PairPosterior, Shared

Array = NDArray[np.float64]

TINY_N = 1e-9
MAY_EXCEED = 0.05
"""Probability of going beyond a limit from which a cut is not proposed. Chosen."""


@dataclass(frozen=True)
class SharedError:
    """An error that readings share: by which share of them, and by how much beyond (k,), it moves
    them; under the key that cuts sensed before have.
    """

    error: Shared
    share: Array
    shift: Array


def gain_error(error: Shared) -> SharedError:
    """Return an error of a gain: all of a reading scales."""
    return SharedError(error, np.ones(1), np.zeros(1))


@dataclass(frozen=True)
class SensedComponent:
    """A component that a machine senses: which (0 to 4: force x, y, z, torque, power), sd of its
    sensing, and the errors of its calibration.
    """

    quantity: int
    sd: float
    errors: tuple[SharedError, ...]


@dataclass(frozen=True)
class PlanLimits:
    """What a machine gives: largest size of force x, y, z [N], torque [N·m], power [W] (5,)."""

    largest: Array

    def exceeded(self, expected: Forecast) -> Array:
        """Return the probability (n, 5) that a cut's force is beyond its limit."""
        over = ndtr((expected.mean - self.largest) / expected.sd)
        under = ndtr((-self.largest - expected.mean) / expected.sd)
        return np.asarray(over + under)


@dataclass(frozen=True)
class Proposal:
    """A cut of the candidates, and the sd of the targets (n, 5) that are left after it."""

    candidate: int
    sd: Array


def propose(
    posterior: PairPosterior,
    candidates: PairCuts,
    targets: PairCuts,
    *,
    sensed: tuple[SensedComponent, ...],
    quantities: tuple[int, ...],
    limits: PlanLimits | None = None,
) -> Proposal | None:
    """Return the candidate after which ``quantities`` of the targets are least open.

    Least is the mean over targets and quantities of the variance over the force's
    square. None where every candidate may exceed a limit.
    """
    left, variance = target_sds(
        posterior, candidates, targets, sensed=sensed, quantities=quantities, limits=limits
    )
    best = int(np.argmin(variance))
    return Proposal(best, left[best]) if np.isfinite(variance[best]) else None


def target_sds(
    posterior: PairPosterior,
    candidates: PairCuts,
    targets: PairCuts,
    *,
    sensed: tuple[SensedComponent, ...],
    quantities: tuple[int, ...],
    limits: PlanLimits | None = None,
) -> tuple[Array, Array]:
    """Return the sd of the targets (candidates, targets, 5) after each candidate, and ``variance``.

    ``variance`` (candidates,) is the mean over targets and quantities of the variance over the
    force's square; infinite of a cut that may exceed a limit.
    """
    laws = posterior.law_errors(candidates.operation, targets.operation)
    assumed = (*candidates.assumed, *targets.assumed)
    shared = (moved.error for one in sensed for moved in one.errors)
    known = posterior.also((*shared, *laws, *assumed))
    tried, asked = forecast(known, candidates), forecast(known, targets)
    left = np.sqrt(_variance_left(known, tried, asked, sensed))
    size = np.maximum(np.abs(asked.mean), TINY_N)
    variance = np.mean((left / size)[:, :, list(quantities)] ** 2, axis=(1, 2))
    if limits is not None:
        risky = np.any(limits.exceeded(tried) > MAY_EXCEED, axis=1)
        variance = np.where(risky, np.inf, variance)
    return left, variance


def _variance_left(
    known: PairPosterior, tried: Forecast, asked: Forecast, sensed: tuple[SensedComponent, ...]
) -> Array:
    """Return the targets' variances (candidates, targets, 5) after each of the candidates."""
    measured = [one.quantity for one in sensed]
    slopes = tried.slopes[:, measured].copy()
    for k, one in enumerate(sensed):
        for moved in one.errors:
            by = moved.share * tried.mean[:, one.quantity, None] + moved.shift
            slopes[:, k, known.columns(moved.error.key)] = by
    noise = np.array([one.sd for one in sensed]) ** 2 + tried.own[:, measured]
    spread = slopes @ known.state.covariance
    sums = spread @ np.swapaxes(slopes, 1, 2) + noise[:, :, None] * np.eye(len(measured))
    seen = np.einsum("tqp,ckp->ctqk", asked.slopes, spread)
    gained = np.einsum("ctqk,ckl,ctql->ctq", seen, np.linalg.inv(sums), seen)
    return np.asarray(np.maximum(asked.sd**2 - gained, asked.own))
