"""Which machine's pair is not what the others lead to expect, and whether its calibration or its
cutting is the cause.

The information of a pair's own cuts (Λ, Λθ̂), its calibrations taken as they are, is compared with
the posterior of the others, N(m, V), in the directions in which it has information beside them:

    z_k = b_k / √(l_k (1 + l_k)),   b = V^½ (Λθ̂ − Λm),   l eigenvalues of V^½ Λ V^½

are standard normal but for the gain of the machine's calibrations, which moves the z of all of its
pairs by one vector g (along the cutting speed, across it): z = T g + e, e ~ N(0, 1). Of g a
calibration states how far off it may be, N(0, S). Three accounts of a machine are weighed:

    as stated      g ~ N(0, S)
    calibration    g ~ N(0, S + FAR²)
    cutting        g ~ N(0, S), and a pair's own N(0, FAR²) beside it: other work, another edge

A machine is named where what it sensed is improbable as stated. The cause is the account that odds
favour, where the machine shares three pairs with others or has cuts of known force, which are
readings of g; without these, or without such odds, either may be.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from autodb.cutting.shear import BETA, EDGE_R, EDGE_T, TAU, Edge, chip_coefficients
from autodb.fitting.gaussian import Gaussian
from autodb.pairs.hierarchy import ACTIVE, InformationOfCuts
from autodb.pairs.posterior import OWN

Array = NDArray[np.float64]

FALSE_ALARM = 0.01
"""Probability of naming any pair of a fleet where none disagrees. Chosen."""
INFORMATION = 0.25
"""Information, of that in the others' posterior, from which on a direction is compared. Chosen."""
FAR = 0.3
"""Share by which a calibration or a pair's cutting is off where it is. Chosen."""
SURE = 20.0
"""Odds from which on a cause is named. Chosen: what is usual for strong evidence."""
SHARED_PAIRS = 3
"""Pairs shared with others from which on a calibration is distinguished from cutting."""
THICKNESS_MM, SPEED_M_MIN = 0.1, 100.0
"""Chip at which a gain's effect on the law's numbers is worked out. Chosen: middling."""


class DisagreementCause(Enum):
    """Why a machine disagrees with the others."""

    CALIBRATION = "its calibration"
    CUTTING = "its cutting"
    EITHER = "its calibration or its cutting"


@dataclass(frozen=True)
class ComparedPair:
    """One pair beside the others: ``z`` (r,), ``turned`` (r, 2) how a gain moves it, and how far
    the calibrations' gain may be off as stated, ``stated`` (2, 2).
    """

    z: Array
    turned: Array
    stated: Array

    def improbable(self) -> float:
        """Return the probability of a pair at least as far off as stated, in size or otherwise."""
        own = np.eye(len(self.z)) + self.turned @ self.stated @ self.turned.T
        return min(1.0, 2.0 * min(_beyond(self.z, own), _gain_beyond([self], self.stated)))


@dataclass(frozen=True)
class SensedStandardCut:
    """What a machine sensed of cuts whose force is known: the gain's errors (k,), their sd.

    ``along`` (k, 2): which gain, of the force along or across the cutting speed, each shows.
    """

    gain: Array
    sd: Array
    along: Array


