"""How far the coefficients of curves are drawn to none: as far as their evidence says."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.bench import WhiteRows
from autodb.explain.engine.candidates import Choice
from autodb.explain.engine.evidence import Products
from autodb.explain.engine.noise import Noise

Array = NDArray[np.float64]


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
