"""Work-tool pairs whose truth is a power law with saturating ploughing, in turning and milling.

Another law than a thin shear zone's on purpose: per width of edge, with h the uncut chip,

    tangential  k_t h (h/h0)^-m_t s(v) + p_t (1 - e^(-h/h_p))
    thrust      k_r h (h/h0)^-m_r s(v) + p_r (1 - e^(-h/h_p))    along the edge  c tan(i) tangential

s(v) = 1 - g tanh(ln(v/150)). In turning the chip's thrust has one direction for the whole chip, the
mean over its area (Young, Mathew and Oxley 1987), ploughing has each place's own. Every number is
drawn 25 % around what a shop would expect of the material; none is a published constant.
Scatter: of the process, P1 Table 2 (tangential 1.89 %, thrust 5.49 %, each cut one factor on all
of either); of sensing, physics reference section 9 (18.5 N tangential, 16.1 N the others); of a
calibration's gain 5 %, common to a machine.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.machines.lathe.process import SCATTER_TANGENTIAL, SCATTER_THRUST

Array = NDArray[np.float64]

SPREAD = 0.25  # of a pair around what is expected of its material; chosen
GAIN = 0.05  # of a calibration, common to a machine; chosen
SENSING_N = (16.1, 18.5, 16.1)  # x, y, z; physics reference section 9
CHIP_MM = 0.2  # h0 of the law
FAST_M_MIN = 150.0
NOSE_STEPS = 120
TURN_STEPS = 90  # angles of a tooth from 0 to pi
SLICES = 12


@dataclass(frozen=True)
class ExpectedForces:
    """What a shop expects of a material: specific forces at h0, exponents, ploughing N/mm."""

    tangential: float
    thrust: float
    exponent_t: float
    exponent_r: float
    plough_t: float
    plough_r: float


STEEL = ExpectedForces(2000.0, 900.0, 0.17, 0.25, 25.0, 35.0)  # chosen
TITANIUM = ExpectedForces(1700.0, 550.0, 0.2, 0.3, 20.0, 35.0)  # chosen
ALUMINIUM = ExpectedForces(850.0, 300.0, 0.18, 0.3, 10.0, 15.0)  # chosen
MATERIALS = {"steel": STEEL, "titanium": TITANIUM, "aluminium": ALUMINIUM}


@dataclass(frozen=True)
class PowerPair:
    """One pair's truth, the gains of its machine's calibrations, its insert and its mill."""

    material: str
    law: ExpectedForces
    plough_mm: float
    softening: float
    along: float
    gains: Array  # x, y, z, torque
    nose_mm: float = 0.8
    kappa_deg: float = 95.0  # an 80 degree insert that faces at the same angle
    diameter_mm: float = 10.0
    teeth: int = 4
    helix_deg: float = 30.0

    def per_width(self, h_mm: Array, speed_m_min: Array) -> tuple[Array, Array, Array, Array]:
        """Return tangential and thrust of the chip, then of ploughing, N/mm (m,)."""
        soft = 1.0 - self.softening * np.tanh(np.log(speed_m_min / FAST_M_MIN))
        thin = np.maximum(h_mm, 1e-9) / CHIP_MM
        rubs = -np.expm1(-h_mm / self.plough_mm)
        law = self.law
        return (
            law.tangential * h_mm * thin**-law.exponent_t * soft,
            law.thrust * h_mm * thin**-law.exponent_r * soft,
            law.plough_t * rubs,
            law.plough_r * rubs,
        )


def draw_power_pair(rng: np.random.Generator) -> PowerPair:
    """Draw a pair and its machine's gains."""
    material = str(rng.choice(sorted(MATERIALS)))
    expected = MATERIALS[material]

    def around(value: float) -> float:
        return value * math.exp(SPREAD * rng.standard_normal())

    law = ExpectedForces(*(around(value) for value in vars(expected).values()))
    return PowerPair(
        material=material,
        law=law,
        plough_mm=around(0.03),
        softening=0.05 * rng.standard_normal(),
        along=around(0.45),
        gains=1.0 + GAIN * rng.standard_normal(4),
        nose_mm=float(rng.choice([0.4, 0.8, 1.2])),
        diameter_mm=float(rng.choice([8.0, 10.0, 16.0])),
        teeth=int(rng.choice([2, 3, 4])),
        helix_deg=float(rng.choice([20.0, 30.0, 38.0])),
    )


