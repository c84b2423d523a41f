"""Least squares within passes, with errors from what whole passes differ by."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Numbers = NDArray[np.intp]

SINGULAR = 1e-10
"""Part of the largest eigenvalue below which nothing tells a coefficient. Chosen."""


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


def one_out(design: Array, target: Array, groups: Numbers) -> Array:
    """Return the covariance (p, p) of least squares by leaving out one group at a time.

    Jackknife: (g − 1)/g · Σ (b₋ᵢ − b)(b₋ᵢ − b)', which holds where few groups tell a coefficient
    and White's is too small. MacKinnon, White 1985; of groups: Bell, McCaffrey 2002.
    """
    inner, right = design.T @ design, design.T @ target
    here = np.linalg.solve(inner, right)
    names = np.unique(groups)
    off = []
    for one in names:
        own = design[groups == one]
        without = right - own.T @ target[groups == one]
        off.append(
            np.linalg.pinv(inner - own.T @ own, rcond=SINGULAR, hermitian=True) @ without - here
        )
    moved = np.array(off)
    return np.asarray((len(names) - 1) / len(names) * moved.T @ moved)


def lack(place: Numbers, left: Array) -> float:
    """Return the sd of places' means beyond what passes of a place differ by; ``left`` (n,)."""
    _, at, count = np.unique(place, return_inverse=True, return_counts=True)
    mean = np.bincount(at, left) / count
    freedom = float(np.sum(count - 1))
    if freedom <= 0:
        return 0.0
    own = float(np.sum((left - mean[at]) ** 2)) / freedom
    return float(np.sqrt(max(0.0, float(np.mean(mean**2) - own * np.mean(1.0 / count)))))
