"""Other ways to predict a cut's force from cuts sensed: the nearest of them, and Kienzle's line.

Each sees the same readings as autodb does: of cuts (n, 3), the logarithms of feed [mm], depth of
cut a_p [mm] and speed [m/min], one component's forces (n,), N. None knows a gain's uncertainty, a
tool or a material. Kienzle, a straight line by least squares:

    log F = c_0 + log a_p + (1 - m) log f  [+ e log v]

Source: Kienzle 1952, specific force k_c1.1 f^-m; the power of the speed is a common addition.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.runs.pairs.pair_cuts import TURNED_DEPTH_MM, TURNED_FEED_MM, TURNED_SPEED_M_MIN

Array = NDArray[np.float64]

FEED, DEPTH, SPEED = range(3)
RANGES = np.log([TURNED_FEED_MM, TURNED_DEPTH_MM, TURNED_SPEED_M_MIN])
"""Lowest and highest of each column that cuts are drawn between."""


@dataclass(frozen=True)
class Peer:
    """A way to predict: its name, how many cuts it needs, forces (m,) of cuts asked (m, 3)."""

    name: str
    needs: int
    predict: Callable[[Array, Array, Array], Array]


def nearest_cut(cuts: Array, force_N: Array, asked: Array) -> Array:
    """Return the force of the cut known that is nearest, each column in shares of its range."""
    return force_N[_nearest(cuts, asked)]


def nearest_by_section(cuts: Array, force_N: Array, asked: Array) -> Array:
    """Return the force of the nearest cut known, in proportion to the section a_p f."""
    which = _nearest(cuts, asked)
    grown = asked[:, [FEED, DEPTH]].sum(axis=1) - cuts[which][:, [FEED, DEPTH]].sum(axis=1)
    return np.asarray(force_N[which] * np.exp(grown))


def kienzle_line(cuts: Array, force_N: Array, asked: Array) -> Array:
    """Return what Kienzle's line through the cuts known expects."""
    return _line(cuts, force_N, asked, [FEED])


def kienzle_with_speed(cuts: Array, force_N: Array, asked: Array) -> Array:
    """Return what Kienzle's line with a power of the speed expects."""
    return _line(cuts, force_N, asked, [FEED, SPEED])


def _nearest(cuts: Array, asked: Array) -> NDArray[np.intp]:
    """Return which of the cuts known is nearest to each asked (m,)."""
    apart = (asked[:, None] - cuts[None]) / (RANGES[:, 1] - RANGES[:, 0])
    return np.asarray(np.argmin((apart**2).sum(axis=2), axis=1))


def _line(cuts: Array, force_N: Array, asked: Array, columns: list[int]) -> Array:
    def design(rows: Array) -> Array:
        return np.column_stack([np.ones(len(rows)), rows[:, columns]])

    found, *_ = np.linalg.lstsq(design(cuts), np.log(force_N) - cuts[:, DEPTH])
    return np.asarray(np.exp(asked[:, DEPTH] + design(asked) @ found))


PEERS = (
    Peer("nearest cut", 1, nearest_cut),
    Peer("nearest cut, by a_p f", 1, nearest_by_section),
    Peer("Kienzle", 2, kienzle_line),
    Peer("Kienzle with speed", 3, kienzle_with_speed),
)
