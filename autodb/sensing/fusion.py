"""Several sensors of one force become one answer: the best linear unbiased combination of theirs.

Each estimates a force and its standard deviation at every row, NaN where it does not sense. Where
the force was known, it was learnt by how much a sensor is off in the mean (bias), by what factor
its standard deviations are too small or large, and how far errors of several go together
(correlation R). With D = diag(factor · sd) of a row, C = D R D and the answer is

    F = Σ w_i (F_i − b_i),  w = C⁻¹1 / (1ᵀC⁻¹1),  var F = 1 / (1ᵀC⁻¹1)

so that a sensor that is not sure of a row, or says what another says, counts less there; none
counts against itself (w ≥ 0).

A sensor that starts to disagree is found by how far each is from what the others say together, in
standard deviations, against how far it was where it was learnt. Of three or more it is the one
without which the others agree; of two nobody can say which.
Source: Aitken 1935 (generalised least squares).

What the sensors of force over time are called, wherever several are put together.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.gaussian import NORMAL_95
from autodb.wording import msgid

DRIVE, NETWORK, TABLE = msgid("drive model"), msgid("network"), msgid("table dynamometer")


Array = NDArray[np.float64]

ROWS = 200
"""Rows of each recording that are learnt from: it counts alike, however long it is."""
SHRUNK = 0.05
"""Share by which correlations are drawn to none: few recordings determine them. Chosen."""
NEARER = 0.98
"""Times the error of the nearest sensor alone that several together must not exceed, in recordings
left out in turn, to be used. Chosen."""
APART = 2.0
"""Times its usual distance from the others beyond which a sensor disagrees. Chosen."""
USUAL = 1.5
"""Distance, in standard deviations, that is usual of sensors that were never compared. Chosen."""


@dataclass(frozen=True)
class SensedTogether:
    """What sensors estimated of one recording's force: values and sds (n, k) N; NaN: not sensed."""

    value_N: Array
    sd_N: Array


@dataclass(frozen=True)
class Fusion:
    """How sensors (k,) of one component are put together.

    ``by_row``: whether by the standard deviations that they state, row by row, or by those that
    they had; ``counts`` (k,): which count where they sense: a sensor that adds nothing waits until
    the others do not. ``usual`` (k,): how far each is from the others at most, in standard
    deviations; ``wider``: the factor on the answer's sd that makes 95 % hold.
    """

    names: tuple[str, ...]
    bias_N: Array
    size_N: Array
    factor: Array
    correlation: Array
    by_row: bool
    counts: tuple[bool, ...]
    usual: Array
    wider: float = 1.0

    def to_json(self) -> dict[str, Any]:
        """Return it as JSON keeps it."""
        return {
            "names": list(self.names),
            "bias_N": self.bias_N.tolist(),
            "size_N": self.size_N.tolist(),
            "factor": self.factor.tolist(),
            "correlation": self.correlation.tolist(),
            "told": self.by_row,
            "counts": list(self.counts),
            "usual": self.usual.tolist(),
            "wider": self.wider,
        }

    @classmethod
    def of_json(cls, kept: Mapping[str, Any]) -> "Fusion":
        """Return what ``to_json`` made."""
        return cls(
            names=tuple(kept["names"]),
            bias_N=np.array(kept["bias_N"]),
            size_N=np.array(kept["size_N"]),
            factor=np.array(kept["factor"]),
            correlation=np.array(kept["correlation"]),
            by_row=kept["told"],
            counts=tuple(kept["counts"]),
            usual=np.array(kept["usual"]),
            wider=kept["wider"],
        )


@dataclass(frozen=True)
class FusedForce:
    """Force and its sd (n,) N, and by what weight each sensor (n, k) made it; NaN: none senses."""

    value_N: Array
    sd_N: Array
    weight: Array


def learn_fusion(
    names: Sequence[str], heard: Sequence[SensedTogether], known_N: Sequence[Array]
) -> Fusion:
    """Return how sensors go together, from recordings whose force (n,) N was known.

    Ways that are tried, each on recordings left out in turn: all sensors by what they state, all by
    what they were, and each alone; several must be nearer than the nearest alone. Rows at which not
    all sense show nothing of their correlation.
    """
    both = list(zip(heard, known_N, strict=True))
    every = (True,) * len(names)
    alone = [tuple(k == j for k in range(len(names))) for j in range(len(names))]
    ways = [(True, every), (False, every), *((True, one) for one in alone)]
    errors = [_left_out(names, both, by_row=by_row, counts=counts) for by_row, counts in ways]
    together, single = int(np.argmin(errors[:2])), 2 + int(np.argmin(errors[2:]))
    best = together if errors[together] <= NEARER * errors[single] else single
    by_row, counts = ways[best]
    begun = _learnt(names, both, by_row=by_row, counts=counts)
    apart = np.max([sensor_distances(begun, one) for one in heard], axis=0)
    return replace(begun, usual=np.maximum(apart, 1.0), wider=_wider(begun, both))


