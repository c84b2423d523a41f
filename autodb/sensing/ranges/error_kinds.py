"""Two kinds of error of a sensed force: one cut's own, and what all cuts of a calibration share.

More cuts average the first, never the second. Shared are the errors
of the coefficients, of what one tool, material or day has of its own, and of the reference forces.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.groups import Components, components, small_sample

Array = NDArray[np.float64]

DAY_SHARE = {"x": 0.0, "z": 0.0, "spindle": (485.78 - 465.21) / 485.78}
"""Relative difference of an axis' gain between the day calibrated on and another: P1, table 2, the
mean force sensed in 12 repeats against the mean measured; that of F_z agrees.
"""
CLEAR = 2.0
"""Standard errors above which errors of neighbouring cuts go together by more than chance."""
LEAST_OWN = 0.1
"""Share of the error on groups left out that is at least one cut's own."""


@dataclass(frozen=True)
class ErrorKinds:
    """What a calibration's cuts say of both kinds.

    ``cut_sd``: standard deviation of one cut's own error, in the target's unit. ``gain_share``:
    relative standard deviation between the gain fitted and that of the cuts of another day, as far
    as groups do not hold it. ``reference_share``: that of all reference forces together.
    ``group`` (2, 2): covariance of the offset, in the target's unit, and of the share of gain by
    which a new group differs; None: a calibration of 0.1.0, which did not look for it.
    ``current_sd``: rms standard error of the cuts' currents, whose part is not in ``cut_sd``; 0:
    none was stated, and it is.
    """

    cut_sd: float
    gain_share: float
    reference_share: float
    group: Array | None = None
    current_sd: float = 0.0

    def shared(self, scaling: Array) -> Array:
        """Return the covariance of coefficients that scale by ``scaling`` (p,) a share.

        It is (p + 1, p + 1), the last one an offset of the target; (p, p) without ``group``.
        """
        share = self.gain_share**2 + self.reference_share**2
        by_share = share * np.outer(scaling, scaling)
        if self.group is None:
            return np.asarray(by_share)
        moves = day_moves(scaling)
        return np.pad(by_share, (0, 1)) + moves @ self.group @ moves.T

    def standing(self, scaling: Array) -> Array:
        """Return the covariance (p, p) of what all days share but reference forces.

        Half of ``gain_share``: a difference of two days is that of the calibration's day too.
        """
        return np.asarray(0.5 * self.gain_share**2 * np.outer(scaling, scaling))

    @property
    def of_a_day(self) -> Array:
        """Covariance (2, 2) of the offset and the share of gain that are one day's alone.

        All by which groups differ, and the other half of ``gain_share``.
        """
        group = np.zeros((2, 2)) if self.group is None else self.group
        return group + np.diag([0.0, 0.5 * self.gain_share**2])


def day_moves(scaling: Array) -> Array:
    """Return how a day's offset and gain move coefficients (p,) and the offset after them."""
    moves = np.zeros((len(scaling) + 1, 2))
    moves[-1, 0], moves[:-1, 1] = 1.0, scaling
    return moves


@dataclass(frozen=True)
class FittedCuts:
    """Cuts (n,) in their order that a law was fitted to: its estimates, target − estimate, the
    estimates' derivatives by the coefficients (n, p), the covariance (p, p) of these as from cuts
    that share nothing, and groups of cuts; None: groups that other cuts never share. ``current_sd``
    (n,): the currents' own error, 0: not known; ``by_current``: the estimates' derivative by it.
    """

    estimate: Array
    error: Array
    slopes: Array
    covariance: Array
    groups: NDArray[np.generic] | None
    current_sd: Array
    by_current: Array

    @property
    def from_current(self) -> Array:
        """Variance (n,) that the currents' errors give the estimates."""
        return np.asarray((self.current_sd * self.by_current) ** 2)


def error_kinds_of(
    cuts: FittedCuts, *, rmse: float, day_share: float, reference_share: float
) -> tuple[ErrorKinds, Array]:
    """Tell the kinds apart; return them, and the covariance (p, p) of the coefficients.

    Groups differ by an offset and a gain, which go together as they may (random effects,
    ``fitting.components``). What groups left out show beyond that, ``rmse``, is a cut's own error.
    Of the wander of the gain from cut to cut counts what groups do not hold, and of a difference
    known from other machines what the cuts show less than.
    """
    both = np.column_stack([np.ones_like(cuts.estimate), cuts.estimate])
    found = _components(cuts, both)
    covariance = cuts.covariance + _of_groups(cuts, both, found)
    by_groups = _mean_variance(both, found.between)
    rest = by_groups + _mean_variance(cuts.slopes, covariance) + float(np.mean(cuts.from_current))
    own = max(found.own, rmse**2 - rest)

    # what wanders from cut to cut is no cut's own
    offset, gain = slow(cuts.estimate, cuts.error - np.sum(both * found.effects[found.of], axis=1))
    square = float(np.mean(cuts.estimate**2))
    own = max(own - offset - gain * square, (LEAST_OWN * rmse) ** 2)
    seen = gain + (offset + by_groups) / square
    freedom = len(cuts.error) - cuts.slopes.shape[1]
    kinds = ErrorKinds(
        cut_sd=float(np.sqrt(own * small_sample(freedom))),
        gain_share=float(np.sqrt(gain + max(0.0, day_share**2 - seen))),
        reference_share=reference_share,
        group=found.widened + np.diag([offset, 0.0]),
        current_sd=float(np.sqrt(np.mean(cuts.current_sd**2))),
    )
    return kinds, covariance


def _mean_variance(columns: Array, covariance: Array) -> float:
    return float(np.mean(np.einsum("ij,jk,ik->i", columns, covariance, columns)))


def _components(cuts: FittedCuts, both: Array) -> Components:
    groups = np.arange(len(cuts.error)) if cuts.groups is None else cuts.groups
    return components(cuts.slopes, both, cuts.error, groups, known=cuts.from_current)


def _of_groups(cuts: FittedCuts, both: Array, found: Components) -> Array:
    """Return what groups add to the coefficients' covariance (p, p): K Z B Zᵀ Kᵀ over groups.

    K = C Xᵀ/s² is how the coefficients follow the targets.
    """
    freedom = max(1, len(cuts.error) - cuts.slopes.shape[1])
    variance = float(cuts.error @ cuts.error) / freedom
    if variance == 0.0:
        return np.zeros_like(cuts.covariance)
    pull = np.zeros((len(found.effects), cuts.slopes.shape[1], 2))
    np.add.at(pull, found.of, cuts.slopes[:, :, None] * both[:, None, :])
    moved = cuts.covariance @ pull / variance
    return np.asarray(np.einsum("gpa,ab,gqb->pq", moved, found.widened, moved))


def slow(estimate: Array, error: Array) -> Array:
    """Return the variances (2,) of an offset and of a gain that wander slowly from cut to cut.

    Errors of neighbours go together as far as these are the same for both: e_i e_{i+1} is on
    average the one plus f_i f_{i+1} times the other, f the estimates (n,); by least squares,
    neither below zero. A mean product below ``CLEAR`` standard errors of chance counts as none.
    """
    from scipy.optimize import nnls

    together, chance = error[1:] * error[:-1], float(error @ error) / len(error)
    if float(np.mean(together)) <= CLEAR * chance / np.sqrt(len(error)):
        return np.zeros(2)
    products = estimate[1:] * estimate[:-1]
    scale = np.sqrt(np.mean(products**2))
    found = nnls(np.column_stack([np.ones_like(products), products / scale]), together)[0]
    return np.asarray(found / [1.0, scale])
