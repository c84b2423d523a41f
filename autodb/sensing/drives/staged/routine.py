"""The staged routine of a ball-screw axis: passes, then one stage after the other (P2 III)."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.sensing.drives.moves.prepared import Prepared
from autodb.sensing.drives.staged.along_travel import Along, along_travel
from autodb.sensing.drives.staged.segments import Averages, averages, length_of
from autodb.sensing.drives.staged.stages import (
    Stages,
    inertia_told,
    laws_told,
    middle_of,
    passes_at_speeds,
    stage_friction,
    stretch_of,
    warming_told,
)
from autodb.sensing.drives.staged.weight import Weight, weight_of
from autodb.wording import phrase

Array = NDArray[np.float64]

TURN = 3
"""Segments of the middle at least: a turn of the screw, over which its ripple is no friction."""


@dataclass(frozen=True)
class Staged(Stages):
    """What P2's stages found, in the effort's unit."""

    averages: Averages
    weight: Weight
    along: Along

    def friction(self, x_mm: Array, speed_mm_s: Array, sense: int) -> tuple[Array, Array]:
        """Return the size of friction (n,) at places and speeds (n,) in a direction, and its sd."""
        value, sd = self.laws[sense].at(speed_mm_s)
        gain, gain_sd = self.along.at(x_mm)
        return value + gain, np.sqrt(sd**2 + gain_sd**2 + self.weight.sd**2)

    def steady(self, x_mm: Array, velocity_mm_s: Array, factor: Array) -> Array:
        """Return weight and friction (n,), friction warmed by a factor (n,)."""
        speed = np.abs(velocity_mm_s)
        size = np.where(
            velocity_mm_s > 0, *(self.friction(x_mm, speed, s)[0] for s in (1, -1))
        )  # fmt: skip
        return np.asarray(self.weight.value + np.sign(velocity_mm_s) * size * factor)


def staged(rows: Prepared, *, pitch_mm: float | None, cold: bool) -> Staged:
    """Run the stages on one axis' recording.

    ``pitch_mm`` of the screw, None where it is not known; ``cold``: refer friction to a cold axis,
    by the warming that the passes show, so that it compares with a joint fit that has `warmup`.

    Raises UnusableInput for a spindle or a rotary axis, and where passes are too few or were not
    repeated.
    """
    passes, position = passes_at_speeds(rows), rows.inputs["position"]
    if not any(one.repeat for one in passes):
        raise UnusableInput(
            phrase(
                "{file}: no speed of {axis} was passed twice in one direction, so the scatter "
                "between passes cannot be estimated; use the moves that 'autodb sweep' writes",
                file=rows.path,
                axis=rows.axis,
            )
        )
    length = length_of(passes, position, rows.whole_effort, pitch_mm=pitch_mm)
    stretch = stretch_of(rows, passes, length)
    cut, smooth = stretch.cut, stretch.smooth
    weight = weight_of(cut, stretch.effort, stretch.told, path=rows.path)
    seen = cut.sense * (stretch.effort - weight.value)
    warming = warming_told(stretch, seen, rows.inputs)
    friction = stage_friction(rows, cut, seen, warming if cold else None)
    middle = np.isin(cut.place, middle_of(passes, cut, TURN))
    found = Staged(
        passes=passes,
        length=length,
        averages=averages(cut, stretch.effort, seen, stretch.stuck),
        verdicts=stretch.verdicts,
        weight=weight,
        laws=laws_told(stretch, friction, middle, rows.path),
        along=along_travel(
            cut.some(smooth), friction.size[smooth], position,
            period_mm=length.period_mm, middle_mm=cut.x_mm[middle],
        ),
        warming=warming,
        inertia=None,
        cold=cold and warming is not None,
    )  # fmt: skip
    return replace(found, inertia=inertia_told(rows, found.laws, found.steady, friction.factor))
