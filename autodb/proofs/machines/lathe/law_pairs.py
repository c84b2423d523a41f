"""Turned pairs of three laws: tools with a nose and without one, forces, what is read of them.

The edge runs from the lowest point of the nose, where the finished surface is left, up to the
entering angle κ_r and on to the depth of cut; with q the angle of a place to the feed its chip is
f sin q thick. When the tool feeds to the axis its other edge cuts, at 270° - κ_r - ε.

What the table of the proof is split by is not drawn: in blocks of 27 seeds each law meets each size
exponent and entering angle once, in blocks of 16 a nose, an edge force, a dynamometer and a stated
tool are there and not there in every combination. All else is drawn. Scatter, sensing and gains are
those of ``power_pairs``; a dynamometer's gain is off by 1 % and its noise is 3 N (chosen).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.machines.lathe.edge_laws import (
    EDGE_LAWS,
    EDGE_N_MM,
    EDGE_NUMBERS,
    OPEN_EXPONENT,
    SCALE,
    SIZE_EXPONENTS,
    EdgeLaw,
    Slants,
)
from autodb.proofs.machines.lathe.power_pairs import GAIN, SENSING_N, Factors, TurnedCut

Array = NDArray[np.float64]
L = TypeVar("L")

PLATE_GAIN, PLATE_NOISE_N = 0.01, 3.0
PLACES = 60
"""Places of the nose. Chosen: forces move by less than 0.1 % with twice as many (a test)."""
SPEED_M_MIN = (100.0, 250.0)
FACES_DEG = 45.0
"""A path that is steeper to the axis faces."""


@dataclass(frozen=True)
class EdgeTool:
    """An insert in its holder; a nose of 0: a straight edge."""

    nose_mm: float
    kappa_deg: float
    included_deg: float
    rake_deg: float
    inclination_deg: float

    def entering_rad(self, inward_deg: float) -> float:
        """Return the angle between a path and the edge that cuts."""
        if inward_deg > FACES_DEG:
            facing = 270.0 - self.kappa_deg - self.included_deg
            return math.radians(facing + 90.0 - inward_deg)
        return math.radians(self.kappa_deg + inward_deg)

    def places(self, depth_mm: float, inward_deg: float) -> tuple[Array, Array]:
        """Return the angles to the feed (m,) of places along the edge, and their widths, mm."""
        last = self.entering_rad(inward_deg)
        height = self.nose_mm * (1.0 - math.cos(last))
        end = last if depth_mm >= height else math.acos(1.0 - depth_mm / self.nose_mm)
        step = end / PLACES
        straight = max(0.0, depth_mm - height) / math.sin(last)
        angles = np.append(step * (np.arange(PLACES) + 0.5), last)
        return angles, np.append(np.full(PLACES, self.nose_mm * step), straight)


STRAIGHT, NOSES_MM = 0.0, (0.4, 0.8)
KAPPA_DEG = {90.0: 80.0, 75.0: 90.0, 45.0: 90.0}
"""Entering angles, and the angle between both edges of the insert in such a holder."""
RAKE_INCLINATION_DEG = ((-6.0, -6.0), (0.0, 0.0))
"""Double-sided inserts, and single-sided ones."""
LAW_LEVELS = tuple(product(EDGE_LAWS, SIZE_EXPONENTS, KAPPA_DEG))
TWO_LEVELS = tuple(product((True, False), repeat=4))
"""Of nose, edge force, forces measured, tool stated."""


@dataclass(frozen=True)
class LawPair:
    """A pair: its law, the law's numbers, the tool, gains of the machine or of the dynamometer.

    ``edge``: whether there is an edge force; ``measured``: all forces by a dynamometer, else the
    machine senses the tangential and the feed force; ``stated``: the shop states the tool.
    """

    law: EdgeLaw
    numbers: dict[str, float]
    tool: EdgeTool
    edge: bool
    measured: bool
    stated: bool
    speed_m_min: float
    gains: Array  # x, y, z

    @property
    def spread(self) -> dict[str, float]:
        """The spreads that its law's open numbers are drawn by; an edge force that is not, none."""
        known = dict(zip(self.law.names, self.law.spread, strict=True))
        edge = {name: SCALE * self.numbers[name] for name in EDGE_NUMBERS if self.edge}
        return {**known, "m_c": OPEN_EXPONENT, **edge}

    @property
    def gain_share(self) -> float:
        """The spread of a gain."""
        return PLATE_GAIN if self.measured else GAIN

    @property
    def noise_N(self) -> Array:
        """What a reading of force x, y, z scatters by for itself."""
        return np.full(3, PLATE_NOISE_N) if self.measured else np.array(SENSING_N)


