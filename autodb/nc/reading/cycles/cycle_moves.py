"""What cycles have in common: moves to places in mm, and numbers that count thousandths."""

from collections.abc import Mapping
from math import dist
from typing import Protocol

from autodb.nc.reading.codes import INCH_MM
from autodb.nc.reading.compensation import RadiusOf
from autodb.nc.reading.corners import CornerRecord
from autodb.nc.reading.cycles.stated import StatedOfProgram
from autodb.nc.reading.lines.blocks import ProgramBlock, Word
from autodb.nc.reading.motions import feed_straight, go_rapid
from autodb.nc.reading.paths import Feed, Speed
from autodb.nc.reading.runner import Runner
from autodb.nc.reading.state import AXES, ProgramState, word_value
from autodb.nc.reading.travels import Circle, ProgramMove, ToolPlace


class Carrying(Protocol):
    """What carries out a program, as cycles see it."""

    state: ProgramState
    record: CornerRecord
    runner: Runner
    modal_call: tuple[str, Word] | None
    in_contour: bool
    stated: StatedOfProgram
    radius_of: RadiusOf | None

    def step(self, block: ProgramBlock) -> None:
        """Carry out a block."""


CLEAR_MM = 0.5
"""How far a cycle draws back between two pecks or passes, where it does not say. Chosen: controls
keep it in a parameter, of some tenths of a millimetre."""
_COUNTED_MM = 50.0
"""A length without a decimal point counts thousandths where it would be as long otherwise. Chosen:
no cut is so many millimetres deep, and none so few thousandths."""


def rapid_to(m: Carrying, block: ProgramBlock, **to: float) -> None:
    """Go fast to a place, mm; an axis that is not named stays."""
    go_rapid(m.state, {**m.state.place, **to}, block, m.record)


def feed_to(
    m: Carrying,
    block: ProgramBlock,
    to: Mapping[str, float],
    *,
    feed: Feed | None = None,
    thread: bool = False,
) -> None:
    """Go straight to a place at a feed, mm, that in force where none is given."""
    feed_straight(m.state, {**m.state.place, **to}, block, m.record, feed=feed, thread=thread)


SAME_MM = 1e-6
"""Distance below which two places are one."""


def go_along(
    m: Carrying,
    block: ProgramBlock,
    end: ToolPlace,
    feed: Feed | None,
    speed: Speed,
    *,
    circle: Circle | None = None,
) -> None:
    """Go to a place of the machine, straight or on an arc; fast where there is no feed."""
    state = m.state
    begin = ToolPlace(state.known("x"), state.known("y"), state.known("z"))
    if circle is None and dist(begin, end) < SAME_MM:
        return
    turning = None if feed is None else speed
    m.record(ProgramMove(begin, end, feed, turning, block.line, state.tool, circle))
    state.place.update(zip(AXES, end, strict=True))


def known_start(m: Carrying, block: ProgramBlock) -> dict[str, float]:
    """Return where a cycle begins; raises UnusableInput where that is not known."""
    for axis in AXES:
        if m.state.place[axis] is None:
            raise block.refusal(
                block.words[0].text,
                f"the cycle's start is not known in {axis.upper()}; state it in a G0 before",
            )
    return {axis: m.state.known(axis) for axis in AXES}


def thousandths(state: ProgramState, word: Word) -> float:
    """Return a length in mm of a word that counts thousandths where it has no decimal point."""
    if "." in word.written:
        return word_value(word) * state.unit_mm
    least_mm = 0.0001 * INCH_MM if state.unit_mm == INCH_MM else 0.001
    return word_value(word) * least_mm


def _is_large(state: ProgramState, word: Word) -> bool:
    return abs(word_value(word)) * state.unit_mm >= _COUNTED_MM


def depth_of_cut(state: ProgramState, word: Word) -> float:
    """Return a depth D in mm: thousandths where it is a large number without a decimal point."""
    return abs(signed_depth(state, word))


def signed_depth(state: ProgramState, word: Word) -> float:
    """Return such a length with its sign."""
    counted = "." not in word.written and _is_large(state, word)
    return thousandths(state, word) if counted else word_value(word) * state.unit_mm


def cycle_lengths(
    state: ProgramState, values: Mapping[str, Word], letters: str
) -> dict[str, float]:
    """Return lengths in mm of a cycle's words, as they are written: X of a diameter too.

    Where none has a decimal point and one is a large number, all count least increments, and so do
    those without a point in a cycle's second block.
    """
    words = {n: values[n] for n in letters if n in values}
    plain = {n: w for n, w in words.items() if "." not in w.written and word_value(w)}
    if len(plain) == sum(bool(word_value(w)) for w in words.values()) and any(
        _is_large(state, word) for word in plain.values()
    ):
        state.taken["counted"] = 1.0
    counted = plain if state.taken.get("counted") else {}
    return {
        n: thousandths(state, w) if n in counted else word_value(w) * state.unit_mm
        for n, w in words.items()
    }
