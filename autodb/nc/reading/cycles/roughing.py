"""Roughing towards a contour: G71 along the axis, G72 square to it, G73 in its shape, G70 once.

Passes go at levels a depth apart from where the cycle begins; one after them follows the contour,
moved by the allowances. Pockets of the contour are cut at each level as well (type 2). Fanuc's
allowances move the contour by U/2 and W; LinuxCNC's D and Sinumerik's FAL are square to it.
Source: operator's manuals of these controls, as their makers describe the words.
"""

import copy
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from autodb.nc.reading.controls import LINUXCNC
from autodb.nc.reading.corners import CornerRecord
from autodb.nc.reading.cycles.contours import Array, chain, moved, runs_beyond, without_pockets
from autodb.nc.reading.cycles.cycle_moves import (
    CLEAR_MM,
    Carrying,
    cycle_lengths,
    depth_of_cut,
    feed_to,
    known_start,
    rapid_to,
)
from autodb.nc.reading.lines.blocks import ProgramBlock, Word
from autodb.nc.reading.motions import go_rapid
from autodb.nc.reading.state import word_value
from autodb.nc.reading.travels import ProgramMove

MOST_PASSES = 5000
AXES_OF = {"G71": ("z", "x"), "G72": ("x", "z")}
INDEX_OF = {"x": 0, "z": 2}
"""Where an axis stands in a place."""


@dataclass(frozen=True)
class Passes:
    """How roughing goes: axes along and across the cut, depth, retract, allowances, mm.

    ``by``: allowance along and across; ``off_mm``: square to the contour; ``start``: along, across;
    ``pockets``: whether those alone are cut, or they are left; None: all is cut.
    """

    along: str
    across: str
    depth_mm: float
    back_mm: float
    by: tuple[float, float]
    off_mm: float
    start: tuple[float, float]
    pockets: bool | None = None


def fanuc_roughing(m: Carrying, code: str, values: Mapping[str, Word], block: ProgramBlock) -> None:
    """Carry out G70 to G73, in two blocks or, as on Haas, in one with D."""
    if "P" not in values or "Q" not in values:
        _first_block(m, code, values, block)
        return
    first, last = (f"N{word_value(values[letter]):.0f}" for letter in "PQ")
    if code == "G70":
        if "F" in values:
            m.state.feed = word_value(values["F"]) * m.state.unit_mm
        begun = dict(m.state.place)
        blocks = list(m.runner.contour(first, last, block))
        if any((one.source, one.line) == (block.source, block.line) for one in blocks):
            raise block.refusal(code, "a cycle inside its own contour; write it behind it")
        _follow(m, blocks)
        for axis in ("x", "z"):
            go_rapid(m.state, {**m.state.place, axis: begun[axis]}, block, m.record)
    else:
        known_start(m, block)
        moves = contour_of(m, m.runner.contour(first, last, block), block)
        if "F" in values:
            m.state.feed = word_value(values["F"]) * m.state.unit_mm
        _allowed(m, code, values, block, moves)
    m.runner.skip_contour(last)


def _first_block(m: Carrying, code: str, values: Mapping[str, Word], block: ProgramBlock) -> None:
    """Keep what the first of two blocks says: G71 U R, G72 W R, G73 U W R."""
    state = m.state
    if code == "G70" or not values.keys() & {"U", "W", "R", "D"}:
        raise block.refusal(
            code,
            "this means inches or mm on some controls and a cycle on others; use G20 or G700 for "
            "inches, G21 or G710 for mm, or state the cycle's P and Q",
        )
    state.taken = {}
    state.taken |= cycle_lengths(state, values, "UWD" if code == "G73" else "UWDR")
    if code == "G73" and "R" in values:
        state.taken["R"] = word_value(values["R"])


