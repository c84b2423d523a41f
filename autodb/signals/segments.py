"""A recorded cut begins in air: where it approached, and where it cut."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Segments:
    """Where the tool approached in air and where it cut, as slices of the samples."""

    air: slice
    cut: slice


def air_and_cut(load: Array, *, rate_hz: float, margin_s: float = 0.5) -> Segments | None:
    """Split one recorded cut into its air approach and the cut by fuzzy c-means on the load signal.

    ``load`` (n,): a range that rises or falls in the cut (NaN where the axis stands). The cut is
    the longest run in the cluster that the recording does not start in; the air part is the run
    before it. Both lose ``margin_s`` at each end. None when the clusters are not apart by 6 times
    their spread, or a part is shorter than 0.3 s.
    """
    import skfuzzy

    known = np.isfinite(load)
    if known.sum() < 10:
        return None
    filled = np.interp(np.arange(len(load)), np.flatnonzero(known), load[known])
    centres, member, *_ = skfuzzy.cluster.cmeans(
        filled[None, :], c=2, m=2.0, error=1e-4, maxiter=200, seed=0
    )
    label = np.argmax(member, axis=0)
    spread = np.median(np.abs(filled - centres[label, 0]))
    if abs(centres[0, 0] - centres[1, 0]) < 6.0 * spread:
        return None
    cutting = label != label[np.flatnonzero(known)[0]]
    edges = np.flatnonzero(np.diff(np.concatenate(([0], cutting.astype(int), [0]))))
    if not edges.size:
        return None
    starts, ends = edges[::2], edges[1::2]
    longest = int(np.argmax(ends - starts))
    margin = round(margin_s * rate_hz)
    air = slice(margin, int(starts[longest]) - margin)
    cut = slice(int(starts[longest]) + margin, int(ends[longest]) - margin)
    short = 0.3 * rate_hz
    if air.stop - air.start < short or cut.stop - cut.start < short:
        return None
    return Segments(air, cut)
