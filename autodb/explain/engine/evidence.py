"""Evidence that white rows hold an effect: how much likelier they are with it than without.

Own columns are free without a prior: a simulation may have been refitted to the very recording. A
candidate's p columns have coefficients of size τ (normal, each column scaled to one size), and τ is
the one that makes the rows likeliest (empirical Bayes). Twice the gain of the log-likelihood is

    max over τ of Σᵢ [τ²bᵢ²/(1 + τ²λᵢ) − ln(1 + τ²λᵢ)]

with λ the eigenvalues of the columns' inner products after own and accepted columns are projected
out and b the products with the difference along the eigenvectors, both over the noise variance. So
a smooth curve of many columns pays only for the directions that it uses. Source: MacKay 1992,
Bayesian interpolation (evidence of a linear model).
"""

from collections.abc import Callable, Iterable, Sequence
from copy import copy
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Keys = Sequence[tuple[str, int]]

SIZES = np.exp(np.linspace(np.log(0.3), np.log(3e5), 25))
"""Values of τ²·λ̄ that are tried, λ̄ the mean eigenvalue: signal to noise from weak to clear."""
SPANNED = 1e-6
"""A column of which other columns leave less than this share adds nothing."""


@dataclass(frozen=True)
class ExplainedShare:
    """What a candidate's columns explain.

    ``full``: fall of the sum of squares over the noise variance with free coefficients;
    ``evidence``: the same less what its freedom costs; ``coefficients`` (p,) free, and ``sd``;
    ``size``: the τ² at which the evidence is greatest.
    """

    full: float
    evidence: float
    coefficients: Array
    sd: Array
    size: float = float(SIZES[0])

    @property
    def cost(self) -> float:
        """What the freedom of its columns costs."""
        return self.full - self.evidence


NOTHING = ExplainedShare(0.0, 0.0, np.zeros(0), np.zeros(0))


class Products:
    """Inner products (K + 1, K + 1) of white rows: of the difference, ``own`` columns, then blocks.

    ``widths``: columns of each block by key, in their order; ``variance`` of a white row.
    """

    def __init__(
        self,
        inner: Array,
        *,
        own: int,
        widths: dict[tuple[str, int], int],
        rows: int,
        variance: float,
    ) -> None:
        norm = np.sqrt(np.maximum(np.diag(inner), 0.0))
        norm[norm == 0] = 1.0
        self.inner, self.norm, self.variance = inner / np.outer(norm, norm), norm, variance
        self.rows = rows
        self.own = np.arange(1, 1 + own)
        ends = np.cumsum([1 + own, *widths.values()])
        self.places = {key: np.arange(ends[i], ends[i + 1]) for i, key in enumerate(widths)}
        self._given: dict[frozenset[tuple[str, int]], Given] = {}

    def with_held(self, own: Sequence[int]) -> Self:
        """Return the same with some own columns left as they are, by their numbers."""
        held = copy(self)
        held.own = np.delete(self.own, list(own))
        held._given = {}
        return held

    def freed(self) -> Self:
        """Return the same with own columns that nothing is known of."""
        return self

    def given(self, keys: Keys) -> "Given":
        """Return the products after own columns and those of ``keys`` are projected out."""
        known = frozenset(keys)
        if known not in self._given:
            at = np.concatenate([self.own, *(self.places[key] for key in keys)]).astype(np.intp)
            self._given[known] = Given(self, at)
        return self._given[known]


