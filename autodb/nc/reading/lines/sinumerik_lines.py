"""Lines of Sinumerik as words: names, calls with arguments, addresses with expressions."""

import re
from dataclasses import replace

from autodb.errors import UnusableInput
from autodb.nc.reading.lines.blocks import (
    NUMBER,
    Setting,
    Word,
    WrittenLine,
    WrittenWord,
    plain_word,
)
from autodb.nc.reading.lines.expressions import Expression, Key, expression, expression_at
from autodb.nc.reading.lines.names import HARMLESS_NAMES, REFUSED_SETTINGS

ADDRESSES = frozenset(
    {
        "CR",
        "LIMS",
        "RND",
        "RNDM",
        "CHF",
        "CHR",
        "ANG",
        "AR",
        "TURN",
        "SF",
        "SPOS",
        "FRC",
        "FRCM",
        "RPL",
    }
    | {"AP", "RP", "DL", "OFFN", "DISR", "DISRP", "FAD", "FP", "PT", "ADIS", "ADISPOS", "IPTRLOCK"}
    | {f"{letter}{n}" for letter in "SMIJKFGHDTCAYZX" for n in range(1, 10)}
)
"""Names with = that are words; every other name with = is a variable."""
_BLANKS = re.compile(r"[\s,]*")
_CALL = re.compile(r"([A-Z_][A-Z0-9_]+)\s*\(")
_SET = re.compile(r"(\$?[A-Z_][A-Z0-9_]*(?:\[[^\]=]*\])?)\s*=(?!=)\s*")
_COUNTED = re.compile(r"(IC|AC|DC|ACP|ACN)\s*\(")
_PLAIN = re.compile(rf"([A-Z])({NUMBER})(?![.\dA-Z_])")
_GLUED = re.compile(rf"([A-Z])({NUMBER})")
_NAME = re.compile(r"[A-Z_][A-Z0-9_]*")
_TEXT = re.compile(r'"([^"]*)"')


def sinumerik_worded(line: WrittenLine, text: str) -> WrittenLine:
    """Return a line with its words and settings; raises UnusableInput naming what is none."""
    words: list[Word | WrittenWord] = []
    settings: list[Setting] = []
    at = 0
    while at < len(text):
        blanks = _BLANKS.match(text, at)
        assert blanks is not None
        at = blanks.end()
        if at >= len(text):
            break
        try:
            at = _one(line, text, at, words, settings)
        except UnusableInput as error:
            said = str(error)
            raise (
                error
                if said.startswith(line.source)
                else line.refusal(text[at:].split(maxsplit=1)[0][:40], said)
            ) from None
    return replace(line, words=tuple(words), settings=tuple(settings))


def _one(
    line: WrittenLine,
    text: str,
    at: int,
    words: list[Word | WrittenWord],
    settings: list[Setting],
) -> int:
    """Take the word or setting that begins at a place; return where it ends."""
    found = _SET.match(text, at)
    if found is not None:
        return _assigned(line, text, found, words, settings)
    found = _CALL.match(text, at)
    if found is not None and found[1] in HARMLESS_NAMES:
        words.append(Word(found[1], "", None))
        return _closed(text, found.end())
    if found is not None:
        arguments, end = arguments_at(text, found.end())
        words.append(WrittenWord(found[1], "", None, arguments=arguments))
        return end
    found = _PLAIN.match(text, at) or _GLUED.match(text, at)
    if found is not None:
        words.append(plain_word(line, found[1], found[2]))
        return found.end()
    found = _NAME.match(text, at)
    if found is None or len(found[0]) == 1:
        word = text[at:].split(maxsplit=1)[0][:40]
        if found is not None:
            raise line.refusal(found[0], "a word without a number; write one such as X20.5")
        if word[0] in "()":
            raise line.refusal(word, "a bracket stands alone; write comments after a semicolon")
        raise line.refusal(word, "not a letter and a number; write one such as X20.5")
    words.append(Word(found[0], "", None))
    return found.end()


def _closed(text: str, at: int) -> int:
    """Return where a bracket that is open before a place has closed; those in texts are none.

    Raises UnusableInput, without file and line, where it does not close.
    """
    depth, quoted = 1, False
    for k in range(at, len(text)):
        quoted ^= text[k] == '"'
        if not quoted:
            depth += (text[k] == "(") - (text[k] == ")")
        if depth == 0:
            return k + 1
    raise UnusableInput("a bracket does not close; close it")


def _assigned(
    line: WrittenLine,
    text: str,
    found: re.Match[str],
    words: list[Word | WrittenWord],
    settings: list[Setting],
) -> int:
    name, at = found[1], found.end()
    quoted = _TEXT.match(text, at)
    if quoted is not None:
        words.append(Word(name, quoted[1], None))
        return quoted.end()
    step: bool | None = None
    counted = _COUNTED.match(text, at)
    if counted is not None:
        step = counted[1] == "IC"
        at = counted.end() - 1
    value, end = expression_at(text, at, packed=False)
    if len(name) > 1 and name not in ADDRESSES:
        why = REFUSED_SETTINGS.get(name.split("[")[0])
        if why is not None:
            raise line.refusal(text[found.start() : end].strip()[:40], why)
        settings.append((_key(name), value))
        return end
    written = text[at:end].strip()
    if re.fullmatch(NUMBER, written):
        words.append(replace(plain_word(line, name, written), step=step))
    else:
        words.append(WrittenWord(name, written, value, step))
    return end


def _key(name: str) -> Expression | Key:
    if name.startswith("R["):
        index = expression(name[2:-1], packed=False)
        return lambda env: f"R{index(env) or 0:.0f}"  # type: ignore[return-value]
    return name


def arguments_at(text: str, at: int) -> tuple[tuple[Expression | str | None, ...], int]:
    """Return a call's arguments, None where one is left out, and where its bracket has closed.

    Raises UnusableInput, without file and line, where it does not close.
    """
    found: list[Expression | str | None] = []
    while True:
        rest = text[at:].lstrip()
        at = len(text) - len(rest)
        if not rest:
            raise UnusableInput("a bracket does not close; close it")
        if rest[0] in ",)":
            found.append(None)
        else:
            quoted = _TEXT.match(text, at)
            if quoted is not None:
                found.append(quoted[1])
                at = quoted.end()
            else:
                value, at = expression_at(text, at, packed=False)
                found.append(value)
        rest = text[at:].lstrip()
        at = len(text) - len(rest)
        if rest[:1] == ")":
            return tuple(found), at + 1
        if rest[:1] != ",":
            raise UnusableInput("a bracket does not close; close it")
        at += 1
