"""Over which speed friction turns, where no friction of the simulation says it."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from autodb.explain.axis.read_off import BETTER, WIDTHS
from autodb.explain.axis.signals import AxisSignals

Array = NDArray[np.float64]

ROWS = 8_000
"""Rows that are looked at. Chosen."""


def turned_as_recorded(s: AxisSignals) -> AxisSignals:
    """Return the signals with the sense that turns over the speed which what the simulation leaves
    shows.

    Laws that turn with the motion all share it: level, difference by direction, slope along the
    travel, dip at creep. It stays as it is where another leaves as much, or where the simulation's own friction
    has told it.
    """
    if s.recorded is None or "coulomb" in s.had:
        return s
    rows = slice(None, None, max(1, len(s.recorded) // ROWS))
    place = s.position - s.position.mean()
    plain = [*s.own.values(), np.ones_like(place), place, s.velocity, s.acceleration]

    dips = [np.exp(-np.abs(s.velocity) / speed) for speed in s.scales.dips()]

    def left(sense: Array) -> float:
        laws = [*plain, sense, np.abs(sense), sense * place, *(sense * dip for dip in dips)]
        matrix = np.column_stack(laws)[rows]
        size = np.sqrt(np.mean(matrix**2, axis=0))
        matrix = matrix / np.where(size > 0.0, size, 1.0)
        target = (s.recorded - s.simulation)[rows]
        found = np.linalg.lstsq(matrix, target, rcond=None)[0]
        return float(np.sum((target - matrix @ found) ** 2))

    tried = [np.tanh(s.velocity / (share * s.scales.top)) for share in WIDTHS]
    remains = [left(sense) for sense in tried]
    best = int(np.argmin(remains))
    if remains[best] >= BETTER * left(s.sense):
        return s
    return replace(s, sense=tried[best])