def independent(names: Sequence[str]) -> Fusion:
    """Return how sensors go together that were never compared: as each says of itself."""
    k = len(names)
    return Fusion(
        tuple(names), np.zeros(k), np.ones(k), np.ones(k), np.eye(k), by_row=True,
        counts=(True,) * k, usual=np.full(k, USUAL),
    )  # fmt: skip


def with_sensor(fusion: Fusion, name: str) -> Fusion:
    """Return a fusion with one more sensor, which errs by itself and as it says of itself.

    Then all count, by what they state row by row: how large its errors were is unknown.
    """
    k = len(fusion.names)
    correlation = np.eye(k + 1)
    correlation[:k, :k] = fusion.correlation
    return Fusion(
        names=(*fusion.names, name),
        bias_N=np.append(fusion.bias_N, 0.0),
        size_N=np.append(fusion.size_N, np.inf),
        factor=np.append(fusion.factor, 1.0),
        correlation=correlation,
        by_row=True,
        counts=(True,) * (k + 1),
        usual=np.append(fusion.usual, USUAL),
        wider=fusion.wider,
    )


def sensor_distances(fusion: Fusion, heard: SensedTogether) -> Array:
    """Return how far each sensor (k,) is from the others together, rms, in standard deviations.

    NaN where it, or all the others, sense nothing.
    """
    sd = fusion.factor * heard.sd_N
    weight = np.where(np.isfinite(heard.value_N) & np.isfinite(sd), sd**-2.0, 0.0)
    value = np.where(weight > 0.0, heard.value_N - fusion.bias_N, 0.0)
    found = np.full(len(fusion.names), np.nan)
    for k in range(len(fusion.names)):
        others = np.arange(len(fusion.names)) != k
        total = weight[:, others].sum(axis=1)
        rows = (weight[:, k] > 0.0) & (total > 0.0)
        if not rows.any():
            continue
        rest = np.sum(weight[rows][:, others] * value[rows][:, others], axis=1) / total[rows]
        variance = 1.0 / weight[rows, k] + 1.0 / total[rows]
        found[k] = np.sqrt(np.mean((value[rows, k] - rest) ** 2 / variance))
    return found


@dataclass(frozen=True)
class Apart:
    """Sensors that do not agree; by what factor their standard deviations are too small.

    Two names say that one of both is off, and it cannot be decided which.
    """

    names: tuple[str, ...]
    factor: float


def disagreeing(fusion: Fusion, heard: SensedTogether) -> Apart | None:
    """Return which sensors do not agree in a recording, or None where all do."""
    far = sensor_distances(fusion, heard) / fusion.usual
    if not np.any(far > APART):
        return None
    senses = np.flatnonzero(np.isfinite(far))
    if len(senses) > 2:
        for k in senses[np.argsort(-far[senses])]:
            if not np.any(sensor_distances(fusion, _without(heard, k)) / fusion.usual > APART):
                return Apart((fusion.names[k],), float(far[k]))
    names = tuple(fusion.names[k] for k in senses if far[k] > APART)
    return Apart(names, float(np.nanmax(far)))


def _without(heard: SensedTogether, sensor: int) -> SensedTogether:
    value = heard.value_N.copy()
    value[:, sensor] = np.nan
    return SensedTogether(value, heard.sd_N)


def trusting_less(fusion: Fusion, apart: Apart) -> Fusion:
    """Return a fusion in which sensors that do not agree are as unsure as they are apart.

    All count then: a sensor that was the nearest may be no longer.
    """
    wide = np.array([apart.factor if name in apart.names else 1.0 for name in fusion.names])
    return replace(
        fusion, factor=wide * fusion.factor, size_N=wide * fusion.size_N,
        counts=(True,) * len(fusion.names),
    )  # fmt: skip


Known = Sequence[tuple[SensedTogether, Array]]


def _left_out(
    names: Sequence[str], both: Known, *, by_row: bool, counts: tuple[bool, ...]
) -> float:
    """Return the mean error, N, in recordings that were left out in turn."""
    errors = []
    for k, (one, known) in enumerate(both):
        made = fuse(_learnt(names, [*both[:k], *both[k + 1 :]], by_row=by_row, counts=counts), one)
        errors.append(float(np.sqrt(np.nanmean((made.value_N - known) ** 2))))
    return float(np.mean(errors))


