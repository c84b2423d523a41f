"""Why a word is not read, and what to write instead."""

from autodb.errors import UnusableInput
from autodb.nc.reading.blocks import ProgramBlock, Word
from autodb.nc.reading.codes import REFUSED
from autodb.nc.reading.controls import FANUC_A
from autodb.nc.reading.state import ProgramState


def not_read(word: Word, block: ProgramBlock, state: ProgramState) -> UnusableInput:
    """Return the error of a word that is not read, with its reason and remedy."""
    if word.code in REFUSED:
        return block.refusal(word.text, REFUSED[word.code])
    if word.code in ("G98", "G99") and state.control is not FANUC_A:
        return block.refusal(word.text, "this belongs to G-code system A; use G94 and G95 here")
    if word.code in ("G90", "G91", "G95") and state.control is FANUC_A:
        return block.refusal(
            word.text,
            "this belongs to the G-code systems B and C, other words of this program to A; use U, "
            "W, G98, G99 alone, or G90, G91, G94, G95 alone",
        )
    why = {
        "G": "this G is not read; write out the moves of a cycle as G0, G1, G2 and G3",
        "M": "this M is not read; leave it out if it moves no axis and calls nothing",
    }
    return block.refusal(
        word.text, why.get(word.name, "this is not read; write out moves as G0, G1, G2 and G3")
    )
