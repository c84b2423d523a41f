"""Over which speed friction turns, where no friction of the simulation says it."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from autodb.explain.axis.read_off import WIDTHS
from autodb.explain.axis.signals import AxisSignals
from autodb.explain.engine.fit import Folds
from autodb.explain.engine.laws import GAIN
from autodb.explain.engine.plain import BLOCKS, rms_fall

Array = NDArray[np.float64]

ROWS = 8_000
"""Rows that are looked at. Chosen."""


def turned_as_recorded(s: AxisSignals) -> AxisSignals:
    """Return the signals with the sense that turns over the speed which what the simulation leaves
    shows.

    Laws that turn with the motion all share it: level, difference by direction, slope along the
    travel, dip at creep. It stays as it is unless with another these predict blocks left out
    clearly better, and dry friction alone no worse; or where the simulation's own friction has told
    it.
    """
    if s.recorded is None or "coulomb" in s.had:
        return s
    place = s.position - s.position.mean()
    dips = [np.exp(-np.abs(s.velocity) / speed) for speed in s.scales.dips()]
    own = [*s.own.values(), np.ones_like(place)]
    plain = [s.recorded - s.simulation, *own, place, s.velocity, s.acceleration]
    thin = slice(None, None, max(1, len(place) // ROWS))

    def left(sense: Array) -> tuple[Array, Array]:
        laws = [sense, np.abs(sense), sense * place, *(sense * dip for dip in dips)]
        rows = np.column_stack([*plain, *laws])[thin]
        folds = Folds(rows, 0, blocks=BLOCKS, folds=BLOCKS)
        everything = np.arange(1, rows.shape[1])
        dry = np.array([*range(1, 1 + len(own)), len(plain)])
        return tuple(folds.by_fold(at, np.zeros(len(at))) for at in (everything, dry))

    whole, alone = left(s.sense)
    best, sense = GAIN, s.sense
    for share in WIDTHS:
        other = np.tanh(s.velocity / (share * s.scales.top))
        with_all, with_it = left(other)
        fall = rms_fall(whole, with_all)
        if fall > best and with_it.sum() <= alone.sum():
            best, sense = fall, other
    return replace(s, sense=sense)
