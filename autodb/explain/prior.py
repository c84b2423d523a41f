"""How far the coefficients of curves are drawn to none: as far as their evidence says."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from autodb.explain.bench import Bench
from autodb.explain.evidence import Products
from autodb.explain.noise import Whitener
from autodb.explain.suspects import Choice

Array = NDArray[np.float64]


def drawn(bench: Bench, choices: Sequence[Choice], noise: tuple[Whitener, float]) -> Array:
    """Return what a squared coefficient costs, (p,) of own and chosen columns, for ``solved``.

    Own columns and those of plain laws cost nothing. A curve of many columns costs what makes its
    coefficients the likeliest: of the size at which its evidence is greatest. So directions that
    the rows hardly show add no noise to the correction.
    """
    whitener, variance = noise
    products = Products(
        whitener(bench.own_reduced), whitener(bench.reduced_difference), variance=variance
    )
    products.add({c.key: whitener(bench.columns(c.key, c.shape)) for c in choices})
    weights = [np.zeros(len(bench.own))]
    for number, choice in enumerate(choices):
        norm = products.norm[products.places[choice.key]]
        if choice.shape.names:
            weights.append(np.zeros(len(norm)))
            continue
        others = [c.key for c in (*choices[:number], *choices[number + 1 :])]
        weights.append(norm**2 / products.given(others).gain(choice.key).size)
    return np.concatenate(weights)
