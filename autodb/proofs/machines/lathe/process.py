"""Cutting forces of the virtual lathe: a power law, ploughing that saturates, wear in three stages.

No number below is a published material constant. Shapes are *chosen* truths of a machine that does
not exist; only the aluminium pair is anchored, to the repeated cut of P1 (autonomous machining
database, current sensing), Table 2.
"""

import math
import zlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MOVING = {"turn": ("z",), "face": ("x",), "taper": ("x", "z")}  # the slides that feed
REFERENCE_DEPTH_MM = 2.0  # P1, note under Table 2
REFERENCE_FEED_MM = 0.2  # P1, note under Table 2
REFERENCE_RPM = 1000.0  # P1, note under Table 2
ENTERING_DEG = 93.0  # P1, note under Table 2: PDJNR2525M15
NOSE_MM = 0.8  # P1, note under Table 2: DNMG150608

# Process scatter of repeated cuts, relative to the force: P1 Table 2, sqrt(variance)/mean.
SCATTER_TANGENTIAL = math.sqrt(84.0) / 485.78  # 9.2 N at 486 N
SCATTER_THRUST = math.sqrt(320.0) / 325.78  # 17.9 N at 326 N; passive force: the same (assumed)

WORN_MM = 0.30  # flank wear at the end of an edge's life; chosen
LIFE_SPREAD = 0.12  # edges differ by up to this share of the life; chosen


@dataclass(frozen=True)
class TruePair:
    """One work-tool pair's truth: two forces of the reference cut and chosen shapes around it."""

    work: str
    tool: str
    tangential_N: float  # F_y of the reference cut, fresh edge
    feed_N: float  # feed force of the reference cut, fresh edge
    exponent_tangential: float = 0.24  # chip part ~ h^(1 - exponent); chosen
    exponent_thrust: float = 0.40  # chosen
    plough_tangential: float = 0.12  # share of ploughing in the reference cut; chosen
    plough_thrust: float = 0.26  # chosen
    plough_mm: float = 0.05  # uncut thickness at which ploughing saturates; chosen
    softening: float = 0.05  # chip part falls by up to this share with speed; chosen
    reference_m_min: float = 150.0  # speed of no softening; chosen
    worn_tangential: float = 0.40  # growth at WORN_MM, share of the reference force; chosen
    worn_thrust: float = 0.60  # chosen
    life_s: float = 1400.0  # cutting time to WORN_MM; chosen


@dataclass(frozen=True)
class TrueCut:
    """One pass at constant conditions; `diameter_mm` is the machined one (facing: its mean)."""

    speed_m_min: float
    feed_mm: float
    depth_mm: float
    diameter_mm: float
    operation: str  # a key of MOVING
    tool_edge: str
    cutting_time_s: float  # on this edge before the cut
    duration_s: float
    material: str
    inward_deg: float = 0.0  # a taper's path: from along the axis towards the axis

    @property
    def entering_rad(self) -> float:
        """Entering angle against the path: a path that dives towards the axis meets more edge."""
        return math.radians(ENTERING_DEG + self.inward_deg)

    @property
    def spindle_rpm(self) -> float:
        """Spindle speed n = 1000 v / (pi D), rpm; v m/min at the machined diameter D mm."""
        return 1000.0 * self.speed_m_min / (math.pi * self.diameter_mm)


ALUMINIUM = TruePair(
    "aluminium alloy",
    "DNMG150608-QM",
    tangential_N=485.78,  # P1 Table 2, row 1
    feed_N=325.78,  # P1 Table 2, row 1
    reference_m_min=188.5,  # 1000 rpm on 60 mm; P1's diameter varied and is not printed
)
STEEL = TruePair("steel bar", "carbide insert", 810.0, 420.0)  # chosen
BRASS = TruePair("brass", "carbide insert", 430.0, 170.0, exponent_tangential=0.15)  # chosen


def flank_wear_mm(pair: TruePair, tool_edge: str, time_s: float) -> float:
    """Flank wear runs in fast, grows steadily, then accelerates: three stages over an edge's life.

    VB = 0.02 (1 - e^(-t/25 s)) + 0.13 u + 0.15 u^7, mm, u = t/life. The edge's life is the pair's
    times 1 +- LIFE_SPREAD, fixed by the edge's name. Speed is left out. Shape and numbers: chosen.
    """
    lot = zlib.crc32(tool_edge.encode()) / 2**32
    used = time_s / (pair.life_s * (1.0 + LIFE_SPREAD * (2.0 * lot - 1.0)))
    return 0.02 * (1.0 - math.exp(-time_s / 25.0)) + 0.13 * used + 0.15 * used**7


