"""Cuts that are turned, and readings of a truth that may be off the law."""

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.insert import Insert, TurnedCuts, insert_elements
from autodb.pairs.observed import Observed, PairCuts, X, Y, Z
from autodb.pairs.prior import CardForces, of_card

Array = NDArray[np.float64]

TOOL = Insert(0.8, 95.0, -6.0, -6.0, 80.0)
THICK = np.array([0.05, 0.1, 0.2, 0.4])
PRIOR = of_card(CardForces(THICK, 1800.0 * THICK**0.75, 900.0 * THICK**0.6, level=0.12, shape=0.05))


def cuts_of(count: int, seed: int) -> PairCuts:
    """Return cuts that are turned, from shallower than the nose is round to deep."""
    rng = np.random.default_rng(seed)
    feed, depth = rng.uniform(0.08, 0.4, count), np.exp(rng.uniform(np.log(0.3), np.log(4), count))
    one = np.ones(count)
    return PairCuts(
        "turn", insert_elements(TOOL, TurnedCuts(feed, depth, 100.0 * one, 20.0 * one, 0.0 * one))
    )


def sensed(cuts: PairCuts, value: Array, *, sd_N: float = 5.0) -> Observed:
    """Return readings (n, 3) of force x, y, z."""
    count = len(value)
    return Observed(
        (cuts,), np.tile(np.arange(count), 3), np.repeat([X, Y, Z], count), value.T.ravel(),
        np.full(3 * count, sd_N), np.zeros((3 * count, 0)),
    )  # fmt: skip
