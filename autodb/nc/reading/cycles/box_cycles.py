"""Cycles of one pass of Fanuc's lathes: along the axis (G90), a thread (G92), a face (G94).

The tool goes in fast, cuts, draws back and returns to where it began; each further block with a
place makes a pass. R is the taper: where the pass begins, from where it ends, as a radius (G94:
along the axis). Systems B and C call them otherwise (``codes``).
"""

from collections.abc import Mapping

from autodb.nc.reading.cycles.cycle_moves import Carrying, feed_to, known_start, rapid_to
from autodb.nc.reading.lines.blocks import ProgramBlock, Word
from autodb.nc.reading.motions import nothing_left
from autodb.nc.reading.paths import PerRev
from autodb.nc.reading.state import word_value
from autodb.nc.reading.targets import LETTERS, targets, without

_TAKEN = ("F", "R", "I", "K", "S", "T", "N", "Q", "E", "M", "O")


def box(m: Carrying, code: str, values: Mapping[str, Word], block: ProgramBlock) -> None:
    """Make one pass of the cycle that is in force, or that begins here."""
    state, kind = m.state, code.strip()
    if state.cycle != code:
        state.cycle, state.taken, state.motion = code, {}, None
    axes = {letter: word for letter, word in values.items() if _is_axis(letter)}
    start = known_start(m, block) if axes else {}
    nothing_left(without(values, *axes, *_TAKEN), block, state)
    to = targets(state, axes, block)
    for axis in ("x", "z"):
        if any(letter in axes for letter in LETTERS[axis]):
            state.taken[axis] = to[axis] or 0.0
    for letter in ("R", "I", "K"):
        if letter in values:
            state.taken["taper"] = state.unit_mm * word_value(values[letter])
    if not axes:
        return
    if not {"x", "z"} <= state.taken.keys():
        raise block.refusal(block.words[0].text, "this cycle needs X and Z; state both")
    x, z, taper = state.taken["x"], state.taken["z"], state.taken.get("taper", 0.0)
    if kind == "G94":
        rapid_to(m, block, z=z + taper)
        feed_to(m, block, {"x": x, "z": z})
        feed_to(m, block, {"z": start["z"]})
        rapid_to(m, block, x=start["x"])
        return
    rapid_to(m, block, x=x + taper)
    if kind == "G92":
        if not state.feed:
            raise block.refusal(kind, "a thread without a pitch; state F")
        feed_to(m, block, {"x": x, "z": z}, feed=PerRev(state.feed), thread=True)
        rapid_to(m, block, x=start["x"])
    else:
        feed_to(m, block, {"x": x, "z": z})
        feed_to(m, block, {"x": start["x"]})
    rapid_to(m, block, z=start["z"])


def _is_axis(letter: str) -> bool:
    return any(letter in pair for pair in LETTERS.values())
