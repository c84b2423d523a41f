"""How far from the axis the edge cuts, over a recording: in facing the torque falls with it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.turning import TURNED
from autodb.records.tables import Recording

Array = NDArray[np.float64]

LEAST_SHARE = 0.5
"""Share of the radius where the cut begins below which a cut is left out of the averages: torque,
range and radius are then of the same moment, and near the axis a spindle's range says little of its
torque. Chosen."""
CHANGES = 0.1
"""Share of the radius by which it changes, from which on the torque's fall is looked at. Chosen."""


@dataclass(frozen=True)
class RadiusCourse:
    """The edge's radius over the samples of a recording, (n,), mm.

    ``moved_mm``: how far it has moved away from the axis since the first sample; ``begins_mm``: the
    radius of a cut that begins at the sample.
    """

    moved_mm: Array
    begins_mm: Array

    @property
    def changes(self) -> bool:
        """Whether the radius changes enough for the torque to fall or rise with it."""
        return float(np.ptp(self.moved_mm)) > CHANGES * float(np.median(self.begins_mm))

    def until(self, end: int) -> "RadiusCourse":
        """Return the course up to a sample."""
        return RadiusCourse(self.moved_mm[:end], self.begins_mm[:end])

    def of_cut(self, begin: int) -> Array:
        """Return the radius (n,) of a cut that begins at a sample; 0 beyond the axis."""
        moved = self.moved_mm - self.moved_mm[begin]
        return np.asarray(np.maximum(self.begins_mm[begin] + moved, 0.0))

    def high(self, begin: int, cut: slice) -> slice:
        """Return the part of a cut, which begins at a sample, that is far enough from the axis."""
        radius = self.of_cut(begin)
        low = np.flatnonzero(radius[cut] < LEAST_SHARE * radius[begin])
        return slice(cut.start, cut.start + int(low[0])) if low.size else cut


def radius_course(recording: Recording, speed_rpm: Array | None) -> RadiusCourse | None:
    """Return the radius over a recording of a turned cut; None where it is not known.

    ``work.diameter`` where it is recorded. Else the side file's, at which the cut begins, and from
    there the way of x, where it is recorded, or the feed at ``speed_rpm`` (n,).
    """
    side = recording.side.cut
    recorded = recording.get("work.diameter")
    if recorded is not None:
        radius = 0.5 * recorded
        moved = np.zeros_like(radius) if side.operation == "turn" else radius - radius[0]
        return RadiusCourse(moved, np.maximum(radius, 1e-3))
    if side.operation not in TURNED or side.work_diameter_mm is None:
        return None
    moved = _moved_mm(recording, speed_rpm)
    if moved is None:
        return None
    return RadiusCourse(moved, np.full(len(recording), 0.5 * side.work_diameter_mm))


def _moved_mm(recording: Recording, speed_rpm: Array | None) -> Array | None:
    """Return how far the edge has moved away from the axis since the first sample, (n,).

    Along a cylinder x stands: what it moves before and after is no radius of the cut.
    """
    side = recording.side.cut
    if side.operation == "turn":
        return np.zeros(len(recording))
    x_mm, x_mm_s = recording.get("x.position"), recording.get("x.velocity")
    if x_mm is not None:
        return np.asarray(x_mm - x_mm[0])
    steps_s = np.diff(recording.t_s, prepend=recording.t_s[0])
    if x_mm_s is not None:
        return np.cumsum(x_mm_s * steps_s)
    usual_deg = {"turn": 0.0, "face": 90.0}.get(str(side.operation))
    lean_deg = usual_deg if side.feed_direction_deg is None else side.feed_direction_deg
    if side.feed_mm_rev is None or speed_rpm is None or lean_deg is None:
        return None
    inward_mm_s = side.feed_mm_rev * speed_rpm / 60.0 * np.sin(np.radians(lean_deg))
    return np.asarray(-np.cumsum(inward_mm_s * steps_s))