def force_growth(
    chip_mm: float, chip_ref_mm: float, *, exponent: float, plough: float, plough_mm: float
) -> tuple[float, float]:
    """Chip and ploughing part of a force, relative to the reference cut at the same width.

    chip = (1 - p)(h/h0)^(1-m); plough = p (1 - e^(-h/hp))/(1 - e^(-h0/hp)); they sum to 1 at h0.
    """
    chip = (1.0 - plough) * (chip_mm / chip_ref_mm) ** (1.0 - exponent)
    saturation = math.expm1(-chip_mm / plough_mm) / math.expm1(-chip_ref_mm / plough_mm)
    return chip, plough * saturation


def thrust_angle_rad(depth_mm: float) -> float:
    """Angle of the thrust from the feed direction: a shallow cut sits on the nose and pushes away.

    psi = 0.22 + 0.5 r_nose/a_p (chosen), at most 1.2 rad.
    """
    return min(1.2, 0.22 + 0.5 * NOSE_MM / depth_mm)


def mean_forces_N(pair: TruePair, cut: TrueCut) -> Array:
    """Mean force (x, y, z) of the work on the tool without scatter, N, at the middle of the cut.

    With width b = a_p/sin k, chip thickness h = f sin k (k = 93 deg, more in a taper):
    F = F0 (b/b0) [chip(h) (1 - s tanh ln(v/v0)) + plough(h) + g VB/VB_end], for the tangential
    force and for the thrust, which splits into feed (cos psi) and passive force (sin psi).
    """
    lean, lean_ref = math.sin(cut.entering_rad), math.sin(math.radians(ENTERING_DEG))
    chip_mm, chip_ref_mm = cut.feed_mm * lean, REFERENCE_FEED_MM * lean_ref
    width = cut.depth_mm / REFERENCE_DEPTH_MM * lean_ref / lean
    speed = 1.0 - pair.softening * math.tanh(math.log(cut.speed_m_min / pair.reference_m_min))
    time_s = cut.cutting_time_s + 0.5 * cut.duration_s
    worn = flank_wear_mm(pair, cut.tool_edge, time_s) / WORN_MM

    def total(exponent: float, plough: float, grows: float) -> float:
        chip, edge = force_growth(
            chip_mm, chip_ref_mm, exponent=exponent, plough=plough, plough_mm=pair.plough_mm
        )
        return width * (chip * speed + edge + grows * worn)

    tangential_N = pair.tangential_N * total(
        pair.exponent_tangential, pair.plough_tangential, pair.worn_tangential
    )
    thrust_ref_N = pair.feed_N / math.cos(thrust_angle_rad(REFERENCE_DEPTH_MM))
    thrust_N = thrust_ref_N * total(pair.exponent_thrust, pair.plough_thrust, pair.worn_thrust)

    # Along the feed and away from the cut surface
    lean_rad = thrust_angle_rad(cut.depth_mm)
    x_N, z_N = _in_machine_axes(
        cut, feed_N=thrust_N * math.cos(lean_rad), passive_N=thrust_N * math.sin(lean_rad)
    )
    return np.array([x_N, tangential_N, z_N])


def _in_machine_axes(cut: TrueCut, *, feed_N: float, passive_N: float) -> tuple[float, float]:
    """Force on the tool along x and z, N, from that against the feed and that off the surface.

    Signs (contract): the tool feeds along -z in turning and -x in facing, the surface looks along
    +x and +z; a taper turns turning's frame by its angle.
    """
    if cut.operation == "face":
        return feed_N, passive_N
    angle = math.radians(cut.inward_deg)
    return (
        passive_N * math.cos(angle) + feed_N * math.sin(angle),
        feed_N * math.cos(angle) - passive_N * math.sin(angle),
    )


def true_forces_N(pair: TruePair, cut: TrueCut, rng: np.random.Generator) -> Array:
    """Mean force (x, y, z) that this one cut really had, N: `mean_forces_N` with process scatter.

    Independent normal factors, sd 1.89 % for y and 5.49 % for x and z (P1 Table 2, rows 1).
    """
    scatter = np.array([SCATTER_THRUST, SCATTER_TANGENTIAL, SCATTER_THRUST])
    return mean_forces_N(pair, cut) * (1.0 + scatter * rng.standard_normal(3))
