"""The stages that ball screws and linear drives have in common: passes, friction, warming, inertia.

Beside the joint fit, not in its place: what is fitted first takes up what a later stage would have
explained, and no stage knows how unsure the one before was but by what repeats differ by.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.files.channels import ROTARY_AXES
from autodb.sensing.drives.fit.drive_errors import SPEEDING, states
from autodb.sensing.drives.moves.motion import SPINDLE
from autodb.sensing.drives.moves.passes import SpeedPass, both_ways, levels_of, passes_of
from autodb.sensing.drives.moves.prepared import Prepared
from autodb.sensing.drives.staged.accelerated import Inertia, inertia_of
from autodb.sensing.drives.staged.over_speed import SpeedLaw, fit_speed_law, levels_of_way
from autodb.sensing.drives.staged.segments import Length, PassSegments, pass_segments
from autodb.sensing.drives.staged.sticking import StickingVerdict, sticking
from autodb.sensing.drives.staged.warming import WarmingDrop, warming_of
from autodb.signals.segments import flagged_runs
from autodb.wording import phrase

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

FOLLOWED = 3.0
"""Periods of the low-pass that an accelerated part lasts at least. Chosen."""
FEWEST_LEVELS = 4
"""Speeds passed both ways that a routine needs: two parameters and two to spare. Chosen."""


@dataclass(frozen=True)
class Stages:
    """What the stages in common found, in the effort's unit.

    ``laws`` by direction ±1; ``cold``: friction is that of a cold axis, else of this recording.
    """

    passes: tuple[SpeedPass, ...]
    length: Length
    verdicts: Mapping[int, StickingVerdict]
    laws: Mapping[int, SpeedLaw]
    warming: WarmingDrop | None
    inertia: Inertia | None
    cold: bool

    @property
    def levels(self) -> dict[int, float]:
        """Speed mm/s of each level that was passed both ways, slowest first."""
        return both_ways(self.passes)

    @property
    def compared(self) -> tuple[int, ...]:
        """Levels that friction over speed is of, in both directions: they pass the middle."""
        told = [set(law.levels.speed_mm_s.tolist()) for law in self.laws.values()]
        speeds = levels_of(self.passes)
        return tuple(k for k in self.levels if all(speeds[k] in one for one in told))


@dataclass(frozen=True)
class MeasuredStretch:
    """Segments of a recording's passes, their mean effort (n,), and the levels that stick."""

    passes: tuple[SpeedPass, ...]
    verdicts: Mapping[int, StickingVerdict]
    length: Length
    cut: PassSegments
    effort: Array

    @property
    def stuck(self) -> set[int]:
        """Numbers of the levels that stick."""
        return {k for k, one in self.verdicts.items() if one.sticks}

    @property
    def told(self) -> list[int]:
        """Numbers of the levels that were passed both ways and do not."""
        return [k for k in self.verdicts if k not in self.stuck]

    @property
    def smooth(self) -> Flags:
        """Say which segments (n,) are of levels that do not."""
        return ~np.isin(self.cut.level, list(self.stuck))


@dataclass(frozen=True)
class StageFriction:
    """Friction of the segments (n,) as it is compared, the sd of what warming leaves open of it, a
    share, and the factor by which warming lowered it in each row.
    """

    size: Array
    unsure: Array
    factor: Array


def passes_at_speeds(rows: Prepared) -> tuple[SpeedPass, ...]:
    """Return the passes of a recording; raises UnusableInput where no stage can do with them."""
    if rows.axis == SPINDLE:
        raise UnusableInput(phrase("--staged: a spindle has no travel; use a linear axis"))
    if rows.axis in ROTARY_AXES:
        raise UnusableInput(
            phrase("--staged: {axis} turns and has no screw; use a linear axis", axis=rows.axis)
        )
    passes = passes_of(rows.inputs)
    count = len(both_ways(passes))
    if count < FEWEST_LEVELS:
        raise UnusableInput(
            phrase(
                "{file}: {axis} passes at {n} constant speeds in both directions, and the "
                "staged routine needs {fewest_levels}; use the moves that 'autodb sweep' writes",
                file=rows.path,
                axis=rows.axis,
                n=count,
                fewest_levels=FEWEST_LEVELS,
            )
        )
    return passes


def stretch_of(rows: Prepared, passes: tuple[SpeedPass, ...], length: Length) -> MeasuredStretch:
    """Return the segments of a recording's passes."""
    verdicts = sticking(passes, rows.inputs, rows.whole_effort)
    cut = pass_segments(passes, rows.inputs["position"], length.mm)
    return MeasuredStretch(passes, verdicts, length, cut, cut.means(rows.whole_effort))


def stage_friction(
    rows: Prepared, cut: PassSegments, seen: Array, warming: WarmingDrop | None
) -> StageFriction:
    """Return friction as it was seen, or that of the cold axis where a warming is given."""
    if warming is None:
        return StageFriction(seen, np.zeros_like(seen), np.ones_like(rows.whole_effort))
    factor = 1.0 - warming.lost(rows.inputs)
    kept = cut.means(factor)
    slopes = np.column_stack([cut.means(one) for one in warming.slopes(rows.inputs).T])
    return StageFriction(seen / kept, warming.sd(slopes) / kept, factor)


