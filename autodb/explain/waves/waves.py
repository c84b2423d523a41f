"""A simulation of milled forces as waves of teeth: the mill, how its law is seen, and its angle.

The angle of the spindle counts from tooth 0 at φ = 0 (contract); where it was not recorded, the
passing of teeth tells it, up to a constant.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.explain.waves.law import ReadLaw
from autodb.explain.waves.teeth import SLICES, TURN, Mill, Teeth, contrasts
from autodb.records.tables import Recording
from autodb.wording import phrase
from autodb.wording.kept import said_again

Array = NDArray[np.float64]

ENTRY = 0.3
"""Share of the time in the work, its first, in which the mill may still come in."""
MOSTLY = 0.4
"""Share of the time in the work after which a curve would be drawn on too far before."""


@dataclass(frozen=True)
class Waves:
    """A simulation as waves of teeth: rows (n,), components (C,) in the recording's frame.

    ``frames`` (C, 3, n): from the feed's frame to the recorded components; ``law``: what it
    follows; ``fits``: share of the simulation's squares that this gives. ``uneven`` (z - 1, 3):
    N/mm that teeth make otherwise than their mean, in directions of ``contrasts``, of a simulation
    that has a run-out of its own; None: its teeth are alike.
    """

    names: tuple[str, ...]
    t_s: Array
    teeth: Teeth
    frames: Array
    law: ReadLaw
    simulation: Array
    fits: float
    uneven: Array | None = None

    @property
    def made(self) -> Array:
        """What the law and the simulation's own run-out make (C, n)."""
        return self.seen(self.teeth.forces(self.law.whole)) + self.runout

    @property
    def runout(self) -> Array:
        """What the simulation's own run-out adds (C, n)."""
        if self.uneven is None:
            return np.zeros_like(self.simulation)
        return np.asarray(
            np.einsum("kw,kwcn->cn", self.uneven, self.between_teeth(self._contrasts))
        )

    @property
    def _contrasts(self) -> Array:
        return contrasts(self.teeth.mill.teeth)

    def at(self, rows: NDArray[np.intp]) -> "Waves":
        """Return the same at some rows."""
        teeth = replace(
            self.teeth,
            angle_rad=self.teeth.angle_rad[rows],
            engaged=self.teeth.engaged[rows],
            reach=self.teeth.reach[rows],
        )
        return replace(
            self,
            t_s=self.t_s[rows],
            teeth=teeth,
            frames=self.frames[:, :, rows],
            simulation=self.simulation[:, rows],
        )

    def between_teeth(self, shape: Array) -> Array:
        """Return what edges make that differ from tooth to tooth, each way (k, 3, C, n).

        ``shape`` (z, k): N/mm of each tooth.
        """
        return self.seen(self.teeth.between_teeth(shape))

    def seen(self, forces: Array) -> Array:
        """Return forces (..., 3, n) of the feed's frame as the recording has them, (..., C, n)."""
        return np.asarray(np.einsum("cin,...in->...cn", self.frames, forces))


def mill_of(recording: Recording) -> Mill:
    """Return the mill and its cut as a side file states them; raises UnusableInput naming gaps."""
    tool, cut = recording.side.tool, recording.side.cut
    lacking = [
        name
        for name, value in {
            "[tool] diameter_mm": tool.diameter_mm,
            "[tool] teeth": tool.teeth,
            "[cut] depth_mm": cut.depth_mm,
            "[cut] feed_mm_tooth": cut.feed_mm_tooth,
        }.items()
        if value is None
    ]
    if lacking:
        raise UnusableInput(
            phrase(
                "{file}: force over time needs the mill and its cut; state {names} in a side file",
                file=recording.path,
                names=", ".join(lacking),
            )
        )
    assert tool.diameter_mm and tool.teeth and cut.depth_mm and cut.feed_mm_tooth
    helix = np.radians(tool.helix_deg or 0.0)
    twist_rad = float(cut.depth_mm * np.tan(helix) / (0.5 * tool.diameter_mm))
    return Mill(
        teeth=tool.teeth,
        twist_rad=twist_rad,
        depth_mm=cut.depth_mm,
        feed_mm=cut.feed_mm_tooth,
        arc=_arc(cut.operation, cut.width_mm or tool.diameter_mm, tool.diameter_mm),
        direction_rad=float(np.radians(cut.feed_direction_deg or 0.0)),
        slices=SLICES if twist_rad else 1,
    )


def _arc(operation: str | None, width_mm: float, diameter_mm: float) -> tuple[float, float]:
    angle = float(np.arccos(np.clip(1.0 - 2.0 * width_mm / diameter_mm, -1.0, 1.0)))
    if operation == "side-up":
        return 0.0, angle
    if operation == "side-down":
        return np.pi - angle, np.pi
    return 0.0, np.pi


def heard(recording: Recording, mill: Mill, forces: Array, engaged: Array, reach: Array) -> Array:
    """Return the angle (n,), rad, that teeth passing in forces (C, n) tell, up to a constant.

    It is told where all of the arc is in the work, and goes on from there: by a line where that is
    but a part of the cut.

    Raises UnusableInput where the speed is not known, or there is a gap.
    """
    speed = recording.get("spindle.speed")
    rpm = recording.side.cut.speed_rpm if speed is None else float(np.median(speed))
    if rpm is None:
        raise UnusableInput(
            phrase(
                "{file}: neither spindle.angle nor spindle.speed, and no speed_rpm in its side "
                "file; record one of them or state it there",
                file=recording.path,
            )
        )
    if len(recording.pieces) > 1:
        raise UnusableInput(
            phrase(
                "{file}: column 't': {timing}; teeth cannot be followed over a gap: record "
                "spindle.angle, or give one piece as a file of its own ({parted})",
                file=recording.path,
                timing=said_again(str(recording.timing)),
                parted=recording.timing.parted(recording.t_s),
            )
        )
    t = recording.t_s
    passing = mill.teeth * rpm / 60.0
    rows = np.flatnonzero(engaged > 0.0)
    turning = np.exp(-1j * TURN * passing * t[rows])
    strongest = forces[int(np.argmax(np.std(forces[:, rows], axis=1)))][rows]
    slow = (strongest - strongest.mean()) * turning
    window = max(3, round(3.0 / (passing * recording.timing.step_s)))
    smooth = np.convolve(slow, np.hanning(window + 2), mode="same")
    first = max(int(ENTRY * len(rows)), int(np.searchsorted(reach[rows], 1.0)))
    steady = slice(min(first, 2 * len(rows) // 3), len(rows) - window)
    phase = np.unwrap(np.angle(smooth[steady]))
    degree = 3 if first < MOSTLY * len(rows) else 1
    course = np.polynomial.Polynomial.fit(t[rows][steady], phase, degree)
    slope = course.deriv()
    low, high = t[rows][steady][[0, -1]]
    inside = np.clip(t, low, high)
    beyond = (t - inside) * slope(inside)
    return np.asarray((TURN * passing * t + course(inside) + beyond) / mill.teeth)
