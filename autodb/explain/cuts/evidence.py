"""Evidence for effects in a table of cuts: few rows, whose scatter is itself only estimated.

With scatter estimated with ν degrees of freedom, twice the log-likelihood of a sum of squares s
of N rows over the variance is, but for a constant, −(ν + N) ln(1 + s/ν): its slope is 1 where s is
as expected, and less where everything fits badly, so that a short table names nothing by luck.
Before anything was found the size of the scatter is not known at all, as the difference may hold
far more than any model that is freed at once: −N ln s then. The sums are of inner products, taken
once of everything that the forces may hold, in chunks of cuts.
"""

from collections.abc import Sequence
from copy import copy
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from autodb.explain.cuts.candidates.laws import LawColumns, SpreadLaw
from autodb.explain.cuts.stack import Stack
from autodb.explain.engine.candidates import Candidate, Choice
from autodb.explain.engine.evidence import Given, Keys, Products
from autodb.explain.engine.search import DETAIL, CandidateSearch, FoundSet

Array = NDArray[np.float64]

EXACT = 1e-4
"""Share of the first guess of the variance that scatter is at least."""


class TableProducts(Products):
    """Inner products with ``freedom`` of the white difference.

    Its variance is 1, or, where that is not ``known``, only as far as weights go. ``prior`` (own,):
    precision of own columns' coefficients, as of one more row for each that has any; none of a
    column that is left as it is, whose change is looked at like any effect's.
    """

    def __init__(
        self,
        inner: Array,
        *,
        prior: Array,
        widths: dict[tuple[str, int], int],
        rows: int,
        freedom: float,
        known: bool,
    ) -> None:
        own = len(prior)
        super().__init__(inner, own=own, widths=widths, rows=rows, variance=1.0)
        self.prior = prior / self.norm[self.own] ** 2
        self.inner[self.own, self.own] += self.prior
        self.freedom, self.known = freedom, known
        self.rows_free = max(1.0, rows - own)
        self._seen: dict[frozenset[tuple[str, int]], TableGiven] = {}

    def with_held(self, own: Sequence[int]) -> Self:
        """Return the same with some own columns left as they are, by their numbers."""
        return super().with_held(own)._without_prior(self.own[list(own)])

    def freed(self) -> Self:
        """Return the same with own columns that nothing is known of."""
        return copy(self)._without_prior(self.own)

    def _without_prior(self, at: NDArray[np.intp]) -> Self:
        self._seen, self.inner = {}, self.inner.copy()
        self.inner[at, at] -= self.prior[at - 1]
        return self

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
        super().__init__(products, columns)
        self.of: TableProducts = products

    @cached_property
    def rss(self) -> float:
        """Residual sum of squares over the noise variance."""
        return float(max(1.0 - self.explained, 1e-15) * self.of.norm[0] ** 2)

    def worth(self, full: Array, cost: Array) -> Array:
        """Return the evidence where the sum of squares falls by ``full``, with what that costs."""
        after = self.of.likelihoods(np.maximum(self.rss - full, 0.0))
        return np.asarray(np.maximum(after - self.of.likelihood(self.rss) - cost, 0.0))

    def _counted(self, full: Array, evidence: Array) -> tuple[Array, Array]:
        """Return by how much twice the log-likelihood rises where squares fall by ``full``, and
        its evidence.
        """
        after = self.of.likelihoods(np.maximum(self.rss - full, 0.0))
        rise = after - self.of.likelihood(self.rss)
        return rise, np.maximum(rise - (full - evidence), 0.0)


