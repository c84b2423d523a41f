"""Dwells: how long the tool rests."""

from collections.abc import Mapping

from autodb.nc.reading.controls import LINUXCNC
from autodb.nc.reading.lines.blocks import ProgramBlock, Word
from autodb.nc.reading.motions import nothing_left
from autodb.nc.reading.state import ProgramState, word_value
from autodb.nc.reading.targets import without


def rest_s(state: ProgramState, values: Mapping[str, Word], block: ProgramBlock) -> float:
    """Return a dwell in s: P in ms on Fanuc's controls, in s on LinuxCNC; X, U and F in s."""
    nothing_left(without(values, "P", "X", "U", "F", "S", "N"), block, state)
    seconds = 0.0
    for letter, word in without(values, "N").items():
        number = word_value(word)
        if letter == "P":
            whole = state.control is not LINUXCNC and "." not in word.written
            seconds = number / 1000.0 if whole else number
        elif letter == "S" and state.speed:
            seconds = 60.0 * number / state.speed
        else:
            seconds = number
    return max(seconds, 0.0)
