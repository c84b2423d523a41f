"""A law's shape between the points of its grid: tuned on white rows, with its uncertainty.

Each value is first looked for over its range; from there Newton's steps, all values of a shape at
once, end where what the shape explains rises no more.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from autodb.explain.engine.bench import WhiteRows
from autodb.explain.engine.candidates import CandidateForm, Choice
from autodb.explain.engine.noise import Noise
from autodb.explain.engine.normal import HELD
from autodb.fitting.linear import orthonormal_basis
from autodb.fitting.rounds import NotSettled, stationary

Array = NDArray[np.float64]

ROUNDS = 2
FINE = 1e-3
"""Values are looked for to this share of the range that they are looked for in."""
CURVED = 0.02
"""Half width, as a share of that range, over which the curvature at the best value is taken."""
SETTLED, STEPS = 1e-6, 20
"""Step in standard errors at which values are at their best, and the most steps: a step in time
that lies between two rows has no best place."""
NEAR = 0.03
"""Half width in standard errors over which slope and curvature are taken, once they are known."""
APART = 0.1
"""Least eigenvalue of the inner products of columns, each of size 1, that are nearly orthogonal."""
PASSES, TOGETHER = 30, 1e-5
"""The most times that several effects are tuned one beside the others, and the step in standard
errors at which none moves."""


@dataclass(frozen=True)
class Tuned:
    """A choice with its shape tuned, and the standard deviations of its shape's values by name."""

    choice: Choice
    sd: dict[str, float]


