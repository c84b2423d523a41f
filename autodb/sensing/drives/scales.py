"""Newtons an ampere of a feed drive, from a load that is known: a measured force, or a cut.

Air moves give ratios only. A load reconstructed in amperes, over the
force that it is, gives the scale; its error is common to all that is sensed with it. The force of
the work on the tool is minus the load.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb import signals
from autodb.fitting.covariance import long_run_variance
from autodb.fitting.gaussian import NORMAL_95
from autodb.fitting.linear import least_squares, spanning
from autodb.sensing.drives.reconstruct import DriveLoad

Array = NDArray[np.float64]

CORRELATED_S = 1.0
"""Errors of rows nearer than this are not independent: friction wanders about so long. Chosen."""
FEWEST_S = 1.0
"""Least time in motion, well after a turn, under a measured force. Chosen."""


@dataclass(frozen=True)
class ForceScale:
    """Newtons an ampere with its relative sd; negative where a sign is turned round."""

    newtons_per_ampere: float
    share: float


def by_force(load: DriveLoad, force_N: Array, *, rate_hz: float) -> ForceScale | None:
    """Return the scale from a load and the force (n,) measured beside it: a push, a dynamometer.

    Rows in which friction may hold the load, at a limit or outside do not count. A constant, and
    one that turns with the direction, is friction that differs from the day of the moves. None
    where the axis hardly moves under the force, or the force does not vary.
    """
    kept = ~(load.standing | load.turned | load.at_limit | load.outside)
    if kept.sum() < FEWEST_S * rate_hz:
        return None
    smooth = signals.lowpass(force_N, rate_hz=rate_hz, cutoff_hz=load.bandwidth_hz)[kept]
    sense = np.sign(load.direction[kept])
    design = np.column_stack([-smooth, np.ones_like(smooth), sense])
    spans = spanning(design)
    if 0 not in spans or np.ptp(smooth) == 0.0:
        return None
    lags = round(CORRELATED_S * rate_hz)
    fit = least_squares(design[:, spans], load.value[kept], lags=lags)
    amperes_per_newton = float(fit.coefficients[0])
    return ForceScale(1.0 / amperes_per_newton, float(fit.sd[0]) / abs(amperes_per_newton))


def by_step(load: DriveLoad, force_N: float, share: float, *, rate_hz: float) -> ForceScale | None:
    """Return the scale from the step of a load between air and a cut whose mean force is known.

    ``share``: relative sd of the force. Both sides are in motion, so that friction goes out. None
    where air and cut are not told apart, by more than the load's own 95 % and in one direction.
    """
    moving = np.where(load.standing, np.nan, load.value)
    parts = signals.air_and_cut(moving, rate_hz=rate_hz)
    if parts is None:
        return None
    cut, air = (_mean(moving[part]) for part in (parts.cut, parts.air))
    step, variance = cut[0] - air[0], cut[1] + air[1]
    one_way = np.sign(np.mean(load.direction[parts.cut])) == np.sign(
        np.mean(load.direction[parts.air])
    )
    if not one_way or abs(step) < NORMAL_95 * float(np.median(load.sd[parts.cut])):
        return None
    return ForceScale(-force_N / step, float(np.sqrt(share**2 + variance / step**2)))


def _mean(values: Array) -> tuple[float, float]:
    """Return the mean of the known values and its variance, which correlated rows make larger."""
    known = values[np.isfinite(values)]
    mean = float(known.mean())
    return mean, long_run_variance(known - mean) / len(known)
