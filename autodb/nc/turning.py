"""Paths of longitudinal and facing cuts on a bar, cut after cut, bar after bar.

Program coordinates: x is the radius from the spindle's axis, z counts from the bar's first face
towards the tailstock. Every rapid stays outside the bar as it was clamped.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from autodb.errors import UnusableInput
from autodb.nc.steps import CutPath, StraightMove, feed, rapid
from autodb.standard import BarStock, CutProtocol, StandardCut


@dataclass(frozen=True)
class _Left:
    """What is left of a bar: radius of the turned part and z of its face, mm."""

    radius_mm: float
    face_mm: float


@dataclass(frozen=True)
class _Job:
    """One cut about to be made: the bar, what is left of it before, and distances, mm."""

    cut: StandardCut
    bar: BarStock
    left: _Left
    clearance_mm: float
    air_mm: float

    @property
    def outside_mm(self) -> float:
        """Radius at which the bar as clamped is passed."""
        return self.bar.diameter_mm / 2 + self.clearance_mm


def turning_paths(
    protocol: CutProtocol, bar: BarStock, cuts: Sequence[StandardCut], *, clearance_mm: float
) -> Iterator[CutPath]:
    """Yield the path of each cut in turn.

    Raises UnusableInput naming a cut that is no turning cut or that no new bar allows.
    """
    left = fresh = _Left(bar.diameter_mm / 2, 0.0)
    for cut in cuts:
        if cut.operation not in _MADE or cut.feed_mm_rev is None:
            raise UnusableInput(
                f"protocol '{protocol.name}': cut '{cut.name}': use 'turn' and 'face' with "
                "feed_mm_rev on a bar"
            )
        after = _after(cut, left)
        new_stock = not _allowed(after, bar)
        if new_stock:
            left, after = fresh, _after(cut, fresh)
        if not _allowed(after, bar):
            raise UnusableInput(
                f"protocol '{protocol.name}': cut '{cut.name}': depth_mm = {cut.depth_mm:g} is "
                "more than the bar allows"
            )
        air_mm = protocol.air_s * cut.feed_mm_rev * cut.speed_rpm / 60.0
        job = _Job(cut, bar, left, clearance_mm, air_mm)
        axis, lift_mm, moves = _MADE[cut.operation](job, after)
        yield CutPath(cut, moves, axis, lift_mm, new_stock)
        left = after


def _after(cut: StandardCut, left: _Left) -> _Left:
    thinner_mm, shorter_mm = _TAKES[cut.operation](cut.depth_mm or 0.0)
    return _Left(left.radius_mm - thinner_mm, left.face_mm - shorter_mm)


def _allowed(after: _Left, bar: BarStock) -> bool:
    return (
        2 * after.radius_mm >= bar.least_diameter_mm
        and after.face_mm + bar.length_mm >= bar.least_length_mm
    )


_Made = tuple[str, float, tuple[StraightMove, ...]]


def _turn(job: _Job, after: _Left) -> _Made:
    """Approach in front of the face, feed along z to the shoulder, off it, and out along x."""
    per, clear_mm = job.cut.feed_mm, job.clearance_mm
    start_mm = max(job.left.face_mm + clear_mm + job.air_mm, clear_mm)
    end_mm, radius_mm = -job.bar.length_mm, after.radius_mm
    moves = (
        rapid(z=start_mm),
        rapid(x=radius_mm),
        feed(per, z=end_mm),
        feed(per, x=radius_mm + clear_mm, z=end_mm + clear_mm),
        feed(per, x=job.outside_mm),
    )
    return "x", job.outside_mm - radius_mm, moves


def _face(job: _Job, after: _Left) -> _Made:
    """Approach outside the bar, feed along x to the hub, off it, and out along z."""
    per, clear_mm = job.cut.feed_mm, job.clearance_mm
    start_mm = max(job.left.radius_mm + clear_mm + job.air_mm, job.outside_mm)
    end_mm, face_mm = job.bar.hub_diameter_mm / 2, after.face_mm
    moves = (
        rapid(z=face_mm),
        rapid(x=start_mm),
        feed(per, x=end_mm),
        feed(per, x=end_mm + clear_mm, z=face_mm + clear_mm),
        feed(per, z=clear_mm),
    )
    return "z", clear_mm - face_mm, moves


_TAKES: dict[str, Callable[[float], tuple[float, float]]] = {
    "turn": lambda depth_mm: (depth_mm, 0.0),
    "face": lambda depth_mm: (0.0, depth_mm),
}
_MADE: dict[str, Callable[[_Job, _Left], _Made]] = {"turn": _turn, "face": _face}
