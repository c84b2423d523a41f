"""The staged routine of a ball-screw axis: passes, then one stage after the other (P2 III).

Beside the joint fit, not in its place: what is fitted first takes up what a later stage would have
explained, and no stage knows how unsure the one before was but by what repeats differ by.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.channels import ROTARY_AXES
from autodb.errors import UnusableInput
from autodb.sensing.drive_errors import SPEEDING, states
from autodb.sensing.passes import Pass, both_ways, levels_of, passes_of
from autodb.sensing.prepared import SPINDLE, Prepared
from autodb.sensing.staged.accelerated import Inertia, inertia_of
from autodb.sensing.staged.along_travel import Along, along_travel
from autodb.sensing.staged.over_speed import Law, law_of, levels_of_way
from autodb.sensing.staged.segments import (
    Averages,
    Length,
    Segments,
    averages,
    length_of,
    segments_of,
)
from autodb.sensing.staged.sticking import Verdict, sticking
from autodb.sensing.staged.warming import Warming, warming_of
from autodb.sensing.staged.weight import Weight, weight_of
from autodb.signals.segments import runs

Array = NDArray[np.float64]

TURN = 3
"""Segments of the middle at least: a turn of the screw, over which its ripple is no friction."""
FOLLOWED = 3.0
"""Periods of the low-pass that an accelerated part lasts at least. Chosen."""
FEWEST_LEVELS = 4
"""Speeds passed both ways that the routine needs: two parameters and two to spare. Chosen."""


@dataclass(frozen=True)
class Staged:
    """What the stages found, in the effort's unit.

    ``laws`` by direction ±1; ``cold``: friction is that of a cold axis, else of this recording.
    """

    passes: tuple[Pass, ...]
    length: Length
    averages: Averages
    verdicts: Mapping[int, Verdict]
    weight: Weight
    laws: Mapping[int, Law]
    along: Along
    warming: Warming | None
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

    def friction(self, x_mm: Array, speed_mm_s: Array, sense: int) -> tuple[Array, Array]:
        """Return the size of friction (n,) at places and speeds (n,) in a direction, and its sd."""
        value, sd = self.laws[sense].at(speed_mm_s)
        gain, gain_sd = self.along.at(x_mm)
        return value + gain, np.sqrt(sd**2 + gain_sd**2 + self.weight.sd**2)


@dataclass(frozen=True)
class _Field:
    """Segments of a recording's passes, their mean effort (n,), and the levels that stick."""

    passes: tuple[Pass, ...]
    verdicts: Mapping[int, Verdict]
    length: Length
    cut: Segments
    effort: Array

    @property
    def stuck(self) -> set[int]:
        """Numbers of the levels that stick."""
        return {k for k, one in self.verdicts.items() if one.sticks}

    @property
    def smooth(self) -> NDArray[np.bool_]:
        """Say which segments (n,) are of levels that do not."""
        return ~np.isin(self.cut.level, list(self.stuck))


@dataclass(frozen=True)
class _Friction:
    """Friction of the segments (n,) as it is compared, the sd of what warming leaves open of it, a
    share, and the factor by which warming lowered it in each row.
    """

    size: Array
    unsure: Array
    factor: Array


def staged(rows: Prepared, *, pitch_mm: float | None, cold: bool) -> Staged:
    """Run the stages on one axis' recording.

    ``pitch_mm`` of the screw, None where it is not known; ``cold``: refer friction to a cold axis,
    by the warming that the passes show, so that it compares with a joint fit that has `warmup`.

    Raises UnusableInput for a spindle or a rotary axis, and where passes are too few or were not
    repeated.
    """
    field = _field(rows, pitch_mm)
    cut = field.cut
    told = [k for k in field.verdicts if k not in field.stuck]
    weight = weight_of(cut, field.effort, told, path=rows.path)
    seen = cut.sense * (field.effort - weight.value)
    warming = _warming(field, seen, rows.inputs)
    friction = _friction(rows, cut, seen, warming if cold else None)
    middle = np.isin(cut.place, _middle(field.passes, cut))
    found = Staged(
        passes=field.passes,
        length=field.length,
        averages=averages(cut, field.effort, seen, field.stuck),
        verdicts=field.verdicts,
        weight=weight,
        laws={s: _law(field, friction, middle & (cut.sense == s), rows.path) for s in (1, -1)},
        along=along_travel(
            cut.some(field.smooth),
            friction.size[field.smooth],
            rows.inputs["position"],
            period_mm=field.length.period_mm,
            middle_mm=cut.x_mm[middle],
        ),
        warming=warming,
        inertia=None,
        cold=cold and warming is not None,
    )
    return replace(found, inertia=_inertia(rows, found, friction.factor))


def _field(rows: Prepared, pitch_mm: float | None) -> _Field:
    """Return the segments of a recording's passes."""
    passes, position = _passes(rows), rows.inputs["position"]
    verdicts = sticking(passes, rows.inputs, rows.whole_effort)
    length = length_of(passes, position, rows.whole_effort, pitch_mm=pitch_mm)
    cut = segments_of(passes, position, length.mm)
    return _Field(passes, verdicts, length, cut, cut.means(rows.whole_effort))


def _friction(rows: Prepared, cut: Segments, seen: Array, warming: Warming | None) -> _Friction:
    """Return friction as it was seen, or that of the cold axis where a warming is given."""
    if warming is None:
        return _Friction(seen, np.zeros_like(seen), np.ones_like(rows.whole_effort))
    factor = 1.0 - warming.lost(rows.inputs)
    kept = cut.means(factor)
    slopes = np.column_stack([cut.means(one) for one in warming.slopes(rows.inputs).T])
    return _Friction(seen / kept, warming.sd(slopes) / kept, factor)


