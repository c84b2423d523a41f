"""Turning with an insert: which of its edge cuts, as elements of the nose and of the edge behind.

Seen along the feed the edge begins at the lowest point of the nose, where the finished surface is
left, and turns up to the entering angle κ_r. With q the angle of an element to the feed

    h = f sin q    b = r_ε dq on the nose, a straight edge behind it    height r_ε (1 - cos q)

up to the depth of cut, so that the chip's cross-section is a_p f whatever the nose; the cusp that
the feed leaves is not in it.

The inclination is ISO 3002's λ_s, positive where the tip is the first to meet the work: the rake
face then pulls the tool towards the surface, and a negative one pushes it off. The law's i is that
of an edge whose tip is the last, so that its F_a is away from the tip: i = -λ_s (a test resolves
the vectors in machine axes).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.cutting import turning
from autodb.cutting.elements import Elements
from autodb.cutting.shear import Edge
from autodb.errors import UnusableInput
from autodb.wording import localized, phrase

Array = NDArray[np.float64]

ON_NOSE = 19
"""Elements of the nose; one more is the straight edge behind it. Off an integral over 400 by less
than 0.05 % (a test)."""
TANGENTIAL = (0.0, 1.0, 0.0)
CREEP_M_MIN = 1.0
"""Speed below which the law stays as it is there: near the centre of a face the work hardly moves.
Chosen: cutting speeds of metals begin at some m/min."""
SQUARE_RAD = 1e-3
"""Off square to the axis by less, a path away from it is a face cut outward, by a tool of the other
hand: the edge that faces meets the work mirrored. The edge behind the feed would all but lie in it
(at 3 to 5° for κ_r 93 to 95°)."""
STEEPEST_RAD = np.pi / 4.0
"""A path that dives more steeply to the axis than this faces: the edge's other side cuts. Chosen:
half way between longitudinal and facing."""


@dataclass(frozen=True)
class Insert:
    """An insert in its holder: nose radius, entering angle κ_r, normal rake, inclination λ_s.

    ``included_deg``: angle between its two edges; None where it is not known, and the edge that
    faces then meets the work at κ_r too (as of an 80° insert at 95°). ``least_deg``: the angle to
    the path that the edge has at least, of a holder that is taken to be one that can follow it;
    None: it is as stated, and a path that it cannot follow is refused.
    """

    nose_radius_mm: float
    kappa_deg: float
    rake_deg: float = 0.0
    inclination_deg: float = 0.0
    included_deg: float | None = None
    least_deg: float | None = None

    @property
    def facing_deg(self) -> float:
        """Entering angle of the edge that cuts when the tool feeds to the axis."""
        if self.included_deg is None:
            return self.kappa_deg
        return 270.0 - self.kappa_deg - self.included_deg


@dataclass(frozen=True)
class TurnedCuts:
    """Cuts that one insert turns: arrays (n,).

    ``feed_mm`` a revolution, ``depth_mm`` across the feed, ``radius_mm`` arm of the torque, and
    ``speed_m_min`` the speed there;
    ``inward_rad``: from feeding along the axis to the chuck (0) towards the axis (π/2: facing) or
    away from it (-π/2: facing outward).
    """

    feed_mm: Array
    depth_mm: Array
    speed_m_min: Array
    radius_mm: Array
    inward_rad: Array


def insert_elements(insert: Insert, cuts: TurnedCuts, *, on_nose: int = ON_NOSE) -> Elements:
    """Return the elements of the engaged edge of each cut: on_nose + 1 a cut.

    Raises UnusableInput where the feed leaves the edge no side to cut with.
    """
    (made,) = elements_of_each([insert], cuts, on_nose=on_nose)
    return made


def elements_of_each(
    inserts: Sequence[Insert], cuts: TurnedCuts, *, on_nose: int = ON_NOSE
) -> list[Elements]:
    """Return the elements of the same cuts with each of several inserts, worked out together.

    Raises UnusableInput as ``insert_elements`` does.
    """
    entering = _entering(inserts, cuts.inward_rad)
    nose = np.array([[one.nose_radius_mm] for one in inserts])
    height = nose * (1.0 - np.cos(entering))
    full = cuts.depth_mm >= height
    within = np.arccos(np.maximum(1.0 - cuts.depth_mm / np.maximum(nose, 1e-12), -1.0))

    # The nose in steps of one angle, each element at the angle that has the chip's mean thickness
    step = np.where(full, entering, within) / on_nose
    angle, width = np.empty((2, *entering.shape, on_nose + 1))
    angle[..., :-1] = step[..., None] * np.arange(0.5, on_nose)
    angle[..., -1] = entering
    sin, cos = np.sin(angle), np.cos(angle)
    width[..., :-1] = (nose * step)[..., None]
    width[..., -1] = np.where(full, (cuts.depth_mm - height) / sin[..., -1], 0.0)
    thin = cuts.feed_mm[:, None] * sin
    thin[..., :-1] *= (np.sin(0.5 * step) / (0.5 * step))[..., None]

    area = thin * width
    along, across = np.vecdot(area, sin)[..., None], np.vecdot(area, cos)[..., None]
    whole = np.hypot(along, across)
    flow = along / whole, across / whole
    angles = np.radians([[[one.rake_deg, one.inclination_deg]] for one in inserts])
    rake, inclined = angles[..., :1], angles[..., 1:]
    upright, frames = (np.ones((1, 1)), np.zeros((1, 1))), _frames(cuts.inward_rad)
    return [
        Elements(
            count=len(cuts.feed_mm),
            of=None,
            edge=Edge(
                thin[k],
                np.maximum(cuts.speed_m_min, CREEP_M_MIN)[:, None],
                rake[k],
                -inclined[k],
            ),
            width_mm=width[k],
            kappa=(sin[k], cos[k]),
            phi=upright,
            radius_mm=cuts.radius_mm[:, None],
            speed_rpm=turning.speed_rpm(2.0 * cuts.radius_mm, cuts.speed_m_min),
            frames=frames,
            flow=(flow[0][k], flow[1][k]),
        )
        for k in range(len(inserts))
    ]


def _entering(inserts: Sequence[Insert], inward_rad: Array) -> Array:
    """Return the angle (v, n) between the feed and the edge that cuts, of each insert."""
    outward = np.abs(inward_rad + 0.5 * np.pi) < SQUARE_RAD
    dives = (inward_rad <= STEEPEST_RAD) & ~outward
    along = np.radians([[one.kappa_deg] for one in inserts]) + inward_rad
    least = np.radians([[-np.inf if o.least_deg is None else o.least_deg] for o in inserts])
    along = np.maximum(along, least)
    across = np.radians([[one.facing_deg] for one in inserts]) + (0.5 * np.pi - np.abs(inward_rad))
    entering = np.where(dives, along, across)
    refused = (entering <= 0) | (entering >= np.pi)
    if refused.any():
        which = int(np.argmax(refused.any(axis=1)))
        worst = np.degrees(inward_rad[np.argmax(np.abs(entering[which] - 0.5 * np.pi))])
        raise UnusableInput(
            phrase(
                "an edge at {kappa_deg}° cannot follow a feed {worst}° off the axis; use a "
                "tool with another kappa_deg or included_deg",
                kappa_deg=localized(f"{inserts[which].kappa_deg:g}"),
                worst=localized(f"{worst:g}"),
            )
        )
    return np.asarray(entering)


def _frames(inward_rad: Array) -> Array:
    """Return rows feed, tangential and off the surface in machine axes (n, 3, 3)."""
    dives = inward_rad <= STEEPEST_RAD
    side = np.where(dives, 1.0, -1.0)
    sin, cos = np.sin(inward_rad), np.cos(inward_rad)
    rows = np.zeros((len(inward_rad), 3, 3))
    rows[:, 0, 0], rows[:, 0, 2] = -sin, -cos
    rows[:, 1] = TANGENTIAL
    rows[:, 2, 0], rows[:, 2, 2] = side * cos, -side * sin
    return rows
