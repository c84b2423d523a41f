"""What rows of one group share: components of variance of a linear model with random effects.

e = X a + Z b_g + ε, b_g ~ N(0, B) one draw a group g, ε ~ N(0, σ² + k) one a row, k known: σ² and B
by restricted maximum likelihood (Patterson, Thompson 1971, Biometrika 58:545; Laird, Ware 1982,
Biometrics 38:963), which counts what the columns X have taken up.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.linear import check_rank, triangle
from autodb.fitting.optimum import optima

Array = NDArray[np.float64]

ROWS_A_GROUP = 2
"""Mean number of rows from which on a group's share and a row's own are separated."""
STARTS = (0.3, 0.03, 1.0)
"""Sizes of the groups' effects, shares of the scatter, from which the likelihood is climbed."""
OWN_START = 0.7
"""A row's own error there, as a share of the scatter."""
LEAST = 1e-4
"""Share of the scatter that a row's own error has at least."""
NORMAL_95 = 1.959963984540054


@dataclass(frozen=True)
class Components:
    """``own``: variance of a row's own error beyond the known. ``between`` (q, q): covariance of a
    group's effects. ``effects`` (g, q): the groups' own, as far as the rows show (BLUP), and
    ``of`` (n,) the index of each row's.
    """

    own: float
    between: Array
    effects: Array
    of: NDArray[np.intp]

    @property
    def widened(self) -> Array:
        """``between`` so that normal 95 % intervals of a new group hold as Student's would.

        g groups determine a variance with g − 1 degrees of freedom.
        """
        return self.between * small_sample(len(self.effects) - 1)


def small_sample(freedom: int) -> float:
    """Return by how much a variance of so many degrees of freedom is to be taken larger.

    So that normal 95 % intervals are as wide as Student's.
    """
    from scipy import stats

    return float(np.square(stats.t.ppf(0.975, max(1, freedom)) / NORMAL_95))


def components(
    design: Array, shared: Array, values: Array, groups: NDArray[np.generic], *, known: Array
) -> Components:
    """Return the components of values (n,): columns X (n, p), Z (n, q), group of each row (n,).

    ``known`` (n,): variance of each row that is known already. Fewer than ROWS_A_GROUP rows a group
    on average determine none: all of it is the rows' own. Raises Undetermined where the columns do
    not stand apart.
    """
    names, of = np.unique(groups, return_inverse=True)
    g, q = len(names), shared.shape[1]
    own = _all_own(design, values, known)
    if len(values) < ROWS_A_GROUP * g or own == 0.0:
        return Components(own, np.zeros((q, q)), np.zeros((g, q)), of.ravel())
    reduced = triangle(shared, values)
    check_rank(reduced)
    to_unit = np.linalg.inv(reduced.factor[:q, :q] * reduced.scale) * np.sqrt(len(values))
    scatter = float(np.sqrt(own + np.mean(known)))
    order = np.argsort(of.ravel(), kind="stable")
    rows = _Rows(
        design[order],
        (shared @ to_unit)[order],
        values[order] / scatter,
        np.searchsorted(of.ravel()[order], np.arange(g)),
        of.ravel()[order],
        known[order] / scatter**2,
    )
    found = _optima(rows)
    to_own = scatter * to_unit
    between = sum(p * one.root @ one.root.T for p, one in found)
    return Components(
        own=scatter**2 * sum(p * one.own for p, one in found),
        between=to_own @ between @ to_own.T,
        effects=sum(p * one.effects for p, one in found) @ to_own.T,
        of=of.ravel(),
    )


def _all_own(design: Array, values: Array, known: Array) -> float:
    """Return the variance beyond the known where no group shares any: n − p degrees of freedom."""
    left = values - design @ np.linalg.lstsq(design, values, rcond=None)[0]
    freedom = max(1, len(values) - design.shape[1])
    return float(max(0.0, (left @ left) / freedom - np.mean(known)))


