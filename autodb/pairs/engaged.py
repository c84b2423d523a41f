"""Cuts as people state them - operation, feed, depth, speed, tool - as elements of the edge.

What is not stated and may be assumed is: geometry of the tool, and the cutting speed. It becomes a
variant of the cuts, an error that they share; what cannot be assumed is named.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.cutting import drill, endmill, insert, tools, turning
from autodb.cutting.elements import Elements
from autodb.cutting.shear import SPEED_M_MIN
from autodb.files.job_cut import KEYS
from autodb.files.tool import ToolKind
from autodb.pairs.observed import PairCuts, Variant

Array = NDArray[np.float64]
Conditions = Mapping[str, float]
"""Of one cut: what is stated of it, by channel of a cut table."""

FEED, DEPTH, WIDTH = "cutting.feed", "cutting.depth", "cutting.width"
SPEED, RPM, DIAMETER = "cutting.speed", "spindle.speed", "work.diameter"
DIRECTION, RAMP, HOLE = "cutting.direction", "cutting.ramp", "pocket.diameter"
CUTTING_TIME, FLANK_WEAR, EDGE = "tool.cutting_time", "tool.flank_wear", "tool.edge"
BAND_LOW, BAND_HIGH = "cutting.band_low", "cutting.band_high"
"""From where to where, to the left of the feed, a mill is engaged, mm from its axis."""
OFF = 2.0
"""Factor by which an assumed cutting speed may be off. Chosen."""


@dataclass(frozen=True)
class Stated:
    """Cuts (n,) of one operation: channels by name, NaN where a cut does not state one."""

    rows: Sequence[Conditions]

    def __getitem__(self, name: str) -> Array:
        return np.array([row.get(name, np.nan) for row in self.rows])

    def given(self, name: str, otherwise: float) -> Array:
        """Return a channel with ``otherwise`` where a cut does not state it."""
        values = self[name]
        return np.where(np.isfinite(values), values, otherwise)


Made = Callable[[Mapping[str, float], Stated], tuple[Elements, list[Variant]]]
"""What makes elements and variants of a tool's numbers and cuts."""
Band = Callable[[float, Stated], tuple[Array, Array]]
"""What says which band across the feed a mill of a diameter is engaged in, mm."""


@dataclass(frozen=True)
class CutOperation:
    """An operation, and the channels that it needs of a cut."""

    name: str
    needs: tuple[str, ...]
    made: Made
    tool_kind: ToolKind | None = None

    @property
    def kind(self) -> ToolKind:
        """The kind of tool that makes it."""
        return self.tool_kind or KEYS[self.name].kind

    def lacking(self, conditions: Conditions) -> tuple[str, ...]:
        """Return the channels that a cut does not state and that cannot be assumed."""
        return tuple(name for name in self.needs if name not in conditions)

    def cuts(
        self, tool: Mapping[str, float], rows: Sequence[Conditions], *, called: str
    ) -> PairCuts:
        """Return cuts (n,) with a tool called so, its numbers by name; mills: means over a turn.

        A cut that does not state how long its edge has cut counts as one with a fresh edge. Raises
        UnusableInput where the tool cannot make them.
        """
        stated = Stated(rows)
        elements, variants = self.made(tool, stated)
        named = tuple(Variant(f"{called}: {one.key}", one.elements) for one in variants)
        worn_s = stated.given(CUTTING_TIME, 0.0)
        edges = tuple(str(row[EDGE]) if EDGE in row else None for row in rows)
        return PairCuts(self.name, elements, named, worn_s if worn_s.any() else None, edges)


def _speed_m_min(stated: Stated, radius_mm: Array) -> Array:
    """Return the speed (n,) at a radius; NaN where neither speed is stated.

    A cutting speed alone is that at the work's diameter; where that is not known either, it is
    taken as it is.
    """
    rpm, speed, diameter = stated[RPM], stated[SPEED], stated[DIAMETER]
    rpm = np.where(np.isfinite(rpm), rpm, turning.speed_rpm(diameter, speed))
    there = turning.speed_m_min(2.0 * radius_mm, rpm)
    return np.where(np.isfinite(there) & np.isfinite(diameter), there, speed)


