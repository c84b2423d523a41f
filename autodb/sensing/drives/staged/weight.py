"""Stage one: the weight, mean of (up + down)/2 over the speeds that do not stick (P2 III B)."""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.fitting.groups import components, small_sample
from autodb.sensing.drives.staged.pairs import Pairs, pairs_of
from autodb.sensing.drives.staged.segments import PassSegments
from autodb.wording import phrase

Array = NDArray[np.float64]
Places = NDArray[np.intp]


@dataclass(frozen=True)
class Weight:
    """The weight in the effort's unit, its sd, and the levels that it is the mean over.

    What friction differs by direction, the same at all speeds, counts as weight. ``x_mm`` (k,): the
    mean place at which each level told it.
    """

    value: float
    sd: float
    levels: tuple[int, ...]
    x_mm: Array


def weight_of(
    segments: PassSegments, effort: Array, levels: Collection[int], *, path: str
) -> Weight:
    """Return the weight of segments' effort (n,), each of the levels counting alike.

    The error is from what repeats of a level differ by and what levels differ by beyond that
    (restricted maximum likelihood), not from rows or segments, which are alike along the way.

    Raises UnusableInput where no level has a place that was passed both ways.
    """
    pairs = pairs_of(segments, levels)
    if not len(pairs.of):
        raise UnusableInput(
            phrase(
                "{file}: no speed without stick-slip passes one place in both directions, so "
                "the weight cannot be estimated; make passes there and back over one stretch",
                file=path,
            )
        )
    of, values, places = _of_pairs(pairs, pairs.mean(effort), segments.x_mm[pairs.ahead])
    names, at, count = np.unique(of, return_inverse=True, return_counts=True)
    mean = np.bincount(at, values) / count
    ones = np.ones((len(values), 1))
    parts = components(ones, ones, values, of, known=np.zeros(len(values)))
    own = parts.own * small_sample(len(values) - 1)
    variance = (parts.widened[0, 0] + own * float(np.mean(1.0 / count))) / len(names)
    return Weight(
        value=float(mean.mean()),
        sd=float(np.sqrt(variance)),
        levels=tuple(int(k) for k in names),
        x_mm=np.bincount(at, places) / count,
    )


def _of_pairs(pairs: Pairs, values: Array, x_mm: Array) -> tuple[Places, Array, Array]:
    """Return level, mean value and mean place mm of each pair of passes."""
    _, first, at, count = np.unique(
        pairs.of, return_index=True, return_inverse=True, return_counts=True
    )
    mean, place = (np.bincount(at, one) / count for one in (values, x_mm))
    return pairs.level[first], mean, place