def contour_of(
    m: Carrying, blocks: Iterable[ProgramBlock], block: ProgramBlock
) -> list[ProgramMove]:
    """Return the moves of a contour, run apart: nothing of it stays in force."""
    if m.in_contour:
        raise block.refusal(block.words[0].text, "a cycle inside a contour; write it behind it")
    kept, record = m.state, m.record
    m.state, m.in_contour = copy.copy(kept), True
    m.state.in_profile = kept.control is LINUXCNC
    m.state.place, m.state.shift = dict(kept.place), dict(kept.shift)
    if m.state.feed is None:
        m.state.feed = 1.0  # a contour's feeds are those of its finishing
    found: list[ProgramMove] = []
    begins: int | None = None
    m.record = CornerRecord(found.append, source=block.source)
    try:
        for one in blocks:
            m.step(one)
            # The first block with a place goes to where the contour begins
            if begins is None and any(word.name in "XZUW" for word in one.words):
                begins = len(found)
        m.record.finish()
    finally:
        m.state, m.record, m.in_contour = kept, record, False
    if not found[begins:]:
        raise block.refusal(block.words[0].text, "the contour has no moves; give two or more")
    return found[begins:]


def _follow(m: Carrying, blocks: Sequence[ProgramBlock]) -> None:
    """Run a contour's blocks as they stand: the finishing pass."""
    for one in blocks:
        m.step(one)


def _allowed(
    m: Carrying,
    code: str,
    values: Mapping[str, Word],
    block: ProgramBlock,
    moves: Sequence[ProgramMove],
) -> None:
    state, taken = m.state, m.state.taken
    start = {axis: state.known(axis) for axis in ("x", "z")}
    over = cycle_lengths(state, values, "UW")
    over_x = over.get("U", 0.0) * state.factor("x") / state.unit_mm
    over_z = over.get("W", 0.0)
    if code == "G73":
        _pattern(m, values, block, moves, (over_z, over_x))
        return
    depth = taken.get("U" if code == "G71" else "W", taken.get("D", 0.0))
    if "D" in values:
        depth = depth_of_cut(state, values["D"])
    if depth <= 0:
        raise block.refusal(code, "the depth of a pass is missing; state U (G72: W) or D")
    along, across = AXES_OF[code]
    by = (over_z, over_x) if code == "G71" else (over_x, over_z)
    how = Passes(
        along, across, depth, taken.get("R", CLEAR_MM), by, 0.0, (start[along], start[across])
    )
    places = chain(moves, along=INDEX_OF[along], across=INDEX_OF[across])
    rough(m, block, places, how)
    rapid_to(m, block, **{across: start[across]})
    rapid_to(m, block, **{along: start[along]})


def rough(m: Carrying, block: ProgramBlock, places: Array, how: Passes) -> None:
    """Cut a contour (n, 2) out at levels, and then along it; ends at the contour's last place."""
    side = 1.0 if how.start[1] >= places[:, 1].mean() else -1.0
    left = moved(places, by=how.by, off_mm=how.off_mm, side=side)
    if how.pockets is False:
        left = without_pockets(left, side)
    deepest = left[:, 1].min() if side > 0 else left[:, 1].max()
    level, count = how.start[1], 0
    while side * (level - deepest) > how.depth_mm * (1 + 1e-9):
        above, level = level, level - side * how.depth_mm
        count += 1
        if count > MOST_PASSES:
            raise block.refusal(
                block.words[0].text, f"more than {MOST_PASSES} passes; make them deeper"
            )
        for way, end in runs_beyond(left, level, side, above=above):
            if way or not how.pockets:
                _pass(m, block, how, (end, level), side=side, way=way)
    rapid_to(m, block, **{how.along: how.start[0]})
    rapid_to(m, block, **{how.across: float(left[0, 1])})
    for a, d in left.tolist():
        feed_to(m, block, {how.along: a, how.across: d})


