"""The staged routine of a linear drive, in four steps (P0 section 2.2).

One and two: the load over the travel, a line and a table of a pole. Three: friction over speed.
Four: inertia. Passes, friction, warming and inertia are the stages that ball screws have too.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.sensing.drives.moves.passes import SpeedPass, both_ways
from autodb.sensing.drives.moves.prepared import Prepared
from autodb.sensing.drives.staged.load import TravelLoad, patches, travel_load_of
from autodb.sensing.drives.staged.over_speed import STRIBECK_LEVELS
from autodb.sensing.drives.staged.segments import TRAVEL_SHARE, Length
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
from autodb.terms.ripple import NODES
from autodb.wording import localized, phrase

Array = NDArray[np.float64]

MIDDLE = NODES // 3
"""Segments of the middle at least, a third of a pole: the slowest passes cross little more. Chosen.
"""


@dataclass(frozen=True)
class FourSteps(Stages):
    """What P0's four steps found, in the effort's unit.

    Friction is that of the places ``middle_mm`` (k,), and ``middle_sd`` how unsure the load is
    there. ``repeated``: whether some speed was passed twice in one direction; where not, errors of
    friction are from what its law leaves, and how runs differ is not in them.
    """

    load: TravelLoad
    middle_mm: Array
    middle_sd: float
    repeated: bool

    def friction(self, speed_mm_s: Array, sense: int) -> tuple[Array, Array]:
        """Return the size of friction (n,) at speeds (n,) in a direction, and its sd."""
        value, sd = self.laws[sense].at(speed_mm_s)
        return value, np.hypot(sd, self.middle_sd)

    def steady(self, x_mm: Array, velocity_mm_s: Array, factor: Array) -> Array:
        """Return load and friction (n,), friction warmed by a factor (n,)."""
        speed = np.abs(velocity_mm_s)
        size = np.where(velocity_mm_s > 0, *(self.friction(speed, s)[0] for s in (1, -1)))
        return np.asarray(self.load.at(x_mm) + np.sign(velocity_mm_s) * size * factor)


def four_steps(rows: Prepared, *, pole_mm: float | None, cold: bool) -> FourSteps:
    """Run the four steps on one axis' recording.

    ``pole_mm``: the way after which cogging repeats, None where there is none; ``cold`` as in
    ``staged``.

    Raises UnusableInput for a spindle or a rotary axis, and where passes are too few.
    """
    passes, position = passes_at_speeds(rows), rows.inputs["position"]
    repeated = any(one.repeat for one in passes)
    if not repeated:
        _refuse_few_speeds(passes, rows)
    stretch = stretch_of(rows, passes, _length(passes, pole_mm))
    cut = stretch.cut
    load = travel_load_of(stretch, position, axis=rows.axis, path=rows.path)
    seen = cut.sense * (stretch.effort - cut.means(load.at(position)))
    warming = warming_told(stretch, seen, rows.inputs)
    friction = stage_friction(rows, cut, seen, warming if cold else None)
    places = middle_of(passes, cut, MIDDLE)
    middle = np.isin(cut.place, places)
    middle_mm = np.asarray((places + 0.5) * stretch.length.mm, dtype=np.float64)
    found = FourSteps(
        passes=passes,
        length=stretch.length,
        verdicts=stretch.verdicts,
        laws=laws_told(stretch, friction, middle, rows.path),
        warming=warming,
        inertia=None,
        cold=cold and warming is not None,
        load=load,
        middle_mm=middle_mm,
        middle_sd=_sd_over(load, middle_mm),
        repeated=repeated,
    )
    patch = patches(position, pole_mm, float(np.ptp(position)))
    inertia = inertia_told(rows, found.laws, found.steady, friction.factor, patch=patch)
    return replace(found, inertia=inertia)


def _length(passes: tuple[SpeedPass, ...], pole_mm: float | None) -> Length:
    """Return segments as many to a pole as its table has nodes, or else a part of the travel."""
    if pole_mm is not None:
        return Length(
            pole_mm / NODES,
            phrase("{nodes} to a pole of {pole} mm", nodes=NODES, pole=localized(f"{pole_mm:.4g}")),
            pole_mm,
        )
    travel = max(p.high_mm for p in passes) - min(p.low_mm for p in passes)
    return Length(
        TRAVEL_SHARE * travel, phrase("a fortieth of the travel: no cogging is known"), None
    )


def _sd_over(load: TravelLoad, x_mm: Array) -> float:
    """Return the sd of the mean load over places (k,), with what it is off line and table there."""
    _, sd = load.told(x_mm, np.full((1, len(x_mm)), 1.0 / len(x_mm)))
    return float(np.hypot(sd[0], load.lack_over(len(x_mm))))


def _refuse_few_speeds(passes: tuple[SpeedPass, ...], rows: Prepared) -> None:
    """Raise UnusableInput where too few speeds, each passed once, tell no error of friction."""
    count = len(both_ways(passes))
    if count < STRIBECK_LEVELS:
        raise UnusableInput(
            phrase(
                "{file}: {axis} passes at {n} speeds in both directions, each once, so the "
                "uncertainty of friction cannot be estimated; use {stribeck_levels} speeds, or "
                "pass each twice",
                file=rows.path,
                axis=rows.axis,
                n=count,
                stribeck_levels=STRIBECK_LEVELS,
            )
        )