def compared(
    own: InformationOfCuts, *, as_stated: InformationOfCuts, others: Gaussian, rake_rad: float = 0.0
) -> ComparedPair:
    """Compare the information of a pair's cuts with the posterior about them from all others
    (OWN,).

    ``own``: with the machine's calibrations taken as they are; ``as_stated``: with their errors.
    """
    mean, variance = others.mean[ACTIVE], others.covariance[np.ix_(ACTIVE, ACTIVE)]
    values, vectors = np.linalg.eigh(variance)
    root = (vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T
    information, turned = np.linalg.eigh(root @ own.precision @ root)
    kept = information > INFORMATION
    size = np.sqrt(information[kept] * (1.0 + information[kept]))
    into = (turned[:, kept] / size).T @ root
    gains = gain_directions(others.mean, rake_rad)[ACTIVE]
    return ComparedPair(
        z=into @ (own.weighted - own.precision @ mean),
        turned=into @ own.precision @ gains,
        stated=_stated(own, as_stated, gains),
    )


def _stated(own: InformationOfCuts, as_stated: InformationOfCuts, gains: Array) -> Array:
    """Return the covariance (2, 2) by which errors of calibrations widen the estimate of a gain."""
    widths = [np.linalg.pinv(gains.T @ one.precision @ gains) for one in (as_stated, own)]
    values, vectors = np.linalg.eigh(widths[0] - widths[1])
    return np.asarray((vectors * np.maximum(values, 0.0)) @ vectors.T)


def gain_directions(mean: Array, rake_rad: float) -> Array:
    """Return by how much gains of the force along and across move the law's coordinates (OWN, 2).

    The edge's forces grow by them; of the chip's, shear stress and friction together, as the
    derivatives of K_tc and K_rc say.
    """
    step = 1e-4
    edge = Edge(*(np.array([x]) for x in (THICKNESS_MM, SPEED_M_MIN, rake_rad, 0.0)))

    def logs(theta: Array) -> Array:
        along, across, _ = chip_coefficients(theta, edge)
        return np.array([np.log(abs(along[0])), np.log(abs(across[0]))], dtype=np.float64)

    moved = []
    for k in (TAU, BETA):
        up = mean.copy()
        up[k] += step
        moved.append((logs(up) - logs(mean)) / step)
    found = np.zeros((OWN, 2))
    found[[TAU, BETA]] = np.linalg.inv(np.column_stack(moved))
    found[EDGE_T, 0] = found[EDGE_R, 1] = 1.0
    return found


@dataclass(frozen=True)
class Disagrees:
    """A machine that disagrees: which of its pairs do by themselves, and why.

    ``gain``: what its calibration would be off by, along and across, were that the cause, and its
    sd; ``pair``: which pair's cutting is the likeliest; ``odds`` of calibration over cutting.
    """

    pairs: tuple[int, ...]
    cause: DisagreementCause
    gain: tuple[float, float]
    gain_sd: tuple[float, float]
    pair: int
    odds: float
    determined_from: str


def disagrees(
    pairs: Sequence[ComparedPair],
    *,
    compared_in_all: int,
    standard: SensedStandardCut | None = None,
) -> Disagrees | None:
    """Say whether a machine's pairs disagree with the others, and why; None: they do not.

    ``compared_in_all``: pairs and machines that are compared in the fleet, so that a fleet of
    machines that agree names one with a probability of FALSE_ALARM.
    """
    telling = [k for k, one in enumerate(pairs) if len(one.z)]
    if not telling:
        return None
    least = FALSE_ALARM / max(compared_in_all, 1)
    outlying = tuple(k for k in telling if pairs[k].improbable() < least)
    every = _Machine([pairs[k] for k in telling], standard)
    if not outlying and every.gain_improbable() < least:
        outlying = tuple(telling)
    if not outlying:
        return None
    odds, likeliest = every.odds()
    grounds, cause = [], DisagreementCause.EITHER
    if len(telling) >= SHARED_PAIRS:
        grounds.append(f"{len(telling)} pairs shared with others")
    if standard is not None:
        grounds.append("its cuts of known force")
    if grounds and odds > SURE:
        cause = DisagreementCause.CALIBRATION
    elif grounds and odds < 1.0 / SURE:
        cause = DisagreementCause.CUTTING
    gain, sd = every.gain()
    return Disagrees(
        pairs=outlying,
        cause=cause,
        gain=(float(gain[0]), float(gain[1])),
        gain_sd=(float(sd[0]), float(sd[1])),
        pair=telling[likeliest],
        odds=odds,
        determined_from=" and ".join(grounds),
    )


class _Machine:
    """All readings of a machine's gain: the z of its pairs, and its cuts of known force."""

    def __init__(self, pairs: Sequence[ComparedPair], standard: SensedStandardCut | None) -> None:
        self._pairs = pairs
        self._stated = np.mean([one.stated for one in pairs], axis=0)
        self._z = np.concatenate([one.z for one in pairs])
        self._turned = np.vstack([one.turned for one in pairs])
        ends = np.cumsum([len(one.z) for one in pairs])
        self._rows = [slice(end - len(one.z), end) for end, one in zip(ends, pairs, strict=True)]
        if standard is not None:
            self._z = np.concatenate([self._z, standard.gain / standard.sd])
            self._turned = np.vstack([self._turned, standard.along / standard.sd[:, None]])

    def gain_improbable(self) -> float:
        """Return the probability of a common gain at least as far off as stated, by its pairs."""
        return _gain_beyond(self._pairs, self._stated)

    def gain(self) -> tuple[Array, Array]:
        """Return the gain (2,), were the calibration the cause, and its sd."""
        precision = self._turned.T @ self._turned + np.linalg.inv(self._stated + FAR**2 * np.eye(2))
        covariance = np.linalg.inv(precision)
        return covariance @ self._turned.T @ self._z, np.sqrt(np.diag(covariance))

    def odds(self) -> tuple[float, int]:
        """Return the odds of calibration over cutting, and the pair whose cutting is likeliest."""
        own = np.eye(len(self._z))
        far = FAR**2 * np.eye(2)
        as_stated = own + self._turned @ self._stated @ self._turned.T
        calibration = _log_density(
            self._z, own + self._turned @ (self._stated + far) @ self._turned.T
        )
        cutting = []
        for rows in self._rows:
            beside = np.zeros_like(self._turned)
            beside[rows] = self._turned[rows]
            cutting.append(_log_density(self._z, as_stated + beside @ far @ beside.T))
        likeliest = int(np.argmax(cutting))
        return float(np.exp(np.clip(calibration - cutting[likeliest], -50.0, 50.0))), likeliest


def _gain_beyond(pairs: Sequence[ComparedPair], stated: Array) -> float:
    """Return the probability that a gain common to pairs seems at least as far off as stated."""
    precision = sum((one.turned.T @ one.turned for one in pairs), np.zeros((2, 2)))
    weighted = sum((one.turned.T @ one.z for one in pairs), np.zeros(2))
    return _beyond(weighted, precision + precision @ stated @ precision)


def _beyond(value: Array, covariance: Array) -> float:
    """Return the probability of a normal value at least as improbable as one; 1 of nothing."""
    if not len(value):
        return 1.0
    misfit = float(value @ np.linalg.pinv(covariance) @ value)
    return float(chdtrc(np.linalg.matrix_rank(covariance), misfit))


def _log_density(value: Array, covariance: Array) -> float:
    misfit = value @ np.linalg.solve(covariance, value)
    return float(-0.5 * (misfit + np.linalg.slogdet(covariance)[1]))
