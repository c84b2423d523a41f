"""Fit effects beside the simulation's own terms to a table of cuts: a set of them, or one alone.

A set is fitted to all cuts, and to cuts left out block by block. The parameters of one effect have
intervals, everything else beside it left free.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from autodb.explain.answer import IntervalValue
from autodb.explain.cuts.candidates.laws import LawColumns
from autodb.explain.cuts.stack import Stack
from autodb.explain.engine.candidates import Choice
from autodb.explain.engine.normal import HELD, Normal
from autodb.fitting.gaussian import NORMAL_95
from autodb.fitting.linear import orthonormal_basis

Array = NDArray[np.float64]

FOLDS = 5
BLOCKS = 20
OWN_PRIOR = 1e-9
"""Precision of own columns of unit norm, of effects' in units of their mean square: hardly any."""
WEAKEST = 1e-9
GRID = 25


@dataclass(frozen=True)
class CutsFit:
    """Coefficients (p,), their covariance (p, p), and what is left (C, n) [N].

    ``parts``: contribution (C, n) of each own term and each effect, in their order, of all columns
    (p) times ``mix`` (p, p): of each its own, less what `beside_own` takes off.
    """

    coefficients: Array
    covariance: Array
    left: Array
    parts: tuple[Array, ...]
    places: tuple[slice, ...]
    mix: Array


def fit_cuts(stack: Stack, own: dict[str, LawColumns], choices: tuple[Choice, ...]) -> CutsFit:
    """Fit own terms and effects; directions that the cuts do not hold are pulled to zero."""
    columns = all_columns(own, choices)
    inner = inner_products(stack, columns)
    coefficients, covariance = _solve(inner, columns, len(own), norm=norms(inner))
    ends = np.cumsum([0, *_widths(columns)])
    places = tuple(slice(int(a), int(b)) for a, b in pairwise(ends))
    parts = tuple(c.part(coefficients[at]) for c, at in zip(columns, places, strict=True))
    left = stack.recording - stack.simulation - np.sum(parts, axis=0)
    return CutsFit(coefficients, covariance, left, parts, places, np.eye(len(coefficients)))


def beside_own(
    stack: Stack, own: dict[str, LawColumns], choices: tuple[Choice, ...], fitted: CutsFit
) -> CutsFit:
    """Return the same fit in which what has no name is only what the own terms leave of it.

    Of a curve over the cutting time and an own wear, say, the cuts hold the sum alone: each may
    grow as long as the other takes it back. What own terms can do they do.
    """
    if all(choice.candidate.named for choice in choices):
        return fitted
    columns = all_columns(own, choices)
    inner = inner_products(stack, columns)
    norm, inner = norms(inner), inner[1:, 1:]
    inner, count = inner / np.outer(norm, norm), sum(_widths(list(own.values())))
    inverse = np.linalg.pinv(inner[:count, :count], rcond=WEAKEST, hermitian=True)
    mix = np.eye(len(norm))
    for choice, at in zip(choices, fitted.places[len(own) :], strict=True):
        if not choice.candidate.named:
            held = inverse @ inner[:count, at]
            mix[:count, at] = -held * norm[at] / norm[:count, None]
    back = 2.0 * np.eye(len(norm)) - mix
    coefficients = back @ fitted.coefficients
    covariance = back @ fitted.covariance @ back.T
    parts = tuple(
        _added(columns, fitted.places, mix[:, at] @ coefficients[at]) for at in fitted.places
    )
    return CutsFit(coefficients, covariance, fitted.left, parts, fitted.places, mix)


def _added(columns: list[LawColumns], places: tuple[slice, ...], weights: Array) -> Array:
    """Return what all columns add up to by their weights (p,), (C, n) [N]."""
    pairs = zip(columns, places, strict=True)
    parts = [c.part(weights[at]) for c, at in pairs if weights[at].any()]
    return np.sum(parts, axis=0) if parts else np.zeros(columns[0].stack.simulation.shape)


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


