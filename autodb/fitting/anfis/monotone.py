"""An output that never falls (or never rises) along one input, over the box of the training rows.

The slope ∂f/∂x_j is linear in the consequents for given premises (``premises.input_slopes``), so
the constraint is a linear inequality at every point. Consequents that minimise the regularised sum
of squares under inequalities at finitely many points are found by Lawson and Hanson's least
distance programming (1974, chapter 23), which is one non-negative least squares. Points where the
slope then still is too small are added until none is found (exchange method of semi-infinite
programming; Hettich and Kortanek 1993, SIAM Review 35:380).

**What is guaranteed.** At every point of the constraint set - a grid over the box with its
corners, and every point added - the slope is at least half of ``MARGIN``, up to rounding. Between
these points a lower slope was searched for at ``CHECKED`` low-discrepancy points and downhill from
the lowest of them, and none was found; that is a search, not a proof. Outside the box nothing is
guaranteed. The premises are as they were learned, without the constraint.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls
from scipy.stats import qmc

from autodb.fitting.anfis.premises import Premises, input_slopes
from autodb.fitting.anfis.sums import Posterior

Array = NDArray[np.float64]

MARGIN = 1e-3
"""Smallest slope asked for at the points, in standard deviations of the output a half range: room
for what lies between them, 0.2 % of the output's spread over the whole range."""
GRID_POINTS = 300
"""The first constraint set has about so many points, at least 2 an input (the corners)."""
CHECKED = 4096
LOWEST, NEIGHBOURS, DESCENTS = 30, 24, 8
"""From so many of the lowest points, so many steps downhill with so many trials each."""
MOST_ROUNDS = 30


class NotMonotone(ValueError):  # noqa: N818 - the model's state, not a program error
    """No consequents were found that are monotone for these premises."""


@dataclass(frozen=True)
class Monotone:
    """The output never falls along input ``along``; never rises where ``falling``."""

    along: int
    falling: bool = False

    @property
    def sign(self) -> float:
        """−1 where the output falls, 1 where it rises."""
        return -1.0 if self.falling else 1.0


def constrained(premises: Premises, plane: Array, found: Posterior, rule: Monotone) -> Array:
    """Return the best consequents less the plane (p,) that keep to the rule over the box.

    ``plane`` (d + 1,): what every rule has in common. Raises NotMonotone where points still had to
    be added after MOST_ROUNDS.
    """

    def slope(points: Array, consequents: Array) -> Array:
        rows = input_slopes(premises, points, rule.along)
        return np.asarray(rule.sign * (rows @ consequents + plane[1 + rule.along]))

    sought = len(premises.sets)
    points, mode = _grid(sought), found.mode
    for _ in range(MOST_ROUNDS):
        if np.min(slope(points, mode)) < 0.5 * MARGIN:
            rows = rule.sign * input_slopes(premises, points, rule.along)
            needed = MARGIN - rule.sign * plane[1 + rule.along]
            mode = nearest_monotone(found, rows, np.full(len(points), needed))
        lowest = _lowest(lambda at, now=mode: slope(at, now), sought)  # type: ignore[misc]
        short = lowest[slope(lowest, mode) < 0.5 * MARGIN]
        if not len(short):
            return mode
        points = np.vstack([points, short])
    raise NotMonotone(f"not monotone along input {rule.along} after {MOST_ROUNDS} rounds")


def nearest_monotone(found: Posterior, rows: Array, least: Array) -> Array:
    """Return the mode of the posterior (p,) under rows (m, p) · mode ≥ least (m,).

    In z = Lᵀ(θ − θ₀) it is the shortest z with A z ≥ b, A = rows · L⁻ᵀ, b = least − rows · θ₀; from
    u ≥ 0 that minimises |[Aᵀ; bᵀ] u − e_last| it is z = Aᵀu/(1 − bᵀu). Each row is divided by its
    length and z by the largest distance asked for.
    """
    across = rows @ found.root.T
    length = np.linalg.norm(across, axis=1)
    short = (least - rows @ found.mode) / length
    across, size = across / length[:, None], max(float(short.max()), 1e-300)
    stacked = np.vstack([across.T, short / size])
    u, _ = nnls(stacked, np.append(np.zeros(across.shape[1]), 1.0), maxiter=50 * len(rows))
    z = across.T @ u / (1.0 - float(short @ u) / size)
    return np.asarray(found.mode + size * (found.root.T @ z))


def _grid(inputs: int) -> Array:
    """Return a grid over the scaled box, corners included, (m, inputs)."""
    levels = max(2, int(GRID_POINTS ** (1.0 / inputs)))
    axes = np.meshgrid(*[np.linspace(-1.0, 1.0, levels)] * inputs, indexing="ij")
    return np.column_stack([axis.ravel() for axis in axes])


def _lowest(slope: Callable[[Array], Array], inputs: int) -> Array:
    """Return places (LOWEST, inputs) of the scaled box where the slope is low."""
    rng = np.random.default_rng(0)
    points = 2.0 * qmc.Sobol(inputs, scramble=False).random(CHECKED) - 1.0
    best = points[np.argsort(slope(points))[:LOWEST]]
    reach = 0.1
    for _ in range(DESCENTS):
        moves = rng.normal(0.0, reach, (LOWEST, NEIGHBOURS, inputs))
        moves[:, 0] = 0.0
        tried = np.clip(best[:, None] + moves, -1.0, 1.0)
        values = slope(tried.reshape(-1, inputs)).reshape(LOWEST, NEIGHBOURS)
        best = tried[np.arange(LOWEST), np.argmin(values, axis=1)]
        reach *= 0.7
    return np.asarray(best)