def _learnt(names: Sequence[str], both: Known, *, by_row: bool, counts: tuple[bool, ...]) -> Fusion:
    picked = [_picked(one, known) for one, known in both]
    off = np.concatenate([off for off, _ in picked])
    sd = np.concatenate([sd for _, sd in picked])
    several = sum(counts) > 1
    bias = off.mean(axis=0) if several else np.zeros(len(names))
    size = np.sqrt(np.mean((off - bias) ** 2, axis=0))
    factor = np.sqrt(np.mean(((off - bias) / sd) ** 2, axis=0))
    share = (off - bias) / (sd * factor if by_row else size)
    correlation = (1.0 - SHRUNK) * (share.T @ share) / len(share)
    np.fill_diagonal(correlation, 1.0)
    usual = np.full(len(names), USUAL)
    return Fusion(tuple(names), bias, size, factor, correlation, by_row, counts, usual)


def _wider(begun: Fusion, both: Known) -> float:
    """Return the factor on standard deviations that makes 95 % hold, each recording alike."""
    ratios = []
    for one, known in both:
        made = fuse(begun, one)
        sensed = np.isfinite(made.value_N)
        off = np.abs(made.value_N - known)[sensed] / made.sd_N[sensed]
        ratios.append(np.quantile(off, np.linspace(0.005, 0.995, 100)))
    return float(np.quantile(np.concatenate(ratios), 0.95) / NORMAL_95)


def _picked(heard: SensedTogether, known_N: Array) -> tuple[Array, Array]:
    """Return errors and sds of some rows at which all sense."""
    all_ = np.flatnonzero(np.isfinite(heard.value_N).all(axis=1))
    rows = all_[np.linspace(0, len(all_) - 1, min(ROWS, len(all_))).astype(np.intp)]
    return heard.value_N[rows] - known_N[rows, None], heard.sd_N[rows]


def fuse(fusion: Fusion, heard: SensedTogether) -> FusedForce:
    """Return the one answer of a recording."""
    senses = np.isfinite(heard.value_N) & np.isfinite(heard.sd_N)
    if senses.all():
        return _fused(fusion, heard, np.flatnonzero(fusion.counts))
    counted = senses & np.array(fusion.counts)
    # Where none of those senses that count, the others are what there is
    used = np.where(counted.any(axis=1)[:, None], counted, senses)
    none = np.full(len(used), np.nan)
    whole = FusedForce(none, none.copy(), np.zeros(used.shape))
    for pattern in np.unique(used, axis=0):
        if not pattern.any():
            continue
        rows = (used == pattern).all(axis=1)
        some = SensedTogether(heard.value_N[rows], heard.sd_N[rows])
        made = _fused(fusion, some, np.flatnonzero(pattern))
        whole.value_N[rows], whole.sd_N[rows] = made.value_N, made.sd_N
        whole.weight[rows] = made.weight
    return whole


def _fused(fusion: Fusion, heard: SensedTogether, kept: NDArray[np.intp]) -> FusedForce:
    """Return the answer of rows at which the sensors ``kept`` sense, and count."""
    value, sd, weight = fuse_rows(fusion, heard.value_N[:, kept], heard.sd_N[:, kept], kept)
    every = np.zeros(heard.value_N.shape)
    every[:, kept] = weight
    return FusedForce(value, fusion.wider * sd, every)


def fuse_rows(
    fusion: Fusion, value_N: Array, sd_N: Array, kept: NDArray[np.intp]
) -> tuple[Array, Array, Array]:
    """Return value and sd (r,) and weights (r, k) of rows at which the sensors ``kept`` sense.

    ``value_N`` and ``sd_N`` (r, k): what these estimated; the sd is not made wider yet.
    """
    stated = fusion.factor[kept] * sd_N
    alone = value_N - fusion.bias_N[kept]
    if len(kept) == 1:
        return alone[:, 0], stated[:, 0], np.ones_like(stated)
    correlation = fusion.correlation[kept][:, kept]
    own = stated[:, :, None] * correlation * stated[:, None, :]
    size = fusion.size_N[kept]
    # What they were is the same at every row
    covariance = own if fusion.by_row else (size[:, None] * correlation * size)[None]
    one = np.linalg.solve(covariance, np.ones((len(covariance), len(kept), 1)))[..., 0]
    weight = np.maximum(one, 0.0)  # estimates are not extrapolated
    weight = np.broadcast_to(weight / weight.sum(axis=1, keepdims=True), stated.shape)
    # The answer is as unsure as its estimates, whichever way the weights were found
    variance = (weight[:, None] @ own @ weight[:, :, None])[:, 0, 0]
    return (weight * alone).sum(axis=1), np.sqrt(variance), weight
