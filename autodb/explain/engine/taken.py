"""How much of the squared error each cause takes away; the largest first.

Causes overlap, and what one takes away depends on which are corrected before it. Each gets its
*relative weight*: with E (n, p) the contributions, each of unit norm, R = EᵀE and r = Eᵀd / |d|
their products with each other and with the difference d = recording − simulation,

    share_j = Σ_k (R^½)_jk² · (R^−½ r)_k².

Shares are not negative and their sum is what all contributions take away together. They are close
to the means over all orders of correcting one cause after the other (Lindeman, Merenda, Gold 1980).
Source: Johnson 2000 (A heuristic method for estimating the relative weight of predictor variables).
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from autodb.explain.answer.answer import Cause

Array = NDArray[np.float64]

ALIKE = 1e-10
"""Share of the largest eigenvalue of R below which a direction is none: contributions are alike."""
TINY = 1e-300


def shares_taken(difference: Array, parts: Sequence[Array]) -> Array:
    """Return the share of |d|² that each contribution takes away, (p,); 0 of one that is none."""
    square = float(difference @ difference)
    if not parts or square == 0.0:
        return np.zeros(len(parts))
    columns = np.column_stack(parts)
    norm = np.linalg.norm(columns, axis=0)
    columns = columns / np.where(norm > 0.0, norm, 1.0)
    values, vectors = np.linalg.eigh(columns.T @ columns)
    there = values > ALIKE * values[-1]
    values, vectors = values[there], vectors[:, there]
    along = vectors @ ((vectors.T @ (columns.T @ difference)) / np.sqrt(values))
    root = (vectors * np.sqrt(values)) @ vectors.T
    return np.asarray(root**2 @ along**2 / square)


def largest_first(
    causes: Sequence[Cause], parts: Sequence[Array], *, correction: Array, difference: Array
) -> tuple[tuple[Cause, ...], tuple[float, ...]]:
    """Return the causes, that with the largest share first, and their shares.

    ``parts`` (n,): what each adds to the simulation; ``correction`` (n,): what is added in all. The
    rest of it is what own terms change along with the causes, such as what a refitted simulation
    has swallowed of them: its share goes to the causes in proportion, so that theirs add up to what
    the correction takes away.
    """
    rest = correction - sum(parts, start=np.zeros_like(correction))
    shares = shares_taken(difference, [*parts, rest])[:-1]
    square, left = (float(values @ values) for values in (difference, difference - correction))
    whole = max(0.0, 1.0 - left / square) if square > 0.0 else 0.0
    shares = shares * whole / max(float(shares.sum()), TINY)
    order = np.argsort(-shares, kind="stable")
    return tuple(causes[k] for k in order), tuple(float(shares[k]) for k in order)
