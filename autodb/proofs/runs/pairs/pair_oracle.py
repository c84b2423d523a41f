"""The best that can be known of a power-law pair: its own law, its own spreads, from the same cuts.

The oracle fits what the generator draws, with the spreads that it draws them by as prior, and knows
every size of noise. No estimator that must do with another law can be narrower and right.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from autodb.proofs.machines.lathe.power_pairs import GAIN, SPREAD, ExpectedForces, PowerPair
from autodb.proofs.machines.lathe.process import SCATTER_TANGENTIAL, SCATTER_THRUST
from autodb.proofs.runs.pairs.pair_cuts import Cut, ReadCuts, as_expected, sensing, true_forces

Array = NDArray[np.float64]

LAW = 6
STEP = 1e-4
SPREADS = np.array([*[SPREAD] * (LAW + 2), 0.05, *[GAIN] * 4])
"""Of the law's numbers, ploughing's thickness and the force along an edge, in logarithms; of the
softening; of the gains."""


@dataclass(frozen=True)
class OracleKnowledge:
    """What the oracle knows: coordinates (13,) off what is expected, and their covariance."""

    pair: PowerPair
    mean: Array
    covariance: Array

    def interval(self, cut: Cut, component: int) -> tuple[float, float]:
        """Return middle and sd of the next cut's force."""

        def at(p: Array) -> float:
            return float(true_forces(_pair(self.pair, p), cut)[component])

        steps = STEP * np.eye(len(self.mean))
        slope = np.array([(at(self.mean + s) - at(self.mean - s)) / (2 * STEP) for s in steps])
        scatter = _scatter(_pair(self.pair, self.mean), cut)[component]
        return at(self.mean), float(np.sqrt(slope @ self.covariance @ slope + scatter**2))


def oracle_fit(pair: PowerPair, measured: ReadCuts) -> OracleKnowledge:
    """Return what the oracle knows after cuts; of ``pair`` only tool and material are used."""
    sensed = list(measured.operation.sensed)
    begun = _pair(pair, np.zeros(len(SPREADS)))
    noise = np.array([
        np.hypot(sensing(pair)[sensed], _scatter(begun, cut)[sensed]) for cut in measured.cuts
    ])  # fmt: skip

    def error(p: Array) -> Array:
        made = _pair(pair, p)
        read = (
            np.array([true_forces(made, cut)[sensed] for cut in measured.cuts]) * made.gains[sensed]
        )
        return np.concatenate([((measured.read - read) / noise).ravel(), p / SPREADS])

    found = least_squares(error, np.zeros(len(SPREADS)))
    slopes = np.asarray(found.jac, dtype=np.float64)
    return OracleKnowledge(pair, np.asarray(found.x), _inverse(slopes.T @ slopes))


def _inverse(square: Array) -> Array:
    return np.asarray(np.linalg.inv(square), dtype=np.float64)


def _pair(pair: PowerPair, p: Array) -> PowerPair:
    """Return the pair at coordinates (13,)."""
    plain = as_expected(pair.material)
    law = np.array(list(vars(plain.law).values())) * np.exp(p[:LAW])
    return replace(
        pair,
        law=ExpectedForces(*law.tolist()),
        plough_mm=plain.plough_mm * float(np.exp(p[LAW])),
        along=plain.along * float(np.exp(p[LAW + 1])),
        softening=float(p[LAW + 2]),
        gains=1.0 + p[LAW + 3 :],
    )


def _scatter(pair: PowerPair, cut: Cut) -> Array:
    """Return the sd of a cut that is repeated, by component."""
    plain = true_forces(pair, cut)
    along = true_forces(pair, cut, (1.0 + SCATTER_TANGENTIAL, 1.0)) - plain
    across = true_forces(pair, cut, (1.0, 1.0 + SCATTER_THRUST)) - plain
    return np.hypot(along, across)