def draw_law_pair(seed: int, rng: np.random.Generator) -> LawPair:
    """Draw the pair of a seed."""
    law, m_c, kappa_deg = _levels(seed, LAW_LEVELS)
    nose, edge, measured, stated = _levels(seed, TWO_LEVELS)
    numbers = dict(zip(law.names, rng.normal(law.expected, law.spread).tolist(), strict=True))
    numbers["m_c"] = m_c
    for name, middle in zip(EDGE_NUMBERS, EDGE_N_MM, strict=True):
        numbers[name] = edge * middle * math.exp(SCALE * rng.standard_normal())
    nose_mm = float(rng.choice(NOSES_MM)) if nose else STRAIGHT
    slants = RAKE_INCLINATION_DEG[rng.integers(len(RAKE_INCLINATION_DEG))]
    return LawPair(
        law=law,
        numbers=numbers,
        tool=EdgeTool(nose_mm, kappa_deg, KAPPA_DEG[kappa_deg], *slants),
        edge=edge,
        measured=measured,
        stated=stated,
        speed_m_min=float(rng.uniform(*SPEED_M_MIN)),
        gains=1.0 + (PLATE_GAIN if measured else GAIN) * rng.standard_normal(3),
    )


def _levels(seed: int, every: Sequence[L]) -> L:
    """Return a seed's combination of levels: each once in every block of as many seeds."""
    block, place = divmod(seed - 1, len(every))
    order = np.random.default_rng([len(every), block]).permutation(len(every))
    return every[int(order[place])]


def law_forces_N(
    pair: LawPair,
    cut: TurnedCut,
    factors: Factors = (1.0, 1.0),
    *,
    numbers: dict[str, float] | None = None,
) -> Array:
    """Return mean force x, y, z on the tool, N: x away from the axis, z away from the chuck.

    ``factors``: on the tangential force and on what is across it; ``numbers``: others of its law.
    """
    angles, width = pair.tool.places(cut.depth_mm, cut.inward_deg)
    h = cut.feed_mm * np.sin(angles)
    slants = Slants(math.radians(pair.tool.rake_deg), math.radians(pair.tool.inclination_deg))
    per = pair.law.per_width(numbers or pair.numbers, h, cut.speed_m_min, slants)
    normal = np.stack([np.sin(angles), np.cos(angles)])  # against the feed, off the surface
    away = np.stack([-np.cos(angles), np.sin(angles)])  # along the edge, off its tip
    weights = pair.law.flow(h, width)
    chip_normal, chip_away = normal, away
    if weights is not None:
        mean = normal @ weights
        chip_normal = (mean / math.hypot(*mean))[:, None]
        chip_away = np.stack([-chip_normal[1], chip_normal[0]])
    across = (chip_normal * per.thrust + chip_away * per.along + normal * per.edge_thrust) @ width
    feed_N, passive_N = (factors[1] * across).tolist()
    tangential_N = factors[0] * float((per.tangential + per.edge_tangential) @ width)
    return np.array(path_forces_N(feed_N, tangential_N, passive_N, cut.inward_deg))


def path_forces_N(
    feed_N: float, tangential_N: float, passive_N: float, inward_deg: float
) -> tuple[float, float, float]:
    """Return force x, y, z of that against the feed, tangential, and off the finished surface."""
    angle = math.radians(inward_deg)
    side = -1.0 if inward_deg > FACES_DEG else 1.0
    return (
        feed_N * math.sin(angle) + side * passive_N * math.cos(angle),
        tangential_N,
        feed_N * math.cos(angle) - side * passive_N * math.sin(angle),
    )
