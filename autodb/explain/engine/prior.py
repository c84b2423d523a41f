"""How far coefficients are drawn to what is likely: curves' to none, as far as their evidence says,
own terms' to what the simulation says, where it says something.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.bench import WhiteRows
from autodb.explain.engine.candidates import Choice
from autodb.explain.engine.evidence import Products
from autodb.explain.engine.noise import Noise

Array = NDArray[np.float64]

OWN_SD = 0.25
"""Relative standard deviation of the simulation's own terms: what a simulation says of itself is
worth something. Chosen of none, 0.25 and free on real recordings."""
FITTED = 0.02
"""Share of the difference's squares that own terms give, up to which the simulation counts as
fitted to the recording. Chosen: of simulations of real axes that were, own terms read off them give
less in nine of ten; of others those alone in which own terms and what is missing have nothing in
common, where it makes no difference."""


def own_deviations(sizes: Array, *, given: float, of: float) -> Array:
    """Return how far the coefficients of own terms may be off, (k,), of their ``sizes`` (k,).

    Own terms can give nothing of what a fit of them has left, and have taken up all that they could
    of what was missing: that may be many times their size, and says nothing of them. ``given``:
    what they give of the difference's squares ``of``.
    """
    fitted = given <= FITTED * of
    return np.full(len(sizes), np.inf) if fitted else OWN_SD * np.abs(sizes)


def coefficient_costs(bench: WhiteRows, choices: Sequence[Choice], noise: Noise) -> Array:
    """Return what a squared coefficient costs, (p,) of own and chosen columns, for ``solved``.

    Own columns and those of plain laws cost nothing. A curve of many columns costs what makes its
    coefficients the likeliest: of the size at which its evidence is greatest. So directions that
    the rows hardly show add no noise to the correction.
    """
    products = _products(bench, choices, noise)
    weights = [np.zeros(len(bench.own))]
    for number, choice in enumerate(choices):
        norm = products.norm[products.places[choice.key]]
        if choice.shape.names:
            weights.append(np.zeros(len(norm)))
            continue
        others = [c.key for c in (*choices[:number], *choices[number + 1 :])]
        weights.append(norm**2 / products.given(others).gain(choice.key).size)
    return np.concatenate(weights)


def evidence_of(bench: WhiteRows, choice: Choice, others: Sequence[Choice], noise: Noise) -> float:
    """Return the evidence of a choice beside others."""
    products = _products(bench, [*others, choice], noise)
    return products.given([c.key for c in others]).gain(choice.key).evidence


def _products(bench: WhiteRows, choices: Sequence[Choice], noise: Noise) -> Products:
    return bench.products({c.key: bench.columns(c.key, c.shape) for c in choices}, noise)