def middle_of(passes: tuple[SpeedPass, ...], cut: PassSegments, turn: int) -> NDArray[np.intp]:
    """Return the places about the middle of the travel: ``turn`` neighbours that most levels pass.

    The nearest to the middle of such, and what lies beside them as far as it is passed as often.
    """
    first, last = int(cut.place.min()), int(cut.place.max())
    key = np.unique(np.column_stack([cut.level, cut.sense, cut.place]), axis=0)
    _, way = np.unique(key[:, :2], axis=0, return_inverse=True)
    crossed = np.zeros((int(way.max()) + 1, last - first + 1))
    crossed[way.ravel(), key[:, 2] - first] = 1.0
    turn = min(turn, crossed.shape[1])
    begun = np.lib.stride_tricks.sliding_window_view(crossed, turn, axis=1).min(axis=2).sum(axis=0)
    centre_mm = 0.5 * (max(p.high_mm for p in passes) + min(p.low_mm for p in passes))
    centre = int(cut.place[np.argmin(np.abs(cut.x_mm - centre_mm))]) - first - turn // 2
    most = np.flatnonzero(begun == begun.max())
    nearest = most[np.argmin(np.abs(most - centre))]
    runs = np.cumsum(np.diff(most, prepend=most[0]) != 1)
    whole = most[runs == runs[most == nearest]]
    return np.asarray(np.arange(whole[0], whole[-1] + turn) + first)


def warming_told(
    stretch: MeasuredStretch, friction: Array, inputs: Mapping[str, Array]
) -> WarmingDrop | None:  # fmt: skip
    """Return the warming that whole passes show, a level and direction a group."""
    names, at = np.unique(stretch.cut.of[stretch.smooth], return_inverse=True)
    mean = np.bincount(at, friction[stretch.smooth]) / np.bincount(at)
    crossed = [stretch.passes[i] for i in names]
    group = np.array([2 * one.level + (one.sense > 0) for one in crossed], dtype=np.intp)
    amid = np.array([(one.begin + one.end) // 2 for one in crossed], dtype=np.intp)
    return warming_of(group, mean, amid, inputs)


def laws_told(
    stretch: MeasuredStretch, friction: StageFriction, middle: Flags, path: str
) -> dict[int, SpeedLaw]:  # fmt: skip
    """Return the law over speed in each direction, of the segments (n,) in the middle."""
    return {s: _law(stretch, friction, middle & (stretch.cut.sense == s), path) for s in (1, -1)}


def _law(stretch: MeasuredStretch, friction: StageFriction, which: Flags, path: str) -> SpeedLaw:
    """Return the law over speed that passes' means over some segments of one direction tell."""
    names, at = np.unique(stretch.cut.of[which], return_inverse=True)
    both = (friction.size[which], friction.unsure[which])
    mean, warm = (np.bincount(at, one) / np.bincount(at) for one in both)
    level = np.array([stretch.passes[i].level for i in names], dtype=np.intp)
    run = np.array([stretch.passes[i].repeat for i in names], dtype=np.intp)
    if len(np.unique(level)) < FEWEST_LEVELS:
        raise UnusableInput(
            phrase(
                "{file}: no place is passed at {fewest_levels} constant speeds in both "
                "directions; make passes that cross the middle of the travel",
                file=path,
                fewest_levels=FEWEST_LEVELS,
            )
        )
    speeds = levels_of(stretch.passes)
    return fit_speed_law(levels_of_way(level, run, mean, warm, speeds=speeds, stuck=stretch.stuck))


def inertia_told(
    rows: Prepared,
    laws: Mapping[int, SpeedLaw],
    steady: Callable[[Array, Array, Array], Array],
    factor: Array,
    *,
    patch: NDArray[np.intp] | None = None,
) -> Inertia | None:
    """Return the inertia of accelerated parts, less what ``steady`` motion takes in them.

    ``steady`` of place mm, velocity mm/s and warming's ``factor`` (n,); ``patch`` as ``inertia_of``
    has it. Up to the highest speed
    that both laws of friction are of: beyond, they are a guess. Parts that are over before the
    low-pass has followed them tell no inertia.
    """
    inputs = {**rows.inputs}
    highest = float(np.quantile(np.abs(inputs["acceleration"]), 0.999))
    top = min(float(law.levels.speed_mm_s.max()) for law in laws.values())
    speeding = states(inputs, highest_mm_s2=highest) == SPEEDING
    speeding &= np.abs(inputs["velocity"]) <= top
    shortest = FOLLOWED * rows.rate_hz / rows.protocol.cutoff_hz
    for part in flagged_runs(speeding):
        speeding[part] &= part.stop - part.start >= shortest
    if not speeding.any():
        return None
    smooth = rows.protocol.smoothed(rows.whole_effort, timing=rows.timing)
    left = np.zeros_like(smooth)
    x, v = inputs["position"][speeding], inputs["velocity"][speeding]
    left[speeding] = smooth[speeding] - steady(x, v, factor[speeding])
    return inertia_of(inputs["acceleration"], inputs["velocity"], left, speeding, patch=patch)