def stated_turning(stated: Stated, inward_deg: Array) -> insert.TurnedCuts:
    """Return turned cuts (n,) that feed ``inward_deg`` off the axis; speed NaN: not stated.

    The speed is that at the radius where the force acts, whichever diameter it was stated for.
    """
    inward = np.radians(inward_deg)
    diameter, depth = stated.given(DIAMETER, 0.0), stated[DEPTH]
    radius = turning.effective_radius_mm(diameter, depth, inward_rad=inward)
    return insert.TurnedCuts(stated[FEED], depth, _speed_m_min(stated, radius), radius, inward)


def stated_milling(mill: endmill.EndMill, stated: Stated, band: Band) -> endmill.Milled:
    """Return milled cuts (n,); one that does not state its direction feeds along +x."""
    low, high = band(mill.diameter_mm, stated)
    return endmill.Milled(
        feed_mm=stated[FEED],
        depth_mm=stated[DEPTH],
        speed_rpm=stated[RPM],
        low_mm=low,
        high_mm=high,
        direction_rad=np.radians(stated.given(DIRECTION, 0.0)),
        ramp_rad=np.radians(stated.given(RAMP, 0.0)),
    )


def _turns(inward_deg: Callable[[Stated], Array]) -> Made:
    def made(tool: Mapping[str, float], stated: Stated) -> tuple[Elements, list[Variant]]:
        assumed = tools.insert_of(tool)
        cuts = stated_turning(stated, inward_deg(stated))
        known = np.isfinite(cuts.speed_m_min)
        if not known.all():
            cuts = replace(cuts, speed_m_min=np.where(known, cuts.speed_m_min, SPEED_M_MIN))
        others = list(assumed.variants)
        elements, *rest = insert.elements_of_each(
            [assumed.tool, *(other for _, other in others)], cuts
        )
        variants = [Variant(one.key, its) for (one, _), its in zip(others, rest, strict=True)]
        if not known.all():
            off = np.where(known, 1.0, OFF)[:, None]
            edge = replace(elements.edge, speed_m_min=off * elements.edge.speed_m_min)
            faster = replace(elements, edge=edge, speed_rpm=off[:, 0] * elements.speed_rpm)
            variants.append(Variant("cutting speed", faster))
        return elements, variants

    return made


def _bores(tool: Mapping[str, float], stated: Stated) -> tuple[Elements, list[Variant]]:
    """Turn inside: the arm ends at the machined radius, and the work pushes towards the axis."""
    within = replace_column(stated, DIAMETER, stated[DIAMETER] - 2.0 * stated[DEPTH])
    elements, variants = _turns(lambda rows: 0.0 * rows[FEED])(tool, within)
    return _passive(elements, -1.0), [
        replace(one, elements=_passive(one.elements, -1.0)) for one in variants
    ]


def _passive(elements: Elements, factor: float) -> Elements:
    """Return elements whose force off the surface counts so many times."""
    frames = elements.frames.copy()
    frames[:, 2] *= factor
    return replace(elements, frames=frames)


def replace_column(stated: Stated, name: str, values: Array) -> Stated:
    """Return cuts with other values of a channel."""
    rows = [{**row, name: value} for row, value in zip(stated.rows, values.tolist(), strict=True)]
    return Stated(rows)


_BLADE = {"nose_radius_mm": 0.0, "kappa_deg": 90.0, "included_deg": 90.0, "inclination_deg": 0.0}
_FLANK_DEG = 30.0
_V = {**_BLADE, "kappa_deg": 120.0, "included_deg": 120.0}
"""A blade's front is square to its feed; a flank of a thread lies at 30° to it."""


def _grooves(tool: Mapping[str, float], stated: Stated) -> tuple[Elements, list[Variant]]:
    """Cut in square to the axis with a blade's front: its width is the chip's, and no nose cuts."""
    wide = replace_column(stated, DEPTH, stated[WIDTH])
    return _turns(lambda rows: np.full(len(rows.rows), 90.0))({**tool, **_BLADE}, wide)


def _threads(tool: Mapping[str, float], stated: Stated) -> tuple[Elements, list[Variant]]:
    """Cut both flanks of a V: the chip is as thick as a pass is deep across a flank.

    A pass d deep, h below the crest, takes d (2h − d) tan 30°: two flanks, each as if an edge at
    30° to a feed of d were (h − d/2) tan 30° deep. What they push along the axis cancels.
    """
    pass_mm = stated[DEPTH]
    height = np.maximum(stated[WIDTH], pass_mm)
    deep = 2.0 * (height - 0.5 * pass_mm) * np.tan(np.radians(_FLANK_DEG))
    flanks = replace_column(replace_column(stated, FEED, pass_mm), DEPTH, deep)
    elements, variants = _turns(lambda rows: np.full(len(rows.rows), 90.0))({**tool, **_V}, flanks)
    return _passive(elements, 0.0), [
        replace(one, elements=_passive(one.elements, 0.0)) for one in variants
    ]


