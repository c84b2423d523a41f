"""Words that give places other coordinates, and moves in those of the machine."""

from collections.abc import Mapping

from autodb.nc.reading.blocks import ProgramBlock, Word
from autodb.nc.reading.codes import MACHINE
from autodb.nc.reading.motions import LETTERS, nothing_left, without
from autodb.nc.reading.state import AXES, ProgramState, word_value

Values = Mapping[str, Word]
_TURNS = frozenset({"ROT", "AROT", "MIRROR", "AMIRROR", "SCALE", "ASCALE"})
FRAMES = _TURNS | {"TRANS", "ATRANS"}
"""Words of Sinumerik that shift coordinates, or turn, mirror or scale them."""


def names_axis(values: Values) -> bool:
    """Return whether a block states a place of an axis."""
    return any(name in values for pair in (*LETTERS.values(), ("@", "^")) for name in pair)


def set_place(state: ProgramState, code: str, values: Values, block: ProgramBlock) -> None:
    """Let the place of the tool have other coordinates (G50, G92), or shift them (G52)."""
    for axis in AXES:
        word = next((values[name] for name in LETTERS[axis] if name in values), None)
        if word is None:
            continue
        to = state.factor(axis) * word_value(word)
        place = state.place[axis]
        if code == "G52":
            state.shift[axis] = to
        elif place is None:
            state.place[axis] = to + state.shift[axis]
        else:
            state.shift[axis] = place - to
    left = without(values, *(n for pair in LETTERS.values() for n in pair), "R", "P", "Q", "C")
    nothing_left(left, block, state)


def shift_frame(state: ProgramState, names: set[str], values: Values, block: ProgramBlock) -> None:
    """Shift coordinates by TRANS or ATRANS; turning, mirroring and scaling are refused."""
    turns = names & _TURNS
    if turns and any(word.number for word in without(values, "N").values()):
        raise block.refusal(min(turns), "this turns, mirrors or scales; program without it")
    if "TRANS" in names or turns:
        state.shift = dict.fromkeys(AXES, 0.0)
    for axis in AXES:
        word = values.get(axis.upper())
        if word is not None and not turns:
            state.shift[axis] += state.factor(axis) * word_value(word)


def move_in_machine(
    state: ProgramState, codes: Mapping[str, Word], values: Values, block: ProgramBlock
) -> None:
    """Move the axes that are named to machine coordinates: they are not known any more."""
    word = next(codes[code] for code in codes if code in MACHINE or codes[code].code == "G75")
    if word.code in {"G53", "SUPA"} and state.motion != "G0" and names_axis(values):
        raise block.refusal(word.text, "this cuts in machine coordinates; use it with G0")
    axes = [a for a in AXES if any(name in values for name in LETTERS[a])]
    if axes or word.code not in ("G53", "SUPA"):
        state.forget(*axes)
    if state.lathe:
        state.place["y"] = 0.0