def _passes(rows: Prepared) -> tuple[Pass, ...]:
    """Return the passes of a recording, refused where the stages cannot do with them."""
    if rows.axis == SPINDLE:
        raise UnusableInput("--staged: a spindle has no travel; a linear axis would work")
    if rows.axis in ROTARY_AXES:
        raise UnusableInput(
            f"--staged: {rows.axis} turns, it has no screw; a linear axis would work"
        )
    passes = passes_of(rows.inputs)
    count = len(both_ways(passes))
    if count < FEWEST_LEVELS:
        raise UnusableInput(
            f"{rows.path}: {rows.axis} passes at {count} constant speeds both ways; the staged "
            f"routine needs {FEWEST_LEVELS}: the moves that autodb sweep writes would work"
        )
    if not any(one.repeat for one in passes):
        raise UnusableInput(
            f"{rows.path}: no speed of {rows.axis} was passed twice in one direction, so that "
            "nothing tells how runs differ; the moves that autodb sweep writes would work"
        )
    return passes


def _middle(passes: tuple[Pass, ...], cut: Segments) -> NDArray[np.intp]:
    """Return the places about the middle of the travel: TURN neighbours that most levels pass.

    The nearest to the middle of such, and what lies beside them as far as it is passed as often.
    """
    first, last = int(cut.place.min()), int(cut.place.max())
    key = np.unique(np.column_stack([cut.level, cut.sense, cut.place]), axis=0)
    _, way = np.unique(key[:, :2], axis=0, return_inverse=True)
    crossed = np.zeros((int(way.max()) + 1, last - first + 1))
    crossed[way.ravel(), key[:, 2] - first] = 1.0
    turn = min(TURN, crossed.shape[1])
    begun = np.lib.stride_tricks.sliding_window_view(crossed, turn, axis=1).min(axis=2).sum(axis=0)
    centre_mm = 0.5 * (max(p.high_mm for p in passes) + min(p.low_mm for p in passes))
    centre = int(cut.place[np.argmin(np.abs(cut.x_mm - centre_mm))]) - first - turn // 2
    most = np.flatnonzero(begun == begun.max())
    nearest = most[np.argmin(np.abs(most - centre))]
    runs = np.cumsum(np.diff(most, prepend=most[0]) != 1)
    whole = most[runs == runs[most == nearest]]
    return np.asarray(np.arange(whole[0], whole[-1] + turn) + first)


def _warming(field: _Field, friction: Array, inputs: Mapping[str, Array]) -> Warming | None:
    """Return the warming that whole passes show, a level and direction a group."""
    names, at = np.unique(field.cut.of[field.smooth], return_inverse=True)
    mean = np.bincount(at, friction[field.smooth]) / np.bincount(at)
    crossed = [field.passes[i] for i in names]
    group = np.array([2 * one.level + (one.sense > 0) for one in crossed], dtype=np.intp)
    amid = np.array([(one.begin + one.end) // 2 for one in crossed], dtype=np.intp)
    return warming_of(group, mean, amid, inputs)


def _law(field: _Field, friction: _Friction, which: NDArray[np.bool_], path: str) -> Law:
    """Return the law over speed that passes' means over some segments of one direction tell."""
    names, at = np.unique(field.cut.of[which], return_inverse=True)
    both = (friction.size[which], friction.unsure[which])
    mean, warm = (np.bincount(at, one) / np.bincount(at) for one in both)
    level = np.array([field.passes[i].level for i in names], dtype=np.intp)
    run = np.array([field.passes[i].repeat for i in names], dtype=np.intp)
    if len(np.unique(level)) < FEWEST_LEVELS:
        raise UnusableInput(
            f"{path}: no place is passed at {FEWEST_LEVELS} constant speeds both ways; passes that "
            "cross the middle of the travel would work"
        )
    speeds = levels_of(field.passes)
    return law_of(levels_of_way(level, run, mean, warm, speeds=speeds, stuck=field.stuck))


def _inertia(rows: Prepared, found: Staged, factor: Array) -> Inertia | None:
    """Return the inertia of accelerated parts, whose friction is that of the stages before.

    Up to the highest speed that both laws of friction are of: beyond, they are a guess. Parts that
    are over before the low-pass has followed them tell no inertia.
    """
    inputs = {**rows.inputs}
    highest = float(np.quantile(np.abs(inputs["acceleration"]), 0.999))
    top = min(float(law.levels.speed_mm_s.max()) for law in found.laws.values())
    speeding = states(inputs, highest_mm_s2=highest) == SPEEDING
    speeding &= np.abs(inputs["velocity"]) <= top
    shortest = FOLLOWED * rows.rate_hz / rows.protocol.cutoff_hz
    for part in runs(speeding):
        speeding[part] &= part.stop - part.start >= shortest
    if not speeding.any():
        return None
    x, v = inputs["position"][speeding], inputs["velocity"][speeding]
    size = np.where(v > 0, *(found.friction(x, np.abs(v), s)[0] for s in (1, -1)))
    smooth = rows.protocol.smoothed(rows.whole_effort, rate_hz=rows.rate_hz)
    left = np.zeros_like(smooth)
    left[speeding] = smooth[speeding] - found.weight.value - np.sign(v) * size * factor[speeding]
    return inertia_of(inputs["acceleration"], inputs["velocity"], left, speeding)