class Given:
    """Products after some columns are projected out; what is left is worked out where asked."""

    def __init__(self, products: Products, columns: NDArray[np.intp]) -> None:
        self.of = products
        self.columns = columns
        self._gains: dict[tuple[str, int], ExplainedShare] = {}
        self._basis = np.zeros((0, 0))
        if len(columns):
            values, vectors = np.linalg.eigh(products.inner[columns[:, None], columns])
            keep = values > SPANNED * 1e-2 * values[-1]
            self._basis = vectors[:, keep] / np.sqrt(values[keep])
        self._difference = self._along(0)

    def _along(self, at: NDArray[np.intp] | int) -> Array:
        """Return columns, or one, along the columns projected out (q, p), worked out where asked:
        all of those of many sets would fill the memory.
        """
        rows = self.columns if np.ndim(at) == 0 else self.columns[:, None]
        return np.asarray(self._basis.T @ self.of.inner[rows, at])

    @property
    def explained(self) -> float:
        """Share of the difference's squares that the columns projected out explain."""
        return float(self._difference @ self._difference)

    @property
    def rss(self) -> float:
        """Residual sum of squares over the noise variance."""
        left = 1.0 - self.explained
        return max(left, 1e-15) * float(self.of.norm[0]) ** 2 / self.of.variance

    def coefficients(self) -> Array:
        """Return the coefficients of the columns projected out, in their order."""
        if not len(self.columns):
            return np.zeros(0)
        scaled = self._basis @ self._difference
        return np.asarray(scaled * self.of.norm[0] / self.of.norm[self.columns])

    def single(self, at: NDArray[np.intp]) -> tuple[Array, Array]:
        """Return evidence and coefficient (k,) of single columns, each alone; 0 of nothing left.

        With one column the likeliest τ²λ is b²/λ − 1.
        """
        held = self._along(at)
        left = np.maximum(self.of.inner[at, at] - np.einsum("ij,ij->j", held, held), 0.0)
        along = self.of.inner[at, 0] - held.T @ self._difference
        some = left > SPANNED
        size = np.where(some, along / np.where(some, left, 1.0), 0.0)
        full = size * along * self.of.norm[0] ** 2 / self.of.variance
        spread = np.clip(full - 1.0, SIZES[0], SIZES[-1])
        gained = np.maximum(full * spread / (1.0 + spread) - np.log1p(spread), 0.0)
        return self.worth(full, full - gained), size * self.of.norm[0] / self.of.norm[at]

    def worth(self, full: Array, cost: Array) -> Array:
        """Return the evidence where the sum of squares falls by ``full``, with what that costs."""
        return np.asarray(full - cost)

    def gain(
        self, key: tuple[str, int], *, allowed: Callable[[Array], bool] | None = None
    ) -> ExplainedShare:
        """Return what the columns of ``key`` explain of what is left; nothing if not allowed."""
        if key not in self._gains:
            self.work_out([key])
        gain = self._gains[key]
        if gain is NOTHING or allowed is None or allowed(gain.coefficients):
            return gain
        return NOTHING

    def work_out(self, keys: Iterable[tuple[str, int]]) -> None:
        """Work out what the columns of each of some keys explain: those of as many together."""
        alike: dict[int, list[tuple[str, int]]] = {}
        for key in keys:
            if key not in self._gains:
                alike.setdefault(len(self.of.places[key]), []).append(key)
        for some in alike.values():
            at = np.array([self.of.places[key] for key in some])
            self._gains.update(zip(some, self._shares(at, *self._left(at)), strict=True))

    def gain_of(self, at: NDArray[np.intp]) -> ExplainedShare:
        """Return what columns at some places explain of what is left, free or all alike."""
        matrix, right = self._left(at[None])
        mix = (self.of.norm[at] / np.linalg.norm(self.of.norm[at]))[:, None]
        free = self._shares(at[None], matrix, right)
        alike = self._shares(at[None, :1], mix.T @ matrix @ mix, right @ mix)
        return max(*free, *alike, key=lambda gain: gain.evidence)

    def left_of(self, key: tuple[str, int]) -> float:
        """Return what is left of the squares of a block's columns, each of size one."""
        return float(np.trace(self._left(self.of.places[key][None])[0][0]))

    def _left(self, at: NDArray[np.intp]) -> tuple[Array, Array]:
        """Return of k sets of p columns (k, p) what is left of their products with each other,
        (k, p, p), and with the difference, (k, p).
        """
        along = self._along(at.ravel()).reshape(self._basis.shape[1], *at.shape)  # p may be 0
        held = np.moveaxis(along, 0, 2)
        matrix = self.of.inner[at[:, :, None], at[:, None, :]] - held @ held.transpose(0, 2, 1)
        return matrix, self.of.inner[at, 0] - held @ self._difference

    def _shares(self, at: NDArray[np.intp], matrix: Array, right: Array) -> list[ExplainedShare]:
        """Return what each of k sets of columns explains, of what is left of their products.

        ``at`` (k, p): columns of their size.
        """
        values, vectors = np.linalg.eigh(matrix)
        keep = values > SPANNED
        kept = np.count_nonzero(keep, axis=1)
        inverse = np.where(keep, 1.0 / np.where(keep, values, 1.0), 0.0)
        along = (right[:, None, :] @ vectors)[:, 0]
        scaled = (vectors @ (along * inverse)[:, :, None])[:, :, 0]
        size, variance = self.of.norm[0], self.of.variance
        squares = along**2 * inverse * (size**2 / variance)
        spread = np.sqrt((vectors**2 @ inverse[:, :, None])[:, :, 0] * variance)
        greatest, sizes = _greatest_evidence(squares, np.where(keep, values, 0.0), kept)
        full, evidence = self._counted(squares.sum(axis=1), greatest)
        coefficients, sd = scaled * size / self.of.norm[at], spread / self.of.norm[at]
        return [
            ExplainedShare(
                float(full[k]), float(evidence[k]), coefficients[k], sd[k], float(sizes[k])
            )
            if some
            else NOTHING
            for k, some in enumerate(kept)
        ]

    def _counted(self, full: Array, evidence: Array) -> tuple[Array, Array]:
        """Return by how much twice the log-likelihood rises where squares fall by ``full``, and
        its evidence.
        """
        return full, evidence


def _greatest_evidence(
    squares: Array, values: Array, kept: NDArray[np.intp]
) -> tuple[Array, Array]:
    """Return the greatest of the evidence over τ, not below 0 (τ = 0), and its τ², both (k,).

    ``squares`` (k, p): fall of the sum of squares along each direction; ``values`` (k, p), 0 where
    there is none, of which ``kept`` (k,) are.
    """
    mean = values.sum(axis=1) / np.maximum(kept, 1)
    mean[kept == 0] = 1.0
    spread = SIZES[:, None, None] * (values / mean[:, None])
    total = np.sum(squares * (spread / (1.0 + spread)) - np.log1p(spread), axis=2)
    best = np.argmax(total, axis=0)
    greatest = np.take_along_axis(total, best[None], axis=0)[0]
    return np.maximum(greatest, 0.0), SIZES[best] / mean
