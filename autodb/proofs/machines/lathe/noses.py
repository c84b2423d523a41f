"""Inserts with a nose on the virtual lathe: thin depths are cut at a smaller entering angle.

Along the edge, from the finished surface up, places of width db lie at angles q to the feed, from 0
on the nose to the entering angle above it, and cut chips h = f sin q thick. The law of ``process``
sums up over them, each sum over that of the reference cut,

    F = F0 [(1 - p) C (1 - s tanh ln(v/v0)) + p P + g W VB/VB_end]

    C = sum h^(1-m) a db    P = sum (1 - e^(-h/h_p)) a db    W = sum a db

with a = 1 for the tangential force, and a = sin q, the share of a place's thrust that is against
the feed, for the feed force. The passive force stays that of ``process``, which pushes away the
more the less is cut.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from autodb.proofs.machines.lathe.process import (
    ENTERING_DEG,
    MOVING,
    NOSE_MM,
    REFERENCE_DEPTH_MM,
    REFERENCE_FEED_MM,
    WORN_MM,
    Array,
    TrueCut,
    TruePair,
    flank_wear_mm,
    mean_forces_N,
)

NOSE_PLACES = 60
"""Chosen: forces move by less than 0.1 % with twice as many (a test)."""
Law = tuple[float, float, float]
"""Exponent, ploughing and growth of a force with wear."""


@dataclass(frozen=True)
class EdgePlaces:
    """Places of an edge in a cut: their angles to the feed (m,), rad, and widths (m,), mm."""

    angle_rad: Array
    width_mm: Array

    def sums(self, pair: TruePair, exponent: float, feed_mm: float, across: Array) -> Array:
        """Return C, P and W (3,); ``across`` (m,): a."""
        h_mm = feed_mm * np.sin(self.angle_rad)
        each = h_mm ** (1.0 - exponent), -np.expm1(-h_mm / pair.plough_mm), np.ones_like(h_mm)
        return np.array([np.sum(one * across * self.width_mm) for one in each])


def edge_in_cut(entering_rad: float, depth_mm: float, nose_mm: float = NOSE_MM) -> EdgePlaces:
    """Return the places from the finished surface to the depth of cut."""
    height_mm = nose_mm * (1.0 - math.cos(entering_rad))
    rises = depth_mm < height_mm
    end_rad = math.acos(1.0 - depth_mm / nose_mm) if rises else entering_rad
    step_rad = end_rad / NOSE_PLACES
    straight_mm = max(0.0, depth_mm - height_mm) / math.sin(entering_rad)
    return EdgePlaces(
        np.append(step_rad * (np.arange(NOSE_PLACES) + 0.5), entering_rad),
        np.append(np.full(NOSE_PLACES, nose_mm * step_rad), straight_mm),
    )


def with_nose(pair: TruePair, cut: TrueCut) -> TruePair:
    """Return the pair whose straight edge takes in a cut what one with a nose takes of it, along
    the cutting speed and against the feed.
    """
    edge = edge_in_cut(cut.entering_rad, cut.depth_mm)
    standard = edge_in_cut(math.radians(ENTERING_DEG), REFERENCE_DEPTH_MM)
    speed = 1.0 - pair.softening * math.tanh(math.log(cut.speed_m_min / pair.reference_m_min))
    time_s = cut.cutting_time_s + 0.5 * cut.duration_s
    worn = flank_wear_mm(pair, cut.tool_edge, time_s) / WORN_MM

    def total(law: Law, across: Array, across_ref: Array) -> float:
        exponent, plough, grows = law
        sums = edge.sums(pair, exponent, cut.feed_mm, across)
        sums_ref = standard.sums(pair, exponent, REFERENCE_FEED_MM, across_ref)
        return float(np.array([(1.0 - plough) * speed, plough, grows * worn]) @ (sums / sums_ref))

    tangential = total(
        (pair.exponent_tangential, pair.plough_tangential, pair.worn_tangential),
        np.ones_like(edge.angle_rad), np.ones_like(standard.angle_rad),
    )  # fmt: skip
    feed = total(
        (pair.exponent_thrust, pair.plough_thrust, pair.worn_thrust),
        np.sin(edge.angle_rad), np.sin(standard.angle_rad),
    )  # fmt: skip
    straight_N = mean_forces_N(pair, cut)
    straight_feed_N = straight_N["xyz".index(MOVING[cut.operation][0])]
    return replace(
        pair,
        tangential_N=pair.tangential_N**2 * tangential / float(straight_N[1]),
        feed_N=pair.feed_N**2 * feed / float(straight_feed_N),
    )
