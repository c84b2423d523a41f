"""Membership of a value in a fuzzy set, and how it changes with the set's parameters.

Everything is computed as a logarithm: a product of memberships is a sum, and the share of a rule
stays defined where every membership is too small for a double.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

NARROWEST, WIDEST = 0.1, 4.0
"""Half widths at half height that are learned, in halves of the training range: from a twentieth of
the range to one over which a set hardly varies."""
FLATTEST = 1.0
"""Least b of a bell that is learned: with less its curvature has no end at each row that its centre
passes, and learning no optimum that differs between processors. Chosen."""
BELL_SLOPE = 2.0
"""b of a bell before anything is learned (Jang 1993, section V)."""
HALF_HEIGHT = float(np.sqrt(2.0 * np.log(2.0)))
"""Half width of a Gaussian at half its height, in standard deviations."""


@dataclass(frozen=True)
class Membership:
    """A family of fuzzy sets; the last of its ``count`` parameters is the centre.

    ``logarithm`` gives ln μ (m, n) of x (n,) and parameters (m, count); ``slopes`` gives
    d ln μ / d parameter, (count, m, n): a row each, as sums over few sets or rules of many rows are
    slow otherwise. All parameters but the centre are positive. ``around``
    gives the parameters (count,) of a centre and a half width at half height. The family depends
    on x − centre only, so d ln μ/dx is minus the slope of the centre. ``lowest`` and ``highest``
    (count,) bound what is learned: in scaled inputs, so that centres stay in the training range.
    """

    count: int
    logarithm: Callable[[Array, Array], Array]
    slopes: Callable[[Array, Array], Array]
    around: Callable[[float, float], Array]
    lowest: tuple[float, ...]
    highest: tuple[float, ...]


def _columns(parameters: Array) -> Array:
    return parameters.T[:, :, None]


def _bell_exponent(x: Array, parameters: Array) -> Array:
    a, b, c = _columns(parameters)
    with np.errstate(divide="ignore"):
        return np.asarray(2.0 * b * np.log(np.abs((x - c) / a)))


def _bell(x: Array, parameters: Array) -> Array:
    return np.asarray(-np.logaddexp(0.0, _bell_exponent(x, parameters)))


def _bell_slopes(x: Array, parameters: Array) -> Array:
    a, b, c = _columns(parameters)
    exponent = _bell_exponent(x, parameters)
    outside = np.exp(-np.logaddexp(0.0, -exponent))  # 1 − μ
    centred = np.isneginf(exponent)
    by_a = 2.0 * b / a * outside
    by_b = -np.where(centred, 0.0, exponent) * outside / b
    by_c = np.where(centred, 0.0, 2.0 * b * outside / np.where(centred, 1.0, x - c))
    return np.stack([by_a, by_b, by_c])


def _gauss(x: Array, parameters: Array) -> Array:
    sd, c = _columns(parameters)
    return np.asarray(-0.5 * ((x - c) / sd) ** 2)


def _gauss_slopes(x: Array, parameters: Array) -> Array:
    sd, c = _columns(parameters)
    off = (x - c) / sd
    return np.stack([off**2 / sd, off / sd])


BELL = Membership(
    3,
    _bell,
    _bell_slopes,
    lambda centre, half: np.array([half, BELL_SLOPE, centre]),
    (NARROWEST, FLATTEST, -1.0),
    (WIDEST, 10.0, 1.0),
)
"""Generalised bell, μ = 1/(1 + |(x − c)/a|^2b), parameters (a, b, c) (Jang 1993, section III)."""
GAUSS = Membership(
    2,
    _gauss,
    _gauss_slopes,
    lambda centre, half: np.array([half / HALF_HEIGHT, centre]),
    (NARROWEST / HALF_HEIGHT, -1.0),
    (WIDEST / HALF_HEIGHT, 1.0),
)
"""Gaussian, μ = exp(−(x − c)²/(2 s²)), parameters (s, c)."""
