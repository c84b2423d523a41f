"""What rows of one group share: components of variance of a linear model with random effects.

e = X a + Z b_g + ε, b_g ~ N(0, B) one draw a group g, ε ~ N(0, σ² + k) one a row, k known: σ² and B
by restricted maximum likelihood (Patterson, Thompson 1971, Biometrika 58:545; Laird, Ware 1982,
Biometrics 38:963), which counts what the columns X have taken up.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.linear import check_rank, triangle
from autodb.fitting.rounds import NotSettled

Array = NDArray[np.float64]

ROWS_A_GROUP = 2
"""Mean number of rows from which on a group's share and a row's own are told apart."""
STARTS = (0.3, 0.03, 1.0)
"""Sizes of the groups' effects, shares of the scatter, from which the likelihood is climbed."""
MOST_STEPS, SETTLED = 50, 1e-8
"""Newton's steps that end a climb, and their length in standard errors at which they do."""
FLAT = 1e-10
"""Share of the greatest curvature that each direction is taken to have at least."""
WIDTH = 1e-5
"""Half width of differences of the gradient, in shares of the scatter."""
ALIKE = 1e-6
"""Difference of variances, in shares of the scatter's, up to which two optima are one."""
LEAST = 1e-4
"""Share of the scatter that a row's own error has at least."""
NORMAL_95 = 1.959963984540054


@dataclass(frozen=True)
class Components:
    """``own``: variance of a row's own error beyond the known. ``between`` (q, q): covariance of a
    group's effects. ``effects`` (g, q): the groups' own, as far as the rows tell (BLUP), and
    ``of`` (n,) the index of each row's.
    """

    own: float
    between: Array
    effects: Array
    of: NDArray[np.intp]

    @property
    def widened(self) -> Array:
        """``between`` so that normal 95 % intervals of a new group hold as Student's would.

        g groups tell a variance with g − 1 degrees of freedom.
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
    on average tell none: all of it is the rows' own. Raises Undetermined where the columns do not
    stand apart.
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
    optima, likely = _optima(rows)
    root = sum(p * one.root @ one.root.T for p, one in zip(likely, optima, strict=True))
    effects = sum(p * one.effects for p, one in zip(likely, optima, strict=True))
    to_own = scatter * to_unit
    return Components(
        own=scatter**2 * float(sum(p * one.own for p, one in zip(likely, optima, strict=True))),
        between=to_own @ root @ to_own.T,
        effects=effects @ to_own.T,
        of=of.ravel(),
    )


def _all_own(design: Array, values: Array, known: Array) -> float:
    """Return the variance beyond the known where no group shares any: n − p degrees of freedom."""
    left = values - design @ np.linalg.lstsq(design, values, rcond=None)[0]
    freedom = max(1, len(values) - design.shape[1])
    return float(max(0.0, (left @ left) / freedom - np.mean(known)))


def _optima(rows: "_Rows") -> tuple[list["_Point"], Array]:
    """Return the points at which the rows are likeliest, and how probable each is beside others.

    The likelihood may have more optima than one; one that is as high as another within its own
    noise is not taken in its place, but counts as much.
    """
    found: list[_Point] = []
    for share in STARTS:
        point = _climbed(rows, share)
        if not any(one.is_like(point) for one in found):
            found.append(point)
    likely = np.exp(-0.5 * np.array([one.misfit - found[0].misfit for one in found]))
    return found, likely / likely.sum()


def _climbed(rows: "_Rows", share: float) -> "_Point":
    """Return the optimum near the point where groups' effects have a share of the scatter."""
    from scipy.optimize import minimize

    q = rows.shared.shape[1]
    start = np.concatenate([[np.sqrt(0.5)], share * np.eye(q)[np.tril_indices(q)]])
    near = minimize(
        lambda at: rows.at(at).misfit,
        start,
        jac=lambda at: rows.at(at).gradient,
        hess=rows.curvature,
        method="trust-exact",
    ).x
    for _ in range(MOST_STEPS):
        point = rows.at(near)
        curved, ways = np.linalg.eigh(rows.curvature(near))
        curved = np.maximum(curved, FLAT * curved[-1])
        down = ways.T @ point.gradient
        length = float(np.sqrt(np.sum(down**2 / curved) / 2.0))
        if length < SETTLED:
            return point
        near = near - ways @ (down / curved)
    raise NotSettled(f"components of variance still move by {length:.2g} standard errors a step")


def _root(values: Array, q: int) -> Array:
    root = np.zeros((q, q))
    root[np.tril_indices(q)] = values
    return root


@dataclass(frozen=True)
class _Point:
    """Where the likelihood is looked at: −2 ln of it up to a constant, its gradient, and there a
    row's own variance, the root of B and the groups' effects (g, q), B Zᵀ V⁻¹ e.
    """

    misfit: float
    gradient: Array
    own: float
    root: Array
    effects: Array

    def is_like(self, other: "_Point") -> bool:
        """Whether both are one optimum: signs of a root are of no matter."""
        off = self.root @ self.root.T - other.root @ other.root.T
        return abs(self.own - other.own) < ALIKE and bool(np.max(np.abs(off)) < ALIKE)


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
        """Return the point at s, σ² = LEAST + s², and the triangle of B's root.

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
        felt = self._by_group(self.shared * left[:, None])
        gone = root @ np.linalg.solve(kernel, root.T @ inner)
        through = cross - inner @ taken
        spread = inner - inner @ gone
        spread = spread - through[:, :, :p] @ np.linalg.solve(fixed, through[:, :, :p].mT)
        by_root = 2.0 * (spread.sum(axis=0) - felt.T @ felt) @ root
        squared = self._by_group(weighed[:, :, None] * weighed[:, None, :])
        lost = np.linalg.solve(kernel, root.T @ squared @ root)
        trace = np.sum(1.0 / variance) - np.trace(lost, axis1=1, axis2=2).sum()
        trace -= np.trace(np.linalg.solve(fixed, solved[:, :p].T @ solved[:, :p]))
        by_own = 2.0 * at[0] * (trace - left @ left)
        gradient = np.concatenate([[by_own], by_root[np.tril_indices(q)]])
        return _Point(misfit, gradient, float(own), root, felt @ root @ root.T)

    def curvature(self, at: Array) -> Array:
        """Return the Hessian of the misfit, by differences of its gradient."""
        columns = [
            (self.at(at + step).gradient - self.at(at - step).gradient) / (2.0 * WIDTH)
            for step in WIDTH * np.eye(len(at))
        ]
        return 0.5 * (np.array(columns) + np.array(columns).T)

    def _by_group(self, values: Array) -> Array:
        return np.asarray(np.add.reduceat(values, self.first))