def _pass(
    m: Carrying,
    block: ProgramBlock,
    how: Passes,
    span: tuple[float, float],
    *,
    side: float,
    way: Sequence[tuple[float, float]],
) -> None:
    """Cut at one level up to where it ends, and draw back at 45°.

    It begins where the cycle does, or goes down into a pocket along the contour by ``way``, from
    and back to where the cycle began across: a land may be beside it.
    """
    end, level = span
    if way:
        over = min(way[0][1] + side * how.back_mm, how.start[1], key=lambda d: side * d)
        rapid_to(m, block, **{how.across: how.start[1]})
        rapid_to(m, block, **{how.along: way[0][0]})
        rapid_to(m, block, **{how.across: over})
    else:
        rapid_to(m, block, **{how.along: how.start[0]})
        rapid_to(m, block, **{how.across: level})
    for along, across in way:
        feed_to(m, block, {how.along: along, how.across: across})
    begin = way[-1][0] if way else how.start[0]
    feed_to(m, block, {how.along: end})
    back = how.back_mm if end < begin else -how.back_mm
    above = min(level + side * how.depth_mm, how.start[1], key=lambda d: side * d)
    above = above if way else max(level + side * how.back_mm, level, key=lambda d: side * d)
    rapid_to(m, block, **{how.along: end + back, how.across: above})
    if way:
        rapid_to(m, block, **{how.across: how.start[1]})


def _pattern(
    m: Carrying,
    values: Mapping[str, Word],
    block: ProgramBlock,
    moves: Sequence[ProgramMove],
    over: tuple[float, float],
) -> None:
    """Follow the contour some times, each time nearer to it (G73)."""
    state, taken = m.state, m.state.taken
    times = int(taken.get("R", 0.0)) or int(word_value(values["D"]) if "D" in values else 0)
    if times < 1:
        raise block.refusal("G73", "how often is missing; state R in the first block, or D")
    relief_x = taken.get("U", word_value(values["I"]) * state.unit_mm if "I" in values else 0.0)
    relief_z = taken.get("W", word_value(values["K"]) * state.unit_mm if "K" in values else 0.0)
    start = {axis: state.known(axis) for axis in ("x", "z")}
    places = chain(moves, along=2, across=0)
    for k in range(times):
        share = 1.0 - k / (times - 1) if times > 1 else 0.0
        by = over[0] + share * relief_z, over[1] + share * relief_x
        left = moved(places, by=by, off_mm=0.0, side=1.0)
        rapid_to(m, block, z=float(left[0, 0]))
        rapid_to(m, block, x=float(left[0, 1]))
        for z, x in left[1:].tolist():
            feed_to(m, block, {"z": z, "x": x})
        rapid_to(m, block, x=start["x"])
        rapid_to(m, block, z=start["z"])


_POCKETS = {".1": False, ".2": True}
"""Whether LinuxCNC's G71.1, G71.2 and those of G72 leave pockets, or cut them alone."""


def linuxcnc_roughing(
    m: Carrying, code: str, values: Mapping[str, Word], block: ProgramBlock
) -> None:
    """Carry out LinuxCNC's G70, G71, G72: Q the subprogram of the contour, X Z the start, D I R."""
    state = m.state
    if "Q" not in values:
        raise block.refusal(code, "the contour is missing; state its subprogram as Q")
    unit = f"{word_value(values['Q']):.0f}"
    to = {a: state.factor(a) * word_value(values[a.upper()]) if a.upper() in values
          else state.place[a] for a in ("x", "z")}  # fmt: skip
    rapid_to(m, block, **{a: d for a, d in to.items() if d is not None})
    start = known_start(m, block)
    moves = contour_of(m, m.runner.called(unit, block), block)
    length = {n: word_value(values[n]) * state.unit_mm for n in "DIRE" if n in values}
    along, across = AXES_OF["G72" if code.startswith("G72") else "G71"]
    places = chain(moves, along=INDEX_OF[along], across=INDEX_OF[across])
    at = (start[along], start[across])
    if code.startswith("G70"):
        times = max(int(word_value(values["P"])), 1) if "P" in values else 1
        first, last = length.get("D", 0.0), length.get("E", 0.0)
        for k in range(times - 1, -1, -1):
            off = last + k * (first - last) / times
            how = Passes(along, across, 1e9, length.get("R", 0.0), (0.0, 0.0), off, at)
            rough(m, block, places, how)
    else:
        how = Passes(
            along, across, length.get("I", 1.0), length.get("R", CLEAR_MM), (0.0, 0.0),
            length.get("D", 0.0), at, _POCKETS.get(code[3:]),
        )  # fmt: skip
        rough(m, block, places, how)
    rapid_to(m, block, **{across: start[across]})
    rapid_to(m, block, **{along: start[along]})


