"""A program's lines as words: comments taken out, every word with its number or refused.

What is not a plain number is kept as an expression and worked out when the line runs, since
variables may have changed by then. These are the lines of Fanuc, Haas and LinuxCNC; those of
Sinumerik are in ``sinumerik_lines``.
"""

import re
from array import array
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import isfinite

from autodb.errors import UnusableInput
from autodb.nc.reading.lines.expressions import Expression, Key, Variables, expression, value_at

NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)"
_LITERAL = re.compile(rf"([A-Z@^]|,[ACR])({NUMBER})(?![.\d])")
_LETTER = re.compile(
    r"([A-Z@^]|,[ACR])(?=[#\[]|[+-][#\[]|A?SIN|A?COS|A?TAN|ABS|SQRT|ROUND|FIX|FUP)"
)
_SETTING = re.compile(r"#(?:\d+|<[^<>]*>|\[[^=]*?\]|#\d+)=(?!=)")
_COMMENT = re.compile(r"\([^()]*\)")
_TO_FIRST_CLOSE = re.compile(r"\([^)]*\)")
"""A comment that opens twice: the first bracket that closes ends it, as on the controls."""
_OPEN_COMMENT = re.compile(r"(?m)^[ \t]*\([^()\n]*\n(?=[ \t]*\()")
"""A line that is a comment which does not close, before another comment: whether a control goes on
to the end of the line or to the next bracket that closes, it skips the same."""
_NO_TEXT = "\0\1\2\3\4\5\6\b\ufffd"
"""What stands in files that are no text; some programs end in a 0."""
_SKIP = re.compile(r"\s*/[1-9]?(?!\d)")
_SKIP_WITHIN = re.compile(r"(?:^|(?<=[\d.]))/[1-9]?(?=[A-Z](?!\w*[\[(]))")
"""Block skip within a line, of what stands behind it (Fanuc, Haas): X20. / M8."""
_END_OF_FILE = "\x1a"
"""What editors of DOS end a file with."""
_SIMULATOR = re.compile(r"\s*\[\s*[A-Z]", re.IGNORECASE)
"""Lines of simulators, which controls never see: [BILLET X50 Z80, [TOOLDEF T1."""


@dataclass(frozen=True, slots=True)
class Word:
    """A letter or a name with what follows it; ``number`` is None where that is text or nothing.

    ``step``: it counts from where the axis is, or does not, whatever else is in force; None: as is
    in force. ``arguments`` of a call, None where one is left out.
    """

    name: str
    written: str
    number: float | None
    step: bool | None = None
    arguments: tuple[float | str | None, ...] = ()

    @property
    def code(self) -> str:
        """The word without zeros that say nothing: G1 for G01."""
        return self.name if self.number is None else f"{self.name}{self.number:g}"

    @property
    def text(self) -> str:
        """The word in capitals without blanks."""
        between = "=" if len(self.name) > 1 and self.written and self.name[0] != "," else ""
        return f"{self.name}{between}{self.written}"


@dataclass(frozen=True, slots=True)
class WrittenWord:
    """A word whose value is an expression, or a call's arguments."""

    name: str
    written: str
    value: Expression | None
    step: bool | None = None
    arguments: tuple[Expression | str | None, ...] = ()

    def worked_out(self, variables: Variables) -> Word | None:
        """Return the word with its number; None where it is a variable that is vacant."""
        made = tuple(one(variables) if callable(one) else one for one in self.arguments)
        if self.value is None:
            return Word(self.name, self.written, None, self.step, made)
        number = self.value(variables)
        if number is None:
            return None
        return Word(self.name, f"{round(number, 9):.9g}", number, self.step, made)


Setting = tuple[Expression | Key, Expression]
"""A variable, by its name or by an expression for its number, and what it is set to."""


@dataclass(frozen=True, slots=True)
class ProgramBlock:
    """One line of a program as it runs; ``optional``: it begins with /."""

    source: str
    line: int
    words: tuple[Word, ...]
    optional: bool = False

    def refusal(self, word: str, why: str) -> UnusableInput:
        """Return the error that names file, line and word."""
        return UnusableInput(f"{self.source}: line {self.line}: '{word}': {why}")


