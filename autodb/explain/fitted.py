"""The accepted set fitted together with the simulation's own terms, at every row."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.explain.bench import Bench
from autodb.explain.noise import Whitener
from autodb.explain.prior import drawn
from autodb.explain.suspects import Choice

Array = NDArray[np.float64]

KEPT_SDS = 1.5
"""An own term is re-tuned in the correction when its change is this many standard deviations: near
√2, where a coefficient starts to predict better than none (Akaike 1974)."""


@dataclass(frozen=True)
class Fitted:
    """Coefficients (p,) of own and chosen columns, their covariance (p, p), and what they give.

    ``correction`` (n,) is the sum of the effects and of the own terms' re-tuning that is worth it;
    ``columns`` (n, p) of each choice, ``effects`` (n,) its contribution; ``design`` the columns
    (n, q) of the correction; ``retuned`` the numbers of the own terms in it.
    """

    own: tuple[str, ...]
    columns: tuple[Array, ...]
    coefficients: Array
    covariance: Array
    correction: Array
    effects: tuple[Array, ...]
    design: Array
    retuned: tuple[int, ...]

    def of_own(self, name: str) -> tuple[float, float]:
        """Return an own term's change and its standard deviation."""
        at = self.own.index(name)
        return float(self.coefficients[at]), float(np.sqrt(self.covariance[at, at]))

    def of_choice(self, number: int) -> tuple[Array, Array]:
        """Return a choice's coefficients (p,) and their covariance (p, p)."""
        start = len(self.own) + sum(block.shape[1] for block in self.columns[:number])
        at = slice(start, start + self.columns[number].shape[1])
        return self.coefficients[at], self.covariance[at, at]


def fit(bench: Bench, choices: Sequence[Choice], noise: tuple[Whitener, float]) -> Fitted:
    """Fit own and chosen columns together to rows that a noise's filter makes white."""
    columns, own = bench.chosen(choices), tuple(bench.own)
    weight = drawn(bench, choices, noise)
    coefficients, covariance = _least_squares(columns, bench.reduced_difference, noise, weight)
    sd = np.sqrt(np.diag(covariance))
    retuned = [i for i in range(len(own)) if abs(coefficients[i]) > KEPT_SDS * max(sd[i], 1e-300)]
    kept = [*retuned, *range(len(own), columns.shape[1])]
    lean, _ = _least_squares(columns[:, kept], bench.reduced_difference, noise, weight[kept])
    built = tuple(bench.built(choice.shape) for choice in choices)
    design = np.column_stack([bench.own_columns()[:, retuned], *built])
    effects, at = [], len(retuned)
    for block in built:
        effects.append(block @ lean[at : at + block.shape[1]])
        at += block.shape[1]
    return Fitted(
        own, built, coefficients, covariance, design @ lean, tuple(effects), design, tuple(retuned)
    )


def _least_squares(
    columns: Array, difference: Array, noise: tuple[Whitener, float], weight: Array
) -> tuple[Array, Array]:
    """Return coefficients (p,) and covariance (p, p) from white rows; ``weight`` as ``drawn``."""
    whitener, variance = noise
    white, right = whitener(columns), whitener(difference)
    norm = np.linalg.norm(white, axis=0)
    norm[norm == 0] = 1.0
    scaled = white / norm
    inner = scaled.T @ scaled + np.diag(weight / norm**2)
    inverse = np.linalg.pinv(inner, rcond=1e-9, hermitian=True)
    coefficients = inverse @ (scaled.T @ right) / norm
    return np.asarray(coefficients), np.asarray(variance * inverse / np.outer(norm, norm))