class BesideShapes:
    """White rows after own columns, all or those of some numbers, and other effects are projected
    out.
    """

    def __init__(
        self,
        bench: WhiteRows,
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
        self.basis = orthonormal_basis(white, least=HELD**0.5)
        self.target = self._left(whitener(bench.reduced_difference))

    def _left(self, values: Array) -> Array:
        return np.asarray(values - self.basis @ (self.basis.T @ values))

    def gain(self, form: CandidateForm) -> float:
        """Return what a shape explains, over the noise variance.

        An effect whose size its shape already fixes is taken at that size.
        """
        columns = self._left(self.whitener(self.bench.reduce(self.bench.built(form))))
        if form.through is not None:
            at_size = 2.0 * columns[:, 0] @ self.target - columns[:, 0] @ columns[:, 0]
            return float(at_size) / self.variance
        return _explained(columns, self.target) / self.variance

    def fit(self, form: CandidateForm) -> tuple[Array, Array]:
        """Return a shape's coefficients (p,) and their covariance (p, p)."""
        columns = self._left(self.whitener(self.bench.reduce(self.bench.built(form))))
        inverse = np.linalg.pinv(columns.T @ columns, rcond=1e-9, hermitian=True)
        return np.asarray(inverse @ (columns.T @ self.target)), np.asarray(inverse * self.variance)


def _explained(columns: Array, target: Array) -> float:
    """Return the sum of squares of a target (n,) that columns (n, p) explain.

    By their inner products where they are nearly orthogonal, as the waves of a ripple are: these
    lose no digits then, and take a tenth of a factorisation's time.
    """
    norm = np.linalg.norm(columns, axis=0)
    if np.all(norm > 0.0):
        inner = (columns.T @ columns) / np.outer(norm, norm)
        if np.linalg.eigvalsh(inner)[0] > APART:
            along = (columns.T @ target) / norm
            return float(along @ np.linalg.solve(inner, along))
    q, r = np.linalg.qr(columns)
    held = np.abs(np.diag(r)) > 1e-9 * max(float(np.abs(r).max()), 1e-300)
    return float(np.sum((q[:, held].T @ target) ** 2))


def tuned(choice: Choice, beside: BesideShapes) -> Tuned:
    """Return a choice with every value that may be tuned at its best."""
    form = choice.shape
    if not form.within:
        return Tuned(choice, {})
    for _ in range(ROUNDS if len(form.within) > 1 else 1):
        for name, limits in form.within.items():
            form = _best(form, name, limits, beside)
    if beside.gain(form) < beside.gain(choice.shape):
        form = choice.shape
    form, _ = _settled(form, beside)
    sd = {name: _sd(form, name, limits, beside) for name, limits in form.within.items()}
    return Tuned(_with(choice, form), sd)


def tuned_together(bench: WhiteRows, choices: Sequence[Choice], noise: Noise) -> tuple[Choice, ...]:
    """Return choices, the shape of each tuned beside the others, until none moves any more.

    A shape that has no best place, a step in time between two rows, stays where PASSES leave it.
    """
    found = list(choices)
    for number in range(len(found)):
        found[number] = tuned(found[number], _beside(bench, found, number, noise)).choice
    shaped = [number for number, choice in enumerate(found) if choice.shape.within]

    def moved(at: Array) -> tuple[Array, Array]:
        for number, values in zip(shaped, np.split(at, ends), strict=True):
            found[number] = _placed(found[number], values)
        sizes = []
        for number in shaped:
            beside = _beside(bench, found, number, noise)
            form, size = _settled(found[number].shape, beside)
            found[number] = _instead(found[number], form)
            sizes.append(size)
        return _values(found, shaped), np.concatenate(sizes)

    if len(shaped) > 1:
        ends = np.cumsum([len(found[number].shape.within) for number in shaped])[:-1]
        with suppress(NotSettled):
            stationary(moved, _values(found, shaped), settled=TOGETHER, most=PASSES)
    return tuple(found)


def _values(choices: Sequence[Choice], shaped: Sequence[int]) -> Array:
    shapes = [choices[number].shape for number in shaped]
    return np.array([shape.shape[name] for shape in shapes for name in shape.within])


def _beside(bench: WhiteRows, choices: Sequence[Choice], number: int, noise: Noise) -> BesideShapes:
    return BesideShapes(bench, [*choices[:number], *choices[number + 1 :]], noise)


def _placed(choice: Choice, values: Array) -> Choice:
    form = choice.shape
    limits = np.array(list(form.within.values())).T
    return _instead(choice, _shaped(form, list(form.within), np.clip(values, *limits)))


def _with(choice: Choice, form: CandidateForm) -> Choice:
    """Return a choice of a further shape, at the top of its ladder."""
    candidate = replace(choice.candidate, forms=(*choice.candidate.forms, form))
    return Choice(candidate, len(choice.candidate.forms))


def _instead(choice: Choice, form: CandidateForm) -> Choice:
    """Return a choice with a shape in the place of the one at the top of its ladder."""
    candidate = replace(choice.candidate, forms=(*choice.candidate.forms[:-1], form))
    return replace(choice, candidate=candidate)


def _settled(form: CandidateForm, beside: BesideShapes) -> tuple[CandidateForm, Array]:
    """Return a shape from which no step explains more, and its values' standard errors (p,)."""
    names = list(form.within)
    lower, upper = np.array(list(form.within.values())).T
    width, size = CURVED * (upper - lower), upper - lower
    at = np.array([form.shape[name] for name in names])

    def gain(values: Array) -> float:
        return beside.gain(_shaped(form, names, values))

    height = gain(at)
    for _ in range(STEPS):
        slope, curvature = _derivatives(gain, at, height, width)
        sharp, ways = np.linalg.eigh(-curvature)
        if sharp[0] <= 0.0:
            break  # no best value within reach
        there = np.clip(at + ways @ ((ways.T @ slope) / sharp), lower, upper)
        step = float(np.sqrt((there - at) @ -curvature @ (there - at) / 2.0))
        reached = gain(there)
        size = np.sqrt(2.0 / np.diag(-curvature))
        wide, width = width, np.minimum(width, NEAR * size)
        if step >= SETTLED and reached > height:
            at, height = there, reached
        elif np.all(width == wide):
            break
    return _shaped(form, names, at), size


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


def _shaped(form: CandidateForm, names: Sequence[str], values: Array) -> CandidateForm:
    return replace(form, shape={**form.shape, **dict(zip(names, values.tolist(), strict=True))})


def _at(form: CandidateForm, name: str, value: float) -> CandidateForm:
    return replace(form, shape={**form.shape, name: value})


def _best(
    form: CandidateForm, name: str, limits: tuple[float, float], beside: BesideShapes
) -> CandidateForm:
    width = limits[1] - limits[0]
    found = minimize_scalar(
        lambda value: -beside.gain(_at(form, name, float(value))),
        bounds=limits,
        method="bounded",
        options={"xatol": FINE * width, "maxiter": 25},
    )
    return _at(form, name, float(found.x))


def _sd(form: CandidateForm, name: str, limits: tuple[float, float], beside: BesideShapes) -> float:
    """Return the standard deviation of a value from the curvature of what the shape explains."""
    half = CURVED * (limits[1] - limits[0])
    value = form.shape[name]
    around = [beside.gain(_at(form, name, value + step)) for step in (-half, 0.0, half)]
    curvature = (2.0 * around[1] - around[0] - around[2]) / half**2
    return float(np.sqrt(2.0 / curvature)) if curvature > 0 else limits[1] - limits[0]
