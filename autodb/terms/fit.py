"""Fit a channel's parts to what was measured: linear parameters exactly, the shape by search."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.gaussian import Gaussian
from autodb.fitting.linear import CoefficientBounds, solve, triangle
from autodb.fitting.projection import ProjectionProblem, separable
from autodb.terms.channel import (
    ChannelPart,
    Inputs,
    channel_columns,
    free_shape,
    linear_parameters,
    predicted_channel,
    reshaped,
)
from autodb.terms.term import OutputChange, TermParameter

Array = NDArray[np.float64]

REFINED = 2
"""So many of the starts that fit best are refined."""
FLAT = 1e6
"""Standard deviation, in sizes of the parameter, of a posterior that says nothing."""


@dataclass(frozen=True)
class FittedParts:
    """Parts with their shape found, and their linear parameters (p,)."""

    parts: tuple[ChannelPart, ...]
    linear: Array


@dataclass(frozen=True)
class _Seen:
    """A channel (n,), its inputs, and the standard deviation of each row (n,)."""

    inputs: Inputs
    values: Array
    sd: Array

    def left(self, fit: FittedParts) -> Array:
        """Return what a fit leaves, (n,), in standard deviations."""
        return (self.values - predicted_channel(fit.parts, fit.linear, self.inputs)) / self.sd

    def cost(self, fit: FittedParts) -> float:
        """Return the sum of its squares."""
        return float(np.sum(self.left(fit) ** 2))


def fit_parts(
    parts: Sequence[ChannelPart],
    inputs: Inputs,
    values: Array,
    *,
    sd: Array,
    begin_at: Mapping[str, tuple[float, ...]] | None = None,
) -> FittedParts:
    """Fit values (n,) with noise of sd (n,) by parts; their free shape is searched.

    The search begins from every combination of the shape parameters' ``starts``, or of those in
    ``begin_at`` by name; the best are refined by variable projection with the parameters' bounds
    and priors. Where a part acts on the sum (clipped, without sign) the sum is no longer linear and
    all parameters are refined together.

    Raises NotConverged where no start settles.
    """
    begin_at = begin_at or {}
    seen = _Seen(inputs, values, sd)
    free = [p for _, p in free_shape(parts)]
    grid = product(*(begin_at.get(p.name, p.starts) for p in free))
    fits = [_linear(reshaped(parts, np.array(at)), seen) for at in grid]
    best = sorted(fits, key=seen.cost)[:REFINED]
    acts_on_sum = any(isinstance(part.term, OutputChange) for part in parts)
    refine = _together if acts_on_sum else _projected
    return min((refine(fit, seen) for fit in best), key=seen.cost)


def _linear(parts: tuple[ChannelPart, ...], seen: _Seen) -> FittedParts:
    """Return the best linear parameters; a lost sign is tried with every column's sign."""
    matrix = channel_columns(parts, seen.inputs)
    signs: list[Array | float] = [1.0]
    if any(isinstance(part.term, OutputChange) for part in parts):
        signs += list(np.sign(matrix).T)

    def solved(sign: Array | float) -> FittedParts:
        reduced = triangle(matrix, seen.values * sign, 1.0 / seen.sd)
        return FittedParts(parts, solve(reduced)[0])

    return min((solved(sign) for sign in signs), key=seen.cost)


def _projected(fit: FittedParts, seen: _Seen) -> FittedParts:
    """Refine by variable projection from the fit's shape."""
    free = free_shape(fit.parts)
    if not free:
        return fit
    linear = [p for _, p in linear_parameters(fit.parts)]
    start = np.array([part.shape[p.name] for part, p in free])
    problem = ProjectionProblem(
        design=lambda shape: channel_columns(reshaped(fit.parts, shape), seen.inputs),
        values=seen.values,
        typical=np.array([shape_step(p, part.shape[p.name]) for part, p in free]),
        shape_bounds=bounds_of([p for _, p in free]),
        bounds=bounds_of(linear),
        root=1.0 / seen.sd,
        prior=prior_of(linear, fit.linear, [p for _, p in free], start),
    )
    found = separable(problem, start)
    return FittedParts(reshaped(fit.parts, found.shape), found.coefficients)


def _together(fit: FittedParts, seen: _Seen) -> FittedParts:
    """Refine all parameters at once where the sum is not linear in them."""
    from scipy.optimize import least_squares

    free = free_shape(fit.parts)
    shape = np.array([part.shape[p.name] for part, p in free])
    first = np.concatenate([shape, fit.linear])
    limits = bounds_of([*(p for _, p in free), *(p for _, p in linear_parameters(fit.parts))])

    def at(values: Array) -> FittedParts:
        return FittedParts(reshaped(fit.parts, values[: len(free)]), values[len(free) :])

    def left(values: Array) -> Array:
        return seen.left(at(values))

    found = least_squares(
        left,
        np.clip(first, limits.lower, limits.upper),
        bounds=(limits.lower, limits.upper),
        x_scale=np.maximum(np.abs(first), 1e-3),
        diff_step=np.full(len(first), 1e-5),
    )
    return at(found.x)


def bounds_of(parameters: Sequence[TermParameter]) -> CoefficientBounds:
    """Return the parameters' bounds."""
    return CoefficientBounds(
        np.array([p.lower for p in parameters]), np.array([p.upper for p in parameters])
    )


def shape_step(parameter: TermParameter, value: float) -> float:
    """Return the size of change that matters in a shape parameter."""
    return 1e-3 * max(abs(value), *(abs(s) for s in parameter.starts), 1e-6)


def prior_of(
    linear: Sequence[TermParameter], weights: Array, shape: Sequence[TermParameter], start: Array
) -> Gaussian | None:
    """Return the prior of (coefficients, shape); None where there is none."""
    known = [p.prior for p in (*linear, *shape)]
    if not any(known):
        return None
    here = np.concatenate([weights, start])
    flat = FLAT * np.maximum(np.abs(here), 1.0)
    mean = np.array([b.mean if b else h for b, h in zip(known, here, strict=True)])
    sd = np.array([b.sd if b else f for b, f in zip(known, flat, strict=True)])
    return Gaussian(mean, np.diag(sd**2))
