"""Fit a set of effects beside the simulation's own terms, on all cuts and on cuts left out."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from autodb.explain.cutting.laws import Columns
from autodb.explain.cutting.table import Stack
from autodb.explain.suspects import Choice

Array = NDArray[np.float64]

FOLDS = 5
BLOCKS = 20
OWN_PRIOR = 1e-9
"""Precision of own columns of unit norm, of effects' in units of their mean square: hardly any."""
WEAKEST = 1e-9


@dataclass(frozen=True)
class Fit:
    """Coefficients (p,), their covariance (p, p), and what is left (C, n) [N].

    ``parts``: contribution (C, n) of each own term and each effect, in their order.
    """

    coefficients: Array
    covariance: Array
    left: Array
    parts: tuple[Array, ...]
    places: tuple[slice, ...]


def fit(stack: Stack, own: dict[str, Columns], choices: tuple[Choice, ...]) -> Fit:
    """Fit own terms and effects; directions that the cuts do not hold are pulled to zero."""
    columns = all_columns(own, choices)
    raw = [c.raw() for c in columns]
    white = stack.white(np.concatenate(raw, axis=2))
    coefficients, covariance = _solve(white, stack.difference, _widths(columns), len(own))
    ends = np.cumsum([0, *_widths(columns)])
    places = tuple(slice(int(a), int(b)) for a, b in pairwise(ends))
    parts = tuple(r @ coefficients[at] for r, at in zip(raw, places, strict=True))
    left = stack.recording - stack.simulation - np.sum(parts, axis=0)
    return Fit(coefficients, covariance, left, parts, places)


def all_columns(own: dict[str, Columns], choices: tuple[Choice, ...]) -> list[Columns]:
    """Return own columns, then those of the effects."""
    made = [c.shape.law for c in choices]
    return [*own.values(), *(c for c in made if isinstance(c, Columns))]


def _widths(columns: list[Columns]) -> list[int]:
    return [c.mix.shape[2] for c in columns]


def _solve(
    white: Array, difference: Array, widths: list[int], own: int, norm: Array | None = None
) -> tuple[Array, Array]:
    """Return coefficients and covariance of white rows, effects shrunk by their own mean square.

    An effect's columns get the precision p/d², d² what they explain together: hardly felt where
    the rows hold them, and holding where they do not.
    """
    norm = np.linalg.norm(white, axis=0) if norm is None else norm
    norm = np.where(norm == 0, 1.0, norm)
    scaled = white / norm
    inner, right = scaled.T @ scaled, scaled.T @ difference
    precision = np.full(len(norm), OWN_PRIOR)
    inverse = np.linalg.pinv(inner + np.diag(precision), rcond=WEAKEST, hermitian=True)
    plain = inverse @ right
    at = sum(widths[:own])
    for width in widths[own:]:
        here = slice(at, at + width)
        part = float(plain[here] @ inner[here, here] @ plain[here])
        precision[here] = width / max(part, 1.0) if width > 1 else OWN_PRIOR
        at += width
    inverse = np.linalg.pinv(inner + np.diag(precision), rcond=WEAKEST, hermitian=True)
    return inverse @ right / norm, inverse / np.outer(norm, norm)


def held_out_rows(stack: Stack, own: dict[str, Columns], choices: tuple[Choice, ...]) -> Array:
    """Return what is left (C, n) [N] of cuts whose block of neighbours was left out of the fit."""
    columns = all_columns(own, choices)
    raw = np.concatenate([c.raw() for c in columns], axis=2)
    white, difference = stack.white(raw), stack.difference
    count, n = stack.simulation.shape
    fold = (np.arange(n) * min(BLOCKS, n) // n) % FOLDS
    rows = np.tile(fold, count)
    norm = np.linalg.norm(white, axis=0)
    left = stack.recording - stack.simulation
    for number in range(FOLDS):
        seen = rows != number
        coefficients, _ = _solve(
            white[seen], difference[seen], _widths(columns), len(own), norm=norm
        )
        test = fold == number
        left[:, test] -= raw[:, test] @ coefficients
    return np.asarray(left)


def held_out(stack: Stack, own: dict[str, Columns], choices: tuple[Choice, ...]) -> float:
    """Return the mean square of white rows that their fit did not see."""
    left = held_out_rows(stack, own, choices)
    return float(np.mean(stack.white(left[:, :, None]) ** 2))
