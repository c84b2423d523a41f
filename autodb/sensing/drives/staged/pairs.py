"""Places passed there and back at one speed, where the mean of both ways is the load alone."""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.sensing.drives.staged.segments import PassSegments

Array = NDArray[np.float64]
Places = NDArray[np.intp]


@dataclass(frozen=True)
class Pairs:
    """Places (n,) passed both ways: number of the pair of passes, its level, the place, and the
    numbers of the segments of the ways ``ahead`` and ``back``.
    """

    of: Places
    level: Places
    place: Places
    ahead: Places
    back: Places

    def mean(self, values: Array) -> Array:
        """Return the mean of both ways (n,) of what is told of the segments."""
        return np.asarray(0.5 * (values[self.ahead] + values[self.back]))


def pairs_of(segments: PassSegments, levels: Collection[int]) -> Pairs:
    """Return the places that both passes of one repeat at one of the levels crossed."""
    first, repeats = int(segments.place.min()), int(segments.repeat.max()) + 1
    places = int(segments.place.max()) - first + 1
    number = (segments.level * repeats + segments.repeat) * places + segments.place - first
    one, other = (
        np.flatnonzero(np.isin(segments.level, list(levels)) & (segments.sense == s))
        for s in (1, -1)
    )
    _, a, b = np.intersect1d(number[one], number[other], return_indices=True)
    ahead, back = one[a], other[b]
    return Pairs(
        of=np.asarray(number[ahead] // places, dtype=np.intp),
        level=segments.level[ahead],
        place=segments.place[ahead],
        ahead=ahead,
        back=back,
    )
