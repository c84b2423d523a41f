"""Words that give places other coordinates, and moves in those of the machine."""

from collections.abc import Mapping
from math import radians

from autodb.nc.reading.codes import MACHINE
from autodb.nc.reading.controls import OF_FANUC
from autodb.nc.reading.lines.blocks import ProgramBlock, Word
from autodb.nc.reading.motions import nothing_left
from autodb.nc.reading.state import AXES, ProgramState, TurnedPlane, word_value
from autodb.nc.reading.targets import LETTERS, without

Values = Mapping[str, Word]
_TURNS = frozenset({"MIRROR", "AMIRROR", "SCALE", "ASCALE"})
_MIRRORS = frozenset({"MIRROR", "AMIRROR"})
"""These take an axis for its name alone, whatever number stands behind it."""
_ROTATES = frozenset({"ROT", "AROT"})
FRAMES = _TURNS | _ROTATES | {"TRANS", "ATRANS"}
"""Words of Sinumerik that shift coordinates, or turn, mirror or scale them."""


def names_axis(values: Values) -> bool:
    """Return whether a block states a place of an axis."""
    return any(name in values for pair in (*LETTERS.values(), ("@", "^")) for name in pair)


def set_place(state: ProgramState, code: str, values: Values, block: ProgramBlock) -> None:
    """Let the place of the tool have other coordinates (G50, G92), or shift them (G52)."""
    if state.turned is not None:
        raise block.refusal(code, "coordinates are turned here; set places before or after that")
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
    """Shift coordinates by TRANS or ATRANS, turn them by ROT or AROT.

    Mirroring and scaling are refused, and turning on a lathe or about another axis than Z.
    """
    turns, rotates = names & _TURNS, names & _ROTATES
    numbers = [word.number for word in without(values, "N").values()]
    if turns and ((numbers and turns & _MIRRORS) or any(one != 1.0 for one in numbers)):
        raise block.refusal(min(turns), "this mirrors or scales; program without it")
    if "ATRANS" in names and state.turned is not None:
        raise block.refusal("ATRANS", "this shifts turned coordinates; shift them before ROT")
    if names & {"TRANS", "ROT"} or turns:
        state.shift, state.turned = dict.fromkeys(AXES, 0.0), None
    if rotates:
        _rotate(state, min(rotates), values, block)
        return
    for axis in AXES:
        word = values.get(axis.upper())
        if word is not None and not turns:
            state.shift[axis] += state.factor(axis) * word_value(word)


def refuse_axial_shift(codes: Mapping[str, Word], values: Values, block: ProgramBlock) -> None:
    """Raise UnusableInput for Sinumerik's G58 and G59 with a place: they shift axes by it."""
    word = next((codes[code] for code in ("G58", "G59") if code in codes), None)
    if word is not None and names_axis(values):
        raise block.refusal(
            word.text,
            "this shifts axes on some controls and selects an offset on others; use TRANS",
        )


def _rotate(state: ProgramState, name: str, values: Values, block: ProgramBlock) -> None:
    """Turn coordinates about their zero by RPL, or by Z, in the plane of X and Y."""
    word = values.get("RPL", values.get("Z"))
    others = without(values, "RPL", "Z", "N").values()
    if any(one.number for one in others) or (word is not None and word.number and state.lathe):
        raise block.refusal(name, "this turns about another axis than a mill's Z; leave it out")
    if word is None or not word.number:
        return
    if state.plane != "G17":
        raise block.refusal(name, "turned coordinates are read in the plane of X and Y; use G17")
    before = 0.0 if state.turned is None else state.turned.angle_rad
    angle = before + radians(word_value(word))
    state.turned = TurnedPlane(state.shift["x"], state.shift["y"], angle)


def turn_plane(state: ProgramState, values: Values, block: ProgramBlock) -> None:
    """Turn coordinates (G68) about X and Y, or where the tool is, by R degrees to the left."""
    if state.plane != "G17":
        raise block.refusal("G68", "turned coordinates are read in the plane of X and Y; use G17")
    if "R" not in values:
        raise block.refusal("G68", "this turns by nothing; state the angle R")
    if state.turned is not None:
        raise block.refusal("G68", "coordinates are turned already; end that with G69 before")
    about = {}
    for axis in ("x", "y"):
        word = values.get(axis.upper())
        if word is not None:
            about[axis] = state.unit_mm * word_value(word) + state.shift[axis]
        elif state.place[axis] is None:
            raise block.refusal("G68", f"about where is not known; state {axis.upper()}")
        else:
            about[axis] = state.known(axis)
    nothing_left(without(values, "X", "Y", "R"), block, state)
    state.turned = TurnedPlane(about["x"], about["y"], radians(word_value(values["R"])))


def move_in_machine(
    state: ProgramState, codes: Mapping[str, Word], values: Values, block: ProgramBlock
) -> None:
    """Move the axes that are named to machine coordinates: they are not known any more.

    Fanuc's controls go there fast, whatever motion is in force (Series 0i-D, operator's manual
    B-64304EN, machine coordinate system); others only with G0.
    """
    word = next(codes[code] for code in codes if code in MACHINE or codes[code].code == "G75")
    fast = state.motion == "G0" or (
        state.control in OF_FANUC and not codes.keys() & {"G1", "G2", "G3"}
    )
    if word.code in {"G53", "SUPA"} and not fast and names_axis(values):
        raise block.refusal(word.text, "this cuts in machine coordinates; use it with G0")
    axes = [a for a in AXES if any(name in values for name in LETTERS[a])]
    if axes or word.code not in ("G53", "SUPA"):
        state.forget(*axes)
    if state.lathe:
        state.place["y"] = 0.0
