"""Where a likelihood is largest: its optima, each to its end, and how probable each is.

From each start L-BFGS comes near, with the exact gradient, and Newton's steps, with the Hessian
by differences of it, end where a step is nothing beside the standard errors. Of several optima none
is taken in the place of another that is as high within its own noise: they are weighed.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.rounds import NotSettled

Array = NDArray[np.float64]
Misfit = Callable[[Array], tuple[float, Array]]
"""−2 ln of a likelihood up to a constant, and its gradient (p,)."""

MOST_STEPS, SETTLED = 100, 1e-8
"""Newton's steps that end a climb, and their length in standard errors at which they do."""
FLAT = 1e-10
"""Curvature that each direction is taken to have at least, as a share of the greatest and of 1."""
NEAR, SLOWER = 1e-5, 0.5
"""Length of a step from which on it has to be shorter than the last by this share, or is rounding.
"""
COMPARED = 1e-3
"""Length of a step up to which it is taken whole: heights then differ by about its square, 1e-6,
which their rounding may hide (1e-8 was seen); Newton's steps go by the gradient alone. Chosen."""
WITHIN, FAR = 20.0, 1.0
"""Where optima are searched for, and the longest step: parameters are shares and logarithms, of the
order of 1. e²⁰ is 5·10⁸; at e⁵⁰ a likelihood's gradient is rounding, and a first step there stayed
there (the y axis of a mill whose cogging is small).
"""
WIDTH = 1e-5
"""Half width of differences of the gradient."""
ALIKE = 1e-3
"""Difference of their numbers up to which two climbs end in one optimum: some times what is left to
an optimum where the likelihood rises no more. Chosen."""


def optima(
    misfit: Misfit,
    starts: Sequence[Array],
    *,
    numbers: Callable[[Array], Array],
) -> list[tuple[float, Array]]:
    """Return the optima (p,) near some starts, each with its probability.

    ``numbers``: what two optima are alike by.

    Raises NotSettled where a climb does not end.
    """
    near: list[Array] = []
    for start in starts:
        at = _climbed(misfit, start)
        if not any(np.max(np.abs(numbers(at) - numbers(one))) < ALIKE for one in near):
            near.append(at)
    found = [_ended(misfit, at) for at in near]
    heights = np.array([misfit(at)[0] for at in found])
    likely = np.exp(-0.5 * (heights - heights.min()))
    return [(float(p), at) for p, at in zip(likely / likely.sum(), found, strict=True)]


def _climbed(misfit: Misfit, start: Array) -> Array:
    from scipy.optimize import minimize

    bounds = [(-WITHIN, WITHIN)] * len(start)
    return np.asarray(minimize(misfit, start, jac=True, method="L-BFGS-B", bounds=bounds).x)


def _ended(misfit: Misfit, near: Array) -> Array:
    """Return the optimum near a point."""
    length = np.inf
    for _ in range(MOST_STEPS):
        height, slope = misfit(near)
        curved, ways = np.linalg.eigh(_curvature(misfit, near))
        curved = np.maximum(np.abs(curved), FLAT * max(curved[-1], 1.0))  # leaves saddles
        down = ways.T @ slope
        before, length = length, float(np.sqrt(np.sum(down**2 / curved) / 2.0))
        if length < SETTLED or SLOWER * before < length < NEAR:
            return near  # the second: what is left is the gradient's rounding
        step = -ways @ (down / curved)
        step *= min(1.0, FAR / float(np.linalg.norm(step)))
        while length > COMPARED and misfit(near + step)[0] > height:
            step *= SLOWER
        near = near + step
    raise NotSettled(f"a likelihood's optimum still moves by {length:.2g} standard errors a step")


def _curvature(misfit: Misfit, at: Array) -> Array:
    """Return the Hessian."""
    steps = WIDTH * np.eye(len(at))
    rows = [(misfit(at + s)[1] - misfit(at - s)[1]) / (2.0 * WIDTH) for s in steps]
    return 0.5 * (np.array(rows) + np.array(rows).T)
