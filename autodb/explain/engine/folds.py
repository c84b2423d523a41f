"""Squares on stretches left out of a fit, for many sets of columns, from sums of their products."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.fit import BLOCKS, FOLDS
from autodb.explain.engine.normal import Normal

Array = NDArray[np.float64]
Index = NDArray[np.intp]


class Folds:
    """White rows (n, q), the first column what is to be predicted, in contiguous blocks.

    Blocks are dealt to folds in turn; the fit that predicts a fold is without its blocks and the
    ``gap`` rows on both sides of each.
    """

    def __init__(self, white: Array, gap: int) -> None:
        edges = np.linspace(0, len(white), BLOCKS + 1).astype(np.intp)
        shape = (FOLDS, white.shape[1], white.shape[1])
        self.test, near = np.zeros(shape), np.zeros(shape)
        for number, (start, end) in enumerate(pairwise(edges)):
            inside = _products(white[start:end])
            before, after = white[max(0, start - gap) : start], white[end : end + gap]
            self.test[number % FOLDS] += inside
            near[number % FOLDS] += inside + _products(before) + _products(after)
        self.train = self.test.sum(axis=0) - near

    def squares(self, columns: Sequence[int] | Index, weight: Array) -> float:
        """Return the sum of squares on all rows, each predicted by a fit of ``columns`` to others.

        ``weight`` (p,): what a squared coefficient costs.
        """
        at = np.asarray(columns, dtype=np.intp)
        total = 0.0
        for train, test in zip(self.train, self.test, strict=True):
            inner = test[np.ix_(at, at)]
            fitted = Normal(train[np.ix_(at, at)], train[at, 0]).solved(weight)
            total += float(test[0, 0] - 2 * fitted @ test[at, 0] + fitted @ inner @ fitted)
        return total


def _products(rows: Array) -> Array:
    return np.asarray(rows.T @ rows)
