"""Stage two: friction over speed in one direction, from the segments around the middle (P2 III A).

Existing terms, one direction at a time as P2 found better: Coulomb, viscous and, from enough
speeds, Stribeck friction. The parameters are nearly degenerate; what is compared is friction.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb import fitting
from autodb.terms import COULOMB, STRIBECK, VISCOUS
from autodb.terms.channel import Part, columns, free_shape, reshaped
from autodb.terms.fit import fit_parts

Array = NDArray[np.float64]
Numbers = NDArray[np.intp]

EXPONENT = 2.0
"""Of Stribeck friction, taken as given as in the joint fit: P0 section 2.2."""
STRIBECK_LEVELS = 6
"""Levels from which on Stribeck friction is fitted too: four parameters and two to spare. Chosen."""
ROUNDS = 5
"""Times that the law is weighed anew with what it leaves."""


@dataclass(frozen=True)
class Levels:
    """Friction of each level (k,) in one direction: speed mm/s, mean, its sd from the repeats.

    ``run``: sd, as a share, of what all levels have in common because a whole run was stiffer.
    """

    speed_mm_s: Array
    friction: Array
    sd: Array
    run: float


@dataclass(frozen=True)
class Law:
    """A law over speed in one direction: parts, their values (p,), covariance (p, p).

    ``lack``: by how much friction at a speed is off the law (sd), as a share, beyond the repeats'
    error; ``run`` as in ``Levels``.
    """

    parts: tuple[Part, ...]
    values: Array
    covariance: Array
    lack: float
    run: float

    def at(self, speed_mm_s: Array) -> tuple[Array, Array]:
        """Return friction (n,) and its sd (n,) at speeds (n,), for one of each, lack included."""
        value = columns(self.parts, _inputs(speed_mm_s)) @ self.values[: self._linear]
        slopes = self.slopes(speed_mm_s)
        variance = np.einsum("ij,jk,ik->i", slopes, self.covariance, slopes)
        shared = (self.lack**2 + self.run**2) * value**2
        return value, np.asarray(np.sqrt(variance + shared))

    def slopes(self, speed_mm_s: Array) -> Array:
        """Return the derivatives (n, p) of friction by the values."""
        return _slopes(self.parts, self.values[: self._linear], speed_mm_s)

    @property
    def _linear(self) -> int:
        return len(self.values) - len(free_shape(self.parts))

    @property
    def named(self) -> list[tuple[str, float, float]]:
        """Names, values and sd of the parameters."""
        names = [part.term.name for part in self.parts] + [f"{p.key} speed" for p, _ in
                                                           free_shape(self.parts)]  # fmt: skip
        sd = np.sqrt(np.diag(self.covariance))
        return list(zip(names, self.values.tolist(), sd.tolist(), strict=True))


def levels_of_way(
    level: Numbers, run: Numbers, friction: Array, speeds: dict[int, float], stuck: set[int]
) -> Levels:
    """Return the levels of passes (n,) in one direction: their level, run and mean friction.

    What passes of a level differ by is a share of their friction; what a run has in common is told
    from what a pass has of its own by restricted maximum likelihood over the levels that do not
    stick. Of those that stick passes differ by a share of their own.
    """
    names, at, count = np.unique(level, return_inverse=True, return_counts=True)
    mean = np.bincount(at, friction) / count
    share = friction / mean[at] - 1.0
    smooth = ~np.isin(level, list(stuck))
    own, whole = _shares(level[smooth], run[smooth], share[smooth])
    free = float(np.sum(count[np.isin(names, list(stuck))] - 1))
    rough = float(np.sum(share[~smooth] ** 2)) / free if free > 0 else own
    variance = np.where(np.isin(names, list(stuck)), max(rough, own), own)
    return Levels(
        np.array([speeds[int(k)] for k in names]),
        mean,
        np.abs(mean) * np.sqrt(variance / count),
        float(np.sqrt(whole / len(np.unique(run)))),
    )


def _shares(level: Numbers, run: Numbers, share: Array) -> tuple[float, float]:
    """Return the variances of a pass of its own, and of a run as a whole."""
    names, at = np.unique(level, return_inverse=True)
    design = np.eye(len(names))[at]
    known = np.zeros(len(share))
    if len(np.unique(run)) < 2 or len(share) <= len(names) + 1:
        left = share - design @ (design.T @ share / design.sum(axis=0))
        return float(left @ left) / max(1, len(share) - len(names)), 0.0
    found = fitting.components(design, np.ones((len(share), 1)), share, run, known=known)
    return found.own, float(found.widened[0, 0])


def law_of(levels: Levels) -> Law:
    """Fit the law to the levels, each weighed by the repeats' error and by what the law leaves.

    Raises NotConverged where the Stribeck speed does not settle.
    """
    wanted: tuple[Part, ...] = (Part(COULOMB), Part(VISCOUS))
    if len(levels.speed_mm_s) >= STRIBECK_LEVELS:
        shape = {"speed": 2.0, "exponent": EXPONENT}
        law = _fitted(levels, (*wanted, Part(STRIBECK, shape, ("speed",))))
        if _told(law):
            return law
    return _fitted(levels, wanted)


def _told(law: Law) -> bool:
    """Say whether Stribeck friction is there and its speed is known: else it is no part."""
    _, level, sd = next(one for one in law.named if one[0] == "stribeck")
    _, speed, speed_sd = law.named[-1]
    return level > sd and speed > speed_sd


def _fitted(levels: Levels, parts: tuple[Part, ...]) -> Law:
    inputs, lack = _inputs(levels.speed_mm_s), 0.0
    size = np.abs(levels.friction)
    for _ in range(ROUNDS):
        sd = np.sqrt(levels.sd**2 + (lack * size) ** 2)
        found = fit_parts(parts, inputs, levels.friction, sd=sd)
        left = (levels.friction - columns(found.parts, inputs) @ found.linear) / size
        count = len(found.linear) + len(free_shape(found.parts))
        freedom = max(1, len(left) - count)
        lack = float(np.sqrt(max(0.0, left @ left / freedom - np.mean((levels.sd / size) ** 2))))
    slopes = _slopes(found.parts, found.linear, levels.speed_mm_s)
    shape = [part.shape[p.name] for part, p in free_shape(found.parts)]
    information = (slopes / sd[:, None] ** 2).T @ slopes
    values = np.concatenate([found.linear, shape])
    return Law(found.parts, values, np.linalg.pinv(information), lack, levels.run)


def _slopes(parts: tuple[Part, ...], linear: Array, speed_mm_s: Array) -> Array:
    """Return the derivatives (n, p + q) of a law by its coefficients and its free shape."""
    inputs = _inputs(speed_mm_s)
    free = free_shape(parts)
    shape = np.array([part.shape[p.name] for part, p in free])
    made = [columns(parts, inputs)]
    for step in np.diag(1e-4 * shape):
        ahead, behind = (columns(reshaped(parts, shape + way), inputs) for way in (step, -step))
        made.append(((ahead - behind) @ linear / (2.0 * step.sum()))[:, None])
    return np.hstack(made)


def _inputs(speed_mm_s: Array) -> dict[str, Array]:
    return {"velocity": speed_mm_s, "direction": np.ones_like(speed_mm_s)}
