"""Semi-inverse: sensed forces and the cuts' geometry become a pair's parameters, with covariance.

Two kinds of error stay apart: each cut's own scatter, and a calibration's, which all cuts sensed
with it share. The shared part enters as nuisance parameters (the errors of the calibrations'
coefficients and offsets, with their covariance), so more cuts never make it smaller (physics
reference, 7).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.cutting import law
from autodb.fitting import Gaussian, update
from autodb.sensing.forms import Form

Array = NDArray[np.float64]

ROUNDS = 5


@dataclass(frozen=True)
class Shared:
    """What all cuts sensed with one calibration share: the errors of its p coefficients.

    ``covariance`` (k, k) is of the coefficients and, where one was looked for, of an offset after
    them. ``references`` (k,): standard deviation that the error of the reference forces gives each,
    which all calibrations on those references share.
    """

    form: Form
    coefficients: int
    covariance: Array
    references: Array


@dataclass(frozen=True)
class SensedCuts:
    """Cuts of one pair as calibrations felt one component: arrays (n,).

    ``source`` (n,): which of the calibrations felt each cut. ``common`` (n, k): derivatives of the
    force by what all calibrations share, in their order, zero for what is another's.
    """

    feed_mm: Array
    depth_mm: Array
    force_N: Array
    sd_N: Array
    common: Array
    source: NDArray[np.int_]
    shared: tuple[Shared, ...]

    def part(self, rows: slice) -> "SensedCuts":
        """Return some of the cuts."""
        return SensedCuts(
            feed_mm=self.feed_mm[rows],
            depth_mm=self.depth_mm[rows],
            force_N=self.force_N[rows],
            sd_N=self.sd_N[rows],
            common=self.common[rows],
            source=self.source[rows],
            shared=self.shared,
        )

    def shared_covariance(self) -> Array:
        """Return the covariance (k, k) of all that is shared; references tie it together."""
        references = np.concatenate([one.references for one in self.shared])
        whole = np.outer(references, references)
        for one, columns in zip(self.shared, self._columns(), strict=True):
            whole[columns, columns] = one.covariance
        return whole

    def expected(self, law_design: Array) -> Array:
        """Return ``common`` freed of the currents' noise, as a law's columns (n, k) make it."""
        freed = np.zeros_like(self.common)
        for number, (one, columns) in enumerate(zip(self.shared, self._columns(), strict=True)):
            rows = np.flatnonzero(self.source == number)
            if rows.size:
                own = np.ix_(rows, np.arange(columns.start, columns.stop))
                freed[own] = self.common[own]
                slopes = own[0], own[1][:, : one.coefficients]
                freed[slopes] = one.form.expected(self.common[slopes], law_design[rows])
        return freed

    def _columns(self) -> list[slice]:
        ends = np.cumsum([len(one.covariance) for one in self.shared]).tolist()
        return [slice(start, end) for start, end in zip([0, *ends[:-1]], ends, strict=True)]


@dataclass(frozen=True)
class Parameters:
    """Belief about (K_c, K_e, K_n), what the law does not hold, and the number of cuts behind it.

    ``process_share``: share of the force that scatters from cut to cut. ``misfit_N``: standard
    deviation by which the law misses whole regions of depth and feed, however many cuts there are.
    """

    belief: Gaussian
    process_share: float
    misfit_N: float
    n_cuts: int


def learn(cuts: SensedCuts, *, prior: Gaussian = law.PRIOR) -> Parameters:
    """Return the posterior of one component's parameters after the cuts.

    F = K_c a_p f + K_e a_p + K_n + misfit + process + sensing + common·δ, δ ~ N(0, calibration
    covariance). What the residuals hold beyond the sensing sd is split into a misfit of the law
    (means over regions of depth and feed) and process scatter; posterior and split are iterated.
    """
    own_design = law.design(cuts.feed_mm, cuts.depth_mm)
    design = np.column_stack([own_design, cuts.expected(own_design)])
    shared = cuts.shared_covariance()
    start = Gaussian(
        np.concatenate([prior.mean, np.zeros(len(shared))]), _block(prior.covariance, shared)
    )
    share = misfit_N = 0.0
    for _ in range(ROUNDS):
        noise = np.sqrt(cuts.sd_N**2 + (share * cuts.force_N) ** 2 + misfit_N**2)
        posterior = update(start, design, cuts.force_N, noise)
        residual = cuts.force_N - design @ posterior.mean
        misfit_N = _misfit_N(residual, cuts)
        share = _process_share(residual, cuts, misfit_N)
    own = len(prior.mean)
    belief = Gaussian(posterior.mean[:own], posterior.covariance[:own, :own])
    return Parameters(belief, share, misfit_N, len(cuts.force_N))


def _block(a: Array, b: Array) -> Array:
    whole = np.zeros((len(a) + len(b), len(a) + len(b)))
    whole[: len(a), : len(a)] = a
    whole[len(a) :, len(a) :] = b
    return whole


def _misfit_N(residual: Array, cuts: SensedCuts) -> float:
    """Return the rms of the regions' mean residuals beyond what chance gives them.

    Regions are depth and feed, each split at its median; fewer than 3 cuts make no region. 0 where
    chance explains the means, or there are fewer than two regions.
    """
    deep = cuts.depth_mm > np.median(cuts.depth_mm)
    thick = cuts.feed_mm > np.median(cuts.feed_mm)
    excess = []
    for rows in (deep & thick, deep & ~thick, ~deep & thick, ~deep & ~thick):
        n = int(rows.sum())
        if n >= 3:
            chance = float(np.mean(residual[rows] ** 2)) / n
            excess.append(float(np.mean(residual[rows])) ** 2 - chance)
    return float(np.sqrt(max(0.0, float(np.mean(excess))))) if len(excess) > 1 else 0.0


def _process_share(residual: Array, cuts: SensedCuts, misfit_N: float) -> float:
    """Return √((Σr²/(n−2) − mean sd² − misfit²)/mean F²); 0 where the rest explains it."""
    n = len(residual)
    if n <= 2:
        return 0.0
    excess = float(np.sum(residual**2)) / (n - 2) - float(np.mean(cuts.sd_N**2)) - misfit_N**2
    return float(np.sqrt(max(0.0, excess) / np.mean(cuts.force_N**2)))
