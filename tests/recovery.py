"""Fit a channel's parts to what was measured: one place, for every recovery in the tests.

Linear parameters by least squares inside (variable projection), shape parameters by a grid over
their starts and a bounded search from the best of it. What is recorded of a sum (clipped, without
sign) needs all parameters together.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from autodb.terms import OutputChange
from autodb.terms.channel import (
    Inputs,
    Part,
    coefficients,
    columns,
    free_shape,
    predict,
    reshaped,
)

Array = NDArray[np.float64]
REFINED = 2
"""So many of the grid's best are refined."""


@dataclass(frozen=True)
class Recovered:
    """Parts with their shape found, and their linear parameters (p,)."""

    parts: tuple[Part, ...]
    linear: Array

    def value(self, key: str, name: str) -> float:
        """Return a parameter of the part ``key``."""
        for (part, parameter), value in zip(coefficients(self.parts), self.linear, strict=True):
            if (part.key, parameter.name) == (key, name):
                return float(value)
        return next(part.shape[name] for part in self.parts if part.key == key)

    def effect(self, key: str, inputs: Inputs) -> Array:
        """Return the channel with the part ``key`` less the channel without it, (n,)."""
        rest = tuple(part for part in self.parts if part.key != key)
        keep = [part.key != key for part, _ in coefficients(self.parts)]
        without = predict(rest, self.linear[keep], inputs)
        return predict(self.parts, self.linear, inputs) - without


@dataclass(frozen=True)
class Seen:
    """A channel (n,), its inputs and the standard deviation of each row (n,)."""

    inputs: Inputs
    measured: Array
    sd: Array

    def left(self, fit: Recovered) -> Array:
        """Return what a fit leaves, (n,), white."""
        return (self.measured - predict(fit.parts, fit.linear, self.inputs)) / self.sd

    def cost(self, fit: Recovered) -> float:
        """Return the sum of its squares."""
        return float(np.sum(self.left(fit) ** 2))

    def solved(self, parts: Sequence[Part], sign: Array | float) -> Array:
        """Return the linear parameters (p,) that fit the measured values times a sign best."""
        matrix = columns(parts, self.inputs) / self.sd[:, None]
        return _solved(matrix, self.measured * sign / self.sd)


def recover(
    parts: Sequence[Part], seen: Seen, looked: Mapping[str, tuple[float, ...]]
) -> Recovered:
    """Return the fit of parts to what was seen; ``looked`` adds starts by parameter name."""
    free = [p for _, p in free_shape(parts)]
    grid = [np.array(g) for g in product(*(looked.get(p.name, p.starts) for p in free))]
    fits = [_linear(reshaped(parts, at), seen) for at in grid]
    order = np.argsort([seen.cost(f) for f in fits])[:REFINED]
    return min((_refined(fits[i], seen) for i in order), key=seen.cost)


def _linear(parts: tuple[Part, ...], seen: Seen) -> Recovered:
    """Return the best linear parameters; a lost sign is tried with every column's sign."""
    if not any(isinstance(part.term, OutputChange) for part in parts):
        return Recovered(parts, seen.solved(parts, 1.0))
    signs = [1.0, *np.sign(columns(parts, seen.inputs)).T]
    return min((Recovered(parts, seen.solved(parts, sign)) for sign in signs), key=seen.cost)


def _solved(matrix: Array, measured: Array) -> Array:
    norm = np.maximum(np.linalg.norm(matrix, axis=0), 1e-300)
    return np.asarray(np.linalg.lstsq(matrix / norm, measured, rcond=1e-12)[0] / norm)


def _refined(fit: Recovered, seen: Seen) -> Recovered:
    free = free_shape(fit.parts)
    outputs = any(isinstance(part.term, OutputChange) for part in fit.parts)
    shape = np.array([part.shape[p.name] for part, p in free])
    first = np.concatenate([shape, fit.linear]) if outputs else shape
    if not len(first):
        return fit
    open_end = np.full(len(first) - len(free), np.inf)
    bounds = (
        np.concatenate([[p.lower for _, p in free], -open_end]),
        np.concatenate([[p.upper for _, p in free], open_end]),
    )

    def at(values: Array) -> Recovered:
        parts = reshaped(fit.parts, values[: len(free)])
        return Recovered(parts, values[len(free) :] if outputs else seen.solved(parts, 1.0))

    def left(values: Array) -> Array:
        return seen.left(at(values))

    scale, step = np.maximum(np.abs(first), 1e-3), np.full(len(first), 1e-5)
    found = least_squares(left, first, bounds=bounds, x_scale=scale, diff_step=step, max_nfev=60)
    return at(found.x)


def without_columns(of: Array, parts: Sequence[Part], inputs: Inputs) -> Array:
    """Return a curve (n,) less what the columns of parts could say of it."""
    if not parts:
        return of
    matrix = columns(parts, inputs)
    return of - matrix @ _solved(matrix, of)
