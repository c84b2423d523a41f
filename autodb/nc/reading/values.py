"""The words of a block told apart: those that name what to do, and letters with values."""

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
    "R": "a radius belongs to G2 or G3; a rounded corner written out as an arc would work",
    "C": "a chamfer or a rotary axis: the chamfer written out as a G1 move would work",
    "A": "a direction by its angle: the end by X and Z would work",
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
            raise block.refusal(word.text, f"a second {key} in this block; one would work")
        into[key] = word
    return codes, values


def _not_read(word: Word, block: ProgramBlock) -> UnusableInput:
    if word.name in _BY_ITSELF:
        return block.refusal(word.text, _BY_ITSELF[word.name])
    moves = "written out as G0, G1, G2 and G3"
    why = {
        "G": f"this G is not read; a cycle's or a thread's moves {moves} would work",
        "M": "this M is not read; left out, if it moves no axis and calls nothing, it would work",
    }
    return block.refusal(word.text, why.get(word.name, f"not read; moves {moves} would work"))


def without(values: Mapping[str, Word], *letters: str) -> dict[str, Word]:
    """Return the values but those of some letters."""
    return {letter: word for letter, word in values.items() if letter not in letters}


def nothing_left(values: Mapping[str, Word], block: ProgramBlock, modes: Modes) -> None:
    """Raise UnusableInput naming the first value that nothing has taken; N and O number only."""
    for letter, word in without(values, "N", "O").items():
        why = _BY_ITSELF.get(letter, f"nothing in this block takes it (in force: {modes.motion})")
        raise block.refusal(word.text, f"{why}; left out it would work")


def word_value(word: Word) -> float:
    """Return the number of a word that has one."""
    assert word.number is not None  # sorted_out() refused
    return word.number


def positive_value(word: Word, block: ProgramBlock) -> float:
    """Return a word's number; raises UnusableInput where it is not above 0."""
    if word_value(word) <= 0:
        raise block.refusal(word.text, "a number above 0 would work")
    return word_value(word)
