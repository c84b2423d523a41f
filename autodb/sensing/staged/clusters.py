"""Least squares within passes, with errors from what whole passes differ by."""

import numpy as np
from numpy.typing import NDArray

from autodb import fitting

Array = NDArray[np.float64]
Numbers = NDArray[np.intp]


def within(values: Array, of: Numbers) -> Array:
    """Return values (n,) less the mean of their pass."""
    count = np.bincount(of)
    mean = np.bincount(of, values) / np.maximum(count, 1)
    return np.asarray(values - mean[of])


def scores(design: Array, left: Array, groups: Numbers) -> tuple[Array, int]:
    """Return Σ over groups of s s', s = X'r of a group, (p, p), and how many groups there are.

    Between two inverses of X'X it is the covariance of least squares whose errors are alike within
    a group in any way: White 1980, Liang and Zeger 1986.
    """
    names, at = np.unique(groups, return_inverse=True)
    made = np.zeros((len(names), design.shape[1]))
    np.add.at(made, at, design * left[:, None])
    return made.T @ made, len(names)


def lack(place: Numbers, left: Array) -> float:
    """Return the sd of places' means beyond what passes of a place differ by; ``left`` (n,)."""
    _, at, count = np.unique(place, return_inverse=True, return_counts=True)
    mean = np.bincount(at, left) / count
    freedom = float(np.sum(count - 1))
    if freedom <= 0:
        return 0.0
    own = float(np.sum((left - mean[at]) ** 2)) / freedom
    return float(np.sqrt(max(0.0, float(np.mean(mean**2) - own * np.mean(1.0 / count)))))


def two_ways(design: Array, left: Array, one: Numbers, other: Numbers) -> Array:
    """Return what stands between the inverses where errors are alike within groups of two kinds.

    That of either kind, as Student's t of so few groups has it, less that of both together; where
    the difference has negative eigenvalues they count as 0. Cameron, Gelbach, Miller 2011.
    """
    _, both = np.unique(np.column_stack([one, other]), axis=0, return_inverse=True)
    total = -scores(design, left, both.ravel())[0]
    for groups in (one, other):
        between, count = scores(design, left, groups)
        few = max(1, count - 1)
        total += between * count / few * fitting.small_sample(few)
    values, vectors = np.linalg.eigh(0.5 * (total + total.T))
    return np.asarray((vectors * np.maximum(values, 0.0)) @ vectors.T)