@dataclass(frozen=True, slots=True)
class WrittenLine:
    """One line as it is written: its words, and the variables that it sets.

    ``kept``: how many of its words block skip leaves, where a / stands within the line.
    """

    source: str
    line: int
    text: str
    optional: bool = False
    words: tuple[Word | WrittenWord, ...] = ()
    settings: tuple[Setting, ...] = ()
    kept: int | None = None

    def refusal(self, word: str, why: str) -> UnusableInput:
        """Return the error that names file, line and word."""
        return ProgramBlock(self.source, self.line, ()).refusal(word, why)

    def block(self, variables: Variables) -> ProgramBlock:
        """Return the line with its numbers; raises UnusableInput where one cannot be worked out."""
        found = []
        for word in self.words:
            try:
                made = word if isinstance(word, Word) else word.worked_out(variables)
            except (ValueError, OverflowError) as error:
                raise self.refusal(word.written, str(error)) from None
            if made is not None:
                if made.number is not None and not isfinite(made.number):
                    raise self.refusal(made.text[:40], "larger than any number of a program")
                found.append(made)
        return ProgramBlock(self.source, self.line, tuple(found), self.optional)


def numbered_lines(text: str, *, source: str, brackets: bool) -> Iterator[WrittenLine]:
    """Yield the lines that are more than a comment, in capitals.

    ``brackets``: ( … ) is a comment, as well as what follows a semicolon.
    """
    if sum(text.count(one) for one in _NO_TEXT) > 2:
        raise UnusableInput(f"{source}: is no text; give an NC program as plain text")
    text = text.split(_END_OF_FILE, 1)[0].replace("\r\n", "\n").replace("\r", "\n")
    text = _OPEN_COMMENT.sub("\n", text) if brackets else text
    for number, raw in enumerate(_split(text), 1):
        if brackets and _SIMULATOR.match(raw):
            continue
        plain = _without_comments(raw, brackets=brackets).upper()
        skip = _SKIP.match(plain)
        plain = plain[skip.end() :] if skip else plain
        if plain.strip():
            yield WrittenLine(source, number, plain.strip(), skip is not None)


def _split(text: str) -> Iterator[str]:
    """Yield the lines of a text; a long one's are not all there at once."""
    begin = 0
    while (end := text.find("\n", begin)) >= 0:
        yield text[begin:end]
        begin = end + 1
    yield text[begin:]


def _without_comments(raw: str, *, brackets: bool) -> str:
    if not brackets:
        return re.sub(r'("[^"]*")|;.*', lambda found: found[1] or " ", raw)
    before, plain = None, raw
    while plain != before:
        before, plain = plain, _COMMENT.sub(" ", plain)
    if "(" in plain:
        plain = _TO_FIRST_CLOSE.sub(" ", raw)
    return plain.split(";", 1)[0]


def worded(line: WrittenLine, text: str | None = None) -> WrittenLine:
    """Return a line of Fanuc or LinuxCNC with its words; ``text``: what of it is words.

    Raises UnusableInput naming file, line and what is no word.
    """
    plain = re.sub(r"\s", "", line.text if text is None else text)
    starts = [found.start() for found in _SETTING.finditer(plain)]
    settings = [_setting(line, plain[start:end]) for start, end in pairwise([*starts, len(plain)])]
    said = plain[: starts[0]] if starts else plain
    cut = _SKIP_WITHIN.search(said)
    words = tuple(_words(line, said[: cut.start()] if cut else said))
    kept = len(words) if cut else None
    words += tuple(_words(line, said[cut.end() :])) if cut else ()
    return WrittenLine(
        line.source, line.line, line.text, line.optional, words, tuple(settings), kept
    )


def _setting(line: WrittenLine, text: str) -> Setting:
    left, right = text.split("=", 1)
    try:
        value = expression(right, packed=True)
        if left.startswith("#<"):
            return left[2:-1].lower(), value
        if left[1:].isdigit():
            return int(left[1:]), value
        return expression(left[1:], packed=True), value
    except UnusableInput as error:
        raise line.refusal(text[:40], str(error)) from None


