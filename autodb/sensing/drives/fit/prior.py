"""What an earlier version of an axis' model knows, beside what new moves say."""

import numpy as np
from numpy.typing import NDArray

from autodb.sensing.drives.fit.axis_model import (
    ChangedParameter,
    Posteriors,
    predicted_effort,
    unit_in,
)
from autodb.sensing.drives.fit.solved import Solved, given_shape, identified_term
from autodb.sensing.drives.moves.prepared import Prepared

Array = NDArray[np.float64]

SURE_SDS = 1.96
"""Standard deviations of a difference beyond which a parameter has moved (95 %)."""


def combined_with_prior(solved: Solved, posteriors: Posteriors, rows: Prepared) -> Solved:
    """Return the fit combined with posteriors, both weighted by their information.

    What moved by more than 1.96 sd of the difference changed on the machine: the posterior about it
    is widened by the move, so that the new moves decide. A version that lacked a term is believed
    less (``_swallowed``).
    """
    names = [(part.key, p.name) for part, p in solved.problem.names]
    known = [i for i, name in enumerate(names) if name in posteriors.names]
    if not known:
        return solved
    prior = posteriors.of([names[i] for i in known])
    here, own = solved.values[known], solved.covariance[np.ix_(known, known)]
    change = here - prior.mean
    doubted = prior.covariance + np.diag(_swallowed(solved, posteriors, rows)[known] ** 2)
    far = np.abs(change) > SURE_SDS * np.sqrt(np.diag(own) + np.diag(doubted))
    posterior = doubted + np.diag(np.where(far, change**2, 0.0))
    covariance = _combined(solved.covariance, posterior, known)
    gain = covariance[:, known] @ np.linalg.inv(posterior)
    moved = [
        ChangedParameter(
            key=names[known[k]][0],
            parameter=names[known[k]][1],
            unit=unit_in(solved.problem.names[known[k]][1], rows.unit, rows.axis),
            before=float(prior.mean[k]),
            before_sd=float(np.sqrt(prior.covariance[k, k])),
            now=float(here[k]),
            now_sd=float(np.sqrt(own[k, k])),
        )
        for k in np.flatnonzero(far)
    ]
    values = solved.values - gain @ change
    return Solved(
        problem=solved.problem,
        fit=solved.fit,
        deviation=solved.deviation,
        values=values,
        covariance=covariance,
        weights=solved.weights_with(values),
        moved=tuple(moved),
    )


def _swallowed(solved: Solved, posteriors: Posteriors, rows: Prepared) -> Array:
    """Return how far off each parameter may be in a version that lacked some of the terms, (p,).

    Its values are not about the same parameters: fitted without a term, they took up what that term
    gave, in shares that depend on moves which are not at hand any more. One parameter with column x
    can at most have taken up all of a contribution z, which moved it by rms(z)/rms(x) (Cauchy and
    Schwarz: |⟨x, z⟩|/⟨x, x⟩). z is what the terms give on these moves, with 1.96 sd on top: a term
    that these moves do not excite must not get a number from posteriors that never knew it. So
    these moves decide whatever they excite, and what they do not show is kept, with its doubt.
    """
    names = solved.problem.names
    new = np.array([part.key not in posteriors.keys for part, _ in names])
    if not new.any():
        return np.zeros(len(names))
    terms = [
        identified_term(name, value, None, rows)
        for name, value in zip(names, solved.values, strict=True)
    ]
    terms += given_shape(solved.problem.parts, rows)
    had = [term for term in terms if term.key in posteriors.keys]
    given = rows.reduced(predicted_effort(terms, rows.inputs) - predicted_effort(had, rows.inputs))
    size = np.sqrt(np.mean(solved.problem.columns**2, axis=0))
    doubt = np.sqrt(np.sum(np.diag(solved.covariance)[new] * size[new] ** 2))
    whole = np.sqrt(np.mean(given**2)) + SURE_SDS * doubt
    moved: Array = np.divide(whole, size, out=np.zeros_like(size), where=size > 0)
    return moved


def _combined(covariance: Array, posterior: Array, known: list[int]) -> Array:
    """Return (C⁻¹ + Σ⁻¹)⁻¹ with Σ⁻¹ on ``known``; scaled, because C spans many powers of ten."""
    scale = np.sqrt(np.diag(covariance))
    information = np.linalg.inv(covariance / np.outer(scale, scale))
    inner = np.linalg.inv(posterior) * np.outer(scale[known], scale[known])
    information[np.ix_(known, known)] += inner
    combined = np.linalg.inv(information) * np.outer(scale, scale)
    return np.asarray(0.5 * (combined + combined.T), dtype=np.float64)
