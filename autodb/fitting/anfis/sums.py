"""What rows say about consequents, as sums: they can be added, taken away and put together.

With premises fixed the consequents are a Bayesian linear regression. Its prior is the plain
regression plane in every rule, with the ridge's precision; rows enter by ΦᵀΦ, Φᵀy, yᵀy and n only
(information form of recursive least squares, Φ and y scaled and less the plane), so their order
does not matter and what was added can be subtracted.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Sums:
    """ΦᵀΦ (p, p), Φᵀy (p,), yᵀy and the number of rows."""

    gram: Array
    right: Array
    total: float
    rows: int

    def __add__(self, other: "Sums") -> "Sums":
        """Return the sums of both sets of rows."""
        return Sums(
            self.gram + other.gram,
            self.right + other.right,
            self.total + other.total,
            self.rows + other.rows,
        )

    def __sub__(self, other: "Sums") -> "Sums":
        """Return the sums without the rows of the other, which must be among these."""
        return Sums(
            self.gram - other.gram,
            self.right - other.right,
            self.total - other.total,
            self.rows - other.rows,
        )

    def left(self, consequents: Array) -> float:
        """Return the sum of squared residuals of consequents less the plane (p,)."""
        spread = self.total - 2.0 * float(self.right @ consequents)
        return max(spread + float(consequents @ self.gram @ consequents), 0.0)


@dataclass(frozen=True)
class Posterior:
    """Mode of the consequents less the plane (p,), and L⁻¹ (p, p) of ΦᵀΦ + λ1 = L Lᵀ.

    ``freedom`` is n − tr(ΦᵀΦ (ΦᵀΦ + λ1)⁻¹): what the rows leave after the consequents.
    """

    mode: Array
    root: Array
    freedom: float


def consequent_sums(design: Array, left: Array) -> Sums:
    """Return the sums of columns (n, p) and what the plane leaves of the values (n,), scaled."""
    return Sums(design.T @ design, design.T @ left, float(left @ left), len(left))


def posterior(rows: Sums, ridge: float) -> Posterior:
    """Return what the rows and the prior say about the consequents."""
    p = len(rows.right)
    factor = np.linalg.cholesky(rows.gram + ridge * np.eye(p))
    root = np.asarray(solve_triangular(factor, np.eye(p), lower=True))
    mode = root.T @ (root @ rows.right)
    used = p - ridge * float(np.sum(root**2))
    return Posterior(mode, root, rows.rows - used)
