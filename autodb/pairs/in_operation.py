"""What a posterior knows of cuts in an operation, whatever these are: worked out once for each.

It hangs on the posterior, which nobody changes, and goes with it. With it, how the forces of such
cuts are spread: as Student's t, where it is not known by how much.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.gaussian import NORMAL_95
from autodb.pairs.observed import PairCuts
from autodb.pairs.posterior import FEWEST, OF_OPERATION, OWN, PairPosterior, Scatter, lot_key

Array = NDArray[np.float64]

TINY_N = 1e-9
"""Size of a force below which there is none."""
TINY_SHARE = 1e-9
"""Share, and reciprocal of degrees of freedom, below which there is none."""
LEAST = 1.0
"""The fewest degrees of freedom that a force is shaped as. Chosen."""
NOT_NEAR = slice(2, 12)
"""Errors of the law in an operation, and of how it grows there, that a near law has not."""
DIRECTION = OF_OPERATION.start + 2
"""Part of a force that the direction of what is across changes."""


@dataclass(frozen=True)
class InOperation:
    """A posterior that has met what cuts share: ``known``, and where in its state that stands.

    ``law``: errors of the law, in the order of what they change; ``assumed``: what is assumed of
    the cuts; ``lot``: of the lot that is asked for, None where it is among no terms; ``off_law``:
    what the law is found to be off by; ``next_cut``: what the next cut scatters by; ``far`` (p, k):
    square root of what of the covariance goes where the law is near, none where that is sure.
    """

    known: PairPosterior
    law: NDArray[np.intp]
    assumed: NDArray[np.intp]
    lot: int | None
    off_law: Array
    next_cut: Scatter
    far: Array | None

    @property
    def theta(self) -> Array:
        """Coordinates of the law."""
        return self.known.state.mean[:OWN]

    @property
    def of_lot(self) -> float:
        """The share by which forces of the lot that is asked for are larger."""
        return 0.0 if self.lot is None else float(self.known.state.mean[self.lot])

    def freedom(self, slopes: Array, parts: Array, sd: Array) -> Array:
        """Return the degrees of freedom (n, 5) of Student's t that forces of cuts are shaped as.

        ``slopes`` (n, 5, p), ``parts`` (n, 5, 3) and ``sd`` (n, 5) as of a forecast. Variances that
        are not known add up to 1/ν = Σ s_k⁴/ν_k / sd⁴ (Welch 1947, Biometrika 34:28): what cuts
        scatter by has its weight as ν_k. A law that is far with the probability p, else near, has
        the share r of the variance in its errors, which are none where it is near; its forces are
        denser in the middle than a normal's by

            D = (1 - p)/a + p/b,    a² = 1 - r,    b² = a² + r/p

        so that 1/ν is added of the Student's t as dense there.
        """
        variance, scatter = np.maximum(sd**2, TINY_N**2), self.next_cut
        share = (parts[..., :DIRECTION] * scatter.share) ** 2 / variance[..., None]
        less = np.sum(share**2 / np.maximum(scatter.weight, FEWEST), axis=-1)
        if self.far is not None:
            law = self.known.off_law
            errors = np.sum((slopes @ self.far) ** 2, axis=-1)
            errors += (parts[..., DIRECTION] * law.cut_direction_rad) ** 2
            r, p = np.minimum(errors / variance, 1.0 - TINY_SHARE), 1.0 - law.near
            dense = (1.0 - p) / np.sqrt(1.0 - r) + p / np.sqrt(1.0 - r + r / p)
            less += 1.0 / freedom_of_density(dense)
        return np.asarray(1.0 / np.clip(less, TINY_SHARE, 1.0 / LEAST))


def freedom_of_density(dense: Array) -> Array:
    """Return the degrees of freedom of a Student's t that is denser in the middle than a normal.

    By a factor, where both are as wide at 95 %. By Wallace's normal score c (ν ln(1 + t²/ν))^½, c =
    (8 ν + 1)/(8 ν + 3), that factor's square is (e^x - 1)/x with x = (1.96/c)²/ν, whose logarithm
    is x/2 + x²/24 to the second order.
    """
    x = 6.0 * (np.sqrt(1.0 + 4.0 / 3.0 * np.log(np.maximum(dense, 1.0))) - 1.0)
    found = NORMAL_95**2 / np.maximum(x, TINY_SHARE)
    without = found
    for _ in range(2):
        found = without * ((8.0 * found + 3.0) / (8.0 * found + 1.0)) ** 2
    return np.asarray(found)


def in_operation(posterior: PairPosterior, cuts: PairCuts) -> InOperation:
    """Return what a posterior knows of cuts of the operation and tool of these."""
    key = cuts.operation, *(one.key for one in cuts.variants)
    found = posterior.worked_out.get(key)
    if not isinstance(found, InOperation):
        found = posterior.worked_out[key] = _worked_out(posterior, cuts)
    return found


def _worked_out(posterior: PairPosterior, cuts: PairCuts) -> InOperation:
    laws = posterior.law_errors(cuts.operation)
    known = posterior.also((*laws, *cuts.assumed, *posterior.open_terms))
    law = np.concatenate([np.r_[known.columns(one.key)] for one in laws])
    has_lot = known.lot in known.terms.lots
    return InOperation(
        known=known,
        law=law,
        assumed=np.array([known.columns(one.key).start for one in cuts.variants], dtype=np.intp),
        lot=known.columns(lot_key(str(known.lot))).start if has_lot else None,
        off_law=known.state.mean[law],
        next_cut=posterior.scatter.of_next,
        far=_far(known, law[NOT_NEAR]) if 0.0 < known.off_law.near < 1.0 else None,
    )


def _far(known: PairPosterior, columns: NDArray[np.intp]) -> Array:
    """Return a root (p, k) of what of a covariance goes were the errors in some columns none."""
    covariance = known.state.covariance
    columns = columns[np.diag(covariance)[columns] > 0.0]
    size = np.sqrt(np.diag(covariance)[columns])
    alike = covariance[np.ix_(columns, columns)] / np.outer(size, size)
    spread, ways = np.linalg.eigh(alike)
    open_ = spread > TINY_SHARE
    root = ways[:, open_] / np.sqrt(spread[open_])
    return np.asarray(covariance[:, columns] @ (root / size[:, None]))