def cycle95(m: Carrying, block: ProgramBlock, name: str, numbers: Sequence[float | None]) -> None:
    """Cut a contour by CYCLE95(NPP, MID, FALZ, FALX, FAL, FF1, FF2, FF3, VARI, …, VRT)."""
    given = [one or 0.0 for one in [*numbers, *([None] * 11)][:11]]
    kind = int(given[7]) or 1
    mid, falz, falx, fal, ff1, _, ff3, _, _, _, vrt = (m.state.unit_mm * one for one in given)
    code = "G72" if kind in (2, 4, 6, 8, 10, 12) else "G71"
    inside = kind in (3, 4, 7, 8, 11, 12)
    along, across = AXES_OF[code]
    moves = contour_of(m, _contour_blocks(m, name, block), block)
    places = contour_as_cut(chain(moves, along=INDEX_OF[along], across=INDEX_OF[across]))
    edge = places[:, 1].min() if inside and code == "G71" else places[:, 1].max()
    over = (falz, falx * (-1.0 if inside else 1.0))
    by = over if code == "G71" else (over[1], over[0])
    first = float(places[0, 0]) + CLEAR_MM * (1.0 if places[0, 0] >= places[-1, 0] else -1.0)
    at = (first, float(edge) + (-CLEAR_MM if inside and code == "G71" else CLEAR_MM))
    roughs, finishes = kind < 5 or kind > 8, kind > 4
    if roughs and mid <= 0:
        raise block.refusal("CYCLE95", "the depth of a pass is missing; state MID")
    how = Passes(along, across, mid, vrt or 1.0, by, fal, (at[0], float(edge)))
    feeds = (ff1 if roughs else None, ff3 if finishes else None)
    rough_and_finish(m, block, places, how, at=at, feeds=feeds)
    begins, _, ends = name.partition(":")
    m.runner.skip_contour(ends, first=begins)


def rough_and_finish(
    m: Carrying,
    block: ProgramBlock,
    places: Array,
    how: Passes,
    *,
    at: tuple[float, float],
    feeds: tuple[float | None, float | None],
) -> None:
    """Rough a contour (n, 2), finish it, or both, from a place (along, across), and go back to it.

    ``feeds`` of roughing and of finishing: None leaves that out, 0 keeps the feed in force.
    """
    state, (along, across) = m.state, (how.along, how.across)
    rapid_to(m, block, **{across: at[1]})
    rapid_to(m, block, **{along: at[0]})
    once = Passes(along, across, 1e9, how.back_mm, (0.0, 0.0), 0.0, at)
    for passes, feed in zip((how, once), feeds, strict=True):
        if feed is None:
            continue
        state.feed = feed or state.feed
        rough(m, block, places, passes)
        rapid_to(m, block, **{across: at[1]})
    rapid_to(m, block, **{across: at[1]})
    rapid_to(m, block, **{along: at[0]})


def contour_as_cut(places: Array) -> Array:
    """Return a contour the way it is cut, towards the chuck or the axis, however it is written."""
    return places if places[0, 0] >= places[-1, 0] else places[::-1]


def _contour_blocks(m: Carrying, name: str, block: ProgramBlock) -> Iterable[ProgramBlock]:
    first, _, last = name.partition(":")
    return m.runner.contour(first, last, block) if last else m.runner.called(name, block)
