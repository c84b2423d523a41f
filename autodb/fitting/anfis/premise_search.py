"""Variable projection: the premises searched alone, the consequents exact at every step.

For premises ψ the best consequents are θ(ψ) = Φ(ψ)⁺ y; what is left, r(ψ) = y − Φθ, depends on ψ
only, and

    ∂r/∂ψ_k = −P (∂Φ/∂ψ_k) θ − (Φ⁺)ᵀ (∂Φ/∂ψ_k)ᵀ r,    P = 1 − ΦΦ⁺

(Golub and Pereyra 1973, SIAM J. Numer. Anal. 10:413, equation 4.6, exact). Φ has the ridge's rows
√λ·1 below it, so it is never rank deficient. The steps are Levenberg's and Marquardt's, with
columns scaled as Moré (1978) does.

With s_m the share of all rules that ask for set m, f_r the plane of rule r and l = ∂ ln μ_m/∂ψ_k,

    (∂Φ/∂ψ_k) θ  = l · (Σ_{r asks m} share_r f_r − s_m Σ_r share_r f_r)
    (∂Φ/∂ψ_k)ᵀ r = [r asks m] · Φᵀ(l r) − Φᵀ(l s_m r)

so that the exact Jacobian costs little more than Kaufman's approximation. A weak leash to the start
settles what the rows leave open.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dgeqrf, dorgqr, dtrtrs

from autodb.fitting.anfis.premises import Premises, premise_limits, rule_columns
from autodb.fitting.anfis.standardised import LearnerRows

Array = NDArray[np.float64]

DAMPING = 1e-2
LEAST_DAMPING, MOST_DAMPING = 1e-12, 1e10


@dataclass(frozen=True)
class Projected:
    """Consequents less the plane (p,), residual with the ridge's rows (n + p,), Q and R of Φ."""

    consequents: Array
    residual: Array
    design: Array
    q: Array
    r: Array

    @property
    def left(self) -> Array:
        """What the rows have left, (n,)."""
        return self.residual[: len(self.design)]

    @property
    def cost(self) -> float:
        """Sum of squares, the ridge's included."""
        return float(self.residual @ self.residual)


@dataclass(frozen=True)
class Free:
    """Premises as they are searched: logarithms of widths and slopes, centres as they are.

    ``low``, ``high`` and ``start`` (q,) are what is searched at the limits and before the first
    step.
    """

    premises: Premises
    centre: NDArray[np.bool_]
    low: Array
    high: Array
    start: Array

    def leash(self, rows: LearnerRows, here: Array) -> Array:
        """Return the weighed distance from the start, (q,)."""
        return np.asarray(np.sqrt(rows.leash) * (here - self.start))

    def at(self, free: Array) -> Premises:
        """Return the premises at what is searched (q,)."""
        return self.premises.at(
            np.where(self.centre, free, np.exp(np.where(self.centre, 0.0, free)))
        )

    def jacobian(self, rows: LearnerRows, premises: Premises, point: Projected) -> Array:
        """Return d residual / d searched, (n + p, q)."""
        return jacobian(rows, premises, point) * np.where(self.centre, 1.0, premises.vector)


def free_of(start: Premises, x: Array) -> Free:
    """Return the search space of premises over scaled inputs (n, d)."""
    count = start.membership.count
    low, high = premise_limits(start, x)
    centre = np.arange(len(low)) % count == count - 1
    began = start.at(np.clip(start.vector, low, high))
    searched = (_searched(natural, centre) for natural in (low, high, began.vector))
    return Free(began, centre, *searched)


def _searched(natural: Array, centre: NDArray[np.bool_]) -> Array:
    """Return what is searched (q,) for the parameters of the sets (q,)."""
    return np.where(centre, natural, np.log(np.where(centre, 1.0, natural)))