def _mills(band: Band) -> Made:
    def made(tool: Mapping[str, float], stated: Stated) -> tuple[Elements, list[Variant]]:
        assumed = tools.end_mill_of(tool)
        cuts = stated_milling(assumed.tool, stated, band)
        variants = [
            Variant(usual.key, endmill.averaged(other, cuts)) for usual, other in assumed.variants
        ]
        return endmill.averaged(assumed.tool, cuts), variants

    return made


def _drills(tool: Mapping[str, float], stated: Stated) -> tuple[Elements, list[Variant]]:
    assumed = tools.drill_of(tool)
    cuts = drill.DrilledCuts(stated[FEED], stated[RPM])
    variants = [
        Variant(usual.key, drill.drill_elements(other, cuts)) for usual, other in assumed.variants
    ]
    return drill.drill_elements(assumed.tool, cuts), variants


def slot_band(diameter_mm: float, stated: Stated) -> tuple[Array, Array]:
    """Return the band of a slot as wide as the mill."""
    whole = np.full(len(stated.rows), 0.5 * diameter_mm)
    return -whole, whole


def side_up(diameter_mm: float, stated: Stated) -> tuple[Array, Array]:
    """Return the band of side milling against the feed."""
    return endmill.up(diameter_mm, stated[WIDTH])


def side_down(diameter_mm: float, stated: Stated) -> tuple[Array, Array]:
    """Return the band of side milling with the feed."""
    return endmill.down(diameter_mm, stated[WIDTH])


def pocket_band(diameter_mm: float, stated: Stated) -> tuple[Array, Array]:
    """Return the band of widening a round pocket to ``pocket.diameter`` by the width."""
    after = 0.5 * stated[HOLE]
    return endmill.pocket(
        diameter_mm, hole_mm=after - stated[WIDTH], path_mm=after - 0.5 * diameter_mm
    )


def path_band(_diameter_mm: float, stated: Stated) -> tuple[Array, Array]:
    """Return the band that the path of a program has met."""
    return stated[BAND_LOW], stated[BAND_HIGH]


def facing_deg(stated: Stated) -> Array:
    """Return the direction of faces (n,): to the centre, or away from it where they state that."""
    return np.where(stated.given(DIRECTION, 0.0) < 0.0, -90.0, 90.0)


BANDS: dict[str, Band] = {
    "slot": slot_band, "side-up": side_up, "side-down": side_down, "ramp": slot_band,
    "pocket": pocket_band, "mill": path_band,
}  # fmt: skip
_TURNED, _MILLED = (FEED, DEPTH), (FEED, DEPTH, RPM)
INSERT: ToolKind = "turning_insert"
END_MILL: ToolKind = "end_mill"
DRILL: ToolKind = "drill"
OPERATIONS = (
    CutOperation("turn", _TURNED, _turns(lambda stated: 0.0 * stated[FEED])),
    CutOperation("face", _TURNED, _turns(facing_deg)),
    CutOperation("taper", (*_TURNED, DIRECTION), _turns(lambda stated: stated[DIRECTION])),
    CutOperation("contour", (*_TURNED, DIRECTION), _turns(lambda stated: stated[DIRECTION])),
    CutOperation("bore", _TURNED, _bores),
    CutOperation("groove", (FEED, WIDTH), _grooves),
    CutOperation("thread", (*_TURNED, WIDTH), _threads),
    CutOperation("slot", _MILLED, _mills(slot_band)),
    CutOperation("side-up", (*_MILLED, WIDTH), _mills(side_up)),
    CutOperation("side-down", (*_MILLED, WIDTH), _mills(side_down)),
    CutOperation("ramp", (*_MILLED, RAMP), _mills(slot_band)),
    CutOperation("pocket", (*_MILLED, WIDTH, HOLE), _mills(pocket_band)),
    CutOperation("drill", (FEED, RPM), _drills),
)
PATH = CutOperation("mill", (*_MILLED, BAND_LOW, BAND_HIGH), _mills(path_band), END_MILL)
"""A line of a milling program; no cut that a job states."""
BY_NAME = {operation.name: operation for operation in (*OPERATIONS, PATH)}
UNSAID = "turn"
"""What a cut counts as that does not say its operation."""
