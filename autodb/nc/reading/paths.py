"""Moves of a turning tool in the plane of the spindle's axis: rapid, straight, along an arc.

x is the radius from the spindle's axis, z counts away from the chuck, both in mm in the program's
coordinates. Angles turn from +z towards +x: seen with z to the right and x up, against the clock.
"""

from dataclasses import dataclass
from functools import cached_property
from math import atan2, hypot, pi, tau
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_AT_THE_END = 1e-9
"""A share of a way that is its end, but for rounding."""


class Point(NamedTuple):
    """A place of the tool tip: radius and position along the axis, mm."""

    x_mm: float
    z_mm: float


@dataclass(frozen=True)
class PerRev:
    """A feed per revolution of the spindle, mm."""

    mm: float

    def mm_rev(self, speed_rpm: Array) -> Array:
        """Return the feed at each speed, (n,), mm/rev."""
        return np.full_like(speed_rpm, self.mm)


@dataclass(frozen=True)
class FeedPerMinute:
    """A feed per minute, mm; how far a revolution goes depends on the spindle."""

    mm: float

    def mm_rev(self, speed_rpm: Array) -> Array:
        """Return the feed at each speed, (n,), mm/rev."""
        return self.mm / speed_rpm


@dataclass(frozen=True)
class Revolutions:
    """A spindle that keeps its speed, rpm."""

    rpm: float

    def at_rpm(self, x_mm: Array) -> Array:
        """Return the spindle speed with the tool tip at each radius, (n,), rpm."""
        return np.full_like(x_mm, self.rpm)


@dataclass(frozen=True)
class CuttingSpeed:
    """A spindle that keeps the cutting speed at the tool tip, m/min, up to a limit, rpm."""

    m_min: float
    limit_rpm: float | None

    def at_rpm(self, x_mm: Array) -> Array:
        """Return n = 1000 v_c/(2π|x|) with the tool tip at each radius, (n,), rpm.

        Infinite on the axis where the program states no limit.
        """
        limit_rpm = np.inf if self.limit_rpm is None else self.limit_rpm
        with np.errstate(divide="ignore"):
            return np.minimum(1000.0 * self.m_min / (tau * np.abs(x_mm)), limit_rpm)


Feed = PerRev | FeedPerMinute
Speed = Revolutions | CuttingSpeed


@dataclass(frozen=True, slots=True)
class _Straight:
    start: Point
    end: Point

    @property
    def length_mm(self) -> float:
        """Length of the straight line, mm."""
        return distance_mm(self.start, self.end)

    def points(self, shares: Array) -> tuple[Array, Array]:
        """Return x and z, (n,), mm, at shares of the way, 0 to 1."""
        return _straight(self.start, self.end, shares)


@dataclass(frozen=True, slots=True)
class Rapid(_Straight):
    """A rapid; some controls move each axis at its own speed, not along the straight line."""

    line: int
    tool: str | None


@dataclass(frozen=True, slots=True)
class Linear(_Straight):
    """A straight move at a feed; ``thread``: it follows the spindle's angle."""

    feed: Feed
    speed: Speed
    line: int
    tool: str | None
    thread: bool = False


@dataclass(frozen=True)
class Arc:
    """A move along a circle at a feed; ``left`` turns from +z towards +x (G3), else G2.

    Where the end is off the circle by what a program rounds, the radius changes evenly on the way.
    """

    start: Point
    end: Point
    centre: Point
    left: bool
    feed: Feed
    speed: Speed
    line: int
    tool: str | None

    @cached_property
    def radius_mm(self) -> float:
        """Radius of the circle at the start, mm."""
        return distance_mm(self.centre, self.start)

    @cached_property
    def from_rad(self) -> float:
        """Angle of the start seen from the centre, rad."""
        return atan2(self.start.x_mm - self.centre.x_mm, self.start.z_mm - self.centre.z_mm)

    @cached_property
    def sweep_rad(self) -> float:
        """Angle passed, rad: positive to the left; a whole turn where the end is the start."""
        if self.start == self.end:
            return tau if self.left else -tau
        to_rad = atan2(self.end.x_mm - self.centre.x_mm, self.end.z_mm - self.centre.z_mm)
        turned = (to_rad - self.from_rad) % tau
        return turned if self.left else turned - tau

    @property
    def length_mm(self) -> float:
        """Length of the way, mm."""
        mean_mm = (self.radius_mm + distance_mm(self.centre, self.end)) / 2
        return abs(self.sweep_rad) * mean_mm

    def points(self, shares: Array) -> tuple[Array, Array]:
        """Return x and z, (n,), mm, at shares of the way, 0 to 1."""
        angle = self.from_rad + shares * self.sweep_rad
        end_mm = distance_mm(self.centre, self.end)
        radius_mm = self.radius_mm + shares * (end_mm - self.radius_mm)
        x_mm = self.centre.x_mm + radius_mm * np.sin(angle)
        z_mm = self.centre.z_mm + radius_mm * np.cos(angle)
        return x_mm, z_mm

    def turning_shares(self) -> Array:
        """Return the shares of the way at which the tangent passes a multiple of 45°, in order."""
        eighth = pi / 4
        low, high = sorted((self.from_rad, self.from_rad + self.sweep_rad))
        at_rad = eighth * np.arange(np.floor(low / eighth) + 1, np.ceil(high / eighth))
        shares = np.sort((at_rad - self.from_rad) / self.sweep_rad)
        return shares[(shares > _AT_THE_END) & (shares < 1.0 - _AT_THE_END)]


Move = Rapid | Linear | Arc


def distance_mm(a: Point, b: Point) -> float:
    """Return the distance of two places, mm."""
    return hypot(b.x_mm - a.x_mm, b.z_mm - a.z_mm)


def _straight(start: Point, end: Point, shares: Array) -> tuple[Array, Array]:
    x_mm = start.x_mm + shares * (end.x_mm - start.x_mm)
    z_mm = start.z_mm + shares * (end.z_mm - start.z_mm)
    return x_mm, z_mm
