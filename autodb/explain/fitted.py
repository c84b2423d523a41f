"""The accepted set fitted together with the simulation's own terms, at every row."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.explain.bench import Bench
from autodb.explain.noise import Noise
from autodb.explain.prior import drawn, evidence_of
from autodb.explain.suspects import Choice, Rung, Suspect

Array = NDArray[np.float64]

KEPT_SDS = 1.5
"""An own term is re-tuned in the correction when its change is this many standard deviations: near
√2, where a coefficient starts to predict better than none (Akaike 1974)."""

DEVIATES = 0.0
"""Evidence above which what a law gets wrong in shape is corrected too."""


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


def fit(bench: Bench, choices: Sequence[Choice], noise: Noise) -> Fitted:
    """Fit own and chosen columns together to rows that a noise's filter makes white.

    Coefficients are of the laws alone. The correction also takes what a law gets wrong in shape, as
    far as the rows show it.
    """
    columns, own = bench.chosen(choices), tuple(bench.own)
    weight = drawn(bench, choices, noise)
    coefficients, covariance = _least_squares(columns, bench.reduced_difference, noise, weight)
    sd = np.sqrt(np.diag(covariance))
    retuned = [i for i in range(len(own)) if abs(coefficients[i]) > KEPT_SDS * max(sd[i], 1e-300)]
    shaped = [*choices, *deviations(bench, choices, noise)]
    lean, weight = bench.chosen(shaped), drawn(bench, shaped, noise)
    kept = [*retuned, *range(len(own), lean.shape[1])]
    values, _ = _least_squares(lean[:, kept], bench.reduced_difference, noise, weight[kept])
    built = [bench.built(choice.shape) for choice in shaped]
    design = np.column_stack([bench.own_columns()[:, retuned], *built])
    ends = np.cumsum([len(retuned), *(block.shape[1] for block in built)])
    parts = {
        choice.suspect.key: block @ values[low:high]
        for choice, block, low, high in zip(shaped, built, ends[:-1], ends[1:], strict=True)
    }
    effects = tuple(_whole(choice, parts) for choice in choices)
    return Fitted(
        own=own,
        columns=tuple(built[: len(choices)]),
        coefficients=coefficients,
        covariance=covariance,
        correction=design @ values,
        effects=effects,
        design=design,
        retuned=tuple(retuned),
    )


def _whole(choice: Choice, parts: dict[str, Array]) -> Array:
    """Return an effect's law and what it deviates from it by."""
    law = parts[choice.suspect.key]
    return law + parts.get(_deviation_key(choice), np.zeros_like(law))


def _deviation_key(choice: Choice) -> str:
    return f"{choice.suspect.key}, shape"


def deviations(bench: Bench, choices: Sequence[Choice], noise: Noise) -> list[Choice]:
    """Return what plain laws get wrong in shape, each where there is evidence of it."""
    found: list[Choice] = []
    for choice in choices:
        detail = choice.suspect.detail
        if detail is None or not choice.shape.names or choice.shape.through is not None:
            continue
        key = _deviation_key(choice)
        shape = Choice(Suspect(key, choice.suspect.term, (Rung(detail),)), 0)
        if evidence_of(bench, shape, [*choices, *found], noise) > DEVIATES:
            found.append(shape)
    return found


def _least_squares(
    columns: Array, difference: Array, noise: Noise, weight: Array
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
