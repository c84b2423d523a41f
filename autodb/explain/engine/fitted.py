"""The accepted set fitted together with the simulation's own terms, at every row."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.bench import WhiteRows
from autodb.explain.engine.candidates import Candidate, CandidateForm, Choice
from autodb.explain.engine.noise import Noise
from autodb.explain.engine.normal import columns_side_by_side, normal, solved_together
from autodb.explain.engine.prior import coefficient_costs, evidence_of

Array = NDArray[np.float64]

KEPT_SDS = 1.5
"""An own term is re-tuned in the correction when its change is this many standard deviations: near
√2, where a coefficient starts to predict better than none (Akaike 1974)."""

LOOSE = 1e-4
"""A re-tuning that a curve takes up as well, drawn this many times less, is left to the curve.
Chosen: next to free, and still one answer where the curve holds the own term exactly."""
DEVIATES = 0.0
"""Evidence above which what a law gets wrong in shape is corrected too."""


@dataclass(frozen=True)
class FittedEffects:
    """Coefficients (k,) of own columns, their covariance (k, k), and what all columns give.

    ``correction`` (n,) is the sum of the effects and of the own terms' re-tuning that is worth it;
    ``columns`` (n, p) of each choice, ``covariances`` (p, p) of its coefficients beside the own
    terms that are re-tuned, ``effects`` (n,) its contribution; ``design`` the columns
    (n, q) of the correction and ``values`` (q,) their coefficients; ``retuned`` the numbers of the
    own terms in it; ``deviates``: whether what laws get wrong in shape is in it.
    """

    own: tuple[str, ...]
    columns: tuple[Array, ...]
    covariances: tuple[Array, ...]
    coefficients: Array
    covariance: Array
    correction: Array
    effects: tuple[Array, ...]
    design: Array
    values: Array
    retuned: tuple[int, ...]
    deviates: bool

    def of_own(self, name: str) -> tuple[float, float]:
        """Return an own term's change and its standard deviation."""
        at = self.own.index(name)
        return float(self.coefficients[at]), float(np.sqrt(self.covariance[at, at]))


def fit_white_rows(
    bench: WhiteRows,
    choices: Sequence[Choice],
    noise: Noise,
    laws: Sequence[Choice] = (),
    *,
    exact: bool = False,
    free: bool = False,
    also: Collection[int] = (),
) -> FittedEffects:
    """Fit own and chosen columns together to rows that a noise's filter makes white.

    Which own terms are re-tuned is judged beside the laws alone, and beside curves that are free to
    take the re-tuning up: what either would do is no contradiction of the simulation. The
    correction also takes what a law gets wrong in shape, as far as the rows show it; of ``laws``,
    which are among the own columns, too. ``exact``: without that. ``free``: every own term is
    re-tuned; ``also``: these are, by their numbers.
    """
    own = tuple(bench.own)
    choices = [c if c.candidate.static else across_own(bench, c) for c in choices]
    coefficients, covariance = _beside(bench, choices, noise, range(len(own)))
    sd = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    taken, taken_covariance = _beside(bench, choices, noise, range(len(own)), loose=LOOSE)
    taken_sd = np.sqrt(np.maximum(np.diag(taken_covariance), 1e-300))
    off = np.minimum(np.abs(coefficients / sd), np.abs(taken / taken_sd))
    retuned = [i for i in range(len(own)) if free or i in also or off[i] > KEPT_SDS]
    _, law_covariance = _beside(bench, choices, noise, retuned)
    off_shape = [] if exact else deviations(bench, choices, noise, laws)
    shaped = [*choices, *off_shape]
    values, _ = _beside(bench, shaped, noise, retuned)
    built = [bench.built(choice.shape) for choice in shaped]
    design = columns_side_by_side(bench.own_columns()[:, retuned], *built)
    places = _places(len(retuned), built)
    parts = {
        choice.candidate.key: block @ values[at]
        for choice, block, at in zip(shaped, built, places, strict=True)
    }
    return FittedEffects(
        own=own,
        columns=tuple(built[: len(choices)]),
        covariances=tuple(law_covariance[at, at] for at in places[: len(choices)]),
        coefficients=coefficients[: len(own)],
        covariance=covariance[: len(own), : len(own)],
        correction=design @ values,
        effects=tuple(_whole(choice, parts) for choice in choices),
        design=design,
        values=values,
        retuned=tuple(retuned),
        deviates=bool(off_shape),
    )


def across_own(bench: WhiteRows, choice: Choice) -> Choice:
    """Return a choice less what own columns give of it on plain rows.

    What acts on others and what has no name takes only what the simulation's own terms leave.
    """
    columns = bench.columns(choice.key, choice.shape)
    along = solved_together(bench.chosen(()), columns)
    built = bench.built(choice.shape) - bench.own_columns() @ along
    through = choice.shape.through or _as_built
    form = replace(choice.shape, law=lambda **_: built, through=through)
    forms = [*choice.candidate.forms]
    forms[choice.form] = form
    return Choice(replace(choice.candidate, forms=tuple(forms)), choice.form)


def _as_built(columns: Array, **_: float) -> Array:
    """Return columns as they are: what they were built of was seen as it is recorded."""
    return columns


def _beside(
    bench: WhiteRows,
    choices: Sequence[Choice],
    noise: Noise,
    own: Sequence[int],
    *,
    loose: float = 1.0,
) -> tuple[Array, Array]:
    """Return coefficients and covariance of some own columns and the choices' columns.

    Curves are drawn to none, ``loose`` times as much as their evidence says.
    """
    columns, weight = bench.chosen(choices), loose * coefficient_costs(bench, choices, noise)
    kept = [*own, *range(len(bench.own), columns.shape[1])]
    return _least_squares(columns[:, kept], bench.reduced_difference, noise, weight[kept])


def _places(first: int, blocks: Sequence[Array]) -> list[slice]:
    """Return where each block's columns stand after the ``first`` ones."""
    ends = [first, *(first + np.cumsum([block.shape[1] for block in blocks])).tolist()]
    return [slice(low, high) for low, high in pairwise(ends)]


def _whole(choice: Choice, parts: dict[str, Array]) -> Array:
    """Return an effect's law and what it deviates from it by."""
    law = parts[choice.candidate.key]
    return law + parts.get(_deviation_key(choice), np.zeros_like(law))


def _deviation_key(choice: Choice) -> str:
    return f"{choice.candidate.key}, shape"


def deviations(
    bench: WhiteRows, choices: Sequence[Choice], noise: Noise, laws: Sequence[Choice] = ()
) -> list[Choice]:
    """Return what plain laws get wrong in shape, each where there is evidence of it.

    ``laws``: those that are own columns.
    """
    found: list[Choice] = []
    for choice in (*choices, *laws):
        detail = choice.candidate.detail
        acts_on_all = choice.shape.through not in (None, _as_built)
        if detail is None or not choice.shape.names or acts_on_all:
            continue
        key = _deviation_key(choice)
        shape = Choice(Candidate(key, choice.candidate.term, (CandidateForm(detail),)), 0)
        if evidence_of(bench, shape, [*choices, *found], noise) > DEVIATES:
            found.append(shape)
    return found


def _least_squares(
    columns: Array, difference: Array, noise: Noise, weight: Array
) -> tuple[Array, Array]:
    """Return coefficients (p,) and covariance (p, p) of white rows.

    ``weight``: as of ``coefficient_costs``.
    """
    whitener, variance = noise
    equations = normal(whitener(columns), whitener(difference))
    inverse = equations.inverse(weight)
    return np.asarray(inverse @ equations.right), np.asarray(variance * inverse)
