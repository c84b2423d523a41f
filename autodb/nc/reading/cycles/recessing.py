"""Grooves of Sinumerik's lathes: CYCLE93 into the radius, from outside.

The blade goes in beside itself, by steps of at most 95 % of its width, in pecks, and then along
both flanks down to the middle of the base. The width is that of the base; the starting point is the
edge of the groove on the diameter, flanks lean outwards from the base. How wide a blade is, and
which of its corners is programmed, is the tool's, not the program's.
Source: the cycle's parameters as its maker describes them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, radians, sqrt, tan

from autodb.nc.reading.cycles.cycle_moves import (
    CLEAR_MM,
    Carrying,
    feed_to,
    known_start,
    rapid_to,
)
from autodb.nc.reading.cycles.stated import Blade
from autodb.nc.reading.lines.blocks import ProgramBlock
from autodb.nc.reading.motions import feed_straight

OVERLAP = 0.95
"""Share of the blade's width by which it moves over at the most, as the cycle has it."""
BACK_MM = 1.0
"""How far it draws back after a peck, where the call does not say: as the cycle has it."""
_LEFT, _READ = 1, (1, 5)
"""Kinds of VARI: from outside, begun at the groove's left or right edge."""
Corner = tuple[str, float, str] | None


@dataclass(frozen=True)
class _Flank:
    """One side of a groove: z of its top and its base, and the corners there."""

    top_mm: float
    base_mm: float
    outer: Corner
    inner: Corner


@dataclass(frozen=True)
class _Groove:
    """A groove to be cut: radii of top and base, flanks (towards the chuck, away), allowances.

    ``left_mm`` stays on the base for finishing, ``beside_mm`` on the flanks.
    """

    top_mm: float
    base_mm: float
    flanks: tuple[_Flank, _Flank]
    left_mm: float
    beside_mm: float
    peck_mm: float
    back_mm: float


def cycle93(m: Carrying, block: ProgramBlock, numbers: Sequence[float | None]) -> None:
    """Cut a groove by CYCLE93(SPD, SPL, WIDG, DIAG, STA1, ANG1, ANG2, RCO1, …, VARI, VRT)."""
    given = [one or 0.0 for one in [*numbers, *([None] * 17)][:17]]
    kind = int(given[15]) % 10
    if kind not in _READ or given[4]:
        raise block.refusal(
            "CYCLE93", "grooves on faces, on cones and in bores are not read; write out its moves"
        )
    blade = m.stated.blade_of(m.state.tool)
    if blade is None:
        raise block.refusal(
            "CYCLE93",
            "its path depends on the blade; state kind = 'grooving' and width_mm of tool "
            f"'{m.state.tool or ''}'",
        )
    known_start(m, block)
    groove = _groove(m, given, kind)
    left, right = groove.flanks
    if blade.width_mm > right.base_mm - left.base_mm + 1e-6:
        raise block.refusal("CYCLE93", "the blade is wider than the groove; state its width_mm")
    _plunges(m, block, groove, blade)
    _along_flanks(m, block, groove, blade)
    rapid_to(m, block, x=groove.top_mm + BACK_MM)


def _groove(m: Carrying, given: Sequence[float], kind: int) -> _Groove:
    """Return the groove that a call states; ANG1 and the first corners are at its start."""
    spd, spl, width, deep, _, ang1, ang2, rco1, rco2, rci1, rci2, fal1, fal2, peck, *_ = given
    shift, unit = m.state.shift, m.state.unit_mm
    top = spd * m.state.factor("x") + shift["x"]
    deep, width = deep * unit, width * unit
    away = 1.0 if kind == _LEFT else -1.0
    start = spl * unit + shift["z"]
    near = start + away * deep * tan(radians(ang1))
    far = near + away * width
    plain = int(given[15]) < 10
    flanks = (
        _Flank(start, near, _corner(rco1, unit, plain), _corner(rci1, unit, plain)),
        _Flank(far + away * deep * tan(radians(ang2)), far, _corner(rco2, unit, plain),
               _corner(rci2, unit, plain)),
    )  # fmt: skip
    left, right = flanks if away > 0 else flanks[::-1]
    back = abs(given[16]) * unit or BACK_MM
    return _Groove(
        top, top - deep, (left, right), abs(fal1) * unit, abs(fal2) * unit, abs(peck) * unit, back
    )


def _corner(size: float, unit: float, plain: bool) -> Corner:
    """Return a rounded corner (above 0) or a chamfer (below), whose own length may be stated."""
    if size == 0.0:
        return None
    if size > 0:
        return "R", size * unit, "G18"
    return ("CHF" if plain else "C"), -size * unit, "G18"


def _trim(corner: Corner) -> float:
    """Return how far a corner may reach from where its sides meet."""
    return 0.0 if corner is None else corner[1] * (sqrt(2.0) if corner[0] == "R" else 1.0)


def _plunges(m: Carrying, block: ProgramBlock, groove: _Groove, blade: Blade) -> None:
    left, right = groove.flanks
    first = left.base_mm + max(groove.beside_mm, _trim(left.inner))
    last = right.base_mm - max(groove.beside_mm, _trim(right.inner)) - blade.width_mm
    if last < first:
        first = last = 0.5 * (first + last)
    count = ceil((last - first) / (OVERLAP * blade.width_mm) - 1e-9)
    to = groove.base_mm + groove.left_mm
    for k in range(count + 1):
        z = first + (last - first) * k / max(count, 1) + blade.corner_mm
        rapid_to(m, block, x=groove.top_mm + BACK_MM)
        rapid_to(m, block, z=z)
        at = groove.top_mm
        while at > to + 1e-9:
            at = max(at - (groove.peck_mm or groove.top_mm), to)
            feed_to(m, block, {"x": at})
            if at > to + 1e-9:
                rapid_to(m, block, x=at + groove.back_mm)
        rapid_to(m, block, x=groove.top_mm + BACK_MM)


def _along_flanks(m: Carrying, block: ProgramBlock, groove: _Groove, blade: Blade) -> None:
    """Follow each flank with the corner that makes it, down to the middle of the base."""
    left, right = groove.flanks
    middle = 0.5 * (left.base_mm + right.base_mm - blade.width_mm) + blade.corner_mm
    for flank, off, away in (
        (left, blade.corner_mm, -1.0), (right, blade.corner_mm - blade.width_mm, 1.0),
    ):  # fmt: skip
        begin = flank.top_mm + off
        rapid_to(m, block, x=groove.top_mm + BACK_MM)
        if flank.outer is not None:
            begin += away * (_trim(flank.outer) + CLEAR_MM)
        rapid_to(m, block, z=begin)
        feed_to(m, block, {"x": groove.top_mm})
        if flank.outer is not None:
            _cornered(m, block, {"z": flank.top_mm + off}, flank.outer)
        _cornered(m, block, {"x": groove.base_mm, "z": flank.base_mm + off}, flank.inner)
        feed_to(m, block, {"z": middle})


def _cornered(m: Carrying, block: ProgramBlock, to: dict[str, float], corner: Corner) -> None:
    feed_straight(m.state, {**m.state.place, **to}, block, m.record, corner=corner)