class TableSearch(CandidateSearch):
    """The search over sets that hold ``laws``, with the likelihood of a table."""

    def __init__(
        self,
        products: TableProducts,
        candidates: tuple[Candidate, ...],
        laws: tuple[Choice, ...] = (),
    ) -> None:
        self.products: TableProducts = products
        super().__init__(products, candidates, begin=laws)

    def scored(self, choices: tuple[Choice, ...]) -> FoundSet:
        """Return the set with its score."""
        found = super().scored(choices)
        before, after = self._rss(()), self._rss(choices)
        likelihood = self.products.likelihood
        more = likelihood(after) - likelihood(before) - (before - after)
        return FoundSet(choices, found.score + more, found.evidence)

    def _rss(self, choices: tuple[Choice, ...]) -> float:
        return self.products.given([c.key for c in choices]).rss


def products(
    stack: Stack,
    own: Sequence[LawColumns],
    candidates: Sequence[Candidate],
    *,
    freedom: float,
    known: bool,
) -> TableProducts:
    """Return inner products of own columns, all candidates in all shapes, and the difference."""
    blocks: dict[tuple[str, int], LawColumns] = {}
    for candidate in candidates:
        for number, form in enumerate(candidate.forms):
            blocks[candidate.key, number] = _of(form.law)
        if candidate.detail is not None:
            blocks[candidate.key, DETAIL] = _of(candidate.detail)
    inner = _inner(stack, [*own, *blocks.values()])
    widths = [columns.mix.shape[2] for columns in blocks.values()]
    return TableProducts(
        inner,
        prior=np.concatenate([columns.precision for columns in own]),
        widths=dict(zip(blocks, widths, strict=True)),
        rows=stack.simulation.size,
        freedom=freedom,
        known=known,
    )


def _of(build: object) -> LawColumns:
    assert isinstance(build, LawColumns)  # every candidate of a cut table is made of laws
    return build


def _inner(stack: Stack, columns: Sequence[LawColumns]) -> Array:
    """Return the inner products of the white difference and all white columns (K + 1, K + 1)."""
    laws = {id(c.law): c.law for c in columns}
    first = dict(zip(laws, np.cumsum([1, *(law.width for law in laws.values())]), strict=False))
    weight = stack.mixing.T @ stack.mixing
    raw = _by_component(stack, list(laws.values()), weight)
    spread = _spread(columns, first, raw.shape[-1], len(stack.names))
    total = np.zeros((spread[0].shape[1],) * 2)
    for i, of_i in enumerate(spread):
        for j, of_j in enumerate(spread):
            if weight[i, j] != 0.0:
                total += weight[i, j] * (of_i.T @ np.asarray(of_j.T @ raw[i, j].T).T)
    return total


def _by_component(stack: Stack, laws: Sequence[SpreadLaw], weight: Array) -> Array:
    """Return products (C, C, Q + 1, Q + 1) of the laws' columns over the sd."""
    count = len(stack.names)
    width = sum(law.width for law in laws) + 1
    raw = np.zeros((count, count, width, width))
    for rows in stack.chunks:
        difference = (stack.recording - stack.simulation)[:, rows, None]
        built = np.concatenate([difference, *(law.build(rows) for law in laws)], axis=2)
        built /= stack.sd[:, rows, None]
        for i in range(count):
            for j in range(i, count):
                if weight[i, j] != 0.0:
                    raw[i, j] += built[i].T @ built[j]
    for i in range(count):
        for j in range(i):
            raw[i, j] = raw[j, i].T
    return raw


def _spread(
    columns: Sequence[LawColumns], first: dict[int, int], width: int, count: int
) -> list[sparse.csr_array]:
    """Return which columns of the laws add up to which of the stack, by component."""
    at = np.cumsum([1, *(c.mix.shape[2] for c in columns)])
    made = []
    for component in range(count):
        rows, cols, values = [np.zeros(1, int)], [np.zeros(1, int)], [np.ones(1)]
        for c, start in zip(columns, at, strict=False):
            q, p = np.nonzero(c.mix[component])
            rows.append(first[id(c.law)] + q)
            cols.append(start + p)
            values.append(c.mix[component][q, p])
        places = (np.concatenate(rows), np.concatenate(cols))
        shape = (width, int(at[-1]))
        made.append(sparse.csr_array((np.concatenate(values), places), shape=shape))
    return made
