"""A law's shape between the points of its grid: tuned on white rows, with its uncertainty."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from autodb.explain.bench import Bench
from autodb.explain.noise import Noise
from autodb.explain.suspects import Choice, Rung

Array = NDArray[np.float64]

ROUNDS = 2
FINE = 1e-3
"""Values are found to this share of the range that they are looked for in."""
CURVED = 0.02
"""Half width, as a share of that range, over which the curvature at the best value is taken."""


@dataclass(frozen=True)
class Tuned:
    """A choice with its shape tuned, and the standard deviations of its shape's values by name."""

    choice: Choice
    sd: dict[str, float]


class Beside:
    """White rows after own columns, all or those of some numbers, and other effects are projected
    out.
    """

    def __init__(
        self,
        bench: Bench,
        others: Sequence[Choice],
        noise: Noise,
        own: Sequence[int] | None = None,
    ) -> None:
        whitener, variance = noise
        self.bench = bench
        self.whitener = whitener
        self.variance = variance
        kept = range(len(bench.own)) if own is None else own
        chosen = bench.chosen(others)
        white = whitener(chosen[:, [*kept, *range(len(bench.own), chosen.shape[1])]])
        self.basis = np.linalg.svd(white, full_matrices=False)[0] if white.shape[1] else white
        self.target = self._left(whitener(bench.reduced_difference))

    def _left(self, values: Array) -> Array:
        return np.asarray(values - self.basis @ (self.basis.T @ values))

    def gain(self, rung: Rung) -> float:
        """Return what a shape explains, over the noise variance.

        An effect whose size its shape already fixes is taken at that size.
        """
        columns = self._left(self.whitener(self.bench.reduce(self.bench.built(rung))))
        if rung.through is not None:
            at_size = 2.0 * columns[:, 0] @ self.target - columns[:, 0] @ columns[:, 0]
            return float(at_size) / self.variance
        q, r = np.linalg.qr(columns)
        held = np.abs(np.diag(r)) > 1e-9 * max(float(np.abs(r).max()), 1e-300)
        return float(np.sum((q[:, held].T @ self.target) ** 2)) / self.variance

    def fit(self, rung: Rung) -> tuple[Array, Array]:
        """Return a shape's coefficients (p,) and their covariance (p, p)."""
        columns = self._left(self.whitener(self.bench.reduce(self.bench.built(rung))))
        inverse = np.linalg.pinv(columns.T @ columns, rcond=1e-9, hermitian=True)
        return np.asarray(inverse @ (columns.T @ self.target)), np.asarray(inverse * self.variance)


def tuned(choice: Choice, beside: Beside) -> Tuned:
    """Return a choice with every value that may be tuned at its best."""
    rung = choice.shape
    if not rung.within:
        return Tuned(choice, {})
    for _ in range(ROUNDS if len(rung.within) > 1 else 1):
        for name, limits in rung.within.items():
            rung = _best(rung, name, limits, beside)
    if beside.gain(rung) < beside.gain(choice.shape):
        rung = choice.shape
    sd = {name: _sd(rung, name, limits, beside) for name, limits in rung.within.items()}
    suspect = replace(choice.suspect, rungs=(*choice.suspect.rungs, rung))
    return Tuned(Choice(suspect, len(choice.suspect.rungs)), sd)


def _at(rung: Rung, name: str, value: float) -> Rung:
    return replace(rung, shape={**rung.shape, name: value})


def _best(rung: Rung, name: str, limits: tuple[float, float], beside: Beside) -> Rung:
    width = limits[1] - limits[0]
    found = minimize_scalar(
        lambda value: -beside.gain(_at(rung, name, float(value))),
        bounds=limits,
        method="bounded",
        options={"xatol": FINE * width, "maxiter": 25},
    )
    return _at(rung, name, float(found.x))


def _sd(rung: Rung, name: str, limits: tuple[float, float], beside: Beside) -> float:
    """Return the standard deviation of a value from the curvature of what the shape explains."""
    half = CURVED * (limits[1] - limits[0])
    value = rung.shape[name]
    around = [beside.gain(_at(rung, name, value + step)) for step in (-half, 0.0, half)]
    curvature = (2.0 * around[1] - around[0] - around[2]) / half**2
    return float(np.sqrt(2.0 / curvature)) if curvature > 0 else limits[1] - limits[0]
