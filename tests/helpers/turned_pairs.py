"""A pair that is turned: what a card leaves, cuts, and readings of a truth that is the law."""

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.elements import cut_forces
from autodb.cutting.insert import Insert, TurnedCuts, insert_elements
from autodb.pairs.observed import Observed, PairCuts, Y, Z
from autodb.pairs.posterior import PairPosterior, Shared
from autodb.pairs.prior import CardForces, of_card

Array = NDArray[np.float64]

TOOL = Insert(0.8, 95.0)
GAIN = (Shared("gain y", np.array([[0.05**2]])), Shared("gain z", np.array([[0.05**2]])))
SD_N = 5.0


def prior() -> PairPosterior:
    """Return what a card of a plain steel leaves, 25 % either way."""
    chips = np.array([0.05, 0.1, 0.2, 0.4])
    return of_card(
        CardForces(chips, 2000.0 * chips**0.8, 1000.0 * chips**0.7, level=0.25, shape=0.1)
    )


def turn(feed: Array, depth: Array, speed: Array | float = 120.0) -> PairCuts:
    """Return cuts along the axis."""
    one = np.ones_like(feed)
    return PairCuts(
        "turn", insert_elements(TOOL, TurnedCuts(feed, depth, speed * one, 30.0 * one, 0.0 * one))
    )


def cuts_of(seed: int, count: int) -> PairCuts:
    """Return drawn cuts along the axis."""
    rng = np.random.default_rng(seed)
    return turn(
        rng.uniform(0.1, 0.4, count), rng.uniform(1.0, 3.0, count), rng.uniform(80.0, 250.0, count)
    )


def sensed(
    theta: Array, cuts: PairCuts, seed: int, gains: tuple[float, float] = (1.0, 1.0)
) -> Observed:
    """Return readings of y and z of cuts whose truth is the law itself, scatter as of P1."""
    rng, count = np.random.default_rng(seed), cuts.elements.count
    real = cut_forces(theta, cuts.elements).force_N[:, 1:] * gains
    real = real * (1.0 + np.array([0.0189, 0.0549]) * rng.standard_normal((count, 2)))
    read = real + SD_N * rng.standard_normal((count, 2))
    common = np.zeros((2 * count, 2))
    common[:count, 0] = common[count:, 1] = 1.0
    return Observed(
        cuts=(cuts,),
        cut=np.tile(np.arange(count), 2),
        quantity=np.repeat([Y, Z], count),
        value=read.T.ravel(),
        sd=np.full(2 * count, SD_N),
        common=common,
        shared=GAIN,
    )


def truth(seed: int) -> Array:
    """Return a law drawn from the prior, without exaggeration."""
    known = prior().law
    normal = np.random.default_rng(seed).standard_normal(len(known.mean))
    # the symmetric root, of which there is one alone: another's draw goes with how it is rounded
    size, along = np.linalg.eigh(0.5 * known.covariance)
    root = along * np.sqrt(np.maximum(size, 0.0)) @ along.T
    return np.asarray(known.mean + root @ normal)
