"""Grooves and pecks of Fanuc's lathes: G75 into the radius, G74 along the axis.

The tool goes in by pecks, moves over by a step and goes in again until it has been everywhere. P
(or I) and Q (or K) are steps in X and in Z, of which that in the direction of the cut is the peck.
"""

from collections.abc import Mapping

from autodb.nc.reading.cycles.cycle_moves import (
    CLEAR_MM,
    Carrying,
    cycle_lengths,
    feed_to,
    known_start,
    rapid_to,
    thousandths,
)
from autodb.nc.reading.lines.blocks import ProgramBlock, Word
from autodb.nc.reading.state import word_value
from autodb.nc.reading.targets import targets

MOST_PECKS = 20_000


def fanuc_grooves(m: Carrying, code: str, values: Mapping[str, Word], block: ProgramBlock) -> None:
    """Carry out G74 or G75, in two blocks (R, then X Z P Q F) or in one (X Z I K F)."""
    state = m.state
    axes = {n: w for n, w in values.items() if n in "XZUW"}
    if not axes:
        state.taken = {}
        state.taken |= cycle_lengths(state, values, "R")
        return
    start = known_start(m, block)
    to = {axis: place or 0.0 for axis, place in targets(state, axes, block).items()}
    steps = {
        "x": _step(m, values, "P", "I", state.factor("x") / state.unit_mm),
        "z": _step(m, values, "Q", "K", 1.0),
    }
    into, over = ("x", "z") if code == "G75" else ("z", "x")
    back = state.taken.get("R", CLEAR_MM)
    for place in _stations(start[over], to[over], steps[over], block):
        rapid_to(m, block, **{over: place})
        _peck(m, block, into, (start[into], to[into]), step=steps[into], back=back)
    rapid_to(m, block, **{over: start[over]})


def _step(m: Carrying, values: Mapping[str, Word], modern: str, old: str, radial: float) -> float:
    if modern in values:
        return abs(thousandths(m.state, values[modern]))
    if old in values:
        return abs(word_value(values[old])) * m.state.unit_mm * radial
    return 0.0


def _stations(start: float, end: float, step: float, block: ProgramBlock) -> list[float]:
    """Return where the tool goes in: every step from the start, and at the end."""
    way = end - start
    if abs(way) < 1e-9 or step <= 0:
        return [start] if abs(way) < 1e-9 else [start, end]
    count = abs(way) / step
    if count > MOST_PECKS:
        raise block.refusal(block.words[0].text, "a step is far too small; make it larger")
    whole = [start + (step if way > 0 else -step) * k for k in range(int(count + 1e-9) + 1)]
    return whole if abs(whole[-1] - end) < 1e-9 else [*whole, end]


def _peck(
    m: Carrying,
    block: ProgramBlock,
    axis: str,
    span: tuple[float, float],
    *,
    step: float,
    back: float,
) -> None:
    """Feed in by pecks, drawing back a little after each, and out fast."""
    start, end = span
    for place in _stations(start, end, step, block)[1:]:
        feed_to(m, block, {axis: place})
        if abs(place - end) > 1e-9:
            rapid_to(m, block, **{axis: place + (back if start > end else -back)})
    rapid_to(m, block, **{axis: start})
