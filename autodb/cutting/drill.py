"""Drilling: two lips and the chisel edge between them, thrust and torque.

At radius ρ, from the web w to R, with κ half the point angle, θ the helix at the rim,

    h = f/2 sin κ    b = dρ / sin κ    sin i = w/ρ sin κ
    tan α = ρ/R tan θ / sin κ - tan ω cos κ    sin ω = w/ρ

what is across the axis cancels between the lips. The chisel edge, as wide as the web, stands at a
rake of -κ, and lips next to it at even less; a thin shear zone has no chip there (φ + β - α goes
beyond 90°), and what sticks to them is taken to cut at STUCK_DEG. So thrust, which the chisel edge
makes the most of, is a guess where torque is not. Source: geometry of a plain two-lip drill; the
web is a share of the diameter where it is not known.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.elements import Elements
from autodb.cutting.shear import Edge

Array = NDArray[np.float64]

ALONG_LIP = 16
STUCK_DEG = -30.0
"""Rake of what sticks to the chisel edge, and the least of a lip. Chosen: work in front of a blunt
edge slides at 30 to 45° to it."""
WEB_SHARE = 0.15
"""Thickness of the web over the diameter, where it is not known. Chosen: plain twist drills."""


@dataclass(frozen=True)
class Drill:
    """A two-lip drill: point angle between the lips, helix at the rim, thickness of the web."""

    diameter_mm: float
    point_deg: float = 118.0
    helix_deg: float = 30.0
    web_mm: float | None = None

    @property
    def half_web_mm(self) -> float:
        """Half the thickness of the web."""
        return 0.5 * (WEB_SHARE * self.diameter_mm if self.web_mm is None else self.web_mm)


@dataclass(frozen=True)
class DrilledCuts:
    """Cuts of one drill: arrays (n,): feed a revolution, spindle speed."""

    feed_mm: Array
    speed_rpm: Array


def drill_elements(drill: Drill, cuts: DrilledCuts) -> Elements:
    """Return the elements of lips and chisel edge of each cut; thrust pushes away from the work."""
    rim, web = 0.5 * drill.diameter_mm, drill.half_web_mm
    kappa = np.radians(0.5 * drill.point_deg)
    step = (rim - web) / ALONG_LIP
    radius = web + step * (np.arange(ALONG_LIP) + 0.5)
    lean = np.arcsin(web / radius)
    stuck = np.radians(STUCK_DEG)
    rake = np.arctan(
        radius / rim * np.tan(np.radians(drill.helix_deg)) / np.sin(kappa)
        - np.tan(lean) * np.cos(kappa)
    )
    rake = np.maximum(rake, stuck)

    # Lips, then the chisel edge, two of each
    where = np.append(radius, 0.5 * web)
    entering = np.append(np.full(ALONG_LIP, kappa), 0.5 * np.pi)
    width = 2.0 * np.append(np.full(ALONG_LIP, step / np.sin(kappa)), web)
    rpm = cuts.speed_rpm[:, None]
    return Elements(
        count=len(cuts.feed_mm),
        of=None,
        edge=Edge(
            0.5 * cuts.feed_mm[:, None] * np.sin(entering),
            2.0 * np.pi / 1000.0 * where * rpm,
            np.append(rake, stuck)[None],
            np.append(np.arcsin(np.sin(kappa) * web / radius), 0.0)[None],
        ),
        width_mm=width[None],
        kappa=(np.sin(entering)[None], np.cos(entering)[None]),
        phi=(np.ones((1, 1)), np.zeros((1, 1))),
        radius_mm=where[None],
        speed_rpm=cuts.speed_rpm,
        frames=np.array([[[0.0, 0.0, -1.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]]),
    )
