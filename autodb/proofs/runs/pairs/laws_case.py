"""A turned pair of another law: cuts that are learnt, cuts that are asked for, and their forces.

Learnt are 24 cuts along the axis. Asked is for cuts inside their range, for more of thin chips
there, and for cuts outside: thinner and thicker chips, deeper, faster, faces and tapers. Of each
the mean true force is known, and that of the next cut, which scatters; neither has a gain.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.machines.lathe.law_pairs import LawPair, draw_law_pair, law_forces_N
from autodb.proofs.machines.lathe.power_pairs import Factors, TurnedCut, scattered
from autodb.proofs.runs.pairs.pair_cuts import TAPER_DEG

Array = NDArray[np.float64]

FIRST_CUTS = 24
WITHIN = "inside"
THIN_FEED_MM = 0.1
"""Feeds below are judged by themselves."""
SMALLEST = 0.1
"""A force counts as at least this share of the cut's tangential force: errors and widths over a
passive force that is all but none would say nothing. Chosen."""
SENSED_FORCES, MEASURED_FORCES = (1, 2), (0, 1, 2)
"""Components that are read: what the machine senses in turning, or what a dynamometer measures."""


@dataclass(frozen=True)
class CutRanges:
    """Ranges that cuts are drawn in: feed, depth, speed as a share of the pair's, and how many."""

    kind: str
    count: int
    feed_mm: tuple[float, float] = (0.08, 0.4)
    depth_mm: tuple[float, float] = (0.5, 3.0)
    speed: tuple[float, float] = (0.7, 1.3)
    inward_deg: float = 0.0

    def draw(self, rng: np.random.Generator, speed_m_min: float) -> tuple[TurnedCut, ...]:
        """Draw cuts evenly in the ranges."""
        return tuple(
            TurnedCut(
                feed_mm=float(rng.uniform(*self.feed_mm)),
                depth_mm=float(rng.uniform(*self.depth_mm)),
                speed_m_min=speed_m_min * float(rng.uniform(*self.speed)),
                inward_deg=self.inward_deg,
            )
            for _ in range(self.count)
        )


LEARNT_FROM = CutRanges("learnt", FIRST_CUTS)
ASKED_FOR = (
    CutRanges(WITHIN, 8),
    CutRanges(WITHIN, 2, feed_mm=(0.08, THIN_FEED_MM)),
    CutRanges("f 0.04 to 0.08 mm", 3, feed_mm=(0.04, 0.08)),
    CutRanges("f 0.4 to 0.6 mm", 3, feed_mm=(0.4, 0.6)),
    CutRanges("a_p 3 to 5 mm", 3, depth_mm=(3.0, 5.0)),
    CutRanges("v × 1.6", 3, speed=(1.6, 1.6)),
    CutRanges("faces", 3, inward_deg=90.0),
    CutRanges("tapers of 20°", 3, inward_deg=TAPER_DEG),
)


@dataclass(frozen=True)
class LawsCase:
    """A seed's pair; cuts learnt and their readings (n, components); cuts asked for (m,).

    ``kinds`` (m,); ``mean_N`` and ``next_N`` (m, 3): true forces x, y, z, without scatter and with.
    """

    pair: LawPair
    cuts: tuple[TurnedCut, ...]
    read_N: Array
    asked: tuple[TurnedCut, ...]
    kinds: tuple[str, ...]
    mean_N: Array
    next_N: Array

    @property
    def read(self) -> tuple[int, ...]:
        """The components that are read."""
        return pair_components(self.pair)

    @property
    def size_N(self) -> Array:
        """What errors and widths of each force (m, 3) are shares of."""
        return np.maximum(np.abs(self.mean_N), SMALLEST * self.mean_N[:, [1]])


def draw_laws_case(seed: int) -> LawsCase:
    """Draw a seed's pair, its cuts and readings, and the cuts that are asked for."""
    rng = np.random.default_rng(seed)
    pair = draw_law_pair(seed, rng)
    cuts = LEARNT_FROM.draw(rng, pair.speed_m_min)
    real = _forces(pair, cuts, [scattered(rng) for _ in cuts])
    read = real * pair.gains + pair.noise_N * rng.standard_normal(real.shape)
    drawn = [(one.kind, one.draw(rng, pair.speed_m_min)) for one in ASKED_FOR]
    asked = tuple(cut for _, some in drawn for cut in some)
    return LawsCase(
        pair=pair,
        cuts=cuts,
        read_N=read[:, list(pair_components(pair))],
        asked=asked,
        kinds=tuple(kind for kind, some in drawn for _ in some),
        mean_N=_forces(pair, asked, [(1.0, 1.0)] * len(asked)),
        next_N=_forces(pair, asked, [scattered(rng) for _ in asked]),
    )


def pair_components(pair: LawPair) -> tuple[int, ...]:
    """Return the components that are read of a pair's cuts."""
    return MEASURED_FORCES if pair.measured else SENSED_FORCES


def _forces(pair: LawPair, cuts: tuple[TurnedCut, ...], factors: list[Factors]) -> Array:
    return np.array([law_forces_N(pair, c, f) for c, f in zip(cuts, factors, strict=True)])
