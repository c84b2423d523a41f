"""A pair to be learnt in turning: cuts sensed, the next cuts asked for, and their true forces.

The truth is the mean force of the next cuts, without scatter and without the machine's gains, which
every way has sensed with its cuts and none can know.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.machines.lathe.power_pairs import PowerPair
from autodb.proofs.runs.pairs.pair_cuts import (
    TURN,
    Cut,
    ReadCuts,
    draw_pair,
    draw_read_cuts,
    number_of_cuts,
    sensing,
    true_forces,
)

Array = NDArray[np.float64]

SENSED = 40
ASKED = 25
"""Next cuts of a pair: chosen."""
JUDGED = TURN.sensed
"""Components that are sensed and predicted: tangential and along the axis."""


@dataclass(frozen=True)
class CurveCase:
    """A seed's pair, cuts sensed, the next cuts, and their true forces (m, components)."""

    seed: int
    pair: PowerPair
    sensed: ReadCuts
    asked: tuple[Cut, ...]
    truth_N: Array

    @property
    def read_N(self) -> Array:
        """Forces sensed (n, components), fit for a logarithm: a reading below its sensing's own
        noise counts as that.
        """
        return np.maximum(self.sensed.read, sensing(self.pair)[list(JUDGED)])


def draw_case(seed: int) -> CurveCase:
    """Draw a seed's pair, the cuts that are sensed and those that are asked for."""
    rng, pair = draw_pair(seed)
    sensed = draw_read_cuts(rng, pair, TURN, SENSED)
    asked = tuple(TURN.draw(rng, pair) for _ in range(ASKED))
    truth_N = np.array([true_forces(pair, cut) for cut in asked])[:, list(JUDGED)]
    return CurveCase(seed, pair, sensed, asked, truth_N)


def some(sensed: ReadCuts, begin: int, end: int) -> ReadCuts:
    """Return cuts sensed from one on and before another."""
    return replace(sensed, cuts=sensed.cuts[begin:end], read=sensed.read[begin:end])


def settings(cuts: tuple[Cut, ...]) -> Array:
    """Return the logarithms of feed, depth of cut and speed (n, 3)."""
    names = ("feed_mm", "depth_mm", "speed_m_min")
    return np.log(np.column_stack([number_of_cuts(cuts, name) for name in names]))


def median_errors(expected_N: Array, case: CurveCase) -> Array:
    """Return the median relative error of the next cuts, of each component."""
    return np.asarray(np.median(np.abs(expected_N / case.truth_N - 1.0), axis=0))
