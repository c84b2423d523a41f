"""Stage two: friction over speed in one direction, from the segments around the middle (P2 III A).

Existing terms, one direction at a time as P2 found better: Coulomb, viscous and, from enough
speeds, Stribeck friction. The parameters are nearly degenerate; what is compared is friction.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.groups import small_sample
from autodb.fitting.linear import solve, triangle
from autodb.terms.channel import (
    ChannelPart,
    channel_columns,
    free_shape,
    linear_parameters,
    reshaped,
)
from autodb.terms.fit import bounds_of
from autodb.terms.friction import COULOMB, STRIBECK, VISCOUS

Array = NDArray[np.float64]
Numbers = NDArray[np.intp]

EXPONENT = 2.0
"""Of Stribeck friction, taken as given as in the joint fit: P0 section 2.2."""
STRIBECK_LEVELS = 6
"""Levels from which on Stribeck friction is fitted too: four parameters, two to spare. Chosen."""
ROUNDS = 5
"""Times that the law is weighed anew with what it leaves."""
ALIKE = 1e-6
"""Share by which friction of a speed that was passed once is unsure at least. Chosen: finite."""
SPEEDS_TRIED = 30
"""Stribeck speeds that are tried, in equal ratios, and again about the best: 2 % apart over a span
of 1000."""


@dataclass(frozen=True)
class FrictionLevels:
    """Friction of each level (k,) in one direction: speed mm/s, mean, its sd from the repeats, 0
    where none was passed twice.

    ``smooth`` (k,): which do not stick; ``run``: sd, as a share, of what all levels have in common
    because a whole run was stiffer; ``warm`` (k,): sd, as a share, because it is not sure how much
    of it was lost by warming.
    """

    speed_mm_s: Array
    friction: Array
    sd: Array
    smooth: NDArray[np.bool_]
    run: float
    warm: Array


@dataclass(frozen=True)
class SpeedLaw:
    """A law over speed in one direction: parts, their values (p,), covariance (p, p).

    ``levels``: what it was fitted to; ``lack``: by how much friction at a speed is off the law
    (sd), as a share, beyond the repeats' error.
    """

    parts: tuple[ChannelPart, ...]
    values: Array
    covariance: Array
    lack: float
    levels: FrictionLevels

    def at(self, speed_mm_s: Array) -> tuple[Array, Array]:
        """Return friction (n,) and its sd (n,) at speeds (n,), for one of each, lack included."""
        value = channel_columns(self.parts, _inputs(speed_mm_s)) @ self.values[: self._linear]
        slopes = self.slopes(speed_mm_s)
        variance = np.einsum("ij,jk,ik->i", slopes, self.covariance, slopes)
        known = self.levels
        warm = np.interp(np.log(speed_mm_s), np.log(known.speed_mm_s), known.warm)
        shared = (self.lack**2 + known.run**2 + warm**2) * value**2
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
    level: Numbers,
    run: Numbers,
    friction: Array,
    warm: Array,
    *,
    speeds: dict[int, float],
    stuck: set[int],
) -> FrictionLevels:
    """Return the levels of passes (n,) in one direction: their level, run, mean friction, and what
    warming leaves unsure of it.

    What passes of a level differ by is a share of their friction: what a run has in common, and
    what a pass has of its own, over the levels that do not stick. Of those that stick passes differ
    by a share of their own.
    """
    names, at, count = np.unique(level, return_inverse=True, return_counts=True)
    mean = np.bincount(at, friction) / count
    share = friction / mean[at] - 1.0
    smooth = ~np.isin(level, list(stuck))
    own, whole = _shares(level[smooth], run[smooth], share[smooth])
    sticks = np.isin(names, list(stuck))
    free = float(np.sum(count[sticks] - 1))
    rough = float(np.sum(share[~smooth] ** 2)) / free if free > 0 else own
    variance = np.where(sticks, max(rough, own), own)
    return FrictionLevels(
        speed_mm_s=np.array([speeds[int(k)] for k in names]),
        friction=mean,
        sd=np.abs(mean) * np.sqrt(variance / count),
        smooth=~sticks,
        run=float(np.sqrt(whole)),
        warm=np.bincount(at, warm) / count,
    )


def _shares(level: Numbers, run: Numbers, share: Array) -> tuple[float, float]:
    """Return the variance of a pass of its own, and that of the mean over the runs.

    Of the runs that hold half of the levels at least. By the runs' means: they hold some of the
    passes' own error too, but three runs that happen to be alike do not pass for no error.
    """
    levels = len(np.unique(level))
    names, count = np.unique(run, return_counts=True)
    whole = names[count >= 0.5 * levels]
    kept = np.isin(run, whole)
    at = np.searchsorted(whole, run[kept])
    means = np.bincount(at, share[kept], len(whole)) / np.bincount(at, minlength=len(whole))
    left = share[kept] - means[at]
    own = float(left @ left) / max(1, len(left) - levels - len(whole) + 1)
    if len(whole) < 2:
        return own, 0.0
    few = small_sample(len(whole) - 1)
    return own, float(means.var(ddof=1)) / len(whole) * few


def fit_speed_law(levels: FrictionLevels) -> SpeedLaw:
    """Fit the law to the levels, each weighed by the repeats' error and by what the law leaves.

    Stribeck friction is no part where it, or its speed, could as well be nothing, or where no speed
    between the slowest and the fastest passed is best.
    """
    plain: tuple[ChannelPart, ...] = (ChannelPart(COULOMB), ChannelPart(VISCOUS))
    if len(levels.speed_mm_s) >= STRIBECK_LEVELS:
        law = _fitted(levels, (*plain, ChannelPart(STRIBECK, {"speed": 1.0, "exponent": EXPONENT},
                                            ("speed",))))  # fmt: skip
        (_, _, (_, level, level_sd), (_, speed, speed_sd)) = law.named
        slowest, fastest = levels.speed_mm_s.min(), levels.speed_mm_s.max()
        if level > level_sd and speed > speed_sd and slowest < speed < (1.0 - 1e-9) * fastest:
            return law
    return _fitted(levels, plain)


def _fitted(levels: FrictionLevels, parts: tuple[ChannelPart, ...]) -> SpeedLaw:
    """Fit the parts; what they leave of the levels that do not stick tells the lack.

    Where no speed was passed twice it is all that tells an error, as Student's t has it.
    """
    alone, size = not levels.sd.any(), np.abs(levels.friction)
    lack = 1.0 if alone else 0.0
    for _ in range(ROUNDS):
        sd = np.sqrt(levels.sd**2 + (lack * size) ** 2)
        fitted, linear = _best(levels, parts, sd)
        left = (
            levels.friction - channel_columns(fitted, _inputs(levels.speed_mm_s)) @ linear
        ) / size
        count = len(linear) + len(free_shape(fitted))
        lack = _lack(left[levels.smooth], (levels.sd / size)[levels.smooth], count)
        if alone:
            few = small_sample(int(levels.smooth.sum()) - count)
            lack = max(ALIKE, float(np.sqrt(few)) * lack)
    slopes = _slopes(fitted, linear, levels.speed_mm_s)
    shape = [part.shape[p.name] for part, p in free_shape(fitted)]
    information = (slopes / sd[:, None] ** 2).T @ slopes
    values = np.concatenate([linear, shape])
    return SpeedLaw(fitted, values, np.linalg.pinv(information), lack, levels)


def _best(
    levels: FrictionLevels, parts: tuple[ChannelPart, ...], sd: Array
) -> tuple[tuple[ChannelPart, ...], Array]:
    """Return the parts at the shape that fits best, and their coefficients.

    The one shape parameter, a speed, is looked for within the speeds passed: so that it cannot fail
    to settle.
    """
    inputs = _inputs(levels.speed_mm_s)
    limits = bounds_of([p for _, p in linear_parameters(parts)])

    def solved(shape: Array) -> tuple[tuple[ChannelPart, ...], Array, float]:
        made = reshaped(parts, shape)
        matrix = channel_columns(made, inputs)
        linear = solve(triangle(matrix, levels.friction, 1.0 / sd), limits)[0]
        left = (levels.friction - matrix @ linear) / sd
        return made, linear, float(left @ left)

    if not free_shape(parts):
        return solved(np.empty(0))[:2]
    low, high = float(levels.speed_mm_s.min()), float(levels.speed_mm_s.max())
    for _ in range(2):
        grid = np.geomspace(low, high, SPEEDS_TRIED)
        costs = [solved(np.array([one]))[2] for one in grid]
        best = int(np.argmin(costs))
        low, high = grid[max(best - 1, 0)], grid[min(best + 1, SPEEDS_TRIED - 1)]
    return solved(grid[[best]])[:2]


def _lack(left: Array, sd: Array, count: int) -> float:
    """Return the sd of what ``count`` parameters leave (k,) beyond its error (k,): the law's."""
    freedom = max(1, len(left) - count)
    beyond = float(left @ left) - float(sd @ sd)
    return float(np.sqrt(max(0.0, beyond / freedom)))


def _slopes(parts: tuple[ChannelPart, ...], linear: Array, speed_mm_s: Array) -> Array:
    """Return the derivatives (n, p + q) of a law by its coefficients and its free shape."""
    inputs = _inputs(speed_mm_s)
    free = free_shape(parts)
    shape = np.array([part.shape[p.name] for part, p in free])
    made = [channel_columns(parts, inputs)]
    for step in np.diag(1e-4 * shape):
        ahead, behind = (
            channel_columns(reshaped(parts, shape + way), inputs) for way in (step, -step)
        )
        made.append(((ahead - behind) @ linear / (2.0 * float(step.sum())))[:, None])
    return np.hstack(made)


def _inputs(speed_mm_s: Array) -> dict[str, Array]:
    return {"velocity": speed_mm_s, "direction": np.ones_like(speed_mm_s)}
