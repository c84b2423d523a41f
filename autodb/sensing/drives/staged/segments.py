"""Passes cut into segments of the travel: mean effort of each, its repeats, and how they differ."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.sensing.drives.fit.ripples import strongest_ripple
from autodb.sensing.drives.moves.passes import SpeedPass
from autodb.wording import localized, phrase

Array = NDArray[np.float64]
Places = NDArray[np.intp]

PITCH_SHARE = 1.0 / 3.0
"""P2, section III A: a segment is a third of the screw's pitch."""
TRAVEL_SHARE = 1.0 / 40.0
"""Of the travel, where neither a pitch is known nor a ripple tells one. Chosen: friction along the
travel may bend a dozen times."""
WHOLE = 0.5
"""Share of a segment that a pass must cross. Chosen."""


@dataclass(frozen=True)
class Length:
    """How long a segment is, why, and the period of the screw where it is known or found, mm."""

    mm: float
    why: str
    period_mm: float | None


def length_of(
    passes: Sequence[SpeedPass], position: Array, effort: Array, *, pitch_mm: float | None
) -> Length:
    """Return a third of the pitch, else of the ripple that passes hold, else a part of the travel.

    ``position`` and ``effort`` (n,) are those of all rows.
    """
    if pitch_mm is not None:
        return Length(PITCH_SHARE * pitch_mm, phrase(
"a third of the screw's pitch, {pitch} mm",
pitch=localized(f"{pitch_mm:g}")
),
                      pitch_mm)  # fmt: skip
    left, sense = np.zeros_like(effort), np.zeros_like(effort)
    for one in passes:
        place, values = position[one.rows], effort[one.rows]
        left[one.rows] = values - np.polyval(np.polyfit(place, values, 1), place)
        sense[one.rows] = one.sense
    found = strongest_ripple(position, sense, left)
    if found is not None:
        return Length(PITCH_SHARE * found.period, phrase(
"a third of the ripple found, {period} mm",
period=localized(f"{found.period:.4g}")
), found.period)  # fmt: skip
    travel = max(p.high_mm for p in passes) - min(p.low_mm for p in passes)
    return Length(TRAVEL_SHARE * travel, phrase(
"a fortieth of the travel: no pitch is known and no ripple found"
), None)  # fmt: skip


@dataclass(frozen=True)
class PassSegments:
    """Segments (n,) that passes crossed: index of the pass, its level, direction ±1 and repeat;
    number of the place, mean place mm.

    ``cell`` (rows,): the segment that each row is in, −1 for none; ``rows`` (n,) their numbers.
    """

    of: Places
    level: Places
    sense: Places
    repeat: Places
    place: Places
    x_mm: Array
    cell: Places
    rows: Array

    def some(self, which: NDArray[np.bool_]) -> "PassSegments":
        """Return some (n,) of the segments."""
        number = np.where(which, np.cumsum(which) - 1, -1)
        cell = np.where(self.cell >= 0, number[self.cell], -1)
        names = ("of", "level", "sense", "repeat", "place", "x_mm", "rows")
        return replace(self, cell=cell, **{name: getattr(self, name)[which] for name in names})

    def means(self, values: Array) -> Array:
        """Return means (n,) of values (rows,)."""
        inside = self.cell >= 0
        total = np.bincount(self.cell[inside], values[inside], len(self.rows))
        return np.asarray(total / self.rows)


def pass_segments(passes: Sequence[SpeedPass], position: Array, length_mm: float) -> PassSegments:
    """Return the segments that passes crossed for the most part; borders at multiples of it."""
    number = np.floor(position / length_mm).astype(np.intp)
    cell = np.full(len(position), -1, dtype=np.intp)
    of: list[int] = []
    place: list[int] = []
    for i, one in enumerate(passes):
        names, at, count = np.unique(number[one.rows], return_inverse=True, return_counts=True)
        step_mm = (one.high_mm - one.low_mm) / (one.end - one.begin - 1)
        whole = count * step_mm >= WHOLE * length_mm
        cell[one.rows] = np.where(whole, len(of) + np.cumsum(whole) - 1, -1)[at]
        of += [i] * int(whole.sum())
        place += names[whole].tolist()
    inside = cell >= 0
    rows = np.bincount(cell[inside], minlength=len(of)).astype(np.float64)
    total = np.bincount(cell[inside], position[inside], len(of))
    crossed = [passes[i] for i in of]
    return PassSegments(
        of=np.array(of, dtype=np.intp),
        level=np.array([one.level for one in crossed], dtype=np.intp),
        sense=np.array([one.sense for one in crossed], dtype=np.intp),
        repeat=np.array([one.repeat for one in crossed], dtype=np.intp),
        place=np.array(place, dtype=np.intp),
        x_mm=total / rows,
        cell=cell,
        rows=rows,
    )


@dataclass(frozen=True)
class Averages:
    """Segments (n,) averaged over repeats: level, direction, place, effort, standard error.

    ``repeats`` (n,): how many; ``differ``: standard deviation of repeats, of smooth levels' a share
    of their friction.
    """

    level: Places
    sense: Places
    place: Places
    x_mm: Array
    effort: Array
    sd: Array
    repeats: Array
    differ: float


def averages(segments: PassSegments, effort: Array, friction: Array, sticks: set[int]) -> Averages:
    """Average the segments' effort (n,) over repeats; ``friction`` (n,): its size in each.

    What repeats differ by, over the friction, is pooled over the levels that run smoothly and over
    those that stick. A segment passed once gets the error of one of them.
    """
    key = np.column_stack([segments.level, segments.sense, segments.place])
    names, at = np.unique(key, axis=0, return_inverse=True)
    at = at.ravel()
    count = np.bincount(at).astype(np.float64)
    mean = np.bincount(at, effort) / count
    size = np.bincount(at, np.abs(friction)) / count
    off = ((effort - mean[at]) / size[at]) ** 2
    stuck = np.isin(names[:, 0], list(sticks))
    share = np.full(len(names), np.nan)
    for group in (stuck, ~stuck):
        freedom = float(np.sum(count[group] - 1.0))
        if freedom > 0:
            share[group] = np.sqrt(off[group[at]].sum() / freedom)
    return Averages(
        level=names[:, 0],
        sense=names[:, 1],
        place=names[:, 2],
        x_mm=np.bincount(at, segments.x_mm) / count,
        effort=mean,
        sd=share * size / np.sqrt(count),
        repeats=count,
        differ=float(share[~stuck][0]) if not stuck.all() else np.nan,
    )
