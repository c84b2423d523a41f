"""Fit a set of effects beside the simulation's own terms, on all cuts and on cuts left out."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from autodb.explain.cuts.candidates.laws import LawColumns
from autodb.explain.cuts.stack import Stack
from autodb.explain.engine.candidates import Choice

Array = NDArray[np.float64]

FOLDS = 5
BLOCKS = 20
OWN_PRIOR = 1e-9
"""Precision of own columns of unit norm, of effects' in units of their mean square: hardly any."""
WEAKEST = 1e-9


@dataclass(frozen=True)
class CutsFit:
    """Coefficients (p,), their covariance (p, p), and what is left (C, n) [N].

    ``parts``: contribution (C, n) of each own term and each effect, in their order.
    """

    coefficients: Array
    covariance: Array
    left: Array
    parts: tuple[Array, ...]
    places: tuple[slice, ...]


def fit_cuts(stack: Stack, own: dict[str, LawColumns], choices: tuple[Choice, ...]) -> CutsFit:
    """Fit own terms and effects; directions that the cuts do not hold are pulled to zero."""
    columns = all_columns(own, choices)
    inner = inner_products(stack, columns)
    coefficients, covariance = _solve(inner, _widths(columns), len(own), norm=norms(inner))
    ends = np.cumsum([0, *_widths(columns)])
    places = tuple(slice(int(a), int(b)) for a, b in pairwise(ends))
    parts = tuple(c.part(coefficients[at]) for c, at in zip(columns, places, strict=True))
    left = stack.recording - stack.simulation - np.sum(parts, axis=0)
    return CutsFit(coefficients, covariance, left, parts, places)


def all_columns(own: dict[str, LawColumns], choices: tuple[Choice, ...]) -> list[LawColumns]:
    """Return own columns, then those of the effects."""
    made = [c.shape.law for c in choices]
    return [*own.values(), *(c for c in made if isinstance(c, LawColumns))]


def _widths(columns: list[LawColumns]) -> list[int]:
    return [c.mix.shape[2] for c in columns]


def inner_products(stack: Stack, columns: list[LawColumns]) -> Array:
    """Return the inner products (p + 1, p + 1) of the white difference and of white columns."""
    (inner,) = _by_fold(stack, columns, np.zeros(len(stack.known), dtype=np.intp), 1)
    return np.asarray(inner)


def _by_fold(stack: Stack, columns: list[LawColumns], fold: NDArray[np.intp], folds: int) -> Array:
    """Return the same (folds, p + 1, p + 1) of the cuts of each fold (n,)."""
    width, count = 1 + sum(_widths(columns)), len(stack.names)
    inner = np.zeros((folds, width, width))
    for rows in stack.chunks:
        difference = (stack.recording - stack.simulation)[:, rows, None]
        raw = np.concatenate([difference, *(c.raw(rows) for c in columns)], axis=2)
        white = stack.white(raw, rows).reshape(count, -1, width)
        for number in range(folds):
            seen = white[:, fold[rows] == number].reshape(-1, width)
            inner[number] += seen.T @ seen
    return inner


def norms(inner: Array) -> Array:
    """Return the norm of each column (p,), 1 where it is none."""
    norm = np.sqrt(np.diag(inner)[1:])
    return np.asarray(np.where(norm == 0, 1.0, norm))


def _solve(inner: Array, widths: list[int], own: int, *, norm: Array) -> tuple[Array, Array]:
    """Return coefficients and covariance by inner products with the difference first.

    Effects are shrunk by their own mean square: an effect's columns get the precision p/d², d² what
    they explain together: hardly sensed where the rows hold them, and holding where they do not.
    """
    right, inner = inner[1:, 0] / norm, inner[1:, 1:] / np.outer(norm, norm)
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


def held_out_rows(stack: Stack, own: dict[str, LawColumns], choices: tuple[Choice, ...]) -> Array:
    """Return what is left (C, n) [N] of cuts whose block of neighbours was left out of the fit."""
    columns = all_columns(own, choices)
    n, widths = len(stack.known), _widths(columns)
    fold = (np.arange(n) * min(BLOCKS, n) // n) % FOLDS
    inner = _by_fold(stack, columns, fold, FOLDS)
    norm = norms(inner.sum(axis=0))
    found = [
        _solve(np.delete(inner, number, axis=0).sum(axis=0), widths, len(own), norm=norm)[0]
        for number in range(FOLDS)
    ]
    left = stack.recording - stack.simulation
    for rows in stack.chunks:
        raw = np.concatenate([c.raw(rows) for c in columns], axis=2)
        parts = raw @ np.transpose(found)
        left[:, rows] -= np.take_along_axis(parts, fold[None, rows, None], axis=2)[:, :, 0]
    return np.asarray(left)


def held_out_square(stack: Stack, own: dict[str, LawColumns], choices: tuple[Choice, ...]) -> float:
    """Return the mean square of white rows that their fit did not see."""
    left = held_out_rows(stack, own, choices)
    return float(np.mean(stack.white(left[:, :, None]) ** 2))