Factors = tuple[float, float]
NONE: Factors = (1.0, 1.0)


def scattered(rng: np.random.Generator) -> Factors:
    """Factors of one cut on its tangential force and on its thrust."""
    along, across = rng.standard_normal(2)
    return 1.0 + SCATTER_TANGENTIAL * along, 1.0 + SCATTER_THRUST * across


@dataclass(frozen=True)
class TurnedCut:
    """One cut with an insert; ``inward_deg``: 0 along the axis, 90 facing.

    The edge in facing meets the work as in turning: an 80 degree insert at 95 degrees.
    """

    feed_mm: float
    depth_mm: float
    speed_m_min: float
    inward_deg: float = 0.0


@dataclass(frozen=True)
class PowerMilledCut:
    """One cut of a mill, engaged from and to an angle, feed along x."""

    feed_mm: float
    depth_mm: float
    speed_rpm: float
    begins_deg: float
    ends_deg: float


def turned_N(pair: PowerPair, cut: TurnedCut, factors: Factors = NONE) -> Array:
    """Mean force x, y, z on an insert, N."""
    feed_mm, depth_mm, inward_deg = cut.feed_mm, cut.depth_mm, cut.inward_deg
    q, width = _insert_edge(pair, depth_mm, inward_deg)
    h = feed_mm * np.sin(q)
    chip_t, chip_r, rub_t, rub_r = pair.per_width(h, np.full_like(h, cut.speed_m_min))
    normal = np.stack([np.sin(q), np.cos(q)])  # against the feed, off the surface
    mean = normal @ (h * width)
    one = mean / math.hypot(*mean)
    thrust = factors[1] * (one * float(chip_r @ width) + normal @ (rub_r * width))
    tangential = factors[0] * float((chip_t + rub_t) @ width)
    angle = math.radians(inward_deg)
    if inward_deg > 45.0:
        return np.array([thrust[0] * math.sin(angle) - thrust[1] * math.cos(angle),
                         tangential,
                         thrust[0] * math.cos(angle) + thrust[1] * math.sin(angle)])  # fmt: skip
    return np.array([thrust[0] * math.sin(angle) + thrust[1] * math.cos(angle),
                     tangential,
                     thrust[0] * math.cos(angle) - thrust[1] * math.sin(angle)])  # fmt: skip


def _insert_edge(pair: PowerPair, depth_mm: float, inward_deg: float) -> tuple[Array, Array]:
    """Angles of short pieces of the engaged edge to the feed, and their widths."""
    off = inward_deg if inward_deg <= 45.0 else 90.0 - inward_deg
    last = math.radians(pair.kappa_deg + off)
    nose_height = pair.nose_mm * (1.0 - math.cos(last))
    end = last if depth_mm > nose_height else math.acos(1.0 - depth_mm / pair.nose_mm)
    step = end / NOSE_STEPS
    q = step * (np.arange(NOSE_STEPS) + 0.5)
    straight = max(0.0, depth_mm - nose_height) / math.sin(last)
    return np.append(q, last), np.append(np.full(NOSE_STEPS, pair.nose_mm * step), straight)


def milled_N(pair: PowerPair, cut: PowerMilledCut, factors: Factors = NONE) -> Array:
    """Mean force x (feed), y (normal), z over a turn, N, and torque, N·m."""
    begin, end = math.radians(cut.begins_deg), math.radians(cut.ends_deg)
    phi = begin + (end - begin) * (np.arange(TURN_STEPS) + 0.5) / TURN_STEPS
    h = cut.feed_mm * np.sin(phi)
    speed = np.full_like(h, math.pi * pair.diameter_mm * cut.speed_rpm / 1000.0)
    chip_t, chip_r, rub_t, rub_r = pair.per_width(h, speed)
    tangential, thrust = factors[0] * (chip_t + rub_t), factors[1] * (chip_r + rub_r)
    lateral = factors[1] * pair.along * math.tan(math.radians(pair.helix_deg)) * chip_t
    # A tooth passes every angle once a turn: the mean over the turn, all teeth
    share = pair.teeth * cut.depth_mm * (end - begin) / TURN_STEPS / (2.0 * math.pi)
    sin, cos = np.sin(phi), np.cos(phi)
    return share * np.array([
        np.sum(-tangential * cos - thrust * sin),
        np.sum(tangential * sin - thrust * cos),
        np.sum(lateral),
        np.sum(tangential) * pair.diameter_mm / 2000.0,
    ])  # fmt: skip