def _words(line: WrittenLine, plain: str) -> Iterator[Word | WrittenWord]:
    at = 0
    while at < len(plain):
        found = _LITERAL.match(plain, at)
        if found is not None:
            yield plain_word(line, found[1], found[2])
            at = found.end()
            continue
        letter = _LETTER.match(plain, at)
        if letter is None:
            raise _no_word(plain[at:], line)
        try:
            value, end = value_at(plain, letter.end(), packed=True)
        except UnusableInput as error:
            raise line.refusal(plain[at:][:40], str(error)) from None
        yield WrittenWord(letter[1], plain[letter.end() : end], value)
        at = end


def plain_word(line: WrittenLine, name: str, written: str) -> Word:
    """Return a word with a plain number; raises UnusableInput where it is too large, or an exponent
    (X1E-05, as scripts write small numbers), which no control takes."""
    number = float(written)
    if name == "E" and written[0] in "+-":
        raise line.refusal(f"E{written}", "no control takes exponents; write the number out")
    if not isfinite(number):
        raise line.refusal(f"{name}{written}"[:40], "larger than any number of a program")
    return Word(name, written, number)


def of_line(error: UnusableInput, line: WrittenLine, plain: str) -> UnusableInput:
    """Return an error with file and line, where it does not name them yet."""
    named = str(error).startswith(line.source)
    return error if named else line.refusal(plain[:40], str(error))


def _no_word(rest: str, line: WrittenLine) -> UnusableInput:
    word = rest[:40]
    if word[0] in "()":
        return line.refusal(
            word, "a bracket does not close or opens twice; write comments as ( … )"
        )
    if re.match(r"[A-Z](?![\d.+=#\[-])", word):
        return line.refusal(word[0], "a word without a number; write one such as X20.5")
    return line.refusal(word, "not a letter and a number; write one such as X20.5")


_LINE, _WORD, _NUMBER = "\x1d", "\x1e", "\x1f"
"""Separators in a packed line (ASCII), which no text of a program has."""
_SEPARATORS = frozenset({_LINE, _WORD, _NUMBER})


class PackedLines:
    """Lines by their places; those of plain words are packed, and come back as they were put in.

    A program of a milled shape has hundreds of thousands of lines that are alike: a letter and a
    number a few times over. As objects each takes 800 bytes.
    """

    def __init__(self) -> None:
        self._text = bytearray()
        self._begins = array("q", [0])
        self._numbers = array("q")
        self._sources: dict[str, int] = {}
        self._named: list[str] = []

    def __len__(self) -> int:
        """Return how many lines are kept."""
        return len(self._numbers)

    def put(self, line: WrittenLine) -> int | None:
        """Keep a line of plain words and return its place; None: it is of another kind."""
        if line.settings or line.kept is not None or not all(map(_is_plain, line.words)):
            return None
        if not _SEPARATORS.isdisjoint(line.text):
            return None
        source = self._sources.setdefault(line.source, len(self._sources))
        if source == len(self._named):
            self._named.append(line.source)
        words = _WORD.join(f"{one.name}{_NUMBER}{one.written}" for one in line.words)
        packed = f"{source}{'/' if line.optional else ''}{_LINE}{line.text}{_LINE}{words}"
        self._text += packed.encode()
        self._begins.append(len(self._text))
        self._numbers.append(line.line)
        return len(self._numbers) - 1

    def at(self, place: int) -> WrittenLine:
        """Return the line of a place."""
        packed = self._text[self._begins[place] : self._begins[place + 1]].decode()
        source, text, rest = packed.split(_LINE)
        made = (one.split(_NUMBER) for one in rest.split(_WORD)) if rest else ()
        words = tuple(Word(name, written, float(written)) for name, written in made)
        named = self._named[int(source.removesuffix("/"))]
        return WrittenLine(named, self._numbers[place], text, source.endswith("/"), words)


def _is_plain(word: object) -> bool:
    """Return whether a word is a name and the number that is written behind it, and no more."""
    if not isinstance(word, Word) or word.step is not None or word.arguments:
        return False
    if word.number is None or not _SEPARATORS.isdisjoint(word.name + word.written):
        return False
    try:
        return float(word.written) == word.number
    except ValueError:
        return False
