"""The centre of an arc, from its radius or from where the centre lies.

The plane is seen with z to the right and x up: G2 turns with the clock, G3 against it, as on a
lathe whose tool is behind the work; programs for one in front of it read the same.
"""

from math import hypot, sqrt

from autodb.nc.reading.moves import Point

OFF_CIRCLE_MM = 0.01
"""How far rounding may put the end of an arc off its circle. Chosen: ten steps of a thousandth."""


def centre_by_radius(start: Point, end: Point, *, radius_mm: float, left: bool) -> Point | None:
    """Return the centre of the arc of a radius R over a chord, or None where none reaches.

    R > 0 takes the arc up to 180°, R < 0 the one above. With half chord l: the centre lies
    √(R² − l²) off the middle of the chord, to the left of it for a short arc to the left. None
    where start is end and where l exceeds |R| by more than OFF_CIRCLE_MM.
    """
    along_x, along_z = end.x_mm - start.x_mm, end.z_mm - start.z_mm
    half_mm = hypot(along_x, along_z) / 2
    if half_mm == 0 or half_mm > abs(radius_mm) + OFF_CIRCLE_MM:
        return None
    off_mm = sqrt(max(radius_mm**2 - half_mm**2, 0.0))
    share = off_mm / (2 * half_mm) * (1 if left == (radius_mm > 0) else -1)
    return Point(
        (start.x_mm + end.x_mm) / 2 + share * along_z,
        (start.z_mm + end.z_mm) / 2 - share * along_x,
    )


def off_circle_mm(start: Point, end: Point, centre: Point) -> float:
    """Return how far the end lies off the circle through the start, mm."""
    radius_mm = hypot(start.x_mm - centre.x_mm, start.z_mm - centre.z_mm)
    return abs(hypot(end.x_mm - centre.x_mm, end.z_mm - centre.z_mm) - radius_mm)
