"""A program as blocks of words: comments taken out, every word with its number or refused."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from math import isfinite

from autodb.errors import UnusableInput

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)"
_WORD = re.compile(
    rf"""(?P<named>[A-Z]+)\s*=\s*"(?P<quoted>[^"]*)"
    | (?P<name>[A-Z]{{2}}\w*)(?:\s*=\s*(?P<named_number>{_NUMBER})(?![.\d]))?(?!\s*=)
    | (?P<letter>[A-Z])\s*=?\s*(?P<number>{_NUMBER})(?!\s*[.\d=])""",
    re.VERBOSE,
)
_COMMENT = re.compile(r"\([^()]*\)|;.*")
_SKIP = re.compile(r"/[1-9]?(?!\d)")


@dataclass(frozen=True)
class Word:
    """A letter or a name with what follows it; ``number`` is None where that is text or nothing."""

    name: str
    written: str
    number: float | None

    @property
    def code(self) -> str:
        """The word without zeros that say nothing: G1 for G01."""
        return self.name if self.number is None else f"{self.name}{self.number:g}"

    @property
    def text(self) -> str:
        """The word in capitals without blanks."""
        between = "=" if len(self.name) > 1 and self.written else ""
        return f"{self.name}{between}{self.written}"


@dataclass(frozen=True)
class ProgramBlock:
    """One line of a program; ``optional``: it begins with /."""

    source: str
    line: int
    words: tuple[Word, ...]
    optional: bool

    def refusal(self, word: str, why: str) -> UnusableInput:
        """Return the error that names file, line and word."""
        return UnusableInput(f"{self.source}: line {self.line}: '{word}': {why}")


def blocks(text: str, *, source: str) -> Iterator[ProgramBlock]:
    """Yield the blocks that have words.

    ``source`` names the file in messages. Raises UnusableInput naming file, line and the word that
    has no number or is none.
    """
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    for line, raw in enumerate(lines, 1):
        plain = _COMMENT.sub(" ", raw).upper().strip()
        if plain.startswith("%"):
            continue
        skip = _SKIP.match(plain)
        block = ProgramBlock(source, line, (), skip is not None)
        words = tuple(_words(plain[skip.end() :] if skip else plain, block))
        if words:
            yield ProgramBlock(source, line, words, block.optional)


def _words(plain: str, block: ProgramBlock) -> Iterator[Word]:
    at = 0
    while rest := plain[at:].lstrip():
        at = len(plain) - len(rest)
        found = _WORD.match(plain, at)
        if found is None:
            raise _no_word(rest, block)
        yield _word(found, block)
        at = found.end()


def _word(found: re.Match[str], block: ProgramBlock) -> Word:
    parts = found.groupdict(default="")
    name = parts["named"] or parts["name"] or parts["letter"]
    if parts["named"]:
        return Word(name, parts["quoted"], None)
    written = parts["number"] or parts["named_number"]
    number = float(written) if written else None
    if number is not None and not isfinite(number):
        raise block.refusal(found[0][:40], "larger than any number of a program")
    return Word(name, written, number)


def _no_word(rest: str, block: ProgramBlock) -> UnusableInput:
    word = rest.split(maxsplit=1)[0][:40]
    if word[0] in "()":
        return block.refusal(
            word, "a bracket does not close or opens twice; write comments as ( … )"
        )
    if re.match(r"[A-Z](?![\d.+=#-])", word):
        return block.refusal(word[0], "a word without a number; write one such as X20.5")
    return block.refusal(
        word, "not a letter and a number; write out variables, expressions and functions"
    )