@dataclass(frozen=True)
class PremiseSearch:
    """Where the search is: vector (q,), its premises, what is computed there, damping, largest
    columns (q,).
    """

    here: Array
    premises: Premises
    point: Projected
    damping: float
    largest: Array

    cost: float

    @classmethod
    def begin(cls, rows: LearnerRows, free: Free) -> "PremiseSearch":
        """Return the search at its start."""
        point = projected(rows, free.premises)
        return cls(
            free.start, free.at(free.start), point, DAMPING, np.zeros(len(free.start)), point.cost
        )

    def after(self, rows: LearnerRows, free: Free) -> "PremiseSearch | None":
        """Return the next place with a lower cost; None where no step leads to one."""
        low, high = free.low, free.high
        change, left = self._linearised(rows, free)
        uphill = change.T @ left
        blocked = ((self.here <= low) & (uphill > 0)) | ((self.here >= high) & (uphill < 0))
        change = np.where(blocked, 0.0, change)
        largest = np.maximum(self.largest, np.linalg.norm(change, axis=0))
        damping = self.damping
        while damping < MOST_DAMPING:
            there = np.clip(self.here + _step(change, left, largest, damping), low, high)
            premises = free.at(there)
            point = projected(rows, premises)
            cost = point.cost + float(np.sum(free.leash(rows, there) ** 2))
            if cost < self.cost:
                damping = max(damping / 5.0, LEAST_DAMPING)
                return PremiseSearch(there, premises, point, damping, largest, cost)
            damping *= 4.0
        return None

    def _linearised(self, rows: LearnerRows, free: Free) -> tuple[Array, Array]:
        """Return the Jacobian and the residual here, the leash's rows below."""
        held = np.sqrt(rows.leash) * np.eye(len(self.here))
        change = np.vstack([free.jacobian(rows, self.premises, self.point), held])
        return change, np.concatenate([self.point.residual, free.leash(rows, self.here)])


def projected(rows: LearnerRows, premises: Premises) -> Projected:
    """Return the exact consequents of premises and what they leave."""
    columns = rule_columns(premises, rows.x)
    p = columns.shape[1]
    whole = np.vstack([columns, np.sqrt(rows.ridge) * np.eye(p)])
    q, r = _factored(whole)
    found = dtrtrs(r.T, q[: len(columns)].T @ rows.left, lower=1, trans=1)[0]
    residual = np.concatenate([rows.left, np.zeros(p)]) - whole @ found
    return Projected(found, residual, columns, q, r)


def _factored(whole: Array) -> tuple[Array, Array]:
    """Return Q (n, p) and R (p, p) of columns that are never rank deficient.

    LAPACK itself, as for so few columns what ``scipy.linalg.qr`` does around it takes longer.
    """
    packed, tau, _, _ = dgeqrf(whole)
    return dorgqr(packed, tau)[0], np.triu(packed[: whole.shape[1]])


def jacobian(rows: LearnerRows, premises: Premises, point: Projected) -> Array:
    """Return d residual / d premises.vector, (n + p, q), exactly."""
    ahead, back = changes(rows, premises, point)
    moved = np.vstack([ahead, np.zeros((len(back), ahead.shape[1]))])
    across = dtrtrs(point.r.T, back, lower=1)[0]
    return np.asarray(point.q @ (point.q.T @ moved - across) - moved)


def changes(rows: LearnerRows, premises: Premises, point: Projected) -> tuple[Array, Array]:
    """Return (∂Φ/∂ψ) θ (n, q) and (∂Φ/∂ψ)ᵀ r (p, q) of every parameter of the premises."""
    n, p = point.design.shape
    columns, left = point.design, point.residual[:n]
    by_rule = (columns * point.consequents).T.reshape(len(premises.rules), -1, n).sum(axis=1)
    whole = by_rule.sum(axis=0)
    share = np.ascontiguousarray(columns.T[:: rows.x.shape[1] + 1])
    ahead, back = [], []
    for j, sets in enumerate(premises.sets):
        slopes = premises.membership.slopes(rows.x[:, j], sets)
        for m in range(len(sets)):
            asking = premises.rules[:, j] == m
            part = share[asking].sum(axis=0)
            slope = slopes[:, m].T.copy()
            own = by_rule[asking].sum(axis=0) - part * whole
            ahead.append(slope * own[:, None])
            weighed = slope * left[:, None]
            asked = np.repeat(asking, p // len(asking))[:, None]
            back.append(asked * (columns.T @ weighed) - columns.T @ (weighed * part[:, None]))
    return np.hstack(ahead), np.hstack(back)


def _step(change: Array, residual: Array, largest: Array, damping: float) -> Array:
    size = np.where(largest > 0, largest, 1.0)
    below = np.sqrt(damping) * np.diag(size)
    right = np.concatenate([-residual, np.zeros(len(size))])
    return np.asarray(np.linalg.lstsq(np.vstack([change, below]), right, rcond=None)[0])
