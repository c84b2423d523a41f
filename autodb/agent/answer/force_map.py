"""Forces, torque and power of a cut over its feed and depth, and where limits are in the way."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.agent.answer.prediction_basis import PredictionBasis
from autodb.files.job_cut import KEYS, JobCut
from autodb.files.machine import AxisLimits
from autodb.forward.limits import QUANTITIES, PredictedQuantity
from autodb.forward.prediction import PredictedCut
from autodb.pairs.engaged import DEPTH, FEED

Array = NDArray[np.float64]

FEEDS, ACROSS = 15, 11
"""Cells of a map. Chosen: lines between them are smooth, a mill's map is there in a second."""
BEYOND = 1.5
"""Factor that a map goes beyond what was cut, or beyond the cut where nothing was. Chosen."""
ALONE = 2.0


@dataclass(frozen=True)
class Layer:
    """One quantity over a map: mean, and the chance to exceed the machine's limit, (n, m).

    ``limit``: at the cut in the middle; None where the machine states none; where none is stated
    ``chance`` is nought.
    """

    quantity: PredictedQuantity
    mean: Array
    chance: Array
    limit: float | None


@dataclass(frozen=True)
class ForceMap:
    """Layers over feeds (m,) and, across them, depths in mm or speeds in m/min (n,).

    ``across_key``: the cut's key that goes across. ``cut_range``: lowest and highest feed and depth
    that the pair was learnt from; None where they are not known.
    """

    cut: JobCut
    feed_key: str
    across_key: str
    feeds: Array
    across: Array
    layers: tuple[Layer, ...]
    cut_range: tuple[tuple[float, float], tuple[float, float]] | None


def force_map(basis: PredictionBasis, cut: JobCut) -> ForceMap:
    """Return the map around a cut. Raises UnusableInput where the tool cannot make one of it."""
    needs = KEYS[cut.operation].needs
    feed_key = "feed_mm_tooth" if "feed_mm_tooth" in needs else "feed_mm_rev"
    speed_key = "speed_m_min" if cut.speed_m_min is not None else "speed_rpm"
    across_key = "depth_mm" if "depth_mm" in needs else speed_key
    learnt: Mapping[str, tuple[float, float]] = (
        basis.states.usual.ranges if basis.states is not None else {}
    )
    feeds = _around(getattr(cut, feed_key), learnt.get(FEED), FEEDS)
    depths = learnt.get(DEPTH) if across_key == "depth_mm" else None
    across = _around(getattr(cut, across_key), depths, ACROSS)
    asked = [
        cut.model_copy(update={feed_key: float(feed), across_key: float(other)})
        for other in across
        for feed in feeds
    ]
    found, _ = basis.predict(asked)
    shape = (len(across), len(feeds))
    (here,), _ = basis.predict([cut])
    layers = tuple(_layer(one, basis.limits, found, shape, here) for one in QUANTITIES)
    known = (learnt[FEED], learnt[DEPTH]) if depths is not None and FEED in learnt else None
    return ForceMap(cut, feed_key, across_key, feeds, across, layers, known)


def _around(value: float, learnt: tuple[float, float] | None, count: int) -> Array:
    """Return values from below to above what was cut and the cut itself, evenly."""
    low, high = (value / ALONE, value * ALONE) if learnt is None else learnt
    low, high = min(low, value) / BEYOND, max(high, value) * BEYOND
    return np.linspace(low, high, count)


def _layer(
    one: PredictedQuantity,
    limits: Mapping[str, AxisLimits],
    cuts: tuple[PredictedCut, ...],
    shape: tuple[int, int],
    here: PredictedCut,
) -> Layer:
    mean = np.array([getattr(cut, one.field).value for cut in cuts]).reshape(shape)
    chance = np.array([one.chance(cut, one.limit(limits, cut)) or 0.0 for cut in cuts])
    return Layer(one, mean, chance.reshape(shape), one.limit(limits, here))
