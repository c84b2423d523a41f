"""Which columns belong together by what they do: a velocity is the slope of its position, an effort
follows acceleration, velocity and direction.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SPANS = (1, 4, 16)
"""Rows on both sides that slopes are taken over; the one that agrees most counts. Chosen."""
AGREES = 0.98
"""Correlation of a velocity with a slope; recorded ones reach it. Chosen."""
FOLLOWS = 0.5
"""Share of an effort's variance that a motion must explain, on rows that were not fitted. Chosen:
friction alone explains more on an axis that moves, chance next to nothing."""
BLOCKS = 20
"""Blocks of rows that are fitted and tested in turns. Chosen."""
FEWEST = 200
"""Rows below which nothing is said. Chosen."""


@dataclass(frozen=True)
class SlopeOf:
    """A column is the slope of another: ``factor`` times, with this ``correlation``."""

    correlation: float
    factor: float


def mean_slope(values: Array, t_s: Array, span: int) -> Array:
    """Return the mean slope of a column over ``span`` rows on both sides of each row.

    Of (n,) rows those that have as many on both sides.
    """
    return np.asarray(
        (values[2 * span :] - values[: -2 * span]) / (t_s[2 * span :] - t_s[: -2 * span]),
        np.float64,
    )


def mean_over(values: Array, span: int) -> Array:
    """Return the mean of a column between the same rows, by the trapezoidal rule."""
    sums = np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]))])
    return np.asarray((sums[2 * span :] - sums[: -2 * span]) / (2 * span), np.float64)


def slope_of(rate: Array, place: Array, t_s: Array, *, varying: bool = False) -> SlopeOf | None:
    """Return how ``rate`` (n,) is the slope of ``place`` (n,) over time; None where it is not.

    ``varying``: of what changes of them, upwards with each other: any column that hardly changes is
    like the slope of any other that rises.
    """
    best: SlopeOf | None = None
    if len(t_s) < FEWEST:
        return None
    for span in SPANS:
        with np.errstate(divide="ignore", invalid="ignore"):
            along, mean = mean_slope(place, t_s, span), mean_over(rate, span)
        good = np.isfinite(along) & np.isfinite(mean)
        along, mean = along[good], mean[good]
        power = float(along @ along)
        if not power > 0 or not float(mean @ mean) > 0:
            continue
        if varying and not _vary_alike(along, mean):
            continue
        correlation = float(along @ mean) / np.sqrt(power * float(mean @ mean))
        if best is None or abs(correlation) > abs(best.correlation):
            best = SlopeOf(float(correlation), float(mean @ along) / power)
    return best if best is not None and abs(best.correlation) >= AGREES else None


def _vary_alike(one: Array, other: Array) -> bool:
    one, other = one - one.mean(), other - other.mean()
    size = float(np.linalg.norm(one) * np.linalg.norm(other))
    return size > 0 and float(one @ other) >= AGREES * size


def share_followed(
    effort: Array, velocity: Array, t_s: Array, *, with_direction: bool = True
) -> float:
    """Return the share of an effort's variance that acceleration, velocity and direction explain.

    Fitted on every other block of rows and tested on those between; 0 where that is no better than
    a constant. ``with_direction``: else acceleration and velocity alone, which follow any ripple of
    one frequency.
    """
    span = SPANS[1]
    if len(t_s) < FEWEST:
        return 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        acceleration = mean_slope(velocity, t_s, span)
    mean, said = mean_over(velocity, span), mean_over(effort, span)
    scale = float(np.sqrt(np.mean(mean**2))) or 1.0
    direction = [np.tanh(mean / (0.05 * scale))] if with_direction else []
    design = np.column_stack([acceleration, mean, *direction, np.ones_like(mean)])
    good = np.isfinite(design).all(axis=1) & np.isfinite(said)
    design, said = design[good], said[good]
    block = np.arange(len(said)) * BLOCKS // max(len(said), 1)
    fitted, tested = block % 2 == 0, block % 2 == 1
    if tested.sum() < FEWEST / 4 or not np.ptp(said[tested]) > 0:
        return 0.0
    size = np.linalg.norm(design[fitted], axis=0)
    weights = np.linalg.lstsq(design[fitted] / np.where(size > 0, size, 1.0), said[fitted])[0]
    left = said[tested] - design[tested] / np.where(size > 0, size, 1.0) @ weights
    spread = said[tested] - said[tested].mean()
    return max(0.0, 1.0 - float(left @ left) / float(spread @ spread))
