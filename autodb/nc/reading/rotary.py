"""Rotary axes of a mill that stand while it cuts: what is cut at the angles that a job states."""

from collections.abc import Mapping

from autodb.nc.reading.codes import MACHINE
from autodb.nc.reading.lines.blocks import Word
from autodb.nc.reading.motions import ROTARY
from autodb.nc.reading.state import ProgramState, word_value

_SETS = frozenset({"G10", "G50", "G52", "G92"})
"""Words with which a rotary axis is given another place and does not turn."""
_HOME = frozenset({"G28", "G30", "G28.1", "G30.1"})
"""Words with which it turns to its reference point, taken to be 0."""
_SAME_DEG = 1e-3
"""Angles that differ by less are the same: the last decimal of a program. Chosen."""


def turn_rotary(
    state: ProgramState, codes: Mapping[str, Word], values: Mapping[str, Word]
) -> Mapping[str, Word]:
    """Turn rotary axes to what a block says, and return its other words.

    Nothing is done where the job states neither angles nor a plane.
    """
    words = {letter: values[letter] for letter in ROTARY if letter in values}
    still = state.angles is None and state.looks_at is None
    if still or not words or codes.keys() & _SETS:
        return values
    home, machine = (bool(codes.keys() & some) for some in (_HOME, MACHINE))
    for letter, word in words.items():
        before = state.rotary.get(letter, 0.0)
        steps = not (state.absolute or machine) if word.step is None else word.step
        to = 0.0 if home else word_value(word) + before * steps
        state.turning_rotary |= _apart(to, before)
        state.rotary[letter] = to
    return {name: word for name, word in values.items() if name not in words}


def stands_as_stated(state: ProgramState) -> bool:
    """Return whether the rotary axes stand at the angles that the job states, others at 0.

    In a tilted plane they stand wherever it needs them.
    """
    if state.tilt:
        return not state.turning_rotary
    angles = state.angles or {}
    return not state.turning_rotary and not any(
        _apart(state.rotary.get(letter, 0.0), angles.get(letter, 0.0)) for letter in ROTARY
    )


def _apart(a_deg: float, b_deg: float) -> bool:
    return abs((a_deg - b_deg + 180.0) % 360.0 - 180.0) > _SAME_DEG