def _solve(
    inner: Array, columns: list[LawColumns], own: int, *, norm: Array
) -> tuple[Array, Array]:
    """Return coefficients and covariance by inner products with the difference first.

    Effects are shrunk by their own mean square: an effect's columns get the precision p/d², d² what
    they explain together: hardly sensed where the rows hold them, and holding where they do not.
    """
    right, inner = inner[1:, 0] / norm, inner[1:, 1:] / np.outer(norm, norm)
    prior, widths = np.concatenate([c.precision for c in columns]), _widths(columns)
    precision = OWN_PRIOR + prior / norm**2
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
    n = len(stack.known)
    fold = (np.arange(n) * min(BLOCKS, n) // n) % FOLDS
    inner = _by_fold(stack, columns, fold, FOLDS)
    norm = norms(inner.sum(axis=0))
    found = [
        _solve(np.delete(inner, number, axis=0).sum(axis=0), columns, len(own), norm=norm)[0]
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


@dataclass(frozen=True)
class BesideEffect:
    """White rows after own terms and the other effects are projected out."""

    stack: Stack
    basis: Array
    left: Array

    @classmethod
    def others(
        cls, stack: Stack, own: dict[str, LawColumns], choices: tuple[Choice, ...],
        *, plus: Array | None = None,
    ) -> "BesideEffect":  # fmt: skip
        """Project out the columns of own terms and effects; ``plus`` (C, n) joins what is left."""
        empty = np.zeros((*stack.simulation.shape, 0))
        raw = [c.raw() for c in all_columns(own, choices)]
        white = stack.white(np.concatenate([empty, *raw], axis=2))
        basis = orthonormal_basis(white, least=HELD)
        difference = stack.difference
        if plus is not None:
            difference = difference + stack.white(plus[:, :, None])[:, 0]
        return cls(stack, basis, difference - basis @ (basis.T @ difference))

    def clear(self, columns: LawColumns) -> Array:
        """Return white columns (C·n, p) without what the others hold."""
        white = columns()
        return np.asarray(white - self.basis @ (self.basis.T @ white))

    def gain(self, columns: LawColumns) -> float:
        """Return how far the sum of squares falls by some columns."""
        clear = self.clear(columns)
        coefficients, *_ = np.linalg.lstsq(clear, self.left, rcond=1e-8)
        return float(self.left @ (clear @ coefficients))

    def coefficients(self, columns: LawColumns) -> tuple[Array, Array]:
        """Return coefficients (p,) and their standard deviations (p,)."""
        products = self._products(columns)
        inverse = products.inverse()
        found = inverse @ products.right
        fitted = found @ products.inner @ found - 2.0 * found @ products.right
        variance = float(self.left @ self.left + fitted) / self._rows_free
        return found, np.sqrt(np.diag(inverse) * max(variance, 1.0))

    @property
    def _rows_free(self) -> int:
        return max(1, len(self.left) - int(self.basis.shape[1]))

    def _products(self, columns: LawColumns) -> Normal:
        """Return the products of what others leave of columns (p, p), and with ``left``."""
        count, chunks = len(self.stack.names), self.stack.chunks
        basis = self.basis.reshape(count, -1, self.basis.shape[1])
        left = self.left.reshape(count, -1)
        width = columns.mix.shape[2]
        held, inner, right = (
            np.zeros((basis.shape[2], width)),
            np.zeros((width, width)),
            np.zeros(width),
        )
        for rows in chunks:
            held += basis[:, rows].reshape(-1, len(held)).T @ columns(rows)
        for rows in chunks:
            clear = columns(rows) - basis[:, rows].reshape(-1, len(held)) @ held
            inner += clear.T @ clear
            right += left[:, rows].ravel() @ clear
        return Normal(inner, right)

    def profile(
        self, make: Callable[[float], LawColumns], low: float, high: float, unit: str
    ) -> IntervalValue:
        """Return the value of a shape that fits best, and where the fit is 3.84 worse."""
        grid = np.linspace(low, high, GRID)
        gains = np.array([self.gain(make(float(g))) for g in grid])
        at = int(np.argmax(gains))
        fine = np.linspace(grid[max(at - 1, 0)], grid[min(at + 1, GRID - 1)], GRID)
        more = np.array([self.gain(make(float(g))) for g in fine])
        grid, gains = np.concatenate([grid, fine]), np.concatenate([gains, more])
        order = np.argsort(grid, kind="stable")
        grid, gains = grid[order], gains[order]
        best = int(np.argmax(gains))
        inside = np.flatnonzero(gains >= gains[best] - NORMAL_95**2)
        return IntervalValue(
            value=float(grid[best]),
            low=float(_crossing(grid, gains, inside[0], -1, gains[best])),
            high=float(_crossing(grid, gains, inside[-1], 1, gains[best])),
            unit=unit,
        )


def _crossing(grid: Array, gains: Array, at: int, step: int, best: float) -> float:
    """Return where the gain falls below its limit beyond grid point ``at``."""
    beyond = at + step
    if not 0 <= beyond < len(grid):
        return float(grid[at])
    limit = best - NORMAL_95**2
    share = (gains[at] - limit) / max(gains[at] - gains[beyond], 1e-300)
    return float(grid[at] + np.clip(share, 0.0, 1.0) * (grid[beyond] - grid[at]))
