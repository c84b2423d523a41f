"""What rows of one group share: components of variance of a linear model with random effects.

e = X a + Z b_g + ε, b_g ~ N(0, B) one draw a group g, ε ~ N(0, σ² + k) one a row, k known: σ² and B
by restricted maximum likelihood (Patterson, Thompson 1971, Biometrika 58:545; Laird, Ware 1982,
Biometrics 38:963), which counts what the columns X have taken up.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.linear import check_rank, triangle

Array = NDArray[np.float64]

ROWS_A_GROUP = 2
"""Mean number of rows from which on a group's share and a row's own are told apart."""
START = 0.3
"""Size of the groups' effects, a share of the scatter, from which the likelihood is climbed."""
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
        known[order] / scatter**2,
    )
    best = _climbed(rows)
    root = scatter * to_unit @ _root(best[1:], q)
    own = scatter**2 * float(np.exp(best[0]))
    effects = scatter * rows.effects(best) @ to_unit.T
    return Components(own, root @ root.T, effects, of.ravel())


def _all_own(design: Array, values: Array, known: Array) -> float:
    """Return the variance beyond the known where no group shares any: n − p degrees of freedom."""
    left = values - design @ np.linalg.lstsq(design, values, rcond=None)[0]
    freedom = max(1, len(values) - design.shape[1])
    return float(max(0.0, (left @ left) / freedom - np.mean(known)))


def _climbed(rows: "_Rows") -> Array:
    """Return ln σ² and the triangle of B's root at which the rows are likeliest."""
    from scipy.optimize import minimize

    q = rows.shared.shape[1]
    triangle_of_b = len(np.tril_indices(q)[0])
    start = np.concatenate([[np.log(0.5)], START * np.eye(q)[np.tril_indices(q)]])
    bounds = [(np.log(LEAST), None), *[(None, None)] * triangle_of_b]
    return np.asarray(minimize(rows.misfit, start, method="L-BFGS-B", bounds=bounds).x)


def _root(values: Array, q: int) -> Array:
    root = np.zeros((q, q))
    root[np.tril_indices(q)] = values
    return root


@dataclass(frozen=True)
class _Rows:
    design: Array
    shared: Array
    values: Array
    first: NDArray[np.intp]
    known: Array

    def misfit(self, at: Array) -> float:
        """Return −2 ln of the restricted likelihood, up to a constant."""
        p = self.design.shape[1]
        both = np.column_stack([self.design, self.values])
        variance, cross, kernel = self._reduced(at, both)
        products = both.T @ (both / variance[:, None])
        products -= np.einsum("gqi,gqj->ij", cross, np.linalg.solve(kernel, cross))
        fixed = products[:p, :p]
        left = products[p, p] - products[p, :p] @ np.linalg.solve(fixed, products[:p, p])
        sizes = np.log(variance).sum() + np.linalg.slogdet(kernel)[1].sum()
        return float(sizes + np.linalg.slogdet(fixed)[1] + left)

    def effects(self, at: Array) -> Array:
        """Return each group's effects (g, q) as far as the rows tell: B Zᵀ V⁻¹ e."""
        root = _root(at[1:], self.shared.shape[1])
        _, cross, kernel = self._reduced(at, self.values[:, None])
        return np.asarray(np.linalg.solve(kernel, cross)[:, :, 0] @ root.T)

    def _reduced(self, at: Array, both: Array) -> tuple[Array, Array, Array]:
        """Return rows' variances D, and group by group Rᵀ Zᵀ D⁻¹ both and 1 + Rᵀ Zᵀ D⁻¹ Z R."""
        variance = np.exp(at[0]) + self.known
        q = self.shared.shape[1]
        root = _root(at[1:], q)
        weighed = self.shared / variance[:, None]
        cross = np.add.reduceat(weighed[:, :, None] * both[:, None, :], self.first)
        inner = np.add.reduceat(weighed[:, :, None] * self.shared[:, None, :], self.first)
        return variance, root.T @ cross, np.eye(q) + root.T @ inner @ root
