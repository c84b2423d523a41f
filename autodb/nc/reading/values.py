"""The words of a block sorted: those that name what to do, and letters with values."""

from collections.abc import Mapping

from autodb.errors import UnusableInput
from autodb.nc.reading.blocks import ProgramBlock, Word
from autodb.nc.reading.modes import GROUPS, HARMLESS, MACHINE, OFFSETS, ONCE, REFUSED, Modes

AXES = ("X", "Z", "U", "W")
CENTRE = ("I", "K")
RADIUS = ("R", "CR")
_READ = {code for group in GROUPS for code in group} | HARMLESS | OFFSETS | MACHINE | ONCE
_LETTERS = frozenset((*AXES, *CENTRE, *RADIUS, "F", "S", "T", "D", "N", "O", "P", "LIMS"))
_BY_ITSELF = {
    "R": "a radius belongs to G2 or G3; write out a rounded corner as an arc",
    "C": "this is a chamfer or a rotary axis; write out a chamfer as a G1 move",
    "A": "this states a direction by its angle; state the end by X and Z",
    "Y": "only moves of X and Z are read",
}


def sorted_words(block: ProgramBlock) -> tuple[dict[str, Word], dict[str, Word]]:
    """Return the words that name what to do, by code, and those with values, by letter."""
    codes: dict[str, Word] = {}
    values: dict[str, Word] = {}
    for word in block.words:
        if word.code in REFUSED:
            raise block.refusal(word.text, REFUSED[word.code])
        into, key = (codes, word.code) if word.code in _READ else (values, word.name)
        if into is values and (key not in _LETTERS or (word.number is None and key != "T")):
            raise _not_read(word, block)
        if key in into:
            raise block.refusal(word.text, f"this is a second {key} in the block; use one")
        into[key] = word
    return codes, values


def _not_read(word: Word, block: ProgramBlock) -> UnusableInput:
    if word.name in _BY_ITSELF:
        return block.refusal(word.text, _BY_ITSELF[word.name])
    why = {
        "G": "this G is not read; write out the moves of a cycle or thread as G0, G1, G2 and G3",
        "M": "this M is not read; leave it out if it moves no axis and calls nothing",
    }
    return block.refusal(
        word.text, why.get(word.name, "this is not read; write out moves as G0, G1, G2 and G3")
    )


def without(values: Mapping[str, Word], *letters: str) -> dict[str, Word]:
    """Return the values but those of some letters."""
    return {letter: word for letter, word in values.items() if letter not in letters}


def nothing_left(values: Mapping[str, Word], block: ProgramBlock, modes: Modes) -> None:
    """Raise UnusableInput naming the first value that nothing has taken; N and O number only."""
    for letter, word in without(values, "N", "O").items():
        why = _BY_ITSELF.get(letter, f"nothing in this block takes it (in force: {modes.motion})")
        raise block.refusal(word.text, f"{why}; leave it out")


def word_value(word: Word) -> float:
    """Return the number of a word that has one."""
    assert word.number is not None  # sorted_out() refused
    return word.number


def positive_value(word: Word, block: ProgramBlock) -> float:
    """Return a word's number; raises UnusableInput where it is not above 0."""
    if word_value(word) <= 0:
        raise block.refusal(word.text, "use a number above 0")
    return word_value(word)
