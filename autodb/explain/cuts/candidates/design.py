"""Settings of which a table of cuts has a few levels each, cut in an order: a design.

What comes round in the order of the cuts may be a setting that does.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.explain.cuts.stack import Stack

Array = NDArray[np.float64]

SETTINGS = ("cutting.speed", "cutting.feed", "cutting.depth", "cutting.width", "work.diameter")
CUTS_A_LEVEL = 6
"""Cuts that a level of a setting has, in the mean at least, where the table is a design. Chosen."""
FOLLOWS = 0.9
"""Share of a course over the cuts that settings explain where it follows them. Chosen."""


@dataclass(frozen=True)
class CutDesign:
    """Settings of which the cuts of a table have a few: an orthonormal basis (n, q) of their
    levels, the mean among them.
    """

    basis: Array

    @property
    def levels(self) -> bool:
        """Say whether a setting has levels at all."""
        return bool(self.basis.shape[1] > 1)

    def holds(self, courses: Array) -> bool:
        """Say whether courses over the cuts (n, k) follow the settings."""
        apart = courses - courses.mean(axis=0)
        left = apart - self.basis @ (self.basis.T @ apart)
        return bool(np.sum(left**2) <= (1.0 - FOLLOWS) * np.sum(apart**2))


def designed(stack: Stack) -> CutDesign:
    """Return the settings of a table's cuts that have several cuts a level."""
    n, columns = len(stack.known), [np.ones((len(stack.known), 1))]
    for name in SETTINGS:
        values = stack.known.other.get(name)
        if values is not None:
            levels = np.unique(values)
            if len(levels) <= n / CUTS_A_LEVEL:
                columns.append(1.0 * (values[:, None] == levels))
    left, sizes, _ = np.linalg.svd(np.concatenate(columns, axis=1), full_matrices=False)
    return CutDesign(left[:, sizes > 1e-9 * sizes[0]])
