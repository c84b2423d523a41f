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
NOSE_PLACES = 60  # chosen: forces move by less than 0.1 % with twice as many (a test)

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
    nose_mm: float = 0.0  # rounds the edge's tip; 0: straight, its thrust leans by thrust_angle_rad


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


def thrust_angle_rad(depth_mm: float) -> float:
    """Angle of the thrust from the feed direction: a shallow cut sits on the nose and pushes away.

    psi = 0.22 + 0.5 r_nose/a_p (chosen), at most 1.2 rad.
    """
    return min(1.2, 0.22 + 0.5 * NOSE_MM / depth_mm)


@dataclass(frozen=True)
class EdgePlaces:
    """Places of the edge in a cut, (m,) each: angle to the feed, rad, width, mm, and the shares of
    their thrust that are against the feed and off the cut surface.
    """

    angle_rad: Array
    width_mm: Array
    along: Array
    away: Array

    def parts(self, pair: TruePair, exponent: float, feed_mm: float, share: Array) -> Array:
        """Sums over the places of h^(1-m), of 1 - e^(-h/h_p) and of 1, (3,), h = f sin q."""
        h_mm = feed_mm * np.sin(self.angle_rad)
        each = h_mm ** (1.0 - exponent), -np.expm1(-h_mm / pair.plough_mm), np.ones_like(h_mm)
        return np.array([np.sum(one * share * self.width_mm) for one in each])


def edge_in_cut(pair: TruePair, entering_rad: float, depth_mm: float) -> EdgePlaces:
    """The edge from the finished surface to the depth of cut.

    A nose begins at an angle of 0 and rises to the entering angle, or to the depth of cut; each of
    its places pushes across itself. Without a nose the edge is one straight place.
    """
    if pair.nose_mm == 0.0:
        lean_rad = thrust_angle_rad(depth_mm)
        angle_rad, width_mm = np.array([entering_rad]), depth_mm / np.sin([entering_rad])
        return EdgePlaces(angle_rad, width_mm, np.cos([lean_rad]), np.sin([lean_rad]))
    height_mm = pair.nose_mm * (1.0 - math.cos(entering_rad))
    rises = depth_mm < height_mm
    end_rad = math.acos(1.0 - depth_mm / pair.nose_mm) if rises else entering_rad
    step_rad = end_rad / NOSE_PLACES
    straight_mm = max(0.0, depth_mm - height_mm) / math.sin(entering_rad)
    angle_rad = np.append(step_rad * (np.arange(NOSE_PLACES) + 0.5), entering_rad)
    width_mm = np.append(np.full(NOSE_PLACES, pair.nose_mm * step_rad), straight_mm)
    return EdgePlaces(angle_rad, width_mm, np.sin(angle_rad), np.cos(angle_rad))


def mean_forces_N(pair: TruePair, cut: TrueCut) -> Array:
    """Mean force (x, y, z) of the work on the tool without scatter, N, at the middle of the cut.

    Along the edge, places of width db at an angle q to the feed (k = 93 deg, more in a taper; on a
    nose all angles up to it) cut chips h = f sin q thick:

    F = F0 [(1 - p) C (1 - s tanh ln(v/v0)) + p P + g W VB/VB_end]

    with C = sum h^(1-m) db of the chip, P = sum (1 - e^(-h/h_p)) db of ploughing and W = sum db of
    wear, each over that of the reference cut; so for the tangential force and for the thrust, which
    splits into feed (cos psi, on a nose sin q) and passive force (sin psi, cos q).
    """
    edge = edge_in_cut(pair, cut.entering_rad, cut.depth_mm)
    standard = edge_in_cut(pair, math.radians(ENTERING_DEG), REFERENCE_DEPTH_MM)
    speed = 1.0 - pair.softening * math.tanh(math.log(cut.speed_m_min / pair.reference_m_min))
    time_s = cut.cutting_time_s + 0.5 * cut.duration_s
    worn = flank_wear_mm(pair, cut.tool_edge, time_s) / WORN_MM

    def total(law: tuple[float, float, float], share: Array, share_ref: Array) -> float:
        exponent, plough, grows = law
        parts = edge.parts(pair, exponent, cut.feed_mm, share)
        parts_ref = standard.parts(pair, exponent, REFERENCE_FEED_MM, share_ref)
        weights = np.array([(1.0 - plough) * speed, plough, grows * worn])
        return float(weights @ (parts / parts_ref))

    whole, whole_ref = np.ones_like(edge.along), np.ones_like(standard.along)
    tangential = pair.exponent_tangential, pair.plough_tangential, pair.worn_tangential
    thrust = pair.exponent_thrust, pair.plough_thrust, pair.worn_thrust
    x_N, z_N = _in_machine_axes(
        cut,
        feed_N=pair.feed_N * total(thrust, edge.along, standard.along),
        passive_N=pair.feed_N * total(thrust, edge.away, standard.along),
    )
    return np.array([x_N, pair.tangential_N * total(tangential, whole, whole_ref), z_N])


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
