"""A law's shape between the points of its grid: tuned on white rows, with its uncertainty.

Each value is first looked for over its range; from there Newton's steps, all values of a shape at
once, end where what the shape explains rises no more.
"""

from collections.abc import Callable, Sequence
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
"""Values are looked for to this share of the range that they are looked for in."""
CURVED = 0.02
"""Half width, as a share of that range, over which the curvature at the best value is taken."""
SETTLED, STEPS = 1e-6, 20
"""Step in standard errors at which values are at their best, and the most steps: a step in time
that lies between two rows has no best place."""
NEAR = 0.3
"""Half width in standard errors over which slope and curvature are taken, once they are known."""
PASSES = 30
"""Times that several effects are tuned one beside the others, until none moves."""


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
    rung, _ = _settled(rung, beside)
    sd = {name: _sd(rung, name, limits, beside) for name, limits in rung.within.items()}
    return Tuned(_with(choice, rung), sd)


def tuned_together(bench: Bench, choices: Sequence[Choice], noise: Noise) -> tuple[Choice, ...]:
    """Return choices, the shape of each tuned beside the others, until none moves any more."""
    found = list(choices)
    for number in range(len(found)):
        found[number] = tuned(found[number], _beside(bench, found, number, noise)).choice
    shaped = [number for number, choice in enumerate(found) if choice.shape.within]
    for _ in range(PASSES if len(shaped) > 1 else 0):
        farthest = 0.0
        for number in shaped:
            beside = _beside(bench, found, number, noise)
            rung, moved = _settled(found[number].shape, beside)
            farthest = max(farthest, moved)
            found[number] = _with(found[number], rung)
        if farthest < SETTLED:
            break
    return tuple(found)


def _beside(bench: Bench, choices: Sequence[Choice], number: int, noise: Noise) -> Beside:
    return Beside(bench, [*choices[:number], *choices[number + 1 :]], noise)


def _with(choice: Choice, rung: Rung) -> Choice:
    suspect = replace(choice.suspect, rungs=(*choice.suspect.rungs, rung))
    return Choice(suspect, len(choice.suspect.rungs))


def _settled(rung: Rung, beside: Beside) -> tuple[Rung, float]:
    """Return a shape from which no step explains more, and how far it moved, in standard errors."""
    names = list(rung.within)
    lower, upper = np.array(list(rung.within.values())).T
    width = CURVED * (upper - lower)
    at = np.array([rung.shape[name] for name in names])
    moved = 0.0

    def gain(values: Array) -> float:
        return beside.gain(_shaped(rung, names, values))

    height = gain(at)
    for _ in range(STEPS):
        slope, curvature = _derivatives(gain, at, height, width)
        sharp, ways = np.linalg.eigh(-curvature)
        if sharp[0] <= 0.0:
            break  # no best value within reach
        there = np.clip(at + ways @ ((ways.T @ slope) / sharp), lower, upper)
        step = float(np.sqrt((there - at) @ -curvature @ (there - at) / 2.0))
        reached = gain(there)
        if step < SETTLED or reached <= height:
            break
        at, height, moved = there, reached, moved + step
        width = np.minimum(width, NEAR / np.sqrt(np.diag(-curvature) / 2.0))
    return _shaped(rung, names, at), moved


def _derivatives(
    gain: Callable[[Array], float], at: Array, height: float, width: Array
) -> tuple[Array, Array]:
    """Return slope (p,) and curvature (p, p) of what a shape explains, by central differences."""
    steps = np.diag(width)
    after, before = (np.array([gain(at + sign * step) for step in steps]) for sign in (1.0, -1.0))
    slope = (after - before) / (2.0 * width)
    curvature = np.diag((after + before - 2.0 * height) / width**2)
    for i, j in zip(*np.triu_indices(len(at), 1), strict=True):
        both = gain(at + steps[i] + steps[j]) + gain(at - steps[i] - steps[j])
        mixed = both + 2.0 * height - after[[i, j]].sum() - before[[i, j]].sum()
        curvature[i, j] = curvature[j, i] = mixed / (2.0 * width[i] * width[j])
    return slope, curvature


def _shaped(rung: Rung, names: Sequence[str], values: Array) -> Rung:
    return replace(rung, shape={**rung.shape, **dict(zip(names, values.tolist(), strict=True))})


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