def _optima(rows: "_Rows") -> list[tuple[float, "_Point"]]:
    """Return the points at which the rows are likeliest, each with its probability."""
    q = rows.shared.shape[1]
    triangle_of_one = np.eye(q)[_lower(q)]

    def misfit(at: Array) -> tuple[float, Array]:
        point = rows.at(at)
        return point.misfit, point.gradient

    def numbers(at: Array) -> Array:  # the signs of a root are of no matter
        root = _root(at[1:], q)
        return np.concatenate([[at[0] ** 2], (root @ root.T).ravel()])

    starts = [np.concatenate([[OWN_START], share * triangle_of_one]) for share in STARTS]
    return [(p, rows.at(at)) for p, at in optima(misfit, starts, numbers=numbers)]


@cache
def _lower(q: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return where a triangle (q, q) has numbers."""
    return np.tril_indices(q)


def _root(values: Array, q: int) -> Array:
    """Return the symmetric root of B from its lower triangle.

    One with a zero above its diagonal is not single where B has a direction without variance: its
    last numbers then turn on a circle along which the likelihood is one.
    """
    root = np.zeros((q, q))
    root[_lower(q)] = values
    return root + np.tril(root, -1).T


@dataclass(frozen=True)
class _Point:
    """A point of the likelihood: −2 ln of it up to a constant, its gradient, and there a
    row's own variance, the root of B and the groups' effects (g, q), B Zᵀ V⁻¹ e.
    """

    misfit: float
    gradient: Array
    own: float
    root: Array
    effects: Array


@dataclass(frozen=True)
class _Rows:
    """Rows group by group: ``first`` of each, ``of`` (n,) the group of each."""

    design: Array
    shared: Array
    values: Array
    first: NDArray[np.intp]
    of: NDArray[np.intp]
    known: Array

    def at(self, at: Array) -> _Point:
        """Return the point at s, σ² = LEAST + s², and the lower triangle of B's root.

        With P = V⁻¹ − V⁻¹ X (Xᵀ V⁻¹ X)⁻¹ Xᵀ V⁻¹, of a change V̇ of V the misfit changes by
        tr(P V̇) − eᵀ P V̇ P e.
        """
        p, q = self.design.shape[1], self.shared.shape[1]
        own, root = LEAST + at[0] ** 2, _root(at[1:], q)
        variance = own + self.known
        both = np.column_stack([self.design, self.values])
        weighed = self.shared / variance[:, None]
        cross = self._by_group(weighed[:, :, None] * both[:, None, :])
        inner = self._by_group(weighed[:, :, None] * self.shared[:, None, :])
        kernel = np.eye(q) + root.T @ inner @ root
        taken = root @ np.linalg.solve(kernel, root.T @ cross)
        solved = both / variance[:, None] - np.einsum("nq,nqk->nk", weighed, taken[self.of])
        fixed = both[:, :p].T @ solved[:, :p]
        law = np.linalg.solve(fixed, both[:, :p].T @ solved[:, p])
        left = solved[:, p] - solved[:, :p] @ law
        sizes = np.log(variance).sum() + np.linalg.slogdet(kernel)[1].sum()
        misfit = float(sizes + np.linalg.slogdet(fixed)[1] + self.values @ left)
        sensed = self._by_group(self.shared * left[:, None])
        gone = root @ np.linalg.solve(kernel, root.T @ inner)
        through = cross - inner @ taken
        spread = inner - inner @ gone
        spread = spread - through[:, :, :p] @ np.linalg.solve(fixed, through[:, :, :p].mT)
        by_root = 2.0 * (spread.sum(axis=0) - sensed.T @ sensed) @ root
        squared = self._by_group(weighed[:, :, None] * weighed[:, None, :])
        lost = np.linalg.solve(kernel, root.T @ squared @ root)
        trace = np.sum(1.0 / variance) - np.trace(lost, axis1=1, axis2=2).sum()
        trace -= np.trace(np.linalg.solve(fixed, solved[:, :p].T @ solved[:, :p]))
        by_own = 2.0 * at[0] * (trace - left @ left)
        by_both = by_root + np.tril(by_root.T, -1)
        gradient = np.concatenate([[by_own], by_both[_lower(q)]])
        return _Point(misfit, gradient, float(own), root, sensed @ root @ root.T)

    def _by_group(self, values: Array) -> Array:
        return np.asarray(np.add.reduceat(values, self.first))
