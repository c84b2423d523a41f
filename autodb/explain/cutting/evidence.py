"""Evidence for effects in a table of cuts: few rows, whose scatter is itself only estimated.

With scatter estimated with ν degrees of freedom, twice the log-likelihood of a sum of squares s
of N rows over the variance is, but for a constant, −(ν + N) ln(1 + s/ν): its slope is 1 where s is
as expected, and less where everything fits badly, so that a short table names nothing by luck.
Before anything was found the size of the scatter is not known at all, as the difference may hold
far more than any model that is freed at once: −N ln s then.
"""

from collections.abc import Callable
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from autodb.explain.evidence import (
    NOTHING,
    SPANNED,
    Gain,
    Given,
    Keys,
    Products,
    evidence,
)
from autodb.explain.search import Found, Search
from autodb.explain.suspects import Choice, Suspect

Array = NDArray[np.float64]


EXACT = 1e-4
"""Share of the first guess of the variance that scatter is at least."""


class TableProducts(Products):
    """Inner products taken elsewhere (K + 1, K + 1): difference, ``own`` columns, then blocks.

    ``widths``: columns of each block by key; ``rows`` and ``freedom`` of the white difference,
    whose variance is 1, or, where that is not ``known``, only as far as weights go.
    """

    def __init__(
        self,
        inner: Array,
        *,
        own: int,
        widths: dict[tuple[str, int], int],
        rows: int,
        freedom: float,
        known: bool,
    ) -> None:
        norm = np.sqrt(np.maximum(np.diag(inner), 0.0))
        norm[norm == 0] = 1.0
        self.inner, self.norm, self.variance = inner / np.outer(norm, norm), norm, 1.0
        self.own = np.arange(1, 1 + own)
        ends = np.cumsum([1 + own, *widths.values()])
        self.places = {key: np.arange(ends[i], ends[i + 1]) for i, key in enumerate(widths)}
        self.freedom, self.known = freedom, known
        self.rows_free = max(1.0, rows - own)
        self._seen: dict[frozenset[tuple[str, int]], TableGiven] = {}

    def likelihood(self, rss: float) -> float:
        """Return twice the log-likelihood of a sum of squares, but for a constant."""
        return float(self.likelihoods(np.array(rss)))

    def likelihoods(self, rss: Array) -> Array:
        """Return the same of several sums of squares."""
        if not self.known:
            return np.asarray(-self.rows_free * np.log(rss / self.rows_free + EXACT))
        return np.asarray(-(self.freedom + self.rows_free) * np.log1p(rss / self.freedom))

    def given(self, keys: Keys) -> "TableGiven":
        """Return the products after own columns and those of ``keys`` are projected out."""
        key = frozenset(keys)
        if key not in self._seen:
            at = np.concatenate([self.own, *(self.places[k] for k in keys)]).astype(np.intp)
            self._seen[key] = TableGiven(self, at)
        return self._seen[key]


class TableGiven(Given):
    """The same after some columns are projected out; what is left is worked out where asked."""

    def __init__(self, products: TableProducts, columns: NDArray[np.intp]) -> None:
        self.of: TableProducts = products
        self.columns = columns
        inner = products.inner
        values, vectors = np.linalg.eigh(inner[np.ix_(columns, columns)])
        keep = values > SPANNED * 1e-2 * values[-1]
        self._basis = vectors[:, keep] / np.sqrt(values[keep])
        self._held = self._basis.T @ inner[columns]
        self._gains: dict[tuple[tuple[str, int], bool], Gain] = {}

    @cached_property
    def rss(self) -> float:
        """Residual sum of squares over the noise variance."""
        left = 1.0 - float(np.sum(self._held[:, 0] ** 2))
        return float(max(left, 1e-15) * self.of.norm[0] ** 2)

    def gain(self, key: tuple[str, int], *, allowed: Callable[[Array], bool] | None = None) -> Gain:
        """Return what the columns of ``key`` explain of what is left."""
        known = key, allowed is None
        if known not in self._gains:
            self._gains[known] = self._gain(key, allowed)
        return self._gains[known]

    def worth(self, full: Array, cost: Array) -> Array:
        """Return the evidence where the sum of squares falls by ``full``, with what that costs."""
        after = self.of.likelihoods(np.maximum(self.rss - full, 0.0))
        return np.asarray(np.maximum(after - self.of.likelihood(self.rss) - cost, 0.0))

    def _gain(self, key: tuple[str, int], allowed: Callable[[Array], bool] | None) -> Gain:
        at = self.of.places[key]
        held = self._held[:, at]
        matrix = self.of.inner[np.ix_(at, at)] - held.T @ held
        right = self.of.inner[at, 0] - held.T @ self._held[:, 0]
        found = _explained(matrix, right * self.of.norm[0], self.of.norm[at])
        if found is NOTHING or (allowed is not None and not allowed(found.coefficients)):
            return NOTHING
        after = self.of.likelihood(max(self.rss - found.full, 0.0))
        full = after - self.of.likelihood(self.rss)
        return Gain(full, max(0.0, full - found.cost), found.coefficients, found.sd)


def _explained(matrix: Array, right: Array, norm: Array) -> Gain:
    """Return what columns of unit norm explain, with the variance known; ``norm`` as they were."""
    values, vectors = np.linalg.eigh(matrix)
    keep = values > SPANNED
    if not keep.any():
        return NOTHING
    values, vectors = values[keep], vectors[:, keep]
    along = vectors.T @ right
    full = float(np.sum(along**2 / values))
    sd = np.sqrt(np.sum(vectors**2 / values, axis=1)) / norm
    greatest, size = evidence(along**2, values)
    return Gain(full, greatest, vectors @ (along / values) / norm, sd, size)


class TableSearch(Search):
    """The search over sets, with the likelihood of a table."""

    def __init__(self, products: TableProducts, suspects: tuple[Suspect, ...]) -> None:
        super().__init__(products, suspects)
        self.products: TableProducts = products

    def scored(self, choices: tuple[Choice, ...]) -> Found:
        """Return the set with its score."""
        found = super().scored(choices)
        before, after = self._rss(()), self._rss(choices)
        likelihood = self.products.likelihood
        more = likelihood(after) - likelihood(before) - (before - after)
        return Found(choices, found.score + more, found.evidence)

    def _rss(self, choices: tuple[Choice, ...]) -> float:
        return self.products.given([c.key for c in choices]).rss
