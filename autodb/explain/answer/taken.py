"""How much of the squared error each cause takes away; the largest first.

Causes overlap, and what one takes away depends on which are corrected before it. Its share is the
mean over all orders in which the causes may be corrected one after the other. With d = recording −
simulation and e_j the contributions, c = Σ e_j, the squares fall by 2 e_jᵀ(d − s) − |e_j|² where s
is what was corrected before; s is on average half of the others, so that

    share_j = e_jᵀ (2 d − c) / |d|²,    Σ share_j = 1 − |d − c|² / |d|².

A contribution that mostly undoes another has a negative one: it takes nothing away. What own terms
change within their uncertainty goes with the causes, which they would else stand in for. So the
causes' shares are scaled to what the whole correction takes away. Source: Shapley 1953 (A value for
n-person games), of a quadratic game.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from autodb.explain.answer.answer import Cause

Array = NDArray[np.float64]

TINY = 1e-300


def shares_taken(difference: Array, correction: Array, parts: Sequence[Array]) -> Array:
    """Return the share of |d|² that each of the parts of a correction takes away, (p,)."""
    twice_left = 2.0 * difference - correction
    square = max(float(difference @ difference), TINY)
    whole = max(float(correction @ twice_left) / square, 0.0)
    kept = np.array([max(float(part @ twice_left), 0.0) for part in parts])
    return np.asarray(kept * (whole / max(float(kept.sum()), TINY)))


def largest_first(
    causes: Sequence[Cause], parts: Sequence[Array], *, correction: Array, difference: Array
) -> tuple[tuple[Cause, ...], tuple[float, ...]]:
    """Return the causes, that with the largest share first, and their shares.

    ``parts`` (n,): what each adds to the simulation; ``correction`` (n,): what is added in all.
    """
    shares = shares_taken(difference, correction, parts)
    order = np.argsort(-shares, kind="stable")
    return tuple(causes[k] for k in order), tuple(float(shares[k]) for k in order)
