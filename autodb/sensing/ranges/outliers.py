"""Cuts that a calibration does not fit, and cuts that carry it alone: shown, never dropped.

Cuts in which a current jumps though the force does not: a start or a rapid inside a row.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from autodb.fitting.linear import spread
from autodb.fitting.scores import robust_line
from autodb.sensing.ranges.forms import FittedForm
from autodb.wording import listed, localized, phrase, phrase_many

Array = NDArray[np.float64]


TRANSIENT_WINDOW = 4
"""Rows on each side that a row is compared with when transients are searched for."""
TRANSIENT_SPREADS = 10.0
"""A row this many robust standard deviations off its neighbours is a transient."""


def transients(current: Array, target: Array, groups: NDArray[np.generic]) -> NDArray[np.bool_]:
    """Return rows in which the current leaves its neighbours while the force does not.

    In each group, in the order of the rows, the residual from a robust line is compared with the
    median over the 2·TRANSIENT_WINDOW + 1 rows around it (Hampel's identifier). A start, a stop or
    a rapid inside a row makes the current jump though the cut goes on. Groups of fewer rows than
    half of that show nothing.
    """
    _, of, rows = np.unique(groups, return_inverse=True, return_counts=True)
    judged = rows[of.ravel()] > TRANSIENT_WINDOW
    if not judged.any():
        return np.zeros(len(current), dtype=np.bool_)
    c0, c1 = robust_line(current, target)
    expected = c0 + c1 * current
    jump_current = _off_neighbours(expected, groups)
    jump_target = _off_neighbours(target, groups)
    jump = _off_neighbours(target - expected, groups)
    limit = TRANSIENT_SPREADS * spread(jump[judged])
    jumps = (np.abs(jump) > limit) & (np.abs(jump_current) > np.abs(jump_target))
    return np.asarray(judged & jumps)


def _off_neighbours(values: Array, groups: NDArray[np.generic]) -> Array:
    off = np.zeros_like(values)
    width = 2 * TRANSIENT_WINDOW + 1
    for group in np.unique(groups):
        own = values[groups == group]
        windows = np.lib.stride_tricks.sliding_window_view(own, min(width, len(own)))
        centre = np.clip(np.arange(len(own)) - TRANSIENT_WINDOW, 0, len(windows) - 1)
        off[groups == group] = own - np.median(windows, axis=1)[centre]
    return off


BY_CHANCE = 0.05
"""Probability of naming any cut of a sound calibration by its residual (Bonferroni's bound)."""
HIGH_LEVERAGE = 3.0
"""Times the mean leverage from which on a cut alone holds a part of the law (Belsley, Kuh, Welsch
1980, Regression diagnostics, section 2.1, takes 2 for large samples; fewer are named by 3).
"""


STRETCHES = 8
"""Numbers, or ranges of them, that a sentence lists before the rest is counted."""


@dataclass(frozen=True)
class Outlier:
    """A cut by its number: studentised residual and leverage, and which of them is too high."""

    cut: float
    studentised: float
    leverage: float
    off: bool
    alone: bool


def outlier_sentences(named: Sequence[Outlier]) -> list[str]:
    """Return one sentence on outliers of the fit, and one on cuts that dominate it."""
    off = [one for one in named if one.off]
    alone = [one for one in named if one.alone]
    said: list[str] = []
    if off:
        most = max(abs(one.studentised) for one in off)
        said.append(
            phrase_many(
                "{count} cut ({cuts}) deviates from the fit of the others by more than chance, by "
                "up to {most} standard deviations; all cuts stay in the fit",
                "{count} cuts ({cuts}) deviate from the fit of the others by more than chance, by "
                "up to {most} standard deviations; all cuts stay in the fit",
                len(off),
                cuts=_numbers(off),
                most=localized(f"{most:.1f}"),
            )
        )
    if alone:
        leverage = max(one.leverage for one in alone)
        said.append(
            phrase_many(
                "{count} cut ({cuts}) dominates the fit (leverage up to {most}); add cuts in this "
                "range",
                "{count} cuts ({cuts}) dominate the fit (leverage up to {most}); add cuts in this "
                "range",
                len(alone),
                cuts=_numbers(alone),
                most=localized(f"{leverage:.2f}"),
            )
        )
    return said


def _numbers(named: Sequence[Outlier]) -> str:
    return numbers(sorted(one.cut for one in named))


def numbers(cuts: Sequence[float]) -> str:
    """Return cuts by number, neighbours as a range, the first STRETCHES of them.

    >>> numbers([3.0, 4.0, 5.0, 9.0])
    '3 to 5, 9'
    """
    stretches: list[list[float]] = []
    for cut in cuts:
        if stretches and cut == stretches[-1][-1] + 1.0:
            stretches[-1].append(cut)
        else:
            stretches.append([cut])
    said = [
        phrase("{low} to {high}", low=f"{one[0]:g}", high=f"{one[-1]:g}")
        if len(one) > 2
        else ", ".join(f"{cut:g}" for cut in one)
        for one in stretches
    ]
    rest = sum(map(len, stretches[STRETCHES:]))
    some = listed(said[:STRETCHES])
    return phrase("{some} and {count} more", some=some, count=rest) if rest else some


def outliers(law: FittedForm, slopes: Array, error: Array, cut: Array) -> tuple[Outlier, ...]:
    """Return the cuts (n,) named, by target − estimate (n,) and the law's derivatives (n, p).

    Leverage h = sᵀ C s / σ², C the coefficients' covariance, σ² the residual variance; the residual
    is studentised without its own cut: t = e √((n−p−1)/(SSE(1−h)−e²)) (Belsley, Kuh, Welsch 1980,
    equation 2.26).
    """
    n, p = slopes.shape
    freedom = n - p - 1
    squares = float(error @ error)
    if freedom < 1 or squares == 0.0:
        return ()
    variance = squares / (n - p)
    leverage = np.minimum(np.einsum("ij,jk,ik->i", slopes, law.covariance, slopes) / variance, 1.0)
    rest = np.maximum(squares * (1.0 - leverage) - error**2, np.finfo(float).tiny)
    studentised = error * np.sqrt(freedom / rest)
    limit = float(stdtrit(freedom, 1.0 - 0.5 * BY_CHANCE / n))
    off = np.abs(studentised) > limit
    alone = leverage > HIGH_LEVERAGE * p / n
    named = np.flatnonzero(off | alone)
    return tuple(
        Outlier(
            float(cut[i]), float(studentised[i]), float(leverage[i]), bool(off[i]), bool(alone[i])
        )
        for i in named
    )
